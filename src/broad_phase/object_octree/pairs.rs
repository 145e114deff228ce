//! The search for pairs (Swan 1994, section 2.3): leaf by leaf.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::ObjectOctree;
use crate::{
    broad_phase::{Pair, Proxies, ProxyId, overlap},
    octree::NodeId,
};

/// What a search keeps from leaf to leaf and tick to tick.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    /// The objects of the current leaf, those that moved first: boxes in one place, whatever their order in memory.
    boxes: Vec<Aabb3d>,
    ids: Vec<ProxyId>,
    compared: u64,
}

impl ObjectOctree {
    /// Finds the pairs of all leaves that list an object that moved, and another.
    pub(super) fn search_leaves(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let mut search = std::mem::take(&mut self.search);
        search.compared = 0;
        let moved = proxies.moved();
        if moved.len() * 4 > proxies.len() {
            // Most leaves are concerned: depth first through all of them.
            for leaf in self.tree.leaves(NodeId::ROOT) {
                search.leaf(self.tree.data(leaf), proxies, pairs);
            }
        } else {
            let turn = self.next_turn();
            for id in moved {
                for &leaf in &self.entries[id.index()].leaves {
                    let cell = self.tree.data_mut(leaf);
                    if std::mem::replace(&mut cell.tested, turn) != turn {
                        search.leaf(cell, proxies, pairs);
                    }
                }
            }
        }
        let compared = search.compared;
        self.search = search;
        compared
    }
}

impl Search {
    fn leaf(&mut self, cell: &super::Cell, proxies: &Proxies, pairs: &mut Vec<Pair>) {
        if cell.listed().len() < 2 {
            return;
        }
        self.boxes.clear();
        self.ids.clear();
        for wanted in [true, false] {
            for id in cell.listed().iter().map(|object| ProxyId::new(*object)) {
                if proxies.is_moved(id) == wanted {
                    self.ids.push(id);
                    self.boxes.push(proxies.boxes()[id.index()]);
                }
            }
            if self.ids.is_empty() {
                return;
            }
            if wanted {
                self.compared += tests(cell.listed().len(), self.ids.len());
            }
        }
        let moved = self.ids.partition_point(|id| proxies.is_moved(*id));
        for first in 0..moved {
            let aabb = &self.boxes[first];
            for (second, other) in self.boxes.iter().enumerate().skip(first + 1) {
                // Of the leaves that list both, the one that holds the lower corner of the overlap reports the pair.
                if overlap(aabb, other) && cell.contains(Vec3A::max(aabb.min, other.min)) {
                    pairs.push(Pair::new(self.ids[first], self.ids[second]));
                }
            }
        }
    }
}

/// The number of pairs among `all` objects of which one of the first `moved` is a part.
const fn tests(all: usize, moved: usize) -> u64 {
    (moved * (all - moved) + moved * moved.saturating_sub(1) / 2) as u64
}
