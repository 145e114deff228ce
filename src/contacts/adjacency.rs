//! The contacts of each object.

use super::{
    arrangement::Arrangement,
    ledger::Ledger,
    pair::{ContactPair, GONE},
};
use crate::broad_phase::ProxyId;

/// For each object, the numbers of its contacts among all: one array, cut into a range for each
/// object.
#[derive(Clone, Debug)]
pub(super) struct Adjacency {
    /// By handle, where its range begins; and at the end, where the last one ends.
    starts: Vec<u32>,
    slots: Vec<u32>,
}

impl Adjacency {
    /// By counting: O(contacts + objects). The contacts of an object come in the order of all. Who is gone has none.
    pub(super) fn new(contacts: &Ledger, arrangement: &Arrangement) -> Self {
        let both = |contact: &ContactPair| {
            let there = contact.key.ids.into_iter().filter(|id| *id != GONE);
            there.map(ProxyId::index)
        };
        let handles = contacts
            .iter()
            .flat_map(both)
            .max()
            .map_or(0, |last| last + 1);
        // Two slots later than their own, counts become starts, and starts become ends while the
        // ranges fill.
        let mut starts = vec![0; handles + 2];
        for handle in contacts.iter().flat_map(both) {
            starts[handle + 2] += 1;
        }
        for handle in 2..starts.len() {
            starts[handle] += starts[handle - 1];
        }
        let mut slots = vec![0; starts[handles + 1] as usize];
        for (number, contact) in arrangement.numbered(contacts) {
            for handle in both(contact) {
                let next = &mut starts[handle + 1];
                slots[*next as usize] = number;
                *next += 1;
            }
        }
        debug_assert!(
            starts.is_sorted() && starts[handles] as usize == slots.len(),
            "ranges lie side by side"
        );
        Self { starts, slots }
    }

    /// The numbers of an object's contacts.
    pub(super) fn of(&self, id: ProxyId) -> &[u32] {
        match self.starts.get(id.index()..) {
            Some([start, end, ..]) => &self.slots[*start as usize..*end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;

    use super::*;
    use crate::contacts::{ledger::Changes, pair::ContactKey};

    #[test]
    fn every_object_has_its_contacts_in_order() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut world = World::new();
        for objects in [1, 2, 5, 40] {
            let entities: Vec<_> = (0..objects).map(|_| world.spawn_empty().id()).collect();
            let mut keys: Vec<_> = (0..objects * 3)
                .map(|_| [random.usize(0..objects), random.usize(0..objects)])
                .filter(|[a, b]| a < b)
                .map(|ids| ContactKey {
                    a: entities[ids[0]],
                    b: entities[ids[1]],
                    ids: ids.map(|id| ProxyId::new(id as u32)),
                })
                .collect();
            keys.sort_unstable();
            keys.dedup();
            let contact = |key: &ContactKey| ContactPair {
                key: *key,
                layers: Default::default(),
                time: 1.0,
            };
            let mut contacts = Ledger::default();
            // Some rest, and are in a list of their own.
            contacts.enter(&keys, contact, |_| false, Changes::ANY);
            let rests = |contact: &ContactPair| contact.key.ids[0].index().is_multiple_of(2);
            let moving: Vec<_> = keys
                .iter()
                .copied()
                .filter(|key| !rests(&contact(key)))
                .collect();
            contacts.enter(&moving, contact, rests, Changes::ANY);
            let adjacency = Adjacency::new(&contacts, &Arrangement::default());
            for id in (0..objects as u32 + 3).map(ProxyId::new) {
                let found: Vec<_> = adjacency
                    .of(id)
                    .iter()
                    .map(|number| contacts.at(*number).key)
                    .collect();
                let expected = keys.iter().copied().filter(|key| key.ids.contains(&id));
                assert_eq!(found, expected.collect::<Vec<_>>());
            }
        }
    }
}
