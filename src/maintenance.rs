//! Maintenance of the index, and the search for candidate pairs: the systems of the broad phase.

use bevy::{
    ecs::{
        archetype::Archetype, component::ComponentId, entity_disabling::DefaultQueryFilters,
        system::RegisteredSystemError, world::DeferredWorld,
    },
    prelude::*,
};

use crate::{
    bounds,
    broad_phase::ProxyId,
    collision_index::{
        Body, CandidatePairs, CollisionIndex, Extent, Seen, follow::Following, upkeep::Upkeep,
    },
    collision_order::CollisionOrder,
    components::{self, BroadPhaseProxy, WorldAabb},
    counters::CollisionCounters,
    filters::{self, FilterParts},
    narrow_phase::{Moving, NarrowPhase},
    parts,
    schedule::{CollisionSystems, add_to_tick},
    settings::BroadPhaseSettings,
    shear::{self, Sheared},
    swept::{self, IsSwept},
    way::SweptWay,
};

mod tables;

use tables::{Boxed, Job};

/// The plugin for maintenance of the [`CollisionIndex`] and the search for [`CandidatePairs`].
#[derive(Clone, Copy, Debug, Default)]
pub struct BroadPhasePlugin;

impl Plugin for BroadPhasePlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
            // What came or was hung elsewhere in this tick does not meet its own for a tick.
            let regroup = parts::regroup.run_if(parts::is_regroup_due);
            let watch = || watch_disabling.run_if(some_new_disabling);
            let maintain = (regroup, watch(), mend, maintain).chain();
            app.add_systems(
                schedule,
                (
                    // Whose boxes are not computed while they are disabled, are heard of when they
                    // come back. It does nothing to what others look at.
                    watch()
                        .in_set(CollisionSystems::Bounds)
                        .before(bounds::outdate_all)
                        .ambiguous_with_all(),
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
    parts::regroup(world);
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
        &mut BroadPhaseProxy,
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
    for (entity, mut proxy, _, parts, mut aabb) in &mut entities {
        if let Some(id) = proxy.id().filter(|id| index.is_entry_of(*id, entity)) {
            index.change_filter(id, |old| *old = filters::filter(parts));
        }
        BroadPhaseProxy::touch_box(&mut proxy, &mut aabb);
    }
    upkeep.done(&index);
}

/// Lists that are worked with, kept for the next tick.
#[derive(Default)]
pub(crate) struct Memory {
    jobs: Vec<Job>,
    /// Who is decided about one by one.
    left: Vec<Entity>,
    moved: Vec<ProxyId>,
}

/// What is in the index already and has moved is brought up to date table by table, side by side;
/// all else, which comes, goes, or has another shape by now, is left, and decided about one by one.
pub(crate) fn maintain(
    mut index: ResMut<CollisionIndex>,
    (settings, tests, upkeep): (Res<BroadPhaseSettings>, Res<NarrowPhase>, Res<Upkeep>),
    mut boxes: Query<Boxed, With<BroadPhaseProxy>>,
    newcomers: Query<(&Archetype, FilterParts, Option<&CollisionOrder>)>,
    (sheared, swept): (Query<&Sheared>, Query<(), IsSwept>),
    mut counters: ResMut<CollisionCounters>,
    mut memory: Local<Memory>,
) {
    let Memory { jobs, left, moved } = &mut *memory;
    let index = &mut *index;
    index.set_method(&settings.method, settings.pair_kinds);
    if tests.is_changed() {
        index.search_all();
    }
    if swept.is_empty() {
        index.forget_starts();
    }
    left.clear();
    match boxes.contiguous_iter() {
        Ok(tables) => tables.for_each(|table| tables::follow(index, table, jobs, left)),
        // What disables entities may not be in tables.
        Err(_) => {
            let changed = boxes.iter().filter(|(_, aabb, ..)| aabb.is_changed());
            left.extend(changed.map(|(entity, ..)| entity));
        }
    }
    for entity in left.drain(..) {
        let Ok((_, aabb, own, mut proxy, way, _)) = boxes.get_mut(entity) else {
            continue;
        };
        let shape = shear::shape(&own, sheared.get(entity).ok());
        let reshaped = own.last_changed();
        let fit = proxy.fit(aabb.last_changed(), reshaped);
        let start = tables::start(way, entity, &proxy);
        if let Some(id) = proxy.id() {
            let now = Following {
                entity,
                id,
                aabb: &aabb.0,
                pose: proxy.pose(),
                fit,
                reshaped,
                start,
            };
            index.reshape((id, entity), shape, reshaped);
            if index.follow(&now, moved) {
                continue;
            }
        }
        let newcomer = newcomers.get(entity).ok();
        let order = newcomer
            .and_then(|(_, _, order)| order)
            .map(|order| order.0);
        let filter = newcomer
            .filter(|(archetype, ..)| !upkeep.disables(archetype))
            .map(|(_, parts, _)| filters::filter(parts));
        let body = Body {
            entity,
            pose: *proxy.pose(),
            shape: shape.clone(),
            reshaped,
        };
        let extent = extent(&aabb, &body, start, &tests);
        let seen = Seen {
            body,
            extent,
            order,
            filter,
            fit,
        };
        let id = index.upsert(proxy.id(), seen);
        BroadPhaseProxy::note_id(&mut proxy, id);
        if let Some(id) = id {
            index.set_start(id, start.copied());
        }
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

/// Has those observed that are in the world at this moment, before boxes are computed.
pub(crate) fn begin_refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    world.run_system_cached(watch_disabling)
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
