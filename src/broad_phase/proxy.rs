//! Proxies: the boxes of the objects, behind stable handles.

use bevy::math::{bounding::Aabb3d, primitives::HalfSpace};

use super::{
    boxes::{BoxError, EVERYWHERE, ProxyId, check_box, is_box},
    filter::{PairFilter, PairKinds},
    flags::Flags,
    unbounded::Unbounded,
};

pub(crate) mod part;

/// The boxes of all objects, and which of them changed.
///
/// Unbounded objects have a handle too, but no box: they are in none of the lists, and no concern
/// of a broad phase.
///
/// An implementation of [`BroadPhase`](super::BroadPhase) reads this and never writes it.
#[derive(Clone, Debug, Default)]
pub struct Proxies {
    boxes: Vec<Aabb3d>,
    flags: Vec<Flags>,
    /// Empty as long as no filter was set.
    filters: Vec<PairFilter>,
    /// Empty as long as no order was set.
    orders: Vec<u64>,
    /// Was one of them ever that of a detector?
    has_detectors: bool,
    /// Was one of them ever that of a part of a body?
    has_bodies: bool,
    kinds: PairKinds,
    /// Objects with a box that were inserted, moved, touched or removed.
    moved: Changes,
    /// Objects with a box whose filter changed.
    refiltered: Changes,
    handles: Handles,
    /// How many objects there are that have a box, and how many of these have moved.
    alive: usize,
    alive_moved: usize,
    /// Did an object come or go since the last update, and between the last two?
    population_is_changing: bool,
    population_changed: bool,
    /// Did an object move, or go, that had not moved in the update before? And the other way round?
    some_woke: bool,
    some_slept: bool,
    /// The unbounded objects, and those of them that were removed since the last update.
    pub(super) unbounded: Vec<Unbounded>,
    unbounded_pending: bool,
}

/// A list of what changed since the last update, and one of what changed between the last two.
#[derive(Clone, Debug, Default)]
struct Changes {
    pending: Vec<ProxyId>,
    current: Vec<ProxyId>,
}

impl Changes {
    /// Makes the pending changes the current ones.
    fn advance(&mut self) {
        self.current.clear();
        std::mem::swap(&mut self.current, &mut self.pending);
    }
}

/// Handles that no object has.
#[derive(Clone, Debug, Default)]
struct Handles {
    /// Those whose objects were removed since the last update.
    dying: Vec<ProxyId>,
    /// Those whose objects were removed between the last two updates.
    dead: Vec<ProxyId>,
    /// Those that may be handed out again.
    free: Vec<ProxyId>,
}

impl Handles {
    fn advance(&mut self) {
        self.free.append(&mut self.dead);
        std::mem::swap(&mut self.dead, &mut self.dying);
    }
}

impl Proxies {
    /// Returns the number of objects that have a box.
    #[inline]
    #[must_use]
    pub const fn len(&self) -> usize {
        self.alive
    }

    /// Returns `true` if there is no object that has a box.
    #[inline]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.alive == 0
    }

    /// One more than the largest index in use: the length of arrays that run parallel to the
    /// proxies.
    #[inline]
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.boxes.len()
    }

    /// Returns `true` if there is an object with this handle.
    #[inline]
    #[must_use]
    pub fn contains(&self, id: ProxyId) -> bool {
        self.flags
            .get(id.index())
            .is_some_and(|flags| flags.has(Flags::ALIVE))
    }

    /// Returns the box of an object, or `None` if there is no such object, or it is unbounded.
    #[inline]
    #[must_use]
    pub fn get(&self, id: ProxyId) -> Option<&Aabb3d> {
        let has_box = self
            .flags
            .get(id.index())
            .is_some_and(|flags| flags.has_box());
        has_box.then(|| &self.boxes[id.index()])
    }

    /// Returns the unbounded objects.
    pub fn unbounded(&self) -> impl Iterator<Item = ProxyId> {
        self.unbounded
            .iter()
            .map(|unbounded| unbounded.id)
            .filter(|id| self.contains(*id))
    }

    /// Returns all boxes by index, those of removed objects included: for the inner loops of a
    /// broad phase.
    #[inline]
    #[must_use]
    pub fn boxes(&self) -> &[Aabb3d] {
        &self.boxes
    }

    /// Returns what the object is, and what it may meet.
    #[inline]
    #[must_use]
    pub fn filter(&self, id: ProxyId) -> PairFilter {
        self.filters.get(id.index()).copied().unwrap_or_default()
    }

    /// Returns where an object stands among those that are alike in all else, as two that are as near to
    /// a point: by its [order](super::SpatialIndex::set_order), then by its handle.
    #[inline]
    #[must_use]
    pub fn order(&self, id: ProxyId) -> (u64, ProxyId) {
        (self.orders.get(id.index()).copied().unwrap_or(0), id)
    }

    /// Returns the kinds of pairs that are sought.
    #[inline]
    #[must_use]
    pub const fn pair_kinds(&self) -> PairKinds {
        self.kinds
    }

    /// Returns `true` if two objects make a pair, should their boxes overlap. They admit each
    /// other, and are of a kind that is sought.
    #[inline]
    #[must_use]
    pub fn admits(&self, a: ProxyId, b: ProxyId) -> bool {
        let (a, b) = (self.filter(a), self.filter(b));
        a.admits(&b) & self.kinds.include(&a, &b)
    }

    /// Returns the objects whose filter changed between the last two updates; some may be gone, or
    /// listed more than once. All objects, if the [kinds of pairs](Self::pair_kinds) changed.
    #[inline]
    #[must_use]
    pub fn changed_filters(&self) -> &[ProxyId] {
        &self.refiltered.current
    }

    /// Returns `true` if pairs must be asked whether they [admit](Self::admits) each other. Not as
    /// long as no filter was set, for then all objects are alike.
    #[inline]
    #[must_use]
    pub const fn are_filtered(&self) -> bool {
        !self.filters.is_empty() || !self.kinds.moving_moving
    }

    /// Returns `true` if one of the objects may be a [detector](PairFilter::is_detector).
    #[inline]
    #[must_use]
    pub const fn has_detectors(&self) -> bool {
        self.has_detectors
    }

    /// Returns `true` if one of the objects may be a [part of a body](PairFilter::body).
    #[inline]
    #[must_use]
    pub const fn has_bodies(&self) -> bool {
        self.has_bodies
    }

    /// Returns `true` if the object was inserted, moved or touched between the last two updates.
    #[inline]
    #[must_use]
    pub fn is_moved(&self, id: ProxyId) -> bool {
        self.flags
            .get(id.index())
            .is_some_and(|flags| flags.is_moved())
    }

    /// Returns `true` if the object has a part in the pairs of this tick without having moved.
    #[inline]
    #[must_use]
    pub fn is_resting(&self, id: ProxyId) -> bool {
        self.flags
            .get(id.index())
            .is_some_and(|flags| flags.is_resting())
    }

    /// Returns the objects that were inserted, moved, touched or removed between the last two
    /// updates, each once, in the order of their first change. Those for which
    /// [`contains`](Self::contains) is false were removed.
    #[inline]
    #[must_use]
    pub fn moved(&self) -> &[ProxyId] {
        &self.moved.current
    }

    /// Returns `true` if every object moved between the last two updates.
    #[inline]
    #[must_use]
    pub const fn all_moved(&self) -> bool {
        self.alive_moved == self.alive
    }

    /// Returns `true` if more than half of the objects moved between the last two updates.
    pub(super) const fn most_moved(&self) -> bool {
        self.moved.current.len() * 2 > self.alive
    }

    /// Returns `true` if an object was inserted or removed between the last two updates.
    #[inline]
    #[must_use]
    pub const fn population_changed(&self) -> bool {
        self.population_changed
    }

    /// Returns `true` if an object moved between the last two updates that had not moved between
    /// the two before. Objects that came or went count.
    #[inline]
    #[must_use]
    pub const fn some_woke(&self) -> bool {
        self.some_woke
    }

    /// Returns `true` if an object rested between the last two updates that had moved between the
    /// two before.
    #[inline]
    #[must_use]
    pub const fn some_slept(&self) -> bool {
        self.some_slept
    }

    /// Returns `true` if there are changes that no update has seen yet.
    #[inline]
    #[must_use]
    pub const fn has_pending(&self) -> bool {
        !self.moved.pending.is_empty() || self.unbounded_pending
    }

    /// Returns all objects that have a box, by ascending handle. O(capacity).
    pub fn iter(&self) -> impl Iterator<Item = (ProxyId, &Aabb3d)> + Clone {
        (0..)
            .map(ProxyId::new)
            .zip(&self.boxes)
            .zip(&self.flags)
            .filter(|(_, flags)| flags.has_box())
            .map(|(item, _)| item)
    }

    /// Returns the memory taken, in bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let changes = [&self.moved, &self.refiltered]
            .into_iter()
            .flat_map(|list| [&list.pending, &list.current]);
        let lists = changes.chain([&self.handles.dying, &self.handles.dead, &self.handles.free]);
        self.boxes.capacity() * size_of::<Aabb3d>()
            + self.flags.capacity() * size_of::<Flags>()
            + self.filters.capacity() * size_of::<PairFilter>()
            + self.orders.capacity() * size_of::<u64>()
            + self.unbounded.capacity() * size_of::<Unbounded>()
            + lists
                .map(|list| list.capacity() * size_of::<ProxyId>())
                .sum::<usize>()
    }

    pub(super) fn insert(&mut self, aabb: Aabb3d) -> Result<ProxyId, BoxError> {
        check_box(&aabb)?;
        let id = self.allocate(aabb, Flags::ALIVE)?;
        self.alive += 1;
        self.population_is_changing = true;
        Ok(id)
    }

    pub(super) fn insert_unbounded(
        &mut self,
        side: Option<HalfSpace>,
    ) -> Result<ProxyId, BoxError> {
        let id = self.allocate(EVERYWHERE, Flags::ALIVE.with(Flags::UNBOUNDED))?;
        self.unbounded.push(Unbounded { id, side });
        Ok(id)
    }

    /// A handle for a new object.
    fn allocate(&mut self, aabb: Aabb3d, flags: Flags) -> Result<ProxyId, BoxError> {
        let id = match self.handles.free.pop() {
            Some(id) => {
                self.boxes[id.index()] = aabb;
                id
            }
            None => {
                let index = u32::try_from(self.boxes.len())
                    .ok()
                    .filter(|i| *i != u32::MAX)
                    .ok_or(BoxError::Full)?;
                self.boxes.push(aabb);
                self.flags.push(Flags::default());
                ProxyId::new(index)
            }
        };
        self.flags[id.index()] = flags;
        if let Some(filter) = self.filters.get_mut(id.index()) {
            *filter = PairFilter::default();
        }
        if let Some(order) = self.orders.get_mut(id.index()) {
            *order = 0;
        }
        self.mark(id);
        Ok(id)
    }

    #[inline]
    pub(super) fn set(&mut self, id: ProxyId, aabb: &Aabb3d) -> Result<(), BoxError> {
        let (Some(flags), Some(old)) = (
            self.flags.get_mut(id.index()),
            self.boxes.get_mut(id.index()),
        ) else {
            return Err(self.refusal(id, aabb));
        };
        // Most common first: the same box again, which is known to be a good one.
        let is_same = old.min.cmpeq(aabb.min) & old.max.cmpeq(aabb.max);
        let has_box = flags.has_box();
        if is_same.all() && has_box {
            return Ok(());
        }
        if !is_box(aabb) || !has_box {
            return Err(self.refusal(id, aabb));
        }
        *old = *aabb;
        if !flags.has(Flags::PENDING) {
            flags.set(Flags::PENDING);
            self.moved.pending.push(id);
        }
        Ok(())
    }

    /// Why a box is not taken.
    #[cold]
    fn refusal(&self, id: ProxyId, aabb: &Aabb3d) -> BoxError {
        check_box(aabb).err().unwrap_or(BoxError::UnknownProxy(id))
    }

    /// Says where an unbounded object is.
    pub(super) fn set_unbounded(
        &mut self,
        id: ProxyId,
        side: Option<HalfSpace>,
    ) -> Result<(), BoxError> {
        let found = self
            .unbounded
            .iter_mut()
            .find(|unbounded| unbounded.id == id);
        let Some(unbounded) = found.filter(|_| self.flags[id.index()].has(Flags::ALIVE)) else {
            return Err(BoxError::UnknownProxy(id));
        };
        if unbounded.side != side {
            unbounded.side = side;
            self.mark(id);
        }
        Ok(())
    }

    pub(super) fn set_order(&mut self, id: ProxyId, order: u64) -> Result<(), BoxError> {
        if !self.contains(id) {
            return Err(BoxError::UnknownProxy(id));
        }
        if self.orders.len() <= id.index() {
            self.orders.resize(self.boxes.len(), 0);
        }
        self.orders[id.index()] = order;
        Ok(())
    }

    /// Sets the filter of an object, which counts as moved if that is a change.
    pub(super) fn set_filter(&mut self, id: ProxyId, filter: PairFilter) -> Result<(), BoxError> {
        if !self.contains(id) {
            return Err(BoxError::UnknownProxy(id));
        }
        if filter != self.filter(id) {
            if self.filters.len() <= id.index() {
                self.filters.resize(self.boxes.len(), PairFilter::default());
            }
            self.filters[id.index()] = filter;
            self.has_detectors |= filter.is_detector;
            self.has_bodies |= filter.body != PairFilter::NO_BODY;
            let flags = &mut self.flags[id.index()];
            if !flags.has(Flags::UNBOUNDED.with(Flags::REFILTERED)) {
                flags.set(Flags::REFILTERED);
                self.refiltered.pending.push(id);
            }
            self.mark(id);
        }
        Ok(())
    }

    /// Sets the kinds of pairs that are sought. All objects count as moved if that is a change.
    pub(super) fn set_pair_kinds(&mut self, kinds: PairKinds) {
        if kinds != self.kinds {
            self.kinds = kinds;
            self.touch_all();
            self.refiltered.pending.clone_from(&self.moved.pending);
        }
    }

    pub(super) fn touch(&mut self, id: ProxyId) -> bool {
        let known = self.contains(id);
        if known {
            self.mark(id);
        }
        known
    }

    pub(super) fn touch_all(&mut self) {
        for index in 0..self.boxes.len() {
            if self.flags[index].has(Flags::ALIVE) {
                self.mark(ProxyId::new(index as u32));
            }
        }
    }

    /// Has what moved in the last update count as moved in the next one too.
    pub(super) fn touch_moved(&mut self) {
        for index in 0..self.moved.current.len() {
            self.touch(self.moved.current[index]);
        }
        for index in 0..self.unbounded.len() {
            let id = self.unbounded[index].id;
            if self.is_moved(id) {
                self.touch(id);
            }
        }
    }

    pub(super) fn remove(&mut self, id: ProxyId) -> bool {
        if !self.contains(id) {
            return false;
        }
        let flags = &mut self.flags[id.index()];
        flags.clear_unless(false, Flags::ALIVE);
        if !flags.has(Flags::UNBOUNDED) {
            self.alive -= 1;
            self.population_is_changing = true;
        }
        self.mark(id);
        self.handles.dying.push(id);
        true
    }

    /// Makes the pending changes the current ones.
    pub(super) fn begin_update(&mut self) {
        self.some_slept = self.end_moves();
        self.moved.advance();
        self.some_woke = self.begin_moves();
        self.update_unbounded();
        self.refiltered.advance();
        self.population_changed = std::mem::take(&mut self.population_is_changing);
        self.handles.advance();
    }

    /// Sees who moved until now, and rests from now on. Returns `true` if somebody does. Without a
    /// branch.
    fn end_moves(&mut self) -> bool {
        let mut some_slept = false;
        for id in &self.moved.current {
            let flags = &mut self.flags[id.index()];
            debug_assert!(flags.has(Flags::MOVED) && !flags.has(Flags::UNBOUNDED));
            let goes_on = flags.has(Flags::PENDING);
            some_slept |= flags.has(Flags::ALIVE) & !goes_on;
            flags.clear_unless(goes_on, Flags::MOVED);
        }
        some_slept
    }

    /// Sees who moves from now on, and counts them. Returns `true` if somebody did not before.
    /// Without a branch.
    fn begin_moves(&mut self) -> bool {
        let (mut some_woke, mut alive_moved) = (false, 0);
        for id in &self.moved.current {
            let flags = &mut self.flags[id.index()];
            debug_assert!(flags.has(Flags::PENDING) && !flags.has(Flags::UNBOUNDED));
            some_woke |= !flags.has(Flags::MOVED);
            *flags = flags.among(Flags::ALIVE).with(Flags::MOVED);
            alive_moved += usize::from(flags.has(Flags::ALIVE));
        }
        debug_assert!(alive_moved <= self.alive);
        self.alive_moved = alive_moved;
        some_woke
    }

    fn update_unbounded(&mut self) {
        self.unbounded_pending = false;
        self.unbounded.retain(|unbounded| {
            let flags = &mut self.flags[unbounded.id.index()];
            let (moved_before, moves) = (flags.has(Flags::MOVED), flags.has(Flags::PENDING));
            let is_alive = flags.has(Flags::ALIVE);
            // Of a removed one, no pair rests any longer.
            self.some_woke |= !is_alive || (moves && !moved_before);
            self.some_slept |= moved_before && !moves;
            let stays = flags.among(Flags::ALIVE.with(Flags::UNBOUNDED));
            *flags = if moves {
                stays.with(Flags::MOVED)
            } else {
                stays
            };
            is_alive
        });
    }

    #[inline]
    fn mark(&mut self, id: ProxyId) {
        let flags = &mut self.flags[id.index()];
        if !flags.has(Flags::PENDING) {
            flags.set(Flags::PENDING);
            if !flags.has(Flags::UNBOUNDED) {
                self.moved.pending.push(id);
            } else {
                self.unbounded_pending = true;
            }
        }
    }
}

#[cfg(test)]
mod tests;
