//! The broad phase as a resource: entities in, candidate pairs out.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy::{
    ecs::{
        archetype::Archetype, change_detection::Tick, component::ComponentId, entity_disabling::DefaultQueryFilters,
        system::RegisteredSystemError, world::DeferredWorld,
    },
    prelude::*,
};

use crate::{
    broad_phase::{BroadPhase, BroadPhaseMethod, Pair, PairFilter, ProxyId, SpatialIndex},
    components::{self, BroadPhaseProxy, CollisionShape, WorldAabb},
    counters::CollisionCounters,
    filters::{self, FilterParts},
    narrow_phase::{Moving, NarrowPhase, Placed, Shape},
    schedule::{CollisionSystems, add_to_tick},
    settings::{BroadPhaseSettings, NarrowPhaseSettings},
    shear::{self, Sheared},
    swept::{self, Swept, SweptWay},
};

/// The [`SpatialIndex`] of all entities with a [`CollisionShape`].
///
/// It may be taken out of the world for a while, or be replaced by another: at the next tick, or
/// [update](crate::spatial_query::update_spatial_index), it holds what it should.
#[derive(Resource, Debug, Reflect)]
#[reflect(Debug, Default, from_reflect = false)]
pub struct CollisionIndex {
    #[reflect(ignore)]
    index: SpatialIndex,
    /// The method that was asked for last.
    method: BroadPhaseMethod,
    /// By proxy index. Entries of removed proxies stay until the proxy is handed out again.
    #[reflect(ignore)]
    bodies: Vec<Body>,
    /// By proxy index, as far as there are any: where the ways of swept bodies begin.
    #[reflect(ignore)]
    starts: Vec<Option<Transform>>,
    /// How many searches there were whose pairs are for the exact tests.
    #[reflect(ignore)]
    search: u64,
    /// By proxy index: what had moved when pairs were last searched for. Empty as long as the boxes are those of the
    /// search, and say so themselves.
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
            starts: Vec::new(),
            search: 0,
            moved_at_search: Vec::new(),
            listed: Tick::default(),
            number: NUMBER.fetch_add(1, Ordering::Relaxed),
        }
    }
}

/// What the index has to know to be right, though it may miss things: hooks may run while it is out of the world.
#[derive(Resource, Debug, Default)]
pub(crate) struct Upkeep {
    /// The index that all entries are about.
    index: u64,
    /// Has something come to pass that it does not know of?
    missed: bool,
    /// The components that disable an entity, each with its observers.
    disabling: Vec<ComponentId>,
}

impl Upkeep {
    fn disables(&self, archetype: &Archetype) -> bool {
        self.disabling.iter().any(|id| archetype.contains(*id))
    }
}

/// Does something to an entity's entry, at once. What the index misses, it mends at the next tick.
pub(crate) fn in_index(world: &mut DeferredWorld, entity: Entity, act: impl FnOnce(&mut CollisionIndex, ProxyId)) {
    let Some(id) = world.get::<BroadPhaseProxy>(entity).and_then(BroadPhaseProxy::id) else { return };
    if let Some(mut index) = world.get_resource_mut::<CollisionIndex>()
        && index.is_entry_of(id, entity)
    {
        act(&mut index, id);
    } else if let Some(mut upkeep) = world.get_resource_mut::<Upkeep>() {
        upkeep.missed = true;
    }
}

/// What the exact tests need of an entity, in one place: they visit entities in no order of memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) entity: Entity,
    pub(crate) pose: Transform,
    pub(crate) shape: Shape,
    /// When the entity's own shape became this one.
    reshaped: Tick,
}

impl CollisionIndex {
    /// The boxes, the broad phase, and queries, by [`ProxyId`].
    #[must_use]
    pub const fn index(&self) -> &SpatialIndex {
        &self.index
    }

    /// Searches with a broad phase of one's own from the next tick on, until the method in the [`BroadPhaseSettings`]
    /// changes. It must be empty.
    pub fn set_engine(&mut self, engine: Box<dyn BroadPhase>) {
        self.index.set_engine(engine);
    }

    /// The entity behind a handle. For a handle that was removed, the entity that had it last.
    #[must_use]
    pub fn entity(&self, id: ProxyId) -> Option<Entity> {
        self.bodies.get(id.index()).map(|body| body.entity)
    }

    /// The entities of a pair.
    ///
    /// # Panics
    /// If the pair is not of this index.
    #[must_use]
    pub fn entities(&self, pair: Pair) -> [Entity; 2] {
        [pair.a, pair.b].map(|id| self.bodies[id.index()].entity)
    }

    /// What is behind a handle, unless it was removed.
    pub(crate) fn body(&self, id: ProxyId) -> Option<&Body> {
        self.index.proxies().contains(id).then(|| &self.bodies[id.index()])
    }

    /// May there be pairs of which one is swept?
    pub(crate) const fn has_swept(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Was one of the two looked for all along its way?
    #[inline]
    pub(crate) fn is_swept(&self, pair: Pair) -> bool {
        self.has_swept() && (self.is_on_its_way(pair.a) || self.is_on_its_way(pair.b))
    }

    /// Is what is behind a handle looked for all along its way?
    #[inline]
    pub(crate) fn is_on_its_way(&self, id: ProxyId) -> bool {
        self.starts.get(id.index()).is_some_and(Option::is_some)
    }

    /// What is behind a handle, on its way in this tick: at rest where it is, if it is not swept.
    pub(crate) fn moving(&self, id: ProxyId) -> Option<Moving<'_>> {
        let body = self.body(id)?;
        Some(match self.starts.get(id.index()) {
            Some(Some(start)) => Moving::new(&body.shape, start, &body.pose),
            _ => Moving::resting(Placed::new(&body.shape, &body.pose)),
        })
    }

    /// Puts what is behind a handle elsewhere, at once. Ways and pairs stay as they are.
    pub(crate) fn place(&mut self, id: ProxyId, pose: &Transform, tests: &NarrowPhase) {
        let Some(body) = self.bodies.get_mut(id.index()) else { return };
        // What cannot be there stays where it is until the next tick, which says so.
        if let Ok(aabb) = tests.world_aabb(Placed::new(&body.shape, pose))
            && self.index.set(id, &aabb).is_ok()
        {
            body.pose = *pose;
        }
    }

    /// Has queries find everything where it was [put](Self::place).
    pub(crate) fn update(&mut self) {
        self.index.update();
        // An update without a search would have the next one look at everything. The exact tests see nothing of this
        // search: for the next one, which is for them, the same have moved.
        self.index.find_pairs();
        self.index.touch_moved();
    }

    /// Are the candidates just those that were found, each once?
    pub(crate) fn has_listed(&self, candidates: &Res<CandidatePairs>) -> bool {
        candidates.last_changed() == self.listed
    }

    /// The number of the last search whose pairs are for the exact tests.
    #[inline]
    pub(crate) const fn search(&self) -> u64 {
        self.search
    }

    /// Has the next search find all pairs, those in which nothing moved too.
    pub(crate) fn search_all(&mut self) {
        self.index.touch_all();
    }

    /// Keeps in mind what had moved when pairs were last searched for, before the index is updated without a search.
    fn keep_search(&mut self) {
        if self.moved_at_search.is_empty() {
            let proxies = self.index.proxies();
            let handles = (0..proxies.capacity() as u32).map(ProxyId::new);
            self.moved_at_search.extend(handles.map(|id| proxies.is_moved(id)));
        }
    }

    /// Are the boxes those of the last search, so that they say themselves what had moved?
    pub(crate) const fn is_as_searched(&self) -> bool {
        self.moved_at_search.is_empty()
    }

    /// Were the two at rest when pairs were last searched for, and are both still there? What was known of them then
    /// still holds.
    pub(crate) fn rested(&self, pair: Pair, entities: [Entity; 2]) -> bool {
        let proxies = self.index.proxies();
        let rested = |id: ProxyId| {
            let moved = self.moved_at_search.get(id.index()).is_some_and(|moved| *moved);
            if self.is_as_searched() { proxies.is_resting(id) } else { proxies.contains(id) && !moved }
        };
        rested(pair.a) && rested(pair.b) && self.entities(pair) == entities
    }

    fn set_start(&mut self, id: ProxyId, start: Option<Transform>) {
        if start.is_some() && self.starts.len() <= id.index() {
            self.starts.resize(id.index() + 1, None);
        }
        if let Some(place) = self.starts.get_mut(id.index()) {
            *place = start;
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
        self.index.remove(id);
    }

    /// Is this handle that of this entity? Others may have a copy of it, or one of another index.
    #[inline]
    pub(crate) fn is_entry_of(&self, id: ProxyId, entity: Entity) -> bool {
        self.bodies.get(id.index()).is_some_and(|body| body.entity == entity)
    }

    /// Removes all whose entities do not say that the entry is theirs.
    fn remove_strays(&mut self, is_entry: impl Fn(ProxyId, Entity) -> bool) {
        let proxies = self.index.proxies();
        let all = proxies.iter().map(|(id, _)| id).chain(proxies.unbounded());
        let strays: Vec<_> = all.filter(|id| !is_entry(*id, self.bodies[id.index()].entity)).collect();
        strays.into_iter().for_each(|id| self.remove(id));
    }

    /// Takes up the box of this tick of an entity that is in, and gives what is to follow it.
    #[inline]
    fn follow(&mut self, entity: Entity, aabb: &WorldAabb, proxy: &BroadPhaseProxy) -> Option<(ProxyId, &mut Body)> {
        let id = proxy.id?;
        let body = self.bodies.get_mut(id.index()).filter(|body| body.entity == entity)?;
        self.index.set(id, &aabb.0).ok()?;
        // It may have turned inside its box.
        self.index.touch(id);
        Some((id, body))
    }

    /// Takes up one that is new, has no end, or none any longer, or whose box is refused, which takes it out. The filter is
    /// that of a new one; `None` if it is not to come in.
    #[cold]
    fn take_up(
        &mut self,
        entity: Entity,
        (aabb, start): (&WorldAabb, Option<&Transform>),
        proxy: &BroadPhaseProxy,
        shape: &Shape,
        tests: &NarrowPhase,
        filter: Option<PairFilter>,
    ) -> Option<ProxyId> {
        let own = proxy.id.filter(|id| self.is_entry_of(*id, entity));
        // What fills all the space there is has no end: where it is, is up to its shape.
        let side = (*aabb == WorldAabb::UNBOUNDED).then(|| {
            let moving = match start {
                Some(start) => Moving::new(shape, start, &proxy.pose),
                None => Moving::resting(Placed::new(shape, &proxy.pose)),
            };
            swept::side(tests, &moving)
        });
        let body = Body { entity, pose: proxy.pose, shape: shape.clone(), reshaped: Tick::default() };
        if let (Some(id), Some(side)) = (own, side)
            && self.index.set_unbounded(id, side).is_ok()
        {
            self.index.touch(id);
            self.bodies[id.index()] = body;
            return own;
        }
        if let Some(old) = own {
            self.index.remove(old);
        }
        let filter = filter?;
        let id = self.index.insert(aabb.0).ok().or_else(|| self.index.insert_unbounded(side?).ok())?;
        self.change_filter(id, |old| *old = filter);
        match self.bodies.get_mut(id.index()) {
            Some(place) => *place = body,
            None => self.bodies.push(body),
        }
        Some(id)
    }
}

impl Body {
    /// Takes up its entity's shape, which became what it is in this tick, unless an ancestor shears it.
    #[cold]
    fn take_shape(&mut self, shape: &Shape, reshaped: Tick) {
        self.reshaped = reshaped;
        if !self.shape.is_same(shape) {
            self.shape = shape.clone();
        }
    }
}

/// The pairs that the exact tests look at in this tick: those whose boxes overlap and of which at least one entity
/// moved. The verdict on all other pairs is still that of the last tick.
///
/// A system after [`BroadPhase`](CollisionSystems::BroadPhase) and before
/// [`NarrowPhase`](CollisionSystems::NarrowPhase) may take pairs out: they are then not in contact. A pair that is listed
/// twice, or the wrong way round, is one contact. What a
/// [swept](crate::swept::Swept) entity meets after a bounce, within the same tick, is not among them: layers, lists and
/// [hooks](crate::filters::PairHook) see that too.
#[derive(Resource, Clone, Debug, Default, Deref, DerefMut, Reflect)]
#[reflect(Resource, Debug, Default)]
pub struct CandidatePairs(pub Vec<Pair>);

/// Octree maintenance and the search for candidate pairs.
#[derive(Clone, Copy, Debug, Default)]
pub struct BroadPhasePlugin;

impl Plugin for BroadPhasePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Upkeep>();
        add_to_tick(app, |app, schedule| {
            let maintain = (watch_disabling.run_if(some_new_disabling), mend, maintain).chain();
            app.add_systems(
                schedule,
                (maintain.in_set(CollisionSystems::Maintenance), find_candidates.in_set(CollisionSystems::BroadPhase)),
            );
        });
    }
}

/// Takes up all boxes that changed, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    if let Some(mut index) = world.get_resource_mut::<CollisionIndex>() {
        index.keep_search();
    }
    world.run_system_cached(watch_disabling)?;
    world.run_system_cached(mend)?;
    world.run_system_cached(maintain)
}

/// Has an index that missed something, or is a new one, forget all that is not there, and take up all that is.
fn mend(
    mut index: ResMut<CollisionIndex>,
    mut upkeep: ResMut<Upkeep>,
    mut entities: Query<(Entity, &BroadPhaseProxy, &Archetype, FilterParts, &mut WorldAabb)>,
) {
    if !upkeep.missed && upkeep.index == index.number {
        return;
    }
    index.remove_strays(|id, entity| {
        let entry = entities.get(entity).ok().filter(|(_, _, archetype, ..)| !upkeep.disables(archetype));
        entry.is_some_and(|(_, proxy, ..)| proxy.id == Some(id))
    });
    for (entity, proxy, _, parts, mut aabb) in &mut entities {
        if let Some(id) = proxy.id.filter(|id| index.is_entry_of(*id, entity)) {
            index.change_filter(id, |old| *old = filters::filter(parts));
        }
        aabb.set_changed();
    }
    (upkeep.index, upkeep.missed) = (index.number, false);
}

type Boxed<'a> = (Entity, &'a WorldAabb, Ref<'a, CollisionShape>, &'a mut BroadPhaseProxy);
type ChangedBoxes<'a> = (Boxed<'a>, FilterParts<'a>, Option<(&'a Swept, &'a SweptWay)>);

fn maintain(
    mut index: ResMut<CollisionIndex>,
    (settings, narrow, upkeep): (Res<BroadPhaseSettings>, Res<NarrowPhaseSettings>, Res<Upkeep>),
    mut boxes: Query<ChangedBoxes, Changed<WorldAabb>>,
    (archetypes, sheared): (Query<&Archetype>, Query<&Sheared>),
    mut counters: ResMut<CollisionCounters>,
) {
    let index = &mut *index;
    if settings.method != index.method {
        index.method = settings.method.clone();
        index.index.set_method(&settings.method);
    } else if narrow.is_changed() {
        index.index.touch_all();
    }
    index.index.set_pair_kinds(settings.pair_kinds);
    let some_sheared = !sheared.is_empty();
    for ((entity, aabb, own, mut proxy), parts, swept) in &mut boxes {
        let proxy = proxy.bypass_change_detection();
        let way = swept.map(|(_, way)| way).filter(|way| way.belongs_to(entity, proxy.id));
        let start = way.and_then(|way| way.to(&proxy.pose)).copied();
        let id = if let Some((id, body)) = index.follow(entity, aabb, proxy) {
            body.pose = proxy.pose;
            // It may have changed when nobody looked, between two sets.
            if body.reshaped != own.last_changed() || some_sheared {
                body.take_shape(shear::shape(&own, sheared.get(entity).ok()), own.last_changed());
            }
            id
        } else {
            let is_disabled = archetypes.get(entity).is_ok_and(|archetype| upkeep.disables(archetype));
            let filter = (!is_disabled).then(|| filters::filter(parts));
            let shape = shear::shape(&own, sheared.get(entity).ok());
            proxy.id = index.take_up(entity, (aabb, start.as_ref()), proxy, shape, narrow.tests(), filter);
            let Some(id) = proxy.id else { continue };
            id
        };
        index.set_start(id, start);
    }
    index.index.update();
    let proxies = index.index.proxies();
    counters.tick.objects = (proxies.len() + proxies.unbounded().count()) as u64;
    counters.tick.moved = proxies.moved().len() as u64;
}

pub(crate) fn find_candidates(
    mut index: ResMut<CollisionIndex>,
    mut candidates: ResMut<CandidatePairs>,
    mut counters: ResMut<CollisionCounters>,
) {
    let pairs = index.index.find_pairs();
    candidates.0.clear();
    candidates.0.extend_from_slice(pairs.moving());
    counters.tick.candidates = candidates.len() as u64;
    counters.tick.resting_pairs = pairs.resting().len() as u64;
    counters.tick.pairs_tested = index.index.pairs_tested();
    index.listed = candidates.last_changed();
    index.search += 1;
    index.moved_at_search.clear();
}

/// The components that disable entities, and are not observed yet.
fn new_disabling(filters: &DefaultQueryFilters, upkeep: &Upkeep) -> impl Iterator<Item = ComponentId> {
    filters.disabling_ids().filter(move |id| !upkeep.disabling.contains(id))
}

fn some_new_disabling(filters: Option<Res<DefaultQueryFilters>>, upkeep: Res<Upkeep>) -> bool {
    filters.is_some_and(|filters| new_disabling(&filters, &upkeep).next().is_some())
}

/// Has them observed. What they disable already, maintenance deals with.
fn watch_disabling(world: &mut World) {
    let (Some(filters), Some(upkeep)) = (world.get_resource(), world.get_resource()) else { return };
    for id in new_disabling(filters, upkeep).collect::<Vec<_>>() {
        world.spawn(Observer::new(on_disabled).with_component(id));
        world.spawn(Observer::new(on_enabled).with_component(id));
        let mut upkeep = world.resource_mut::<Upkeep>();
        upkeep.disabling.push(id);
        upkeep.missed = true;
    }
}

/// A disabled entity is out of the world until it is enabled again.
fn on_disabled(event: On<Add>, mut world: DeferredWorld) {
    components::leave(&mut world, event.entity);
}

/// Has the box computed anew, which puts the entity back into the index. What comes back has not passed through what was
/// between.
fn on_enabled(event: On<Remove>, mut world: DeferredWorld) {
    if let Some(mut way) = world.get_mut::<SweptWay>(event.entity) {
        way.forget();
    }
    if let Some(mut proxy) = world.get_mut::<BroadPhaseProxy>(event.entity) {
        proxy.set_changed();
    }
}
