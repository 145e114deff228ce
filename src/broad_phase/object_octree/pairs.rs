//! The search for pairs (Swan 1994, section 2.3): leaf by leaf.

use fearless_simd::{Level, Simd, dispatch};

use super::{cell::Cell, octree::ObjectOctree};
use crate::{
    broad_phase::{boxes::ProxyId, group::Group, pairs::Pair, proxy::Proxies},
    octree::NodeId,
};

impl ObjectOctree {
    /// Finds the pairs of all leaves that list an object that moved, and another. Returns the
    /// number of pairs of boxes compared.
    pub(super) fn search_leaves(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        dispatch!(self.level, simd => self.search_leaves_with(simd, proxies, pairs))
    }

    #[inline(always)]
    fn search_leaves_with<S: Simd>(
        &mut self,
        simd: S,
        proxies: &Proxies,
        pairs: &mut Vec<Pair>,
    ) -> u64 {
        let (moved, level) = (proxies.moved(), self.level);
        let mut compared = 0;
        if moved.len() * 16 > proxies.len() {
            // Most leaves are concerned: depth first through all of them.
            for leaf in self.tree.leaves(NodeId::ROOT) {
                compared += search_leaf(
                    simd,
                    level,
                    self.tree.data(leaf),
                    &mut self.group,
                    proxies,
                    pairs,
                );
            }
        } else {
            let turn = self.next_turn();
            for id in moved {
                for &leaf in &self.entries[id.index()].leaves {
                    let cell = self.tree.data_mut(leaf);
                    if std::mem::replace(&mut cell.searched, turn) != turn {
                        compared += search_leaf(simd, level, cell, &mut self.group, proxies, pairs);
                    }
                }
            }
        }
        compared
    }
}

#[inline(always)]
fn search_leaf<S: Simd>(
    simd: S,
    level: Level,
    cell: &Cell,
    group: &mut Group,
    proxies: &Proxies,
    pairs: &mut Vec<Pair>,
) -> u64 {
    if cell.listed().len() < 2 {
        return 0;
    }
    group.gather(
        cell.listed().iter().map(|object| ProxyId::new(*object)),
        cell.bounds().min,
        proxies,
    );
    if group.is_crowd() {
        group.overlaps_in_crowd(level, proxies, pairs)
    } else {
        group.overlaps(simd, pairs)
    }
}
