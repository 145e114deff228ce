//! Going back in time: what has to be saved, and what it takes to restore it.
//!
//! A game with rollback goes back some ticks and simulates again, with what it knows by then. What a tick
//! of this crate does follows from poses and shapes: no tree, no pair and no handle has to be saved. What
//! it does depend on beside components of yours is one small resource, the [`CollisionSnapshot`]: which
//! contacts are open, where the ways of [swept] entities begin, and the
//! [clock](crate::motion::CollisionClock), all by entity. [Which components are state, and how to save all of it with a
//! rollback crate](crate::guide::rollback), is on a page of the guide.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::{prelude::*, rollback::{CollisionSnapshot, RollbackPlugin}};
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update), RollbackPlugin))
//!     .insert_resource(MotionSettings { step: Step::Seconds(1.0) });
//! let ball = (CollisionShape::sphere(0.5), Velocity(Vec3::X), Bounce::Reflect { restitution: 1.0 });
//! let ball = app.world_mut().spawn((ball, CollisionOrder(1), Transform::from_xyz(-2.2, 0.0, 0.0))).id();
//! app.world_mut().spawn((CollisionShape::cuboid(1.0, 1.0, 1.0), CollisionOrder(2)));
//!
//! app.update();
//! let saved = app.world().resource::<CollisionSnapshot>().clone();
//! let state = app.world().entity(ball).get_components::<(&Transform, &Velocity)>().unwrap();
//! let (place, velocity) = (*state.0, *state.1);
//! (0..3).for_each(|_| app.update());
//! let there = *app.world().get::<Transform>(ball).unwrap();
//!
//! // Back, and the same again.
//! app.world_mut().entity_mut(ball).insert((place, velocity));
//! app.insert_resource(saved);
//! (0..3).for_each(|_| app.update());
//! assert_eq!(*app.world().get::<Transform>(ball).unwrap(), there);
//! ```
//!
//! # The same on another machine
//!
//! Things that are spawned again, or on another machine, have another [`Entity`]: give what takes part a
//! [`CollisionOrder`], and the order of things is the same everywhere.

use bevy::{
    ecs::entity::{EntityHashMap, EntityMapper, MapEntities},
    prelude::*,
};

use crate::{
    broad_phase::ProxyId,
    collision_index::CollisionIndex,
    collision_order::CollisionOrder,
    components::BroadPhaseProxy,
    contacts::{Contacts, Places, SavedContacts},
    disabled,
    maintenance::maintain,
    motion::CollisionClock,
    parts::regroup,
    regroup::Regroup,
    schedule::{CollisionSystems, add_to_tick, expect_ticks},
    swept,
    way::SweptWay,
};

/// The plugin that keeps the [`CollisionSnapshot`], and goes back to one that is put in its place.
///
/// Beside [`OctreePlugins`](crate::OctreePlugins), which it is not part of: a snapshot costs a copy of all contacts in each
/// tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct RollbackPlugin;

impl Plugin for RollbackPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CollisionSnapshot>()
            .init_resource::<Restoring>()
            .register_type::<CollisionSnapshot>();
        add_to_tick(app, |app, schedule| {
            let restore_state = restore_state
                .in_set(RestoreSystems)
                .before(CollisionSystems::First);
            let catch_up = catch_up
                .in_set(RestoreSystems)
                // What parts belong to concerns nobody else so early.
                .ambiguous_with_all()
                .before(self::restore_state)
                .run_if(resource_exists_and_changed::<CollisionSnapshot>);
            // By then, all who are there have their handles. Whoever is disabled may have been in contact.
            let restore_contacts = disabled::see_disabled(app.world_mut(), restore_contacts)
                .in_set(CollisionSystems::Maintenance)
                .after(maintain)
                .run_if(|restoring: Res<Restoring>| restoring.is_due);
            let take = take_snapshot
                .after(CollisionSystems::Last)
                .after(CollisionClock::advance)
                // In a tick that leaves maintenance out, what is to be restored stays.
                .run_if(|restoring: Res<Restoring>| !restoring.is_due);
            app.add_systems(schedule, (catch_up, restore_state, restore_contacts, take));
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "RollbackPlugin");
    }
}

/// Where a snapshot that was put back is taken up: ways of [swept](crate::swept::Swept) entities and the clock, before
/// [`First`](CollisionSystems::First). Systems of your own that come before `First` and put entities elsewhere, or ask
/// the clock, are to come after this.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RestoreSystems;

/// What the outcome of the next tick depends on beside components of yours: which contacts are open and
/// whom was told, where the ways of [swept](crate::swept::Swept) entities begin, and the number of the tick.
///
/// It is written at the end of each tick. To go back, put one of before in its place, by
/// `insert_resource` or by a write to it, before the next tick: that begins where the other one ended.
/// Contacts that were open then go on, without a word; those that have started since are as if they had
/// never been. One that was never written is that of a world before its first tick.
///
/// Components are yours to restore, before that tick: transforms, velocities, and whatever else has
/// changed. What is despawned since its snapshot and not spawned again is in contact with nothing: that ends, as ever,
/// with a message.
///
/// # Reports of what is simulated again
///
/// Starts and ends are told as they happen, in each tick that is simulated: what happens again is told again,
/// and what does not happen this time was told by mistake. Who is to hear of each but once, as a sound is to be
/// heard, notes what was told by the number of the tick ([`tick`](Self::tick)), or waits until that is confirmed.
/// Messages are no state: clear them when you go back, or read them in each tick.
///
/// # Entities that change their names
///
/// It is [`MapEntities`], for those who spawn things again: those in it become their successors.
///
/// # Cost
/// 120 bytes or so for each contact. Taking it is a copy; after a restore, one tick looks at all pairs, as the first
/// tick does. No trees, no pairs of boxes: these follow from where things are.
#[doc(alias("rollback", "netcode", "save state", "restore", "serialize"))]
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionSnapshot {
    tick: u64,
    contacts: SavedContacts,
    ways: Vec<SavedWay>,
}

/// Where the way of an entity begins, and where that of the last tick began.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedWay {
    entity: Entity,
    start: Option<Transform>,
    last: Option<Transform>,
}

impl CollisionSnapshot {
    /// Returns the number of the tick that comes next: see [`CollisionClock::tick`].
    #[must_use]
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Returns the number of contacts that are open.
    #[must_use]
    pub const fn contacts(&self) -> usize {
        self.contacts.len()
    }
}

impl MapEntities for CollisionSnapshot {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.contacts.map_entities(mapper);
        for way in &mut self.ways {
            way.entity = mapper.get_mapped(way.entity);
        }
    }
}

/// Contacts are those of another time until they are restored.
#[derive(Resource, Debug, Default)]
struct Restoring {
    is_due: bool,
    /// Those in the snapshot that were in the index when it was put back, by which handles; of which index. Who has another
    /// by the time contacts are restored, has left in between, which ends them.
    handles: EntityHashMap<ProxyId>,
    index: u64,
}

/// Sees to it that parts which are there again, or whose body is marked anew, have their ways before these are those of
/// before: later, they would begin anew.
fn catch_up(world: &mut World) {
    let is_due = |world: &World, due: fn(&Regroup) -> bool| world.get_resource().is_some_and(due);
    if is_due(world, Regroup::is_due) {
        regroup(world);
    }
    if is_due(world, Regroup::is_sweep_due) {
        swept::sweep_parts(world);
    }
}

/// Goes back, if somebody has put another snapshot in place of the one that was taken.
fn restore_state(
    snapshot: Res<CollisionSnapshot>,
    mut clock: ResMut<CollisionClock>,
    mut restoring: ResMut<Restoring>,
    mut ways: Query<(Entity, &mut SweptWay)>,
    (proxies, index): (Query<&BroadPhaseProxy>, Option<Res<CollisionIndex>>),
    mut is_known: Local<bool>,
) {
    // That it is there at all is no change.
    let is_new = !std::mem::replace(&mut *is_known, true);
    if !snapshot.is_changed() || (is_new && *snapshot == CollisionSnapshot::default()) {
        return;
    }
    restoring.is_due = true;
    restoring.handles.clear();
    if let Some(index) = index {
        restoring.index = index.number();
        let entities = snapshot.contacts.entities();
        restoring.handles.extend(entities.filter_map(|(entity, _)| {
            let id = proxies.get(entity).ok()?.id()?;
            index.is_entry_of(id, entity).then_some((entity, id))
        }));
    }
    clock.set_tick(snapshot.tick);
    for (_, mut way) in &mut ways {
        way.forget();
    }
    for saved in &snapshot.ways {
        if let Ok((entity, mut way)) = ways.get_mut(saved.entity) {
            way.restore(entity, saved.start, saved.last);
        }
    }
}

fn restore_contacts(
    snapshot: Res<CollisionSnapshot>,
    (mut contacts, mut index): (ResMut<Contacts>, ResMut<CollisionIndex>),
    (proxies, orders): (Query<&BroadPhaseProxy>, Query<Option<&CollisionOrder>>),
    mut restoring: ResMut<Restoring>,
) {
    restoring.is_due = false;
    let is_same_index = restoring.index == index.number();
    let id_of = |entity: Entity, index: &CollisionIndex| {
        let id = proxies.get(entity).ok()?.id()?;
        let before = restoring.handles.get(&entity).filter(|_| is_same_index);
        let has_stayed = before.is_none_or(|before| *before == id);
        (has_stayed && index.is_entry_of(id, entity)).then_some(id)
    };
    let saved = &snapshot.contacts;
    // This index may never have known those who are gone.
    for (entity, order) in saved.entities() {
        if let Some(order) = order
            && id_of(entity, &index).is_none()
        {
            index.restore_order(entity, order);
        }
    }
    for (body, order) in saved.bodies() {
        if let Some(order) = order
            && !orders.contains(body)
        {
            index.remember_order(body, order);
        }
    }
    let places = Places {
        of_body: &|body| Some(orders.get(body).ok()?.map(|order| order.0)),
        index: &index,
    };
    contacts.restore(saved, |entity| id_of(entity, &index), &places);
    // What rests was at rest at another time.
    index.search_all();
}

/// Writes down how things are at the end of the tick.
fn take_snapshot(
    mut snapshot: ResMut<CollisionSnapshot>,
    (contacts, index): (Res<Contacts>, Option<Res<CollisionIndex>>),
    clock: Res<CollisionClock>,
    ways: Query<(Entity, Option<&CollisionOrder>, &SweptWay), swept::IsSwept>,
    mut order: Local<Vec<(bool, u64, SavedWay)>>,
) {
    // Only others who write to it have something restored.
    let snapshot = snapshot.bypass_change_detection();
    snapshot.tick = clock.tick();
    contacts.save(&mut snapshot.contacts, index.as_deref());
    // Whatever order tables are in, and entities have.
    order.extend(
        ways.iter()
            .filter(|(.., way)| way.has_begun())
            .map(|(entity, order, way)| {
                let saved = SavedWay {
                    entity,
                    start: way.start().copied(),
                    last: way.last_start().copied(),
                };
                (order.is_none(), order.map_or(0, |order| order.0), saved)
            }),
    );
    order.sort_unstable_by_key(|(is_last, order, way)| (*is_last, *order, way.entity));
    snapshot.ways.clear();
    snapshot.ways.extend(order.drain(..).map(|(.., way)| way));
}
