//! Checks of everything that is said to hold.

use super::{LinearOctree, NONE};
use crate::broad_phase::{Proxies, ProxyId};

impl LinearOctree {
    /// Checks the tree against the objects: that each object has a slot, and each slot at most one object; that boxes lie
    /// in their skins, and skins and blocks in the bounds above them. For tests.
    ///
    /// # Panics
    /// If anything is not as it should be, or if `proxies` changed since the last update.
    pub fn assert_well_formed(&self, proxies: &Proxies) {
        for (id, aabb) in proxies.iter() {
            assert!(self.skins.holds(id, aabb), "{id:?} is in its skin");
            let slot = self.slot_of[id.index()];
            assert_eq!(self.owners[slot as usize], id.get(), "{id:?} owns its slot");
            assert_eq!(self.tree.get(slot as usize), *self.skins.get(id), "{id:?} is in the tree with its skin");
        }
        let owned = self.owners.iter().filter(|owner| **owner != NONE);
        assert_eq!(owned.clone().count(), proxies.len(), "each slot that is owned has an object");
        assert!(owned.clone().all(|owner| proxies.contains(ProxyId::new(*owner))));
        assert_eq!(self.is_fresh.len(), self.owners.len());
        assert_eq!(self.is_fresh.iter().filter(|fresh| **fresh).count(), self.fresh.len());
        self.tree.assert_well_formed(self.owners.len());
    }
}
