//! The boxes, the broad phase and the pairs, together.

use std::{any::Any, fmt, ops::Range};

use bevy::math::{bounding::Aabb3d, primitives::HalfSpace};

use super::{
    boxes::{BoxError, ProxyId},
    engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
    filter::{PairFilter, PairKinds},
    method::BroadPhaseMethod,
    pairs::{Pair, PairSet},
    proxy::{Proxies, part::ProxyPart},
};

/// An index over the boxes of objects: boxes in, overlapping pairs out, queries on the side.
///
/// See the [module's documentation](super) for an example.
#[doc(alias(
    "aabb tree",
    "bvh",
    "k-d tree",
    "spatial hash",
    "quadtree",
    "spatial partitioning"
))]
pub struct SpatialIndex {
    proxies: Proxies,
    engine: Box<dyn BroadPhase>,
    pairs: PairSet,
    pairs_tested: u64,
    /// How many updates there were.
    updates: u64,
    /// Have the pairs been searched for since the last update?
    searched: bool,
    /// Has an update been passed over without a search, so that the kept pairs are out of date?
    stale: bool,
}

impl SpatialIndex {
    /// Creates an empty index that searches by `method`.
    #[must_use]
    pub fn new(method: &BroadPhaseMethod) -> Self {
        Self::with_engine(method.engine())
    }

    /// Creates an empty index around an implementation of [`BroadPhase`], which must be empty too.
    #[must_use]
    pub fn with_engine(engine: Box<dyn BroadPhase>) -> Self {
        Self {
            proxies: Proxies::default(),
            engine,
            pairs: PairSet::default(),
            pairs_tested: 0,
            updates: 0,
            searched: true,
            stale: false,
        }
    }

    /// Searches by another method from now on. All objects stay, and take part in the next update
    /// as if they had just been inserted.
    pub fn set_method(&mut self, method: &BroadPhaseMethod) {
        self.set_engine(method.engine());
    }

    /// As [`set_method`](Self::set_method), with an implementation of one's own, which must be
    /// empty.
    pub fn set_engine(&mut self, engine: Box<dyn BroadPhase>) {
        self.engine = engine;
        self.proxies.touch_all();
    }

    /// Returns the broad phase at work.
    #[must_use]
    pub fn engine(&self) -> &dyn BroadPhase {
        &*self.engine
    }

    /// Returns the broad phase at work, if it is of this type: to look into an
    /// [`ObjectOctree`](super::ObjectOctree), say.
    #[must_use]
    pub fn engine_as<E: BroadPhase>(&self) -> Option<&E> {
        let engine: &dyn Any = &*self.engine;
        engine.downcast_ref()
    }

    /// Returns the boxes, as of now: changes that await an update included.
    #[must_use]
    pub const fn proxies(&self) -> &Proxies {
        &self.proxies
    }

    /// Adds an object. O(1) here; it costs its share at the next update.
    ///
    /// # Errors
    /// A box that is not finite or inverted is refused, and nothing changes.
    pub fn insert(&mut self, aabb: Aabb3d) -> Result<ProxyId, BoxError> {
        self.proxies.insert(aabb)
    }

    /// Gives an object its box of this tick. Setting the box that it already has is no change.
    /// O(1).
    ///
    /// # Errors
    /// A box that is not finite or inverted, and an unknown handle, are refused, and nothing
    /// changes.
    #[inline]
    pub fn set(&mut self, id: ProxyId, aabb: &Aabb3d) -> Result<(), BoxError> {
        self.proxies.set(id, aabb)
    }

    /// The parts of the proxies behind some ranges of handles, which ascend and do not overlap: for
    /// jobs to renew boxes side by side.
    pub(crate) fn parts<'a>(
        &'a mut self,
        ranges: impl Iterator<Item = Range<usize>> + 'a,
    ) -> impl Iterator<Item = ProxyPart<'a>> {
        self.proxies.parts(ranges)
    }

    /// Takes note of what the jobs have renewed, in the order in which it is to count as moved.
    pub(crate) fn note_moved(&mut self, moved: &[ProxyId]) {
        self.proxies.note_moved(moved);
    }

    /// Adds an unbounded object, one without an end and so without a box: a ground plane, with the
    /// half-space that it fills; or `None` for one that may be anywhere. It makes a pair with every
    /// box that has a part in the half-space, and with no other unbounded object; queries find it
    /// at a distance of 0, wherever they look, and leave the rest to the caller.
    ///
    /// Meant for a handful: each costs its look at every object that moves, and at all when it
    /// moves itself.
    ///
    /// # Errors
    /// [`BoxError::Full`].
    pub fn insert_unbounded(&mut self, side: Option<HalfSpace>) -> Result<ProxyId, BoxError> {
        self.proxies.insert_unbounded(side)
    }

    /// Says where an unbounded object is in this tick. O(unbounded objects).
    ///
    /// # Errors
    /// A handle that is not that of an unbounded object is refused, and nothing changes.
    pub fn set_unbounded(&mut self, id: ProxyId, side: Option<HalfSpace>) -> Result<(), BoxError> {
        self.proxies.set_unbounded(id, side)
    }

    /// Counts an object as moved though its box stays: it may have turned inside it. False if there
    /// is none.
    pub fn touch(&mut self, id: ProxyId) -> bool {
        self.proxies.touch(id)
    }

    /// Counts all objects as moved. O(n).
    pub fn touch_all(&mut self) {
        self.proxies.touch_all();
    }

    /// Has what moved in the last update count as moved in the next one too: for whoever searched
    /// for pairs and did not look at them.
    pub(crate) fn touch_moved(&mut self) {
        self.proxies.touch_moved();
    }

    /// Says what an object is, and what it may meet; by default, everything. Overlapping boxes of
    /// objects that do not admit each other make no pair. O(1); the object counts as moved if this
    /// is a change.
    ///
    /// # Errors
    /// An unknown handle is refused, and nothing changes.
    pub fn set_filter(&mut self, id: ProxyId, filter: PairFilter) -> Result<(), BoxError> {
        self.proxies.set_filter(id, filter)
    }

    /// Says where an object stands among those that are alike in all else: of several that are as near, a
    /// query takes the one of the lowest order, and of these that of the lowest handle. By default, 0. It
    /// changes nothing about pairs. O(1).
    ///
    /// # Errors
    /// An unknown handle is refused, and nothing changes.
    pub fn set_order(&mut self, id: ProxyId, order: u64) -> Result<(), BoxError> {
        self.proxies.set_order(id, order)
    }

    /// Says which kinds of pairs are sought. Nothing happens if they are those already; otherwise
    /// all objects count as moved, and O(n).
    pub fn set_pair_kinds(&mut self, kinds: PairKinds) {
        self.proxies.set_pair_kinds(kinds);
    }

    /// Removes an object. False if there is none. O(1).
    pub fn remove(&mut self, id: ProxyId) -> bool {
        self.proxies.remove(id)
    }

    /// How many updates there were.
    pub(crate) const fn updates(&self) -> u64 {
        self.updates
    }

    /// One maintenance step: brings the broad phase up to date with every change since the last.
    /// Costs nothing for objects that did not change.
    pub fn update(&mut self) {
        self.stale |= !self.searched;
        self.searched = false;
        self.updates += 1;
        self.proxies.begin_update();
        self.engine.maintain(&self.proxies);
    }

    /// Returns every pair of boxes that overlapped at the last [`update`](Self::update), touching
    /// included, each once. Searched for at the first call after an update; further calls cost
    /// nothing. If boxes changed since, an update comes first.
    pub fn find_pairs(&mut self) -> &PairSet {
        if self.proxies.has_pending() {
            self.update();
        }
        if self.stale {
            // What moved in an update that nobody searched after is not known any more: all pairs
            // are sought anew.
            self.pairs.clear();
            self.proxies.touch_all();
            self.update();
            self.stale = false;
        }
        if !self.searched {
            let found = self.pairs.begin(&self.proxies);
            self.pairs_tested = self.engine.find_pairs(&self.proxies, found);
            self.pairs_tested += self.proxies.find_unbounded_pairs(found);
            if self.proxies.are_filtered() && !self.engine.asks_filters() {
                self.pairs.filter(&self.proxies);
            }
            self.searched = true;
        }
        &self.pairs
    }

    /// Returns the pairs that the last [`find_pairs`](Self::find_pairs) gave.
    #[must_use]
    pub const fn pairs(&self) -> &PairSet {
        &self.pairs
    }

    /// Returns how many pairs of boxes the last search compared.
    #[must_use]
    pub const fn pairs_tested(&self) -> u64 {
        self.pairs_tested
    }

    /// Lets a visitor walk through the index as of the last update: see [`BroadPhase::traverse`].
    pub fn traverse(&self, visitor: &mut dyn Visitor) {
        self.engine.traverse(&self.proxies, visitor);
    }

    /// Calls `found` with every leaf of the broad phase's tree, as of the last update: see
    /// [`BroadPhase::for_each_leaf`]. Takes time linear in the size of the tree.
    pub fn for_each_leaf(&self, mut found: impl FnMut(Leaf)) {
        self.engine.for_each_leaf(&mut found);
    }

    /// Returns figures about the broad phase. Takes time linear in its size.
    #[must_use]
    pub fn stats(&self) -> BroadPhaseStats {
        self.engine.stats()
    }

    /// Returns the memory taken by boxes, broad phase and pairs, in bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.proxies.memory_bytes() + self.stats().bytes + self.pairs.memory_bytes()
    }
}

impl Proxies {
    /// Appends every pair of an unbounded object and a box that may meet, of which at least one
    /// moved, and which admit each other; each once. Returns the number of pairs compared. For each
    /// unbounded object, linear in those that moved, or in all if it moved itself.
    fn find_unbounded_pairs(&self, pairs: &mut Vec<Pair>) -> u64 {
        let mut compared = 0;
        for unbounded in &self.unbounded {
            let mut compare = |id, aabb| {
                compared += 1;
                if unbounded.may_meet(aabb) && self.admits(unbounded.id, id) {
                    pairs.push(Pair::new(unbounded.id, id));
                }
            };
            if self.is_moved(unbounded.id) {
                self.iter().for_each(|(id, aabb)| compare(id, aabb));
            } else {
                self.moved()
                    .iter()
                    .filter_map(|id| Some((*id, self.get(*id)?)))
                    .for_each(|(id, aabb)| compare(id, aabb));
            }
        }
        compared
    }
}

impl Default for SpatialIndex {
    fn default() -> Self {
        Self::new(&BroadPhaseMethod::default())
    }
}

impl fmt::Debug for SpatialIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SpatialIndex")
            .field("engine", &self.engine.name())
            .field("objects", &self.proxies.len())
            .field("pairs", &self.pairs.len())
            .field("stats", &self.stats())
            .finish()
    }
}
