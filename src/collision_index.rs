//! The broad phase as a resource: entities in, candidate pairs out.

use bevy::{
    ecs::{entity_disabling::Disabled, schedule::InternedScheduleLabel, system::RegisteredSystemError},
    prelude::*,
};

use crate::{
    broad_phase::{BroadPhase, Method, Pair, PairFilter, ProxyId, SpatialIndex},
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    counters::CollisionCounters,
    filters::{self, FilterParts},
    narrow_phase::{NarrowPhase, Placed, Shape},
    plugin::{CollisionSystems, NarrowPhaseSettings},
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
}

/// What the exact tests need of an entity, in one place: they visit entities in no order of memory.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) entity: Entity,
    pub(crate) pose: Transform,
    pub(crate) shape: Shape,
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

    /// Says which pairs an entity makes. Nothing happens if it is gone.
    pub(crate) fn set_filter(&mut self, id: ProxyId, filter: PairFilter) {
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
        shape: ShapeChange,
        tests: &NarrowPhase,
        filter: impl FnOnce() -> PairFilter,
    ) {
        let index = &mut self.index;
        let pose = proxy.pose;
        // What fills all the space there is has no end: where it is, is up to its shape.
        let side = || (*aabb == WorldAabb::ENDLESS).then(|| tests.side(Placed::new(shape.shape, &pose)));
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
            self.set_filter(id, filter());
            let body = Body { entity, pose: proxy.pose, shape: shape.shape.clone() };
            match self.bodies.get_mut(id.index()) {
                Some(place) => *place = body,
                None => self.bodies.push(body),
            }
        } else {
            // It may have turned inside its box.
            self.index.touch(id);
            let body = &mut self.bodies[id.index()];
            body.pose = proxy.pose;
            if shape.changed {
                body.shape = shape.shape.clone();
            }
        }
    }
}

struct ShapeChange<'a> {
    shape: &'a Shape,
    changed: bool,
}

/// Settings of the broad phase. Changes take effect at the next tick.
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct BroadPhaseSettings {
    /// How overlapping boxes are searched for.
    pub method: Method,
}

/// The pairs that the exact tests look at in this tick: those whose boxes overlap and of which at least one entity
/// moved. The verdict on all other pairs is still that of the last tick.
///
/// A system after [`BroadPhase`](CollisionSystems::BroadPhase) and before
/// [`NarrowPhase`](CollisionSystems::NarrowPhase) may take pairs out: they are then not in contact.
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
    world.run_system_cached(maintain)
}

type ChangedBoxes<'a> = (Entity, &'a WorldAabb, Ref<'a, CollisionShape>, &'a mut BroadPhaseProxy, FilterParts<'a>);

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
    for (entity, aabb, shape, mut proxy, filter) in &mut boxes {
        let change = ShapeChange { shape: &shape.0, changed: shape.is_changed() };
        index
            .take_up(entity, aabb, proxy.bypass_change_detection(), change, narrow.tests(), || filters::filter(filter));
    }
    index.index.update();
    let proxies = index.index.proxies();
    counters.tick.objects = (proxies.len() + proxies.endless().count()) as u64;
    counters.tick.moved = proxies.moved().len() as u64;
}

fn find_candidates(
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
