//! Where those in contact lie on each other, of which somebody asked.

use super::pair::ContactPair;
use crate::narrow_phase::Manifold;

/// Those of a tick, in the order of keys.
#[derive(Clone, Debug, Default)]
pub(super) struct Manifolds {
    pub(super) known: Vec<(ContactPair, Manifold)>,
    /// Those of the last tick, while this one's are found.
    pub(super) last: Vec<(ContactPair, Manifold)>,
    /// By handle: who carries the marker.
    pub(super) enabled: Vec<bool>,
    /// The search for pairs that they were found for, by its number in the index.
    pub(super) search: u64,
}

impl Manifolds {
    /// That of a contact. O(log n).
    pub(super) fn find(&self, contact: &ContactPair) -> Option<Manifold> {
        let index = self
            .known
            .binary_search_by_key(&contact.key, |(known, _)| known.key)
            .ok()?;
        Some(self.known[index].1)
    }
}
