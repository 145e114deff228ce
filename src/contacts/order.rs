//! The order of contacts.

use super::pair::ContactKey;

/// Puts keys in their order, with memory that outlives it.
///
/// By a counting sort on the first of the two entities, if there are enough keys for the number of
/// entities, and by comparisons within what that leaves together: O(n), but for those that many
/// others touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorter {
    /// By the index of the first entity: where its keys begin, and end once they are put there.
    ends: Vec<u32>,
    sorted: Vec<ContactKey>,
}

/// So many entities for each key make a counting sort slower than comparisons.
const ENTITIES_PER_KEY: usize = 8;

impl Sorter {
    /// Sorts keys, of entities of which none has an index below a number.
    pub(super) fn sort(&mut self, keys: &mut Vec<ContactKey>, lowest: usize) {
        // Where the first entity is counted.
        let place = |key: &ContactKey| {
            debug_assert!(key.a.index_u32() as usize >= lowest);
            key.a.index_u32() as usize - lowest
        };
        let entities = keys.iter().map(place).max().map_or(0, |last| last + 1);
        let is_countable = u32::try_from(keys.len()).is_ok();
        if !is_countable || entities > keys.len().saturating_mul(ENTITIES_PER_KEY) {
            keys.sort_unstable();
            return;
        }
        sort_by_place(keys, (entities, place), &mut self.ends, &mut self.sorted);
        for of_one in self
            .sorted
            .chunk_by_mut(|one, other| place(one) == place(other))
        {
            if of_one.len() > 1 {
                of_one.sort_unstable();
            }
        }
        std::mem::swap(keys, &mut self.sorted);
    }
}

/// Puts keys in the order of their places, of which there are so many, by counting; those of one
/// place stay in their order. `ends` tells where each place ends.
pub(super) fn sort_by_place(
    keys: &[ContactKey],
    (places, place): (usize, impl Fn(&ContactKey) -> usize),
    ends: &mut Vec<u32>,
    sorted: &mut Vec<ContactKey>,
) {
    ends.clear();
    ends.resize(places, 0);
    for key in keys {
        ends[place(key)] += 1;
    }
    let mut start = 0;
    for end in &mut *ends {
        start += std::mem::replace(end, start);
    }
    sorted.clear();
    sorted.extend_from_slice(keys);
    for key in keys {
        let end = &mut ends[place(key)];
        sorted[*end as usize] = *key;
        *end += 1;
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;
    use fastrand::Rng;

    use super::*;
    use crate::broad_phase::ProxyId;

    #[test]
    fn keys_are_sorted_whatever_their_number() {
        let mut world = World::new();
        let entities: Vec<_> = (0..1000).map(|_| world.spawn_empty().id()).collect();
        let mut sorter = Sorter::default();
        let mut rng = Rng::with_seed(4);
        for (known, count) in [
            (2, 0),
            (2, 3),
            (1000, 10),
            (1000, 125),
            (1000, 5000),
            (3, 9000),
        ] {
            let mut keys: Vec<ContactKey> = (0..count)
                .map(|_| {
                    let a = rng.usize(0..known - 1);
                    ContactKey {
                        a: entities[a],
                        b: entities[rng.usize(a + 1..known)],
                        ids: [rng.u32(0..2), rng.u32(2..4)].map(ProxyId::new),
                    }
                })
                .collect();
            let mut expected = keys.clone();
            expected.sort();
            sorter.sort(&mut keys, 0);
            assert_eq!(keys, expected);
        }
    }
}
