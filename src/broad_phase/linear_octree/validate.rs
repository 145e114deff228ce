//! Checks of everything that is said to hold.

use super::octree::{LinearOctree, NONE};
use crate::broad_phase::{block::WIDTH, boxes::ProxyId, proxy::Proxies};

impl LinearOctree {
    /// Checks the tree against the objects: that each object has a slot, and each slot at most one
    /// object; that boxes lie in their skins, and skins and blocks in the bounds above them. For
    /// tests.
    ///
    /// # Panics
    /// If anything is not as it should be, or if `proxies` changed since the last update.
    pub fn assert_well_formed(&self, proxies: &Proxies) {
        for (id, aabb) in proxies.iter() {
            let slot = self.slot_of[id.index()];
            let index = slot as usize;
            assert_eq!(self.owners[index], id.get(), "{id:?} owns its slot");
            assert!(
                self.tree.as_slice()[0][index / WIDTH].holds(index % WIDTH, aabb),
                "{id:?} is in its skin"
            );
            assert!(
                !self.boxes_are_gathered || self.boxes[index] == *aabb,
                "the box of {id:?} is gathered"
            );
        }
        let owned = self.owners.iter().filter(|owner| **owner != NONE);
        assert_eq!(
            owned.clone().count(),
            proxies.len(),
            "each slot that is owned has an object"
        );
        assert!(
            owned
                .clone()
                .all(|owner| proxies.contains(ProxyId::new(*owner)))
        );
        assert_eq!(self.owned, proxies.len());
        self.near.assert_well_formed(self.owners.len());
        self.tree.assert_well_formed(self.owners.len());
    }
}
