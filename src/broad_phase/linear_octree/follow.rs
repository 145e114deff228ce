//! Following the objects from tick to tick: who came, who went, and who left its skin.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{Simd, dispatch};

use super::{
    levels::JOB,
    list::List,
    octree::{LinearOctree, NONE},
    skin::{self, Anchor, REFRESH_SHARE},
};
use crate::{
    broad_phase::{
        block::{ALL, Block, WIDTH},
        boxes::{NOWHERE, ProxyId},
        proxy::Proxies,
    },
    parallel,
};

/// How many boxes are gathered from memory before they are worked on.
const GATHERED: usize = 256;

impl LinearOctree {
    /// Lets go of objects that are gone, and gives slots to new ones; unless these are so many that
    /// all objects had better be put in order.
    pub(super) fn let_go_and_take_in(&mut self, proxies: &Proxies) {
        self.slot_of.resize(proxies.capacity(), NONE);
        let mut new = 0;
        for &id in proxies.moved() {
            if !proxies.contains(id) {
                self.let_go(id);
            } else if self.slot_of[id.index()] == NONE {
                new += 1;
            }
        }
        if new * REFRESH_SHARE < proxies.len() {
            for &id in proxies.moved() {
                if proxies.contains(id) && self.slot_of[id.index()] == NONE {
                    self.take_in(id);
                }
            }
        }
    }

    fn let_go(&mut self, id: ProxyId) {
        let slot = std::mem::replace(&mut self.slot_of[id.index()], NONE);
        if slot != NONE {
            let index = slot as usize;
            debug_assert_eq!(self.owners[index], id.get(), "it is in its slot");
            self.owners[index] = NONE;
            self.owned -= 1;
            self.tree.set(index, &NOWHERE);
            if let Some(aabb) = self.boxes.get_mut(index) {
                *aabb = NOWHERE;
            }
            self.near.renew(slot);
            self.order.note_change();
            self.changes += 1;
        }
    }

    /// Gives an object a slot at the end. It has no skin yet, and will be found to have left it.
    fn take_in(&mut self, id: ProxyId) {
        let index = self.owners.len();
        self.slot_of[id.index()] = index as u32;
        self.owners.push(id.get());
        self.owned += 1;
        self.anchors.push(Anchor::default());
        if self.boxes_are_gathered {
            self.boxes.push(NOWHERE);
        }
        self.tree.push(index);
        self.near.push_slot();
        self.order.note_change();
    }

    /// Gathers the boxes of this tick, and lists the slots of objects that left their skins.
    pub(super) fn follow(&mut self, proxies: &Proxies) {
        let all = proxies.most_moved();
        if all || !self.boxes_are_gathered {
            self.follow_all(proxies);
        } else {
            self.follow_moved(proxies);
        }
        if all {
            self.near.watch_all();
        } else {
            self.near.watch_moved(proxies, &self.slot_of);
            for id in proxies.moved().iter().filter(|id| proxies.contains(**id)) {
                self.near.watch(self.slot_of[id.index()]);
            }
        }
    }

    fn follow_all(&mut self, proxies: &Proxies) {
        self.boxes.resize(self.owners.len(), NOWHERE);
        self.boxes_are_gathered = true;
        let mut escaped_by_job = std::mem::take(&mut self.escaped_by_job);
        escaped_by_job.resize_with(self.owners.len().div_ceil(JOB), List::default);
        let level = self.level;
        parallel::for_each(
            self.whole().cut(JOB).zip(&mut escaped_by_job),
            |(chunk, escaped)| {
                gather(proxies.boxes(), chunk.owners, chunk.boxes);
                dispatch!(level, simd => find_escaped(simd, &chunk, escaped));
            },
        );
        for escaped in &escaped_by_job {
            self.escaped
                .extend(escaped.as_slice().iter().map(|slot| *slot as u32));
        }
        self.escaped_by_job = escaped_by_job;
    }

    fn follow_moved(&mut self, proxies: &Proxies) {
        let boxes = proxies.boxes();
        for id in proxies.moved().iter().filter(|id| proxies.contains(**id)) {
            let slot = self.slot_of[id.index()] as usize;
            let aabb = &boxes[id.index()];
            self.boxes[slot] = *aabb;
            if !self.tree.as_slice()[0][slot / WIDTH].holds(slot % WIDTH, aabb) {
                self.escaped.push(slot as u32);
            }
        }
    }

    /// For how many ticks ahead to make all skins; 0 if they had better be boxes.
    pub(super) fn horizon(&self, proxies: &Proxies) -> f32 {
        // What has no skin is renewed each tick. If so many are fast, all would be renewed before
        // the shortest of skins had served its time.
        const MOST_FAST: f32 = 1.0 / (skin::SHORTEST * REFRESH_SHARE as f32);
        skin::horizon(self.sample(0..self.owners.len(), proxies), MOST_FAST)
    }

    /// For how many ticks ahead to make skins of objects that left theirs. Those that are fast say
    /// nothing about the others.
    pub(super) fn horizon_of_escaped(&self, proxies: &Proxies) -> f32 {
        let escaped = self.escaped.iter().map(|slot| *slot as usize);
        skin::horizon(self.sample(escaped, proxies), 1.0).max(skin::SHORTEST)
    }

    /// Steps of some of the objects in slots, and their boxes.
    fn sample<'a>(
        &'a self,
        slots: impl ExactSizeIterator<Item = usize>,
        proxies: &'a Proxies,
    ) -> impl Iterator<Item = (Vec3A, &'a Aabb3d)> {
        const SAMPLE: usize = 512;
        let step = slots.len() / SAMPLE + 1;
        slots.step_by(step).filter_map(move |slot| {
            let aabb = proxies.boxes().get(*self.owners.get(slot)? as usize)?;
            Some((self.anchors[slot].step(self.tick, aabb), aabb))
        })
    }

    /// Makes the skins of all objects for so many ticks ahead. Returns `true` if each is the box
    /// itself.
    pub(super) fn make_all_skins(&mut self, proxies: &Proxies, horizon: f32) -> bool {
        let (tick, are_gathered) = (self.tick, self.boxes_are_gathered);
        // Without skins, the boxes need not be kept beside the tree.
        self.boxes_are_gathered |= horizon > 0.0;
        self.boxes.resize(
            if self.boxes_are_gathered {
                self.owners.len()
            } else {
                0
            },
            NOWHERE,
        );
        let some_skin = AtomicBool::new(false);
        parallel::for_each(self.whole().cut(JOB), |chunk| {
            let has_skin = chunk.make_skins((!are_gathered).then_some(proxies), tick, horizon);
            some_skin.fetch_or(has_skin, Ordering::Relaxed);
        });
        !some_skin.into_inner()
    }

    /// All slots.
    fn whole(&mut self) -> Chunk<'_> {
        let (owners, anchors, boxes) = (&self.owners, &mut self.anchors, &mut self.boxes);
        debug_assert!(
            anchors.len() == owners.len() && (boxes.is_empty() || boxes.len() == owners.len())
        );
        Chunk {
            start: 0,
            owners,
            anchors,
            blocks: self.tree.boxes_mut(),
            boxes,
        }
    }
}

/// Slots that follow each other, with what there is for each of them.
struct Chunk<'a> {
    /// The first of them. It begins a block.
    start: usize,
    owners: &'a [u32],
    anchors: &'a mut [Anchor],
    /// Their skins, in eights.
    blocks: &'a mut [Block],
    /// Their boxes of this tick; none where these are not kept.
    boxes: &'a mut [Aabb3d],
}

impl<'a> Chunk<'a> {
    /// Cuts it into chunks of so many slots, but for the last.
    fn cut(self, slots: usize) -> impl ExactSizeIterator<Item = Chunk<'a>> {
        debug_assert_eq!(slots % WIDTH, 0, "chunks are of whole blocks");
        debug_assert_eq!(
            self.owners.len().div_ceil(WIDTH).max(1),
            self.blocks.len(),
            "each slot is in a block"
        );
        let Self {
            start,
            owners,
            anchors,
            blocks,
            mut boxes,
        } = self;
        let parts = owners
            .chunks(slots)
            .zip(anchors.chunks_mut(slots))
            .zip(blocks.chunks_mut(slots / WIDTH));
        parts
            .enumerate()
            .map(move |(part, ((owners, anchors), blocks))| {
                let boxes = boxes.split_off_mut(..owners.len()).unwrap_or_default();
                Chunk {
                    start: start + part * slots,
                    owners,
                    anchors,
                    blocks,
                    boxes,
                }
            })
    }

    /// Makes the skins of its objects for so many ticks ahead, or none but their boxes. Gathers
    /// their boxes, if that has not been done. Returns `true` if a skin is more than the box
    /// itself.
    fn make_skins(self, gather_from: Option<&Proxies>, tick: u32, horizon: f32) -> bool {
        let mut passing = [NOWHERE; GATHERED];
        let mut has_skin = false;
        for Chunk {
            owners,
            anchors,
            blocks,
            boxes,
            ..
        } in self.cut(GATHERED)
        {
            let boxes = if boxes.is_empty() {
                &mut passing[..owners.len()]
            } else {
                boxes
            };
            if let Some(proxies) = gather_from {
                gather(proxies.boxes(), owners, boxes);
            }
            for ((eight, anchors), block) in boxes
                .chunks(WIDTH)
                .zip(anchors.chunks_mut(WIDTH))
                .zip(blocks)
            {
                for (lane, (aabb, anchor)) in eight.iter().zip(anchors).enumerate() {
                    if horizon > 0.0 {
                        let skin = anchor.renew(tick, aabb, horizon);
                        has_skin |= skin.is_some();
                        block.set(lane, &skin.unwrap_or(*aabb));
                    } else {
                        block.set(lane, aabb);
                        anchor.drop_at(tick, aabb);
                    }
                }
            }
        }
        has_skin
    }
}

/// Copies the boxes of some objects. In a loop that does nothing else, so that the processor runs
/// ahead and waits for many boxes at once.
fn gather(boxes: &[Aabb3d], owners: &[u32], gathered: &mut [Aabb3d]) {
    for (owner, aabb) in owners.iter().zip(gathered) {
        *aabb = *boxes.get(*owner as usize).unwrap_or(&NOWHERE);
    }
}

/// Lists the slots of a chunk whose boxes are not within their skins.
#[inline(always)]
fn find_escaped<S: Simd>(simd: S, chunk: &Chunk<'_>, escaped: &mut List) {
    escaped.clear();
    escaped.reserve(chunk.blocks.len());
    let slots = (chunk.start as u64..).step_by(WIDTH);
    for ((slot, eight), skins) in slots.zip(chunk.boxes.chunks(WIDTH)).zip(&*chunk.blocks) {
        let mut inner = Block::EMPTY;
        for (lane, aabb) in eight.iter().enumerate() {
            inner.set(lane, aabb);
        }
        escaped.push_lanes(!skins.holds_all(simd, &inner) & ALL, slot, 1);
    }
}
