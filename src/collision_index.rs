//! The index as a resource: bodies behind handles, and the candidate pairs that come of them.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy::{
    ecs::{change_detection::Tick, entity::EntityHashMap},
    math::{
        bounding::{Aabb3d, BoundingVolume},
        primitives::HalfSpace,
    },
    prelude::*,
};

use crate::{
    broad_phase::{
        BroadPhase, BroadPhaseMethod, EVERYWHERE, Pair, PairFilter, PairKinds, ProxyId,
        SpatialIndex,
    },
    narrow_phase::{Fit, Moving, NarrowPhase, Placed, Shape},
};

pub(crate) mod follow;
mod order;
pub(crate) mod upkeep;

/// The [`SpatialIndex`] of all entities with a
/// [`CollisionShape`](crate::components::CollisionShape).
///
/// It may be taken out of the world for a while, or be replaced by another: at the next tick, or
/// [update](crate::spatial_query::update_spatial_index), it holds what it should.
#[doc(alias(
    "bvh",
    "spatial index",
    "spatial hash",
    "quadtree",
    "k-d tree",
    "octree"
))]
#[derive(Resource, Debug, Reflect)]
#[reflect(Debug, Default, from_reflect = false)]
#[type_path = "bevy_octree"]
pub struct CollisionIndex {
    #[reflect(ignore)]
    index: SpatialIndex,
    /// The method that was asked for last.
    method: BroadPhaseMethod,
    /// By proxy index. Entries of removed proxies stay until the proxy is handed out again.
    #[reflect(ignore)]
    bodies: Vec<Body>,
    /// By proxy index too, and by themselves: most pairs need no more of the bodies.
    #[reflect(ignore)]
    entities: Vec<Entity>,
    #[reflect(ignore)]
    fits: Vec<Fit>,
    /// Has one of them ever had a place of its own in the order of all?
    #[reflect(ignore)]
    is_ordered: bool,
    /// The places of those who had one of their own and are gone, of the last time and the time before:
    /// contacts with them are yet to end, here or once they are restored.
    #[reflect(ignore)]
    gone: [EntityHashMap<u64>; 2],
    /// By proxy index, as far as there are any: where the ways of swept bodies begin.
    #[reflect(ignore)]
    starts: Vec<Option<Transform>>,
    /// The highest index of an entity that was ever in.
    #[reflect(ignore)]
    highest_entity: u32,
    /// How many searches there were whose pairs are for the exact tests.
    #[reflect(ignore)]
    search: u64,
    /// How many updates there were until the last of them.
    #[reflect(ignore)]
    searched_at: u64,
    /// By proxy index: what had moved when pairs were last searched for. Empty as long as the boxes
    /// are those of the search, and say so themselves.
    #[reflect(ignore)]
    moved_at_search: Vec<bool>,
    /// When the pairs of the last search were handed out.
    #[reflect(ignore)]
    listed: Tick,
    /// What tells it from all others.
    #[reflect(ignore)]
    number: u64,
}

impl Default for CollisionIndex {
    fn default() -> Self {
        static NUMBER: AtomicU64 = AtomicU64::new(1);
        Self {
            index: SpatialIndex::default(),
            method: BroadPhaseMethod::default(),
            bodies: Vec::new(),
            entities: Vec::new(),
            fits: Vec::new(),
            is_ordered: false,
            gone: Default::default(),
            starts: Vec::new(),
            highest_entity: 0,
            search: 0,
            searched_at: 0,
            moved_at_search: Vec::new(),
            listed: Tick::default(),
            number: NUMBER.fetch_add(1, Ordering::Relaxed),
        }
    }
}

/// The place of an entity in the order of all, if it has none of its own: by its index, and then by its
/// generation.
#[inline]
pub(crate) const fn rank(entity: Entity) -> u64 {
    (entity.index_u32() as u64) << 32 | entity.generation().to_bits() as u64
}

/// A state of an index: what an update makes of the state before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct IndexState {
    index: u64,
    updates: u64,
}

impl IndexState {
    /// Is it the next one of the same index? What that says of who moved since the last update, is
    /// then all that moved in between.
    pub(crate) const fn follows(self, last: Self) -> bool {
        self.index == last.index && self.updates == last.updates + 1
    }
}

/// What the exact tests need of an entity, in one place: they visit entities in no order of memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) entity: Entity,
    pub(crate) pose: Transform,
    pub(crate) shape: Shape,
    /// When the entity's own shape became what it is here: one look at it spares that at the shape.
    pub(crate) reshaped: Tick,
}

impl Body {
    /// Brings the shape up to date with what takes part, which became what it is at that time,
    /// unless an ancestor shears it.
    #[cold]
    pub(crate) fn reshape(&mut self, shape: &Shape, reshaped: Tick) {
        self.reshaped = reshaped;
        if !self.shape.is_same(shape) {
            self.shape = shape.clone();
        }
    }

    /// The shape, where it is at the end of the tick.
    #[inline]
    pub(crate) const fn placed(&self) -> Placed<'_> {
        Placed {
            shape: &self.shape,
            transform: &self.pose,
        }
    }

    /// The shape on its way in this tick: at rest where it is, if it is not swept.
    fn moving(&self, start: Option<&Transform>) -> Moving<'_> {
        Moving::new(&self.shape, start.unwrap_or(&self.pose), &self.pose)
    }
}

/// The two of a pair, as the exact tests look at them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Candidate<'a> {
    /// Where they are at the end of the tick.
    AtTheEnd([Placed<'a>; 2]),
    /// All along their ways, since one of them is swept.
    OnTheWay([Moving<'a>; 2]),
}

/// Where an entity is, as the broad phase has it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Extent {
    /// In a box, which is refused if it is none.
    Box(Aabb3d),
    /// It is unbounded, and all in this half-space; `None` if it may be anywhere.
    Unbounded(Option<HalfSpace>),
}

/// All that the index is to know of an entity that is new in it, or in no box.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) body: Body,
    pub(crate) extent: Extent,
    /// Its own place in the order of all, if it has one.
    pub(crate) order: Option<u64>,
    /// Which pairs it makes, if it comes in; `None` if it is to stay out.
    pub(crate) filter: Option<PairFilter>,
    /// What its box says of it.
    pub(crate) fit: Fit,
}

impl CollisionIndex {
    /// Returns the boxes, the broad phase, and queries, by [`ProxyId`].
    #[must_use]
    pub const fn index(&self) -> &SpatialIndex {
        &self.index
    }

    /// Searches with a broad phase of one's own from the next tick on, until the method in the
    /// [`BroadPhaseSettings`](crate::settings::BroadPhaseSettings) changes. It must be empty.
    pub fn set_engine(&mut self, engine: Box<dyn BroadPhase>) {
        self.index.set_engine(engine);
    }

    /// Returns the entity behind a handle. For a handle that was removed, the entity that had it
    /// last.
    #[must_use]
    pub fn entity(&self, id: ProxyId) -> Option<Entity> {
        self.entities.get(id.index()).copied()
    }

    /// Returns the entities of a pair.
    ///
    /// # Panics
    /// If the pair is not of this index.
    #[must_use]
    pub fn entities(&self, pair: Pair) -> [Entity; 2] {
        [pair.a, pair.b].map(|id| self.entities[id.index()])
    }

    /// The highest index of an entity that was ever in.
    pub(crate) const fn highest_entity(&self) -> u32 {
        self.highest_entity
    }

    /// What is behind a handle, unless it was removed.
    pub(crate) fn body(&self, id: ProxyId) -> Option<&Body> {
        self.index
            .proxies()
            .contains(id)
            .then(|| &self.bodies[id.index()])
    }

    /// Two, as the exact tests are to look at them. `None` if one is gone: pairs may be older than
    /// that.
    #[inline]
    pub(crate) fn candidate(&self, ids: [ProxyId; 2]) -> Option<Candidate<'_>> {
        let (a, b) = (self.body(ids[0])?, self.body(ids[1])?);
        Some(match ids.map(|id| self.start(id)) {
            [None, None] => Candidate::AtTheEnd([a.placed(), b.placed()]),
            [start_a, start_b] => Candidate::OnTheWay([a.moving(start_a), b.moving(start_b)]),
        })
    }

    /// Two shapes, where they are at the end of the tick. `None` if one is gone.
    #[inline]
    pub(crate) fn placed(&self, [a, b]: [ProxyId; 2]) -> Option<[Placed<'_>; 2]> {
        Some([self.body(a)?.placed(), self.body(b)?.placed()])
    }

    /// The box behind a handle; if that was removed, or has none, any box.
    #[inline]
    pub(crate) fn box_of(&self, id: ProxyId) -> Aabb3d {
        let boxes = self.index.proxies().boxes();
        *boxes.get(id.index()).unwrap_or(&EVERYWHERE)
    }

    /// What the box behind a handle says of the shape in it. Nothing, if that was removed.
    #[inline]
    pub(crate) fn fit(&self, id: ProxyId) -> Fit {
        match self.fits.get(id.index()) {
            Some(fit) if self.index.proxies().contains(id) => *fit,
            _ => Fit::Loose,
        }
    }

    /// What is behind a handle, on its way in this tick: at rest where it is, if it is not swept.
    pub(crate) fn moving(&self, id: ProxyId) -> Option<Moving<'_>> {
        Some(self.body(id)?.moving(self.start(id)))
    }

    /// May there be pairs of which one is swept?
    pub(crate) const fn has_swept(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Is what is behind a handle looked for all along its way?
    #[inline]
    pub(crate) fn is_on_its_way(&self, id: ProxyId) -> bool {
        self.start(id).is_some()
    }

    /// Where the way of what is behind a handle begins, if it is on one.
    #[inline]
    fn start(&self, id: ProxyId) -> Option<&Transform> {
        self.starts.get(id.index())?.as_ref()
    }

    /// Puts what is behind a handle elsewhere, at once. Ways and pairs stay as they are.
    pub(crate) fn put(&mut self, id: ProxyId, pose: &Transform, tests: &NarrowPhase) {
        let Some(body) = self.bodies.get_mut(id.index()) else {
            return;
        };
        // What cannot be there stays where it is until the next tick, which says so.
        if let Ok(aabb) = tests.world_aabb(Placed::new(&body.shape, pose))
            && self.index.set(id, &aabb).is_ok()
        {
            body.pose = *pose;
            self.fits[id.index()] = Fit::of(body.placed());
        }
    }

    /// Puts what is behind a handle elsewhere within its box, which stays. False if it is not in there: nothing happens
    /// then. It is to have moved in this tick, or to [be looked at again](Self::look_again): verdicts on it are not kept.
    pub(crate) fn move_within(
        &mut self,
        id: ProxyId,
        pose: &Transform,
        tests: &NarrowPhase,
    ) -> bool {
        let around = self.box_of(id);
        let Some(body) = self.bodies.get_mut(id.index()) else {
            return true;
        };
        let is_within = tests
            .world_aabb(Placed::new(&body.shape, pose))
            .is_ok_and(|aabb| around.contains(&aabb));
        if is_within {
            body.pose = *pose;
            self.fits[id.index()] = Fit::Loose;
        }
        is_within
    }

    /// Has queries find everything where it was [put](Self::put).
    pub(crate) fn settle(&mut self) {
        self.index.update();
        // An update without a search would have the next one look at everything. The exact tests
        // see nothing of this search: for the next one, which is for them, the same have moved.
        self.index.find_pairs();
        self.index.touch_moved();
    }

    /// Searches by this method from now on, and for these kinds of pairs.
    pub(crate) fn set_method(&mut self, method: &BroadPhaseMethod, kinds: PairKinds) {
        if *method != self.method {
            self.method = method.clone();
            self.index.set_method(method);
        }
        self.index.set_pair_kinds(kinds);
    }

    /// Brings the broad phase up to date with all that changed.
    pub(crate) fn update(&mut self) {
        self.index.update();
    }

    /// Searches for the pairs that the exact tests are to look at, and lists them.
    pub(crate) fn list_candidates(&mut self, candidates: &mut ResMut<CandidatePairs>) {
        let pairs = self.index.find_pairs();
        candidates.0.clear();
        candidates.0.extend_from_slice(pairs.moving());
        self.listed = candidates.last_changed();
        self.search += 1;
        self.forget_orders();
        self.searched_at = self.index.updates();
        self.moved_at_search.clear();
    }

    /// Are the candidates just those that were found, each once?
    pub(crate) fn has_listed(&self, candidates: &Res<CandidatePairs>) -> bool {
        candidates.last_changed() == self.listed
    }

    /// Which state of which index this is, if it is the one of the last search.
    pub(crate) fn state_of_search(&self) -> Option<IndexState> {
        let updates = self.index.updates();
        (updates == self.searched_at).then_some(IndexState {
            index: self.number,
            updates,
        })
    }

    /// The number of the last search whose pairs are for the exact tests.
    #[inline]
    pub(crate) const fn search(&self) -> u64 {
        self.search
    }

    /// What tells this index from all others.
    #[inline]
    pub(crate) const fn number(&self) -> u64 {
        self.number
    }

    /// Has the next search find all pairs, those in which nothing moved too.
    pub(crate) fn search_all(&mut self) {
        self.index.touch_all();
    }

    /// Keeps in mind what had moved when pairs were last searched for, before the index is updated
    /// without a search.
    pub(crate) fn keep_search(&mut self) {
        if self.moved_at_search.is_empty() {
            let proxies = self.index.proxies();
            let handles = (0..proxies.capacity() as u32).map(ProxyId::new);
            self.moved_at_search
                .extend(handles.map(|id| proxies.is_moved(id)));
        }
    }

    /// Are the boxes those of the last search, so that they say themselves what had moved?
    pub(crate) const fn is_as_searched(&self) -> bool {
        self.moved_at_search.is_empty()
    }

    /// Were the two at rest when pairs were last searched for, and are both still there? What was
    /// known of them then still holds.
    pub(crate) fn rested(&self, ids: [ProxyId; 2], entities: [Entity; 2]) -> bool {
        let proxies = self.index.proxies();
        let rested = |id: ProxyId| {
            let moved = self
                .moved_at_search
                .get(id.index())
                .is_some_and(|moved| *moved);
            if self.is_as_searched() {
                proxies.is_resting(id)
            } else {
                proxies.contains(id) && !moved
            }
        };
        ids.iter().all(|id| rested(*id)) && ids.map(|id| self.entities[id.index()]) == entities
    }

    /// Brings the shape of an entity up to date, if it is in by this handle: it became what it is at
    /// that time.
    pub(crate) fn reshape(&mut self, (id, entity): (ProxyId, Entity), shape: &Shape, at: Tick) {
        if self.is_entry_of(id, entity)
            && let Some(body) = self.bodies.get_mut(id.index())
        {
            body.reshape(shape, at);
        }
    }

    /// Says where the way of what is behind a handle begins, if it is on one.
    pub(crate) fn set_start(&mut self, id: ProxyId, start: Option<Transform>) {
        if start.is_some() {
            self.make_room_for_starts();
        }
        if let Some(slot) = self.starts.get_mut(id.index()) {
            *slot = start;
        }
    }

    /// Changes which pairs an entity makes. Nothing happens if it is gone.
    pub(crate) fn change_filter(&mut self, id: ProxyId, change: impl FnOnce(&mut PairFilter)) {
        let mut filter = self.index.proxies().filter(id);
        change(&mut filter);
        // The only error is that there is no such entity any more.
        let _ = self.index.set_filter(id, filter);
    }

    /// Has the pairs of an entity sought anew.
    pub(crate) fn look_again(&mut self, id: ProxyId) {
        self.index.touch(id);
    }

    pub(crate) fn remove(&mut self, id: ProxyId) {
        self.remember_order_of(id);
        self.index.remove(id);
    }

    /// Is this handle that of this entity? Others may have a copy of it, or one of another index.
    #[inline]
    pub(crate) fn is_entry_of(&self, id: ProxyId, entity: Entity) -> bool {
        self.entities.get(id.index()) == Some(&entity)
    }

    /// Removes all whose entities do not say that the entry is theirs.
    pub(crate) fn remove_strays(&mut self, is_entry: impl Fn(ProxyId, Entity) -> bool) {
        let proxies = self.index.proxies();
        let all = proxies.iter().map(|(id, _)| id).chain(proxies.unbounded());
        let strays: Vec<_> = all
            .filter(|id| !is_entry(*id, self.entities[id.index()]))
            .collect();
        strays.into_iter().for_each(|id| self.remove(id));
    }

    /// Decides about an entity that cannot [follow](follow::Followers::follow), given the handle that
    /// it says is its own. Returns the one that it has from now on.
    ///
    /// | its own handle is | it has | it |
    /// |---|---|---|
    /// | that of one that is unbounded | no bounds | stays, and is updated |
    /// | any, or none | a box or no bounds, and a filter | leaves, if it was in, and enters anew |
    /// | any, or none | neither, or no filter | leaves, if it was in |
    #[cold]
    pub(crate) fn upsert(&mut self, id: Option<ProxyId>, seen: Seen) -> Option<ProxyId> {
        let Seen {
            body,
            extent,
            order,
            filter,
            fit,
        } = seen;
        let own = id.filter(|id| self.is_entry_of(*id, body.entity));
        if let (Some(own), Extent::Unbounded(side)) = (own, extent)
            && self.index.set_unbounded(own, side).is_ok()
        {
            self.index.touch(own);
            self.bodies[own.index()] = body;
            return Some(own);
        }
        if let Some(own) = own {
            self.index.remove(own);
        }
        self.is_ordered |= order.is_some();
        let order = order.unwrap_or_else(|| rank(body.entity));
        let id = self.enter(body, extent, filter?, fit)?;
        // The only error is that there is no such handle.
        let _ = self.index.set_order(id, order);
        Some(id)
    }

    /// Gives a new entity a handle, unless its box is refused.
    fn enter(
        &mut self,
        body: Body,
        extent: Extent,
        filter: PairFilter,
        fit: Fit,
    ) -> Option<ProxyId> {
        let entered = match extent {
            Extent::Box(aabb) => self.index.insert(aabb),
            Extent::Unbounded(side) => self.index.insert_unbounded(side),
        };
        let id = entered.ok()?;
        self.highest_entity = self.highest_entity.max(body.entity.index_u32());
        self.change_filter(id, |old| *old = filter);
        debug_assert!(id.index() <= self.bodies.len(), "handles are dense");
        if id.index() < self.bodies.len() {
            self.entities[id.index()] = body.entity;
            self.fits[id.index()] = fit;
            self.bodies[id.index()] = body;
        } else {
            self.entities.push(body.entity);
            self.fits.push(fit);
            self.bodies.push(body);
        }
        Some(id)
    }
}

/// The pairs that the exact tests look at in this tick: those whose boxes overlap and of which at
/// least one entity moved. The verdict on all other pairs is still that of the last tick.
///
/// A system after [`BroadPhase`](crate::CollisionSystems::BroadPhase) and before
/// [`NarrowPhase`](crate::CollisionSystems::NarrowPhase) may take pairs out: they are then not in
/// contact. A pair that is listed twice, or the wrong way round, is one contact. What a
/// [swept](crate::swept::Swept) entity meets after a bounce, within the same tick, is not among
/// them: layers, lists and [hooks](crate::filters::PairHook) see that too.
#[doc(alias("broad phase pairs", "possible collisions"))]
#[derive(Resource, Clone, Debug, Default, Deref, DerefMut, Reflect)]
#[reflect(Resource, Debug, Default)]
#[type_path = "bevy_octree"]
pub struct CandidatePairs(pub Vec<Pair>);

/// What others read though nothing maintains the index.
pub(crate) fn register(app: &mut App) {
    app.init_resource::<CollisionIndex>()
        .init_resource::<CandidatePairs>()
        .register_type::<CollisionIndex>()
        .register_type::<CandidatePairs>();
}
