//! The contacts of each object.

use super::pair::ContactPair;
use crate::broad_phase::ProxyId;

/// For each object, the indices of its contacts in a list of all: one array, cut into a range for
/// each object.
#[derive(Clone, Debug)]
pub(super) struct Adjacency {
    /// By handle, where its range begins; and at the end, where the last one ends.
    starts: Vec<u32>,
    slots: Vec<u32>,
}

impl Adjacency {
    /// By counting: O(contacts + objects). The contacts of an object come in the order of the list.
    pub(super) fn new(contacts: &[ContactPair]) -> Self {
        let both = |contact: &ContactPair| [contact.pair.a.index(), contact.pair.b.index()];
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
        let mut slots = vec![0; 2 * contacts.len()];
        for (slot, contact) in contacts.iter().enumerate() {
            for handle in both(contact) {
                let next = &mut starts[handle + 1];
                slots[*next as usize] = slot as u32;
                *next += 1;
            }
        }
        debug_assert!(
            starts.is_sorted() && starts[handles] as usize == slots.len(),
            "ranges lie side by side"
        );
        Self { starts, slots }
    }

    /// The indices of an object's contacts, in the list that this was made from.
    pub(super) fn of(&self, id: ProxyId) -> &[u32] {
        match self.starts.get(id.index()..) {
            Some([start, end, ..]) => &self.slots[*start as usize..*end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::broad_phase::Pair;
    use bevy::prelude::Entity;

    #[test]
    fn every_object_has_its_contacts_in_order() {
        let mut random = fastrand::Rng::with_seed(1);
        for objects in [1, 2, 5, 40] {
            let mut pairs: Vec<_> = (0..objects * 3)
                .map(|_| [random.u32(0..objects), random.u32(0..objects)].map(ProxyId::new))
                .filter(|[a, b]| a != b)
                .map(|[a, b]| Pair::new(a, b))
                .collect();
            pairs.sort_unstable();
            pairs.dedup();
            let none = Entity::PLACEHOLDER;
            let contact = |pair: &Pair| ContactPair {
                pair: *pair,
                a: none,
                b: none,
                layers: Default::default(),
                time: 1.0,
            };
            let contacts: Vec<_> = pairs.iter().map(contact).collect();
            let adjacency = Adjacency::new(&contacts);
            for id in (0..objects + 3).map(ProxyId::new) {
                let expected: Vec<_> = (0..pairs.len() as u32)
                    .filter(|index| {
                        [pairs[*index as usize].a, pairs[*index as usize].b].contains(&id)
                    })
                    .collect();
                assert_eq!(adjacency.of(id), expected);
            }
        }
    }
}
