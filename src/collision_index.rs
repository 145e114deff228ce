//! The broad phase as a resource: entities in, candidate pairs out.

use bevy::{
    ecs::{
        change_detection::Tick, entity_disabling::Disabled, schedule::InternedScheduleLabel,
        system::RegisteredSystemError,
    },
    math::primitives::HalfSpace,
    prelude::*,
};

use crate::{
    broad_phase::{BroadPhase, Method, Pair, PairFilter, PairKinds, ProxyId, SpatialIndex},
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    counters::CollisionCounters,
    filters::{self, FilterParts},
    narrow_phase::{Moving, NarrowPhase, Placed, Shape},
    plugin::{CollisionSystems, NarrowPhaseSettings},
    swept::{self, Swept, SweptWay},
};

/// The [`SpatialIndex`] of all entities with a [`CollisionShape`].
#[derive(Resource, Debug, Default, Reflect)]
#[reflect(Debug, Default, from_reflect = false)]
pub struct CollisionIndex {
    #[reflect(ignore)]
    index: SpatialIndex,
    /// The method that was asked for last.
    method: Method,
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
}

/// What the exact tests need of an entity, in one place: they visit entities in no order of memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) entity: Entity,
    pub(crate) pose: Transform,
    pub(crate) shape: Shape,
    /// When the entity's shape became this one.
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

    /// Takes up an entity's box of this tick. A box that is refused takes the entity out of the index.
    fn take_up(
        &mut self,
        entity: Entity,
        aabb: &WorldAabb,
        proxy: &mut BroadPhaseProxy,
        what: Described,
        tests: &NarrowPhase,
        filter: impl FnOnce() -> PairFilter,
    ) {
        let index = &mut self.index;
        let pose = proxy.pose;
        // What fills all the space there is has no end: where it is, is up to its shape.
        let side = || (*aabb == WorldAabb::ENDLESS).then(|| what.side(&pose, tests));
        let known = proxy.id.filter(|id| {
            index.set(*id, &aabb.0).is_ok() || side().is_some_and(|side| index.set_endless(*id, side).is_ok())
        });
        let insert = || index.insert(aabb.0).ok().or_else(|| index.insert_endless(side()?).ok());
        let Some(id) = known.or_else(insert) else {
            if let Some(id) = proxy.id.take() {
                self.index.remove(id);
            }
            return;
        };
        if known.is_none() {
            if let Some(old) = proxy.id.replace(id) {
                self.index.remove(old);
            }
            self.change_filter(id, |old| *old = filter());
            let body = Body { entity, pose: proxy.pose, shape: what.shape.clone(), reshaped: what.reshaped };
            match self.bodies.get_mut(id.index()) {
                Some(place) => *place = body,
                None => self.bodies.push(body),
            }
        } else {
            // It may have turned inside its box.
            self.index.touch(id);
            let body = &mut self.bodies[id.index()];
            body.pose = proxy.pose;
            // It may have changed when nobody looked, between two sets.
            if body.reshaped != what.reshaped {
                body.reshaped = what.reshaped;
                body.shape = what.shape.clone();
            }
        }
        self.set_start(id, what.way.and_then(|way| way.to(&proxy.pose)).copied());
    }
}

/// What an entity is, besides its box.
struct Described<'a> {
    shape: &'a Shape,
    /// When it became that.
    reshaped: Tick,
    /// Its own way, if it is swept.
    way: Option<&'a SweptWay>,
}

impl Described<'_> {
    /// Where all of a shape without an end is, all along its way.
    #[cold]
    fn side(&self, pose: &Transform, tests: &NarrowPhase) -> Option<HalfSpace> {
        let start = self.way.and_then(|way| way.to(pose)).unwrap_or(pose);
        swept::side(tests, &Moving::new(self.shape, start, pose))
    }
}

/// Settings of the broad phase. Changes take effect at the next tick.
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct BroadPhaseSettings {
    /// How overlapping boxes are searched for.
    pub method: Method,
    /// Which kinds of pairs are sought at all, by which of the two is a
    /// [`StaticCollider`](crate::filters::StaticCollider). Contacts of a kind that is no longer sought end.
    pub pair_kinds: PairKinds,
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
#[derive(Clone, Debug)]
pub struct BroadPhasePlugin(pub(crate) InternedScheduleLabel);

impl Plugin for BroadPhasePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            self.0,
            (maintain.in_set(CollisionSystems::Maintenance), find_candidates.in_set(CollisionSystems::BroadPhase)),
        )
        .add_observer(on_disabled)
        .add_observer(on_enabled);
    }
}

/// Takes up all boxes that changed, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    if let Some(mut index) = world.get_resource_mut::<CollisionIndex>() {
        index.keep_search();
    }
    world.run_system_cached(maintain)
}

type Boxed<'a> = (Entity, &'a WorldAabb, Ref<'a, CollisionShape>, &'a mut BroadPhaseProxy);
type ChangedBoxes<'a> = (Boxed<'a>, FilterParts<'a>, Option<(&'a Swept, &'a SweptWay)>);

fn maintain(
    mut index: ResMut<CollisionIndex>,
    settings: Res<BroadPhaseSettings>,
    narrow: Res<NarrowPhaseSettings>,
    mut boxes: Query<ChangedBoxes, Changed<WorldAabb>>,
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
    for ((entity, aabb, shape, mut proxy), filter, swept) in &mut boxes {
        let way = swept.map(|(_, way)| way).filter(|way| way.belongs_to(entity, proxy.id));
        let what = Described { shape: &shape.0, reshaped: shape.last_changed(), way };
        index.take_up(entity, aabb, proxy.bypass_change_detection(), what, narrow.tests(), || filters::filter(filter));
    }
    index.index.update();
    let proxies = index.index.proxies();
    counters.tick.objects = (proxies.len() + proxies.endless().count()) as u64;
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

/// A disabled entity is out of the world until it is enabled again.
fn on_disabled(
    event: On<Add, Disabled>,
    mut proxies: Query<&mut BroadPhaseProxy, Allow<Disabled>>,
    mut index: ResMut<CollisionIndex>,
) {
    if let Ok(mut proxy) = proxies.get_mut(event.entity)
        && let Some(id) = proxy.id.take()
    {
        index.remove(id);
    }
}

/// Has the box computed anew, which puts the entity back into the index.
fn on_enabled(event: On<Remove, Disabled>, mut proxies: Query<&mut BroadPhaseProxy, Allow<Disabled>>) {
    if let Ok(mut proxy) = proxies.get_mut(event.entity) {
        proxy.set_changed();
    }
}

impl NarrowPhaseSettings {
    pub(crate) const fn tests(&self) -> &NarrowPhase {
        &self.0
    }
}
