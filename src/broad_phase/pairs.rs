//! Candidate pairs, and how they live on from tick to tick.

use bevy::prelude::Reflect;

use super::{boxes::ProxyId, proxy::Proxies};

/// Two objects whose boxes overlap; the lower handle first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[type_path = "bevy_octree"]
pub struct Pair {
    /// The lower handle.
    pub a: ProxyId,
    /// The higher handle.
    pub b: ProxyId,
}

impl Pair {
    /// Returns the pair of two distinct objects, in any order.
    ///
    /// # Panics
    /// In builds with debug assertions, if they are the same.
    #[inline]
    #[must_use]
    pub fn new(a: ProxyId, b: ProxyId) -> Self {
        debug_assert_ne!(a, b, "an object makes no pair with itself");
        if a < b {
            Self { a, b }
        } else {
            Self { a: b, b: a }
        }
    }

    /// Returns a number that orders pairs as the pairs themselves are ordered.
    #[inline]
    #[must_use]
    pub const fn key(self) -> u64 {
        (self.a.get() as u64) << 32 | self.b.get() as u64
    }
}

/// All pairs of overlapping boxes, each once.
///
/// They come in two lists. A pair is *moving* if one of its objects was inserted, moved or touched
/// in the last tick, and *resting* otherwise. Only moving pairs can have changed their exact
/// verdict, so that whoever keeps the verdicts of the last tick need look at no others; and a broad
/// phase need search only for them.
#[derive(Clone, Debug, Default)]
pub struct PairSet {
    moving: Vec<Pair>,
    resting: Vec<Pair>,
}

impl PairSet {
    /// Returns the pairs with an object that moved, in an order that depends on nothing but the
    /// history of the boxes.
    #[inline]
    #[must_use]
    pub fn moving(&self) -> &[Pair] {
        &self.moving
    }

    /// Returns the pairs of which neither object moved.
    #[inline]
    #[must_use]
    pub fn resting(&self) -> &[Pair] {
        &self.resting
    }

    /// Returns all pairs, the moving ones first.
    pub fn iter(&self) -> impl Iterator<Item = Pair> {
        self.moving.iter().chain(&self.resting).copied()
    }

    /// Returns the number of pairs.
    #[inline]
    #[must_use]
    pub const fn len(&self) -> usize {
        self.moving.len() + self.resting.len()
    }

    /// Returns `true` if there is no pair.
    #[inline]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Forgets all pairs, and keeps the memory.
    pub fn clear(&mut self) {
        self.moving.clear();
        self.resting.clear();
    }

    /// Returns the memory taken, in bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        (self.moving.capacity() + self.resting.capacity()) * size_of::<Pair>()
    }

    /// Drops moving pairs whose objects do not admit each other.
    pub(super) fn filter(&mut self, proxies: &Proxies) {
        self.moving.retain(|pair| proxies.admits(pair.a, pair.b));
    }

    /// Sorts last tick's pairs into those that rest now and those that a broad phase finds again,
    /// if they are still pairs; returns the list to push the latter to. Takes time only for pairs,
    /// and none where those that moved go on moving, and those that rest go on resting.
    pub(super) fn begin(&mut self, proxies: &Proxies) -> &mut Vec<Pair> {
        let rests = |pair: &Pair| proxies.is_resting(pair.a) && proxies.is_resting(pair.b);
        if proxies.all_moved() {
            self.resting.clear();
        } else {
            if proxies.some_woke() {
                self.resting.retain(rests);
            }
            if proxies.some_slept() {
                self.resting
                    .extend(self.moving.iter().copied().filter(rests));
            }
        }
        self.moving.clear();
        &mut self.moving
    }
}
