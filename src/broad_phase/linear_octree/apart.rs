//! Objects too fast for skins, which are kept apart from the others: each would make a block of
//! these large, in which all searches end.

use super::{
    list::unpack,
    octree::{LinearOctree, NONE},
};
use crate::broad_phase::{boxes::NOWHERE, proxy::Proxies};

impl LinearOctree {
    /// Moves those of the escaped that are fast to the end, and puts the escaped that are there in
    /// order. What comes after the slots that were sorted is found anew each tick as long as it is
    /// fast, so that it may have any of these slots.
    pub(super) fn set_fast_apart(&mut self, proxies: &Proxies) {
        let mut escaped = std::mem::take(&mut self.escaped);
        for slot in &mut escaped {
            let index = *slot as usize;
            if index < self.sorted && self.anchors[index].is_fast(self.tick, &self.boxes[index]) {
                *slot = self.move_to_end(*slot);
            }
        }
        let at_end = |slot: &u32| *slot as usize >= self.sorted;
        if escaped.iter().any(at_end) {
            escaped.sort_unstable();
            let first = escaped.partition_point(|slot| !at_end(slot));
            self.deal_out(&escaped[first..], proxies);
        }
        self.escaped = escaped;
    }

    fn move_to_end(&mut self, slot: u32) -> u32 {
        let (from, to) = (slot as usize, self.owners.len());
        let id = std::mem::replace(&mut self.owners[from], NONE);
        debug_assert_eq!(self.slot_of[id as usize], slot, "its owner is in the slot");
        self.slot_of[id as usize] = to as u32;
        self.owners.push(id);
        self.anchors.push(self.anchors[from]);
        if self.boxes_are_gathered {
            let aabb = std::mem::replace(&mut self.boxes[from], NOWHERE);
            self.boxes.push(aabb);
        }
        self.tree.set(from, &NOWHERE);
        self.tree.push(to);
        self.near.renew(slot);
        self.near.push_slot();
        self.near.watch(to as u32);
        to as u32
    }

    /// Puts the objects in some slots in order, among these slots. All of them escaped: nothing is
    /// kept of their pairs.
    fn deal_out(&mut self, slots: &[u32], proxies: &Proxies) {
        let owners = &self.owners;
        let items = self.order.sort_some(
            self.level,
            proxies,
            slots.iter().map(|slot| owners[*slot as usize]),
        );
        let ids: Vec<_> = items.iter().map(|item| unpack(*item)[1]).collect();
        let anchors: Vec<_> = ids
            .iter()
            .map(|id| self.anchors[self.slot_of[*id as usize] as usize])
            .collect();
        for ((&slot, id), anchor) in slots.iter().zip(ids).zip(anchors) {
            let index = slot as usize;
            self.slot_of[id as usize] = slot;
            self.owners[index] = id;
            self.anchors[index] = anchor;
            if self.boxes_are_gathered {
                self.boxes[index] = proxies.boxes()[id as usize];
            }
        }
    }
}
