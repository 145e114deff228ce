//! The search for pairs (Swan 1994, section 2.3): leaf by leaf.

use bevy::math::Vec3A;

use super::{Cell, ObjectOctree};
use crate::{
    broad_phase::{Pair, Proxies, ProxyId, group::Group},
    octree::NodeId,
};

impl ObjectOctree {
    /// Finds the pairs of all leaves that list an object that moved, and another. Returns the number of pairs of boxes
    /// compared.
    pub(super) fn search_leaves(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let moved = proxies.moved();
        let mut compared = 0;
        if moved.len() * 4 > proxies.len() {
            // Most leaves are concerned: depth first through all of them.
            for leaf in self.tree.leaves(NodeId::ROOT) {
                compared += search_leaf(self.tree.data(leaf), &mut self.group, proxies, pairs);
            }
        } else {
            let turn = self.next_turn();
            for id in moved {
                for &leaf in &self.entries[id.index()].leaves {
                    let cell = self.tree.data_mut(leaf);
                    if std::mem::replace(&mut cell.tested, turn) != turn {
                        compared += search_leaf(cell, &mut self.group, proxies, pairs);
                    }
                }
            }
        }
        compared
    }
}

fn search_leaf(cell: &Cell, group: &mut Group, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
    if cell.listed().len() < 2 {
        return 0;
    }
    group.gather(cell.listed().iter().map(|object| ProxyId::new(*object)), proxies);
    group.overlaps(|[a, b], [box_a, box_b]| {
        // Of the leaves that list both, the one that holds the lower corner of the overlap reports the pair.
        if cell.contains(Vec3A::max(box_a.min, box_b.min)) {
            pairs.push(Pair::new(a, b));
        }
    })
}
