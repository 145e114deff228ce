//! The search for pairs (Swan 1994, section 2.3): leaf by leaf.

use fearless_simd::{Level, Simd, dispatch};

use super::{cell::Cell, list::List, maintain::FEW, octree::ObjectOctree};
use crate::{
    broad_phase::{
        block::{ALL, WIDTH},
        boxes::ProxyId,
        group::Group,
        pairs::Pair,
        proxy::Proxies,
    },
    octree::NodeId,
};

/// A leaf that lists more objects than this is looked at as a crowd.
const CROWDED: usize = 512;

impl ObjectOctree {
    /// Finds the pairs of all leaves that list an object that moved, and another. Returns the
    /// number of pairs of boxes compared.
    pub(super) fn search_leaves(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let level = self.level;
        let mut compared = if proxies.moved().len() * FEW > proxies.len() {
            dispatch!(level, simd => self.search_all(simd, proxies, pairs))
        } else {
            let turn = self.next_turn();
            dispatch!(level, simd => self.search_for_moved(simd, turn, proxies, pairs))
        };
        for leaf in self.crowded.drain(..) {
            let cell = self.tree.data(leaf);
            compared += search_crowd(level, cell, &mut self.group, proxies, pairs);
        }
        compared
    }

    /// Goes through all leaves in the order of space.
    #[inline(always)]
    fn search_all<S: Simd>(
        &mut self,
        simd: S,
        proxies: &Proxies,
        pairs: &mut Vec<Pair>,
    ) -> u64 {
        if std::mem::take(&mut self.has_new_shape) {
            self.leaves.clear();
            self.leaves.extend(self.tree.leaves(NodeId::ROOT));
        }
        let mut compared = 0;
        let all_moved = proxies.all_moved();
        for &leaf in &self.leaves {
            let list = self.tree.data(leaf).list();
            if list.objects().len() > CROWDED {
                self.crowded.push(leaf);
            } else if all_moved {
                compared += search_leaf::<S, true>(simd, list, proxies, pairs);
            } else {
                compared += search_leaf::<S, false>(simd, list, proxies, pairs);
            }
        }
        compared
    }

    /// Goes through the leaves of the objects that moved.
    #[inline(always)]
    fn search_for_moved<S: Simd>(
        &mut self,
        simd: S,
        turn: u64,
        proxies: &Proxies,
        pairs: &mut Vec<Pair>,
    ) -> u64 {
        let mut compared = 0;
        for &id in proxies.moved() {
            let entry = &self.entries[id.index()];
            for (number, &leaf) in entry.leaves.iter().enumerate() {
                let list = self.tree.data(leaf).list();
                if list.objects().len() > CROWDED {
                    let cell = self.tree.data_mut(leaf);
                    if std::mem::replace(&mut cell.held, turn) != turn {
                        self.crowded.push(leaf);
                    }
                } else if let Some(index) = list.find(id.get(), entry.hint(number)) {
                    compared += search_for(simd, list, index, proxies, pairs);
                }
            }
        }
        compared
    }
}

/// Appends each pair of overlapping boxes of a leaf of which at least one moved, which admit each
/// other, and whose overlap has its lower corner in the cell: of the leaves that list both, that is
/// one. Returns the number of pairs compared.
///
/// The corner is the larger of the two lower corners, axis by axis. It is below the upper borders
/// of every cell that both boxes overlap, and above the lower borders if one of the boxes begins
/// there.
#[inline(always)]
fn search_leaf<S: Simd, const ALL_MOVED: bool>(
    simd: S,
    list: &List,
    proxies: &Proxies,
    pairs: &mut Vec<Pair>,
) -> u64 {
    let (objects, eights) = (list.objects(), list.eights());
    let is_filtered = proxies.are_filtered();
    let mut compared = 0;
    for (own, eight) in eights.iter().enumerate() {
        for lane in 0..WIDTH.min(objects.len() - own * WIDTH) {
            let first = own * WIDTH + lane;
            let id = ProxyId::new(objects[first]);
            let moved = ALL_MOVED || proxies.is_moved(id);
            let aabb = eight.boxes().get(lane);
            let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
            // In its own block, those that follow.
            let mut lanes = ALL & !1 << lane;
            for (number, other) in (own..).zip(&eights[own..]) {
                let mut hits = other.boxes().overlaps(simd, min, max) & lanes;
                lanes = ALL;
                if hits != 0 {
                    hits &= !other.shared_below(eight.begins_below(lane));
                    while hits != 0 {
                        let second = number * WIDTH + hits.trailing_zeros() as usize;
                        hits &= hits - 1;
                        let other = ProxyId::new(objects[second]);
                        if (moved || proxies.is_moved(other))
                            && (!is_filtered || proxies.admits(id, other))
                        {
                            pairs.push(Pair::new(id, other));
                        }
                    }
                }
            }
            compared += (objects.len() - first - 1) as u64;
        }
    }
    compared
}

/// The same for the pairs of one object that moved, which has this index in the list; of two that
/// moved, the first finds the pair.
#[inline(always)]
fn search_for<S: Simd>(
    simd: S,
    list: &List,
    index: usize,
    proxies: &Proxies,
    pairs: &mut Vec<Pair>,
) -> u64 {
    let (objects, eights) = (list.objects(), list.eights());
    let is_filtered = proxies.are_filtered();
    let id = ProxyId::new(objects[index]);
    let (own, lane) = (index / WIDTH, index % WIDTH);
    let aabb = eights[own].boxes().get(lane);
    let below = eights[own].begins_below(lane);
    let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
    for (number, eight) in eights.iter().enumerate() {
        let mut hits = eight.boxes().overlaps(simd, min, max) & !eight.shared_below(below);
        while hits != 0 {
            let second = number * WIDTH + hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let other = ProxyId::new(objects[second]);
            if second != index
                && (second > index || !proxies.is_moved(other))
                && (!is_filtered || proxies.admits(id, other))
            {
                pairs.push(Pair::new(id, other));
            }
        }
    }
    objects.len() as u64 - 1
}

/// The same for a leaf that lists many.
fn search_crowd(
    level: Level,
    cell: &Cell,
    group: &mut Group,
    proxies: &Proxies,
    pairs: &mut Vec<Pair>,
) -> u64 {
    group.gather(
        cell.listed().iter().map(|object| ProxyId::new(*object)),
        cell.bounds().min,
        proxies,
    );
    if group.is_crowd() {
        group.overlaps_in_crowd(level, proxies, pairs)
    } else {
        dispatch!(level, simd => group.overlaps(simd, pairs))
    }
}
