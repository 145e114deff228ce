//! Continuous detection: for what moves far in a tick, measured by how thick things are.
//!
//! Without it, entities are looked at where they are at the end of each tick, as in the report,
//! whose scenes keep steps small against sizes (Swan 1994, section 1.2): what moves further can
//! pass through another unnoticed. An entity with [`Swept`] is looked at all along its way.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.01) });
//! // A wall as thin as paper, and a bullet that covers five times its size per tick.
//! app.world_mut().spawn(CollisionShape::cuboid(0.002, 10.0, 10.0));
//! let bullet = (CollisionShape::sphere(0.1), Bounce::Reflect { restitution: 1.0 }, Swept::default());
//! let bullet = app.world_mut().spawn((bullet, Velocity(Vec3::X * 100.0), Transform::from_xyz(-1.4, 0.0, 0.0))).id();
//! app.update();
//! app.update();
//! // It is met after 1.3 of the 2 units, and has come back as far as is left.
//! let x = app.world().get::<Transform>(bullet).unwrap().translation.x;
//! assert!((x + 0.801).abs() < 1e-3, "{x}");
//! assert_eq!(app.world().resource::<Contacts>().len(), 1);
//! ```
//!
//! The techniques are the second and the third that the report quotes from Cameron (1985): volumes
//! swept by motion, and intersection in space and time, which for constant velocities is a matter
//! of solving equations.
//!
//! # What is done
//!
//! The box of such an entity covers its whole way in a tick
//! ([`NarrowPhase::swept_aabb`](crate::narrow_phase::NarrowPhase::swept_aabb)), so that no pair is
//! missed; the exact test of a pair finds the [time of
//! impact](crate::narrow_phase::NarrowPhase::time_of_impact), and its contact is that of this
//! moment. Turns count too. Where the entity bounces, it does so at the time of impact, and moves
//! on for the rest of the tick by its new velocity; what it meets on the way is found the same way,
//! in the order of time, up to a [bound](Swept::sub_steps).
//!
//! It is done in the set [`NarrowPhase`](crate::CollisionSystems::NarrowPhase), for what is met
//! later in a tick depends on how things bounce earlier in it; velocities and transforms change in
//! [`Response`](crate::CollisionSystems::Response).
//!
//! A response of one's own (in place of the [`BouncePlugin`](crate::plugins::BouncePlugin)) finds a
//! swept entity at the end of its way, beyond what it met, and when it met in
//! [`Collision::time`](crate::contacts::Collision::time). It has to put it back, by its velocity
//! and what was left of the tick, and to insert [`Swept`] anew, so that the next way begins there.
//!
//! # What ends at its first hit
//!
//! What has no [`Bounce`](crate::response::Bounce) passes through all that it meets, and all of it
//! is told in the tick in which it passes: by the time somebody hears of the first wall, the second
//! has been met. A bullet is to be [`Swept::stopping`]: it [stops](AtSolid::Stop) at the first solid
//! that it meets, with its velocity, and is told of that and of the sensors before it, and of nothing
//! behind it. Whoever hears of it may despawn it there, and finds it where it hit:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! #[derive(Component)]
//! struct Bullet;
//!
//! fn shoot(mut commands: Commands) {
//!     commands.spawn((Bullet, CollisionShape::sphere(0.01), Velocity(Vec3::X * 900.0), Swept::stopping(), Transform::default()));
//! }
//!
//! /// In the set `CollisionSystems::Last`.
//! fn hit(mut started: MessageReader<CollisionStarted>, bullets: Query<(), With<Bullet>>, sensors: Query<(), With<Sensor>>, mut commands: Commands) {
//!     for message in started.read() {
//!         let message = if bullets.contains(message.a) { *message } else { message.reversed() };
//!         let (bullet, target) = (message.a, message.b);
//!         if bullets.contains(bullet) && !sensors.contains(target) {
//!             println!("{bullet} hits {target}, after {} of the tick", message.time);
//!             // On an edge of two targets, it hits both.
//!             commands.entity(bullet).try_despawn();
//!         }
//!     }
//! }
//! ```
//!
//! One that nobody despawns stays where it is, in contact with what it hit, and goes on once that is
//! gone. To all that it meets after it has stopped, it is a wall at rest; what it hits answers as to
//! a wall that comes with its velocity. Of two that stop and hit each other, both do. What one bullet
//! destroys has stopped all others of the same tick, for nobody has heard of that before.
//!
//! The [`BouncePlugin`](crate::plugins::BouncePlugin) sees to this, in the order of time with all
//! bounces. A bullet that is [moved elsewhere](crate::motion::MovedElsewhere), or has no velocity, is
//! told of nothing behind the solid either, and stays where its mover put it.
//!
//! # The order of what is told
//!
//! | what | in which order |
//! |---|---|
//! | messages [`CollisionStarted`](crate::contacts::CollisionStarted) | by time within the tick; at the same time, that of the [`Contacts`](crate::contacts::Contacts) |
//! | events `CollisionStarted`, for observers | the same, after those of all that ended; of one contact, that of `a` first |
//! | messages and events [`CollisionEnded`](crate::contacts::CollisionEnded) | that of the `Contacts`: an end has no time |
//! | bounces | by time; at the same time, who comes nearer the least first |
//! | [`Contacts`](crate::contacts::Contacts), [`Collisions`](crate::contacts::Collisions) | by pair, as contacts stay from tick to tick and are looked up; each has its [time](crate::contacts::Collision::time), of which the least is the first hit |
//! | [`CollidingEntities`](crate::contacts::CollidingEntities) | none |
//!
//! Of observers, that of a *bullet* which goes on is told of the first wall alone if it despawns the
//! bullet, for it goes with it. Observers of walls are told of the bullet one after the other, whatever
//! has become of it.
//!
//! # Which triangle it hit
//!
//! A contact tells no polygon, as a [ray's hit](crate::spatial_query::RayHit::polygon) does. A short
//! ray along the contact's normal does so, of what is at rest:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! /// Which polygon of `b` has `a` hit? Of a Bevy mesh, which triangle?
//! fn polygon_hit(started: &CollisionStarted, spatial: &SpatialQuery) -> Option<u32> {
//!     const REACH: f32 = 0.01;
//!     let contact = started.contact?;
//!     // From just before the surface to just behind it.
//!     let ray = Ray3d::new(contact.point - REACH * contact.normal, Dir3::new(contact.normal).ok()?);
//!     let is_hit = |entity| entity == started.b;
//!     let filter = SpatialQueryFilter::DEFAULT.only(&is_hit);
//!     spatial.cast_ray(ray, 2.0 * REACH, &filter)?.polygon
//! }
//! ```
//!
//! The contact is there if [somebody asks](crate::contacts::CollisionEventSettings::geometry). On an
//! edge, several polygons are met; one of them is told. The other way is to cast the bullet once
//! more, from where its way [began](SweptWay::last_start) to where it is, by
//! [`SpatialQuery::cast_shape_with`](crate::spatial_query::SpatialQuery::cast_shape_with) and
//! [`ShapeCastOptions::find_polygon`](crate::spatial_query::ShapeCastOptions::find_polygon): of
//! what does not turn. The example `bullets` does all of this.
//!
//! # Cost
//!
//! A tick looks at every entity with [`Swept`]; for those that moved, boxes are larger and
//! exact tests dearer. Nothing for all others. With 10 000 bullets among 2 000 walls, a tick takes
//! about twice as long as with bullets that are not swept. In a crowd that bounces several times
//! per tick, a body takes some microseconds, whether it is a ball, a cuboid or a small convex mesh, and
//! several times as long if it turns as it goes.

use bevy::{
    ecs::{
        lifecycle::HookContext, message::signal_message_update_system,
        system::RegisteredSystemError, world::DeferredWorld,
    },
    math::primitives::HalfSpace,
    prelude::*,
};
use serde::{Deserialize, Serialize};

use crate::{
    bounds,
    components::{self, BroadPhaseProxy, CollisionShape, WorldAabb},
    disabled::{self, Unfiltered},
    hierarchy::{self, Link},
    narrow_phase::{Moving, NarrowPhase, Placed},
    parts::{BodyParts, CollisionBody, PartOf, RegroupSystems},
    regroup::{self, Due, Regroup},
    schedule::{CollisionSystems, add_to_tick},
    shear::{self, Sheared},
};

pub use crate::way::SweptWay;

/// Has an entity looked at all along its way, however fast it is: see the [module's
/// documentation](self).
///
/// Its way in a tick goes from where it was at the tick before to where it is now, in a straight
/// line, turning by the shorter way, whoever moved it: see [`SweptWay`]. To put it elsewhere
/// without passing through what is between, insert this component anew, with any value. An entity
/// without it counts, for the whole tick, as where it is at the end of it; so of two that move
/// fast, both need it. A new one begins where it is before the set `Motion` of its first tick: what
/// moves it earlier, moves it before it is looked at.
///
/// Where it meets another and [bounces](crate::response::Bounce), it does so only if the two come
/// nearer to each other, by their velocities, and as often as it meets something: what is said of
/// ticks there, holds for impacts here. It moves on for the rest of the tick if it is moved by its
/// [`Velocity`](crate::motion::Velocity); one with a parent does so in the world, wherever the
/// parent goes. What hangs on it goes with it. One that is [moved
/// elsewhere](crate::motion::MovedElsewhere) stays where its mover put it, beyond what it met if
/// that is so: its velocity answers, and the rest is up to its mover.
///
/// Without a `Bounce`, it passes through all that it meets, and is told of each, in the order of
/// time. A bullet is to be [`Swept::stopping`]: see [what ends at its first
/// hit](self#what-ends-at-its-first-hit).
#[doc(alias(
    "ccd",
    "continuous collision detection",
    "tunneling",
    "bullet",
    "tunnelling",
    "swept",
    "sweep test"
))]
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[require(SweptWay)]
#[component(on_insert = begin_anew, on_discard = shrink_box)]
pub struct Swept {
    /// How often the entity may bounce within a tick. At the impact after that, it stays where it
    /// is until the next tick, as a wall at rest to all that it meets, and keeps its velocity. This
    /// bounds the search for impacts, too.
    pub sub_steps: u32,
    /// What it does where it meets something solid.
    pub at_solid: AtSolid,
}

/// What an entity that is [`Swept`] does where it meets something solid: something that it
/// [hears](crate::filters::Detector) of and comes nearer to, where neither is a
/// [`Sensor`](crate::filters::Sensor).
///
/// To go on is the default, as a detector changes nothing by itself: what has no [`Bounce`] is moved
/// by its mover alone, unless somebody asks for more; a laser, a blade or a shock wave goes through
/// what it hits.
///
/// [`Bounce`]: crate::response::Bounce
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
pub enum AtSolid {
    /// It bounces if it has a [`Bounce`](crate::response::Bounce), and passes through if it has none.
    #[default]
    GoOn,
    /// It stops there, whatever its [`Bounce`](crate::response::Bounce), until the next tick, and
    /// meets nothing of what is behind. See [what ends at its first
    /// hit](self#what-ends-at-its-first-hit).
    Stop,
}

impl Swept {
    /// How often an entity may bounce within a tick, unless told otherwise.
    pub const DEFAULT_SUB_STEPS: u32 = 8;

    /// Makes a component with a bound of its own to the number of bounces within a tick.
    #[must_use]
    pub const fn new(sub_steps: u32) -> Self {
        Self {
            sub_steps,
            at_solid: AtSolid::GoOn,
        }
    }

    /// Makes a component for a bullet: what has it [stops](AtSolid::Stop) at the first thing that it
    /// meets and that is solid.
    #[must_use]
    pub const fn stopping() -> Self {
        Self {
            at_solid: AtSolid::Stop,
            ..Self::new(Self::DEFAULT_SUB_STEPS)
        }
    }
}

impl Default for Swept {
    fn default() -> Self {
        Self::new(Self::DEFAULT_SUB_STEPS)
    }
}

/// Marks a part of a body that is [`Swept`]: so it is, too. Those who look for what is swept ask for
/// [either](IsSwept).
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(SweptWay)]
#[component(on_insert = begin_part_anew, on_discard = shrink_box_of_part, clone_behavior = Ignore)]
pub(crate) struct SweptWithBody;

/// What is swept, by itself or with its body.
pub(crate) type IsSwept = Or<(With<Swept>, With<SweptWithBody>)>;

/// Whoever gets the component has been put where it is.
fn begin_anew(mut world: DeferredWorld, context: HookContext) {
    forget_way(&mut world, context.entity);
    regroup::note_to_sweep(&mut world, context.entity);
}

fn begin_part_anew(mut world: DeferredWorld, context: HookContext) {
    forget_way(&mut world, context.entity);
}

fn forget_way(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut way) = world.get_mut::<SweptWay>(entity) {
        way.forget();
    }
}

/// What was swept no longer is: has the box computed anew.
fn shrink_box(mut world: DeferredWorld, context: HookContext) {
    components::outdate(&mut world, context.entity);
    regroup::note_to_sweep(&mut world, context.entity);
}

fn shrink_box_of_part(mut world: DeferredWorld, context: HookContext) {
    components::outdate(&mut world, context.entity);
}

/// The plugin for continuous detection: it says where the ways of entities with [`Swept`] begin and
/// end.
#[derive(Clone, Copy, Debug, Default)]
pub struct SweptPlugin;

impl Plugin for SweptPlugin {
    fn build(&self, app: &mut App) {
        add_to_tick(app, |app, schedule| {
            let sweep_parts_if_due = sweep_parts
                .ambiguous_with(signal_message_update_system)
                .run_if(|regroup: Res<Regroup>| regroup.is_sweep_due())
                .after(RegroupSystems)
                .before(CollisionSystems::Motion);
            let begin_ways = disabled::see_disabled(app.world_mut(), begin_ways);
            let begin_way = disabled::see_disabled(app.world_mut(), begin_ways_of_bodies);
            let begin = (begin_ways, begin_way)
                .after(CollisionSystems::First)
                .after(sweep_parts)
                .before(CollisionSystems::Motion);
            let stretch = stretch_boxes
                .in_set(CollisionSystems::Bounds)
                .after(bounds::update_children);
            let end_way = disabled::see_disabled(app.world_mut(), end_ways_of_bodies);
            let end = (end_ways, end_way)
                .after(CollisionSystems::Response)
                .before(CollisionSystems::Report);
            app.add_systems(
                schedule,
                (
                    sweep_parts_if_due,
                    (begin, stretch, end).run_if(any_with_component::<Swept>),
                ),
            );
        });
    }
}

/// A body without a shape of its own, with whose way its parts go.
type SweptBody = (With<Swept>, With<CollisionBody>, Without<CollisionShape>);
type SweptShape = (IsSwept, With<CollisionShape>);
type Beginning<'a> = (
    Entity,
    &'a Transform,
    Has<ChildOf>,
    Shaped<'a>,
    &'a BroadPhaseProxy,
    &'a mut SweptWay,
);

/// The way of an entity that is new begins where it is before it first moves.
fn begin_ways(mut swept: Query<Beginning, SweptShape>, links: Query<Link>) {
    for (entity, transform, has_parent, (shape, sheared), proxy, mut way) in &mut swept {
        if way.belongs_to(entity, proxy.id()) && way.has_begun() {
            continue;
        }
        let in_world = || {
            let pose = hierarchy::pose_in_world(entity, &links)?;
            Some(shear::put(shape, &pose, sheared).transform)
        };
        let pose = if has_parent {
            in_world()
        } else {
            Some(*transform)
        };
        way.bypass_change_detection().begin(entity, pose);
    }
}

type Shaped<'a> = (&'a CollisionShape, Option<&'a Sheared>);

/// As [`begin_ways`], of bodies without a shape of their own: of these, only the position counts.
fn begin_ways_of_bodies(mut bodies: Query<(Entity, &mut SweptWay), SweptBody>, links: Query<Link>) {
    for (entity, mut way) in &mut bodies {
        if !(way.belongs_to(entity, None) && way.has_begun()) {
            let pose = position_in_world(entity, &links);
            way.bypass_change_detection().begin(entity, pose);
        }
    }
}

/// Where an entity is, turned in no way.
fn position_in_world(entity: Entity, links: &Query<Link>) -> Option<Transform> {
    let pose = hierarchy::pose_in_world(entity, links)?;
    Some(Transform::from_translation(pose.translation.as_vec3()))
}

/// As [`end_ways`], of bodies without a shape of their own.
fn end_ways_of_bodies(mut bodies: Query<(Entity, &mut SweptWay), SweptBody>, links: Query<Link>) {
    for (entity, mut way) in &mut bodies {
        if way.has_begun()
            && way.belongs_to(entity, None)
            && let Some(pose) = position_in_world(entity, &links)
        {
            way.bypass_change_detection().end(None, &pose);
        }
    }
}

/// Has the parts of bodies swept, or no longer, of which that may have changed.
pub(crate) fn sweep_parts(world: &mut World) {
    let Due { mut entities, all } = world.resource_mut::<Regroup>().take_to_sweep();
    if all {
        let mut parts =
            Unfiltered::<Entity, Or<(With<PartOf>, With<SweptWithBody>)>>::from_world(world);
        entities.extend(parts.0.iter(world));
    }
    entities.sort_unstable();
    entities.dedup();
    for entity in entities {
        // A body that is swept anew has its parts put where they are.
        if let Some(parts) = world.get::<BodyParts>(entity) {
            let mut parts: Vec<_> = parts.entities().iter().copied().collect();
            parts.sort_unstable();
            parts
                .into_iter()
                .for_each(|part| sweep_part(world, part, true));
        }
        sweep_part(world, entity, false);
    }
}

/// Has a part swept if its body is, and only then.
fn sweep_part(world: &mut World, part: Entity, anew: bool) {
    let body = world.get::<PartOf>(part).map(PartOf::body);
    let is_swept = body.is_some_and(|body| world.get::<Swept>(body).is_some());
    let Ok(mut part) = world.get_entity_mut(part) else {
        return;
    };
    if is_swept && (anew || !part.contains::<SweptWithBody>()) {
        part.insert(SweptWithBody);
    } else if !is_swept && part.contains::<SweptWithBody>() {
        part.remove::<SweptWithBody>();
    }
}

/// Each way begins where the last one ended. Who has none in this tick gets one at the next.
fn end_ways(mut swept: Query<(Entity, &BroadPhaseProxy, &mut SweptWay), SweptShape>) {
    for (entity, proxy, mut way) in &mut swept {
        if way.has_begun() && way.belongs_to(entity, proxy.id()) {
            way.bypass_change_detection().end(proxy.id(), proxy.pose());
        }
    }
}

type Stretched<'a> = (
    Entity,
    Shaped<'a>,
    &'a BroadPhaseProxy,
    &'a mut SweptWay,
    &'a mut WorldAabb,
);

/// Stretches boxes along the ways so far, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    world.run_system_cached(stretch_boxes)
}

/// Stretches boxes along the ways that led anywhere, and shrinks those of a tick ago.
pub(crate) fn stretch_boxes(mut swept: Query<Stretched, IsSwept>, tests: Res<NarrowPhase>) {
    for (entity, (own, sheared), proxy, mut way, mut aabb) in &mut swept {
        let shape = shear::shape(own, sheared);
        let start = way
            .to(proxy.pose())
            .filter(|_| way.belongs_to(entity, proxy.id()));
        if let Some(start) = start {
            // Nearly always, the box is that of the end, as it was computed in this tick.
            let quick = if proxy.has_box_of(aabb.last_changed()) {
                tests.stretched((shape, &aabb.0), start, proxy.pose())
            } else {
                None
            };
            // What has no box has had its warning.
            let whole = quick.or_else(|| {
                let moving = Moving::new(shape, start, proxy.pose());
                tests.swept_aabb(&moving).ok()
            });
            if let Some(whole) = whole {
                aabb.0 = whole;
            }
        } else if way.is_stretched() {
            *aabb = bounds::world_aabb(&tests, entity, shape, proxy.pose());
        }
        let is_stretched = start.is_some();
        way.bypass_change_detection().note_stretched(is_stretched);
    }
}

/// The half-space that an unbounded shape is in all along its way, if there is one: see
/// [`NarrowPhase::side`].
pub(crate) fn side(tests: &NarrowPhase, moving: &Moving) -> Option<HalfSpace> {
    let [start, end] =
        [0.0, 1.0].map(|time| tests.side(Placed::new(moving.shape(), &moving.at(time))));
    let (start, end) = (start?, end?);
    // As it turns, it comes by everywhere.
    (start.normal() == end.normal()).then(|| if start.d() > end.d() { start } else { end })
}

/// What others read though no way begins.
pub(crate) fn register(app: &mut App) {
    app.register_type::<Swept>()
        .register_type::<AtSolid>()
        .register_type::<SweptWay>();
}
