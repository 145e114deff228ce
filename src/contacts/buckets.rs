//! Contacts in buckets, by their first entity: for jobs that sort and enter them side by side.

use super::{order::sort_by_place, pair::ContactKey};

/// No more buckets than this, so that what each job of the exact tests found is cut into few pieces.
const MOST: u32 = 64;
/// The fewest entities to a bucket, so that there is work for a job.
const FEWEST_ENTITIES: u32 = 1024;

/// Which bucket the contacts of an entity are in: those of entities whose indices are near each
/// other are together. What comes out is the same in one bucket as in many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Buckets {
    /// By so many bits is the index of an entity larger than the number of its bucket.
    shift: u32,
    count: usize,
}

impl Buckets {
    /// One for all.
    pub(super) const ONE: Self = Self {
        shift: 31,
        count: 1,
    };

    /// Those for entities up to this index.
    pub(super) fn up_to(highest: u32) -> Self {
        let entities = (highest / MOST + 1).max(FEWEST_ENTITIES);
        let shift = entities.next_power_of_two().trailing_zeros();
        let count = (highest >> shift) as usize + 1;
        debug_assert!(count <= MOST as usize);
        Self { shift, count }
    }

    pub(super) const fn count(self) -> usize {
        self.count
    }

    /// The bucket of a contact: the last one, where there is none for so high an index.
    #[inline]
    pub(super) fn of(self, key: &ContactKey) -> usize {
        ((key.a.index_u32() >> self.shift) as usize).min(self.count - 1)
    }

    /// The lowest index of the entities of a bucket.
    pub(super) const fn first_entity(self, bucket: usize) -> usize {
        bucket << self.shift
    }
}

/// What one job of the exact tests has found, cut into buckets.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// In any order, until they are divided.
    keys: Vec<ContactKey>,
    divided: Vec<ContactKey>,
    /// By bucket: where it ends.
    ends: Vec<u32>,
}

impl Found {
    pub(super) fn clear(&mut self) {
        self.keys.clear();
        self.divided.clear();
        self.ends.clear();
    }

    pub(super) fn extend(&mut self, keys: impl Iterator<Item = ContactKey>) {
        self.keys.extend(keys);
    }

    /// Brings together what is in one bucket.
    pub(super) fn divide(&mut self, buckets: Buckets) {
        if buckets.count() > 1 {
            let places = (buckets.count(), |key: &ContactKey| buckets.of(key));
            sort_by_place(&self.keys, places, &mut self.ends, &mut self.divided);
        }
    }

    /// All of them.
    pub(super) fn all(&self) -> &[ContactKey] {
        &self.keys
    }

    /// Those of one bucket, once they are divided.
    pub(super) fn of(&self, bucket: usize) -> &[ContactKey] {
        if self.ends.is_empty() {
            // There is but one.
            return &self.keys;
        }
        let start = bucket.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.divided[start as usize..self.ends[bucket] as usize]
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;

    use super::*;
    use crate::broad_phase::ProxyId;

    #[test]
    fn each_key_is_in_one_bucket_and_buckets_ascend() {
        let mut rng = fastrand::Rng::with_seed(3);
        for highest in [1, 1023, 1024, 70_000, 1 << 20, u32::MAX - 1] {
            let buckets = if rng.bool() {
                Buckets::up_to(highest)
            } else {
                Buckets::ONE
            };
            let mut keys: Vec<_> = (0..500)
                .map(|_| {
                    // Some are higher than was said.
                    let index = rng.u32(0..=highest.saturating_add(highest / 8).min(u32::MAX - 1));
                    let entity = Entity::from_raw_u32(index).unwrap();
                    ContactKey {
                        a: entity,
                        b: entity,
                        ids: [rng.u32(0..9), 9].map(ProxyId::new),
                    }
                })
                .collect();
            let mut found = Found::default();
            found.extend(keys.iter().copied());
            found.divide(buckets);
            let mut in_buckets = Vec::new();
            for bucket in 0..buckets.count() {
                let mut of_one = found.of(bucket).to_vec();
                let first = buckets.first_entity(bucket);
                assert!(of_one.iter().all(|key| key.a.index_u32() as usize >= first));
                of_one.sort();
                in_buckets.extend(of_one);
            }
            keys.sort();
            assert_eq!(in_buckets, keys);
        }
    }
}
