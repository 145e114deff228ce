//! Proxies: the boxes of the objects, behind stable handles.

use bevy::math::{bounding::Aabb3d, primitives::HalfSpace};

use super::{
    boxes::{BoxError, EVERYWHERE, ProxyId, check_box, is_box},
    filter::{PairFilter, PairKinds},
    unbounded::Unbounded,
};

const ALIVE: u8 = 1;
/// Changed since the last update.
const PENDING: u8 = 2;
/// Changed between the last two updates: what the current pairs are about.
const MOVED: u8 = 4;
/// Unbounded: without an end, and so without a box.
const UNBOUNDED: u8 = 8;
/// The filter changed since the last update.
const REFILTERED: u8 = 16;

/// The boxes of all objects, and which of them changed.
///
/// Unbounded objects have a handle too, but no box: they are in none of the lists, and no concern of a broad phase.
///
/// An implementation of [`BroadPhase`](super::BroadPhase) reads this and never writes it.
#[derive(Clone, Debug, Default)]
pub struct Proxies {
    boxes: Vec<Aabb3d>,
    flags: Vec<u8>,
    /// Empty as long as no filter was set.
    filters: Vec<PairFilter>,
    kinds: PairKinds,
    /// Whose filter changed since the last update, and between the last two.
    pending_filters: Vec<ProxyId>,
    changed_filters: Vec<ProxyId>,
    pending: Vec<ProxyId>,
    moved: Vec<ProxyId>,
    /// Removed since the last update, removed before it, and free.
    dying: Vec<ProxyId>,
    dead: Vec<ProxyId>,
    free: Vec<ProxyId>,
    alive: usize,
    /// How many of `moved` are still there.
    alive_moved: usize,
    /// Did an object come or go between the last two updates?
    population_changed: bool,
    /// And since the last update?
    population_is_changing: bool,
    /// Did an object move, or go, that had not moved in the update before? And the other way round?
    some_woke: bool,
    some_slept: bool,
    /// The unbounded ones, and those of them that were removed since the last update.
    pub(super) unbounded: Vec<Unbounded>,
    unbounded_pending: bool,
}

impl Proxies {
    /// The number of objects that have a box.
    #[inline]
    #[must_use]
    pub const fn len(&self) -> usize {
        self.alive
    }

    /// Is there no object that has a box?
    #[inline]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.alive == 0
    }

    /// One more than the largest index in use: the length of arrays that run parallel to the proxies.
    #[inline]
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.boxes.len()
    }

    /// Is there an object with this handle?
    #[inline]
    #[must_use]
    pub fn contains(&self, id: ProxyId) -> bool {
        self.flags.get(id.index()).is_some_and(|f| f & ALIVE != 0)
    }

    /// The box of an object, or `None` if there is no such object, or it is unbounded.
    #[inline]
    #[must_use]
    pub fn get(&self, id: ProxyId) -> Option<&Aabb3d> {
        let has_box = self.flags.get(id.index()).is_some_and(|f| f & (ALIVE | UNBOUNDED) == ALIVE);
        has_box.then(|| &self.boxes[id.index()])
    }

    /// The unbounded objects.
    pub fn unbounded(&self) -> impl Iterator<Item = ProxyId> {
        self.unbounded.iter().map(|unbounded| unbounded.id).filter(|id| self.contains(*id))
    }

    /// All boxes by index, those of removed objects included: for the inner loops of a broad phase.
    #[inline]
    #[must_use]
    pub fn boxes(&self) -> &[Aabb3d] {
        &self.boxes
    }

    /// What the object is, and what it may meet.
    #[inline]
    #[must_use]
    pub fn filter(&self, id: ProxyId) -> PairFilter {
        self.filters.get(id.index()).copied().unwrap_or_default()
    }

    /// The kinds of pairs that are sought.
    #[inline]
    #[must_use]
    pub const fn pair_kinds(&self) -> PairKinds {
        self.kinds
    }

    /// Do two objects make a pair, if their boxes overlap? They admit each other, and are of a kind that is sought.
    #[inline]
    #[must_use]
    pub fn admits(&self, a: ProxyId, b: ProxyId) -> bool {
        let (a, b) = (self.filter(a), self.filter(b));
        a.admits(&b) & self.kinds.include(&a, &b)
    }

    /// The objects whose filter changed between the last two updates; some may be gone, or listed more than once. All
    /// objects, if the [kinds of pairs](Self::pair_kinds) changed.
    #[inline]
    #[must_use]
    pub fn changed_filters(&self) -> &[ProxyId] {
        &self.changed_filters
    }

    /// Need pairs be asked whether they [admit](Self::admits) each other? Not as long as no filter was set, for then all
    /// objects are alike.
    #[inline]
    #[must_use]
    pub const fn are_filtered(&self) -> bool {
        !self.filters.is_empty() || !self.kinds.moving_moving
    }

    /// Was the object inserted, moved or touched between the last two updates?
    #[inline]
    #[must_use]
    pub fn is_moved(&self, id: ProxyId) -> bool {
        self.flags.get(id.index()).is_some_and(|f| f & (ALIVE | MOVED) == ALIVE | MOVED)
    }

    /// Has the object a part in the pairs of this tick without having moved?
    #[inline]
    #[must_use]
    pub fn is_resting(&self, id: ProxyId) -> bool {
        self.flags.get(id.index()).is_some_and(|f| f & (ALIVE | MOVED) == ALIVE)
    }

    /// The objects that were inserted, moved, touched or removed between the last two updates, each once, in the
    /// order of their first change. Those for which [`contains`](Self::contains) is false were removed.
    #[inline]
    #[must_use]
    pub fn moved(&self) -> &[ProxyId] {
        &self.moved
    }

    /// Did every object move between the last two updates?
    #[inline]
    #[must_use]
    pub const fn all_moved(&self) -> bool {
        self.alive_moved == self.alive
    }

    /// Returns `true` if more than half of the objects moved between the last two updates.
    pub(super) const fn most_moved(&self) -> bool {
        self.moved.len() * 2 > self.alive
    }

    /// Was an object inserted or removed between the last two updates?
    #[inline]
    #[must_use]
    pub const fn population_changed(&self) -> bool {
        self.population_changed
    }

    /// Did an object move between the last two updates that had not moved between the two before? Objects that came
    /// or went count.
    #[inline]
    #[must_use]
    pub const fn some_woke(&self) -> bool {
        self.some_woke
    }

    /// Did an object rest between the last two updates that had moved between the two before?
    #[inline]
    #[must_use]
    pub const fn some_slept(&self) -> bool {
        self.some_slept
    }

    /// Are there changes that no update has taken up yet?
    #[inline]
    #[must_use]
    pub const fn has_pending(&self) -> bool {
        !self.pending.is_empty() || self.unbounded_pending
    }

    /// All objects that have a box, by ascending handle. O(capacity).
    pub fn iter(&self) -> impl Iterator<Item = (ProxyId, &Aabb3d)> + Clone {
        let has_box = |flags: &u8| flags & (ALIVE | UNBOUNDED) == ALIVE;
        (0..).map(ProxyId::new).zip(&self.boxes).zip(&self.flags).filter(move |(_, f)| has_box(f)).map(|(item, _)| item)
    }

    /// The memory taken, in bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let filters = [&self.pending_filters, &self.changed_filters];
        let lists = [&self.pending, &self.moved, &self.dying, &self.dead, &self.free].into_iter().chain(filters);
        self.boxes.capacity() * size_of::<Aabb3d>()
            + self.flags.capacity()
            + self.filters.capacity() * size_of::<PairFilter>()
            + self.unbounded.capacity() * size_of::<Unbounded>()
            + lists.map(|list| list.capacity() * size_of::<ProxyId>()).sum::<usize>()
    }

    pub(super) fn insert(&mut self, aabb: Aabb3d) -> Result<ProxyId, BoxError> {
        check_box(&aabb)?;
        let id = self.allocate(aabb, ALIVE)?;
        self.alive += 1;
        self.population_is_changing = true;
        Ok(id)
    }

    pub(super) fn insert_unbounded(&mut self, side: Option<HalfSpace>) -> Result<ProxyId, BoxError> {
        let id = self.allocate(EVERYWHERE, ALIVE | UNBOUNDED)?;
        self.unbounded.push(Unbounded { id, side });
        Ok(id)
    }

    /// A handle for a new object.
    fn allocate(&mut self, aabb: Aabb3d, flags: u8) -> Result<ProxyId, BoxError> {
        let id = match self.free.pop() {
            Some(id) => {
                self.boxes[id.index()] = aabb;
                id
            }
            None => {
                let index = u32::try_from(self.boxes.len()).ok().filter(|i| *i != u32::MAX).ok_or(BoxError::Full)?;
                self.boxes.push(aabb);
                self.flags.push(0);
                ProxyId::new(index)
            }
        };
        self.flags[id.index()] = flags;
        if let Some(filter) = self.filters.get_mut(id.index()) {
            *filter = PairFilter::default();
        }
        self.mark(id);
        Ok(id)
    }

    #[inline]
    pub(super) fn set(&mut self, id: ProxyId, aabb: &Aabb3d) -> Result<(), BoxError> {
        let (Some(flags), Some(old)) = (self.flags.get_mut(id.index()), self.boxes.get_mut(id.index())) else {
            return Err(self.refusal(id, aabb));
        };
        // Most common first: the same box again, which is known to be a good one.
        let is_same = old.min.cmpeq(aabb.min) & old.max.cmpeq(aabb.max);
        let has_box = *flags & (ALIVE | UNBOUNDED) == ALIVE;
        if is_same.all() && has_box {
            return Ok(());
        }
        if !is_box(aabb) || !has_box {
            return Err(self.refusal(id, aabb));
        }
        *old = *aabb;
        if *flags & PENDING == 0 {
            *flags |= PENDING;
            self.pending.push(id);
        }
        Ok(())
    }

    /// Why a box is not taken.
    #[cold]
    fn refusal(&self, id: ProxyId, aabb: &Aabb3d) -> BoxError {
        check_box(aabb).err().unwrap_or(BoxError::UnknownProxy(id))
    }

    /// Says where an unbounded object is.
    pub(super) fn set_unbounded(&mut self, id: ProxyId, side: Option<HalfSpace>) -> Result<(), BoxError> {
        let place = self.unbounded.iter_mut().find(|unbounded| unbounded.id == id);
        let Some(unbounded) = place.filter(|unbounded| self.flags[unbounded.id.index()] & ALIVE != 0) else {
            return Err(BoxError::UnknownProxy(id));
        };
        if unbounded.side != side {
            unbounded.side = side;
            self.mark(id);
        }
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
            let flags = &mut self.flags[id.index()];
            if *flags & (UNBOUNDED | REFILTERED) == 0 {
                *flags |= REFILTERED;
                self.pending_filters.push(id);
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
            self.pending_filters.clone_from(&self.pending);
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
            if self.flags[index] & ALIVE != 0 {
                self.mark(ProxyId::new(index as u32));
            }
        }
    }

    /// Has what moved in the last update count as moved in the next one too.
    pub(super) fn touch_moved(&mut self) {
        for place in 0..self.moved.len() {
            self.touch(self.moved[place]);
        }
        for place in 0..self.unbounded.len() {
            let id = self.unbounded[place].id;
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
        *flags &= !ALIVE;
        if *flags & UNBOUNDED == 0 {
            self.alive -= 1;
            self.population_is_changing = true;
        }
        self.mark(id);
        self.dying.push(id);
        true
    }

    /// Makes the pending changes the current ones.
    pub(super) fn begin_update(&mut self) {
        let mut slept = 0;
        for id in self.moved.drain(..) {
            let flags = &mut self.flags[id.index()];
            let goes_on = *flags & PENDING != 0;
            slept |= *flags & ALIVE & !u8::from(goes_on);
            *flags &= if goes_on { !0 } else { !MOVED };
        }
        self.some_slept = slept != 0;
        std::mem::swap(&mut self.moved, &mut self.pending);
        self.alive_moved = 0;
        let mut moved_before = MOVED;
        for id in &self.moved {
            let flags = &mut self.flags[id.index()];
            moved_before &= *flags;
            *flags = *flags & ALIVE | MOVED;
            self.alive_moved += usize::from(*flags & ALIVE);
        }
        self.some_woke = moved_before == 0;
        self.update_unbounded();
        self.changed_filters.clear();
        std::mem::swap(&mut self.changed_filters, &mut self.pending_filters);
        self.population_changed = std::mem::take(&mut self.population_is_changing);
        self.free.append(&mut self.dead);
        std::mem::swap(&mut self.dead, &mut self.dying);
    }

    fn update_unbounded(&mut self) {
        self.unbounded_pending = false;
        self.unbounded.retain(|unbounded| {
            let flags = &mut self.flags[unbounded.id.index()];
            let (moved_before, moves) = (*flags & MOVED != 0, *flags & PENDING != 0);
            let is_alive = *flags & ALIVE != 0;
            // Of a removed one, no pair rests any longer.
            self.some_woke |= !is_alive || moves && !moved_before;
            self.some_slept |= moved_before && !moves;
            *flags = *flags & (ALIVE | UNBOUNDED) | if moves { MOVED } else { 0 };
            is_alive
        });
    }

    #[inline]
    fn mark(&mut self, id: ProxyId) {
        let flags = &mut self.flags[id.index()];
        if *flags & PENDING == 0 {
            *flags |= PENDING;
            if *flags & UNBOUNDED == 0 {
                self.pending.push(id);
            } else {
                self.unbounded_pending = true;
            }
        }
    }
}

#[cfg(test)]
mod tests;
