//! Maintenance of the index, and the search for candidate pairs: the systems of the broad phase.

use bevy::{
    ecs::{
        archetype::Archetype, component::ComponentId, entity_disabling::DefaultQueryFilters,
        system::RegisteredSystemError, world::DeferredWorld,
    },
    prelude::*,
};

use crate::{
    collision_index::{Body, CandidatePairs, CollisionIndex, Extent, Seen, Upkeep},
    components::{self, BroadPhaseProxy, CollisionShape, WorldAabb},
    counters::CollisionCounters,
    filters::{self, FilterParts},
    narrow_phase::{Moving, NarrowPhase},
    schedule::{CollisionSystems, add_to_tick},
    settings::BroadPhaseSettings,
    shear::{self, Sheared},
    swept::{self, Swept},
    way::SweptWay,
};

/// The plugin for maintenance of the [`CollisionIndex`] and the search for [`CandidatePairs`].
#[derive(Clone, Copy, Debug, Default)]
pub struct BroadPhasePlugin;

impl Plugin for BroadPhasePlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
            let maintain = (watch_disabling.run_if(some_new_disabling), mend, maintain).chain();
            app.add_systems(
                schedule,
                (
                    maintain.in_set(CollisionSystems::Maintenance),
                    find_candidates.in_set(CollisionSystems::BroadPhase),
                ),
            );
        });
    }
}

/// Brings the index up to date with all boxes that changed, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    if let Some(mut index) = world.get_resource_mut::<CollisionIndex>() {
        index.keep_search();
    }
    world.run_system_cached(watch_disabling)?;
    world.run_system_cached(mend)?;
    world.run_system_cached(maintain)
}

/// Has an index that missed something, or is a new one, forget all that is not there, and learn of
/// all that is.
fn mend(
    mut index: ResMut<CollisionIndex>,
    mut upkeep: ResMut<Upkeep>,
    mut entities: Query<(
        Entity,
        &BroadPhaseProxy,
        &Archetype,
        FilterParts,
        &mut WorldAabb,
    )>,
) {
    if !upkeep.is_due(&index) {
        return;
    }
    index.remove_strays(|id, entity| {
        let entry = entities
            .get(entity)
            .ok()
            .filter(|(_, _, archetype, ..)| !upkeep.disables(archetype));
        entry.is_some_and(|(_, proxy, ..)| proxy.id() == Some(id))
    });
    for (entity, proxy, _, parts, mut aabb) in &mut entities {
        if let Some(id) = proxy.id().filter(|id| index.is_entry_of(*id, entity)) {
            index.change_filter(id, |old| *old = filters::filter(parts));
        }
        aabb.set_changed();
    }
    upkeep.done(&index);
}

/// What is looked at in each tick, of everything that moved: no more than that.
type Boxed<'a> = (
    Entity,
    Ref<'a, WorldAabb>,
    Ref<'a, CollisionShape>,
    &'a mut BroadPhaseProxy,
    (Has<Swept>, Option<&'a SweptWay>),
);

fn maintain(
    mut index: ResMut<CollisionIndex>,
    (settings, tests, upkeep): (Res<BroadPhaseSettings>, Res<NarrowPhase>, Res<Upkeep>),
    mut boxes: Query<Boxed, Changed<WorldAabb>>,
    newcomers: Query<(&Archetype, FilterParts)>,
    sheared: Query<&Sheared>,
    mut counters: ResMut<CollisionCounters>,
) {
    let index = &mut *index;
    index.set_method(&settings.method, settings.pair_kinds);
    if tests.is_changed() {
        index.search_all();
    }
    let some_sheared = !sheared.is_empty();
    for (entity, aabb, own, mut proxy, (is_swept, way)) in &mut boxes {
        let shape = || shear::shape(&own, sheared.get(entity).ok());
        let way = way.filter(|way| is_swept && way.belongs_to(entity, proxy.id()));
        let start = way.and_then(|way| way.to(proxy.pose())).copied();
        let fit = proxy.fit(aabb.last_changed(), own.last_changed());
        let reshape = |body: &mut Body| {
            // It may have changed when nobody looked, between two sets.
            if body.reshaped != own.last_changed() || some_sheared {
                body.reshape(shape(), own.last_changed());
            }
        };
        let id = if let Some(id) = proxy.id()
            && index.follow((id, entity), &aabb.0, proxy.pose(), fit, reshape)
        {
            id
        } else {
            let newcomer = newcomers.get(entity).ok();
            let filter = newcomer
                .filter(|(archetype, _)| !upkeep.disables(archetype))
                .map(|(_, parts)| filters::filter(parts));
            let (pose, reshaped) = (*proxy.pose(), own.last_changed());
            let body = Body {
                entity,
                pose,
                shape: shape().clone(),
                reshaped,
            };
            let extent = extent(&aabb, &body, start.as_ref(), &tests);
            let seen = Seen {
                body,
                extent,
                filter,
                fit,
            };
            let id = index.upsert(proxy.id(), seen);
            BroadPhaseProxy::note_id(&mut proxy, id);
            let Some(id) = id else { continue };
            id
        };
        index.set_start(id, start);
    }
    index.update();
    let proxies = index.index().proxies();
    counters.tick.objects = (proxies.len() + proxies.unbounded().count()) as u64;
    counters.tick.moved = proxies.moved().len() as u64;
}

/// Where an entity is in this tick. What fills all the space there is is unbounded: where that is,
/// is up to its shape.
#[cold]
fn extent(aabb: &WorldAabb, body: &Body, start: Option<&Transform>, tests: &NarrowPhase) -> Extent {
    if *aabb == WorldAabb::UNBOUNDED {
        let moving = Moving::new(&body.shape, start.unwrap_or(&body.pose), &body.pose);
        Extent::Unbounded(swept::side(tests, &moving))
    } else {
        Extent::Box(aabb.0)
    }
}

pub(crate) fn find_candidates(
    mut index: ResMut<CollisionIndex>,
    mut candidates: ResMut<CandidatePairs>,
    mut counters: ResMut<CollisionCounters>,
) {
    index.list_candidates(&mut candidates);
    let index = index.index();
    counters.tick.candidates = candidates.len() as u64;
    counters.tick.resting_pairs = index.pairs().resting().len() as u64;
    counters.tick.pairs_tested = index.pairs_tested();
}

/// The components that disable entities, and are not observed yet.
fn new_disabling(
    filters: &DefaultQueryFilters,
    upkeep: &Upkeep,
) -> impl Iterator<Item = ComponentId> {
    filters
        .disabling_ids()
        .filter(move |id| !upkeep.watches(*id))
}

fn some_new_disabling(filters: Option<Res<DefaultQueryFilters>>, upkeep: Res<Upkeep>) -> bool {
    filters.is_some_and(|filters| new_disabling(&filters, &upkeep).next().is_some())
}

/// Has them observed. What they disable already, maintenance deals with.
fn watch_disabling(world: &mut World) {
    let (Some(filters), Some(upkeep)) = (world.get_resource(), world.get_resource()) else {
        return;
    };
    for id in new_disabling(filters, upkeep).collect::<Vec<_>>() {
        world.spawn(Observer::new(on_disabled).with_component(id));
        world.spawn(Observer::new(on_enabled).with_component(id));
        world.resource_mut::<Upkeep>().watch(id);
    }
}

/// A disabled entity is out of the world until it is enabled again.
fn on_disabled(event: On<Add>, mut world: DeferredWorld) {
    components::leave(&mut world, event.entity);
}

/// Has the box computed anew, which puts the entity back into the index. What comes back has not
/// passed through what was between.
fn on_enabled(event: On<Remove>, mut world: DeferredWorld) {
    if let Some(mut way) = world.get_mut::<SweptWay>(event.entity) {
        way.forget();
    }
    components::outdate(&mut world, event.entity);
}
