//! Side by side with `bevy_rapier3d`: Rapier moves bodies, this crate detects contacts of its own. Needs the feature
//! `rapier`.
//!
//! An entity opts in by [`ShapeFromRapier`]: the shape of its Rapier `Collider` is its [`CollisionShape`] from then on.
//! All that this crate does for shapes it then does for the entity: contacts, events for observers, queries, bounces.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//! use bevy_rapier3d::prelude as rapier;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, TransformPlugin))
//!     .insert_resource(rapier::TimestepMode::Fixed { dt: 0.5, substeps: 1 })
//!     .add_plugins(rapier::RapierPhysicsPlugin::<()>::default())
//!     .add_plugins((OctreePlugins::new(PostUpdate), RapierInteropPlugin::default()));
//!
//! let gate = (rapier::Collider::cuboid(1.0, 1.0, 1.0), rapier::Sensor, ShapeFromRapier);
//! app.world_mut().spawn((gate, Transform::default()));
//! let ball = (rapier::RigidBody::Dynamic, rapier::Collider::ball(0.5), ShapeFromRapier);
//! app.world_mut().spawn((ball, Transform::from_xyz(0.0, 3.0, 0.0)));
//! app.update();
//! assert_eq!(app.world().resource::<Contacts>().len(), 1); // it has fallen into the gate
//! ```
//!
//! The two crates use some names for components of their own: `Velocity`, `Sensor`, `CollidingEntities`. Import one
//! prelude under a name, as above. They are different components: a Rapier `Sensor` says nothing to this crate, and
//! neither do `CollisionGroups`, `ColliderDisabled`, and the body that a collider is part of: colliders of one body
//! are entities like others. For what may meet, see [`filters`](crate::filters).
//!
//! # Which schedule
//!
//! The plugin has to be told the schedule of the [`OctreePlugins`](crate::OctreePlugins).
//!
//! | Rapier in | this crate in | contacts are those of |
//! |---|---|---|
//! | `FixedUpdate` (`in_fixed_schedule()`) | `FixedPostUpdate`, the default | the step just made, in every step |
//! | any schedule | the same | the step just made: all sets run after `PhysicsSet::Writeback` |
//! | `PostUpdate`, its default | `FixedPostUpdate` | the frame before; steps between two fixed ticks are seen as one |
//!
//! Where Rapier interpolates (`TimestepMode::Interpolated`), contacts are those of the places that it writes, between two
//! steps.
//!
//! Rapier looks for its own contacts at the start of a step, before bodies move, so that its events and pairs tell in
//! the next step what is found here in this one.
//!
//! # Scale
//!
//! Rapier bakes the scale of an entity into its collider, in `PhysicsSet::SyncBackend`. A collider is taken up once
//! Rapier has done so for the first time, and again whenever it changes.
//!
//! # Bounces
//!
//! An entity with a Rapier `Velocity` that has [`ShapeFromRapier`] or [`Bounce`](crate::response::Bounce), and no
//! [`Velocity`](crate::motion::Velocity) of ours, gets one, which mirrors that of Rapier, and
//! [`MovedElsewhere`](crate::motion::MovedElsewhere), so that only Rapier moves it. What bounces off it answers to how fast
//! it is; a body that Rapier does not move, because it is fixed or disabled, is at rest, whatever velocity it was given.
//! Both components go with the last of what they came for.
//!
//! Where there is a `Bounce` too, contacts change the linear velocity, by the same rules as all others. Rapier takes it up
//! in its next step. Rapier itself parts bodies that are solid to it: bounces are for sensors and kinematic bodies.

mod velocity;

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use bevy_rapier3d::{
    geometry::{Collider, RapierColliderHandle},
    plugin::{PhysicsSet, RapierContextInitialization},
};
use std::sync::Arc;

use crate::{
    components::CollisionShape,
    hierarchy,
    narrow_phase::Shape,
    schedule::{CollisionSystems, add_to_tick, expect_ticks},
};

/// Gives an entity the shape of its Rapier `Collider`.
///
/// Its [`CollisionShape`] comes with the collider, follows it when it changes or is scaled, and goes with it, or with
/// this marker. A shape that others give to the entity is replaced.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[component(on_remove = drop_shape)]
pub struct ShapeFromRapier;

/// Keeps shapes, order of systems and velocities in step with `bevy_rapier3d`: see the [module](self).
///
/// Add it beside [`OctreePlugins`](crate::OctreePlugins) and `RapierPhysicsPlugin`, in any order. Colliders without
/// [`ShapeFromRapier`] cost nothing per tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct RapierInteropPlugin {
    all: bool,
}

impl RapierInteropPlugin {
    /// Gives [`ShapeFromRapier`] to every entity that gets a `Collider` from now on. Remove it from those that are not
    /// to take part.
    #[must_use]
    pub const fn for_all_colliders(self) -> Self {
        Self { all: true }
    }
}

impl Plugin for RapierInteropPlugin {
    fn build(&self, app: &mut App) {
        if self.all
            && let Err(error) = app.try_register_required_components::<Collider, ShapeFromRapier>()
        {
            tracing::warn!("colliders do not become shapes by themselves: {error}");
        }
        app.add_observer(on_collider_removed).register_type::<ShapeFromRapier>();
        add_to_tick(app, |app, schedule| {
            let follow = hierarchy::see_disabled(app.world_mut(), follow_colliders);
            let follow = follow.after(CollisionSystems::Motion).before(CollisionSystems::Bounds);
            // Where Rapier runs in another schedule, its set is empty here, and orders nothing.
            app.configure_sets(schedule, CollisionSystems::First.after(PhysicsSet::Writeback))
                .add_systems(schedule, follow);
            velocity::add_systems(app, schedule);
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "RapierInteropPlugin");
        if !app.world().contains_resource::<RapierContextInitialization>() {
            tracing::warn!("there is no `RapierPhysicsPlugin`: no collider becomes a shape");
        }
    }
}

type Followed<'a> = (Entity, &'a Collider, Option<&'a mut CollisionShape>);
/// Colliders that Rapier has scaled: it does so right after it gave them a handle.
type Known = (With<ShapeFromRapier>, With<RapierColliderHandle>);
type Altered = Or<(Changed<Collider>, Added<ShapeFromRapier>, Added<RapierColliderHandle>)>;

fn follow_colliders(
    mut commands: Commands,
    // What changes in a disabled entity is not seen as a change once it is enabled.
    mut colliders: Query<Followed, (Known, Altered)>,
) {
    for (entity, collider, shape) in &mut colliders {
        match shape {
            // Colliders are marked as changed more often than they do. Who writes to a shape that is shared, here too,
            // writes to a copy.
            Some(shape) if matches!(&shape.0, Shape::Rapier(known) if Arc::ptr_eq(&known.0, &collider.raw.0)) => {}
            Some(mut shape) => shape.0 = collider.into(),
            None => {
                commands.entity(entity).try_insert(CollisionShape(collider.into()));
            }
        }
    }
}

/// The shape goes in the moment in which the collider goes.
fn on_collider_removed(event: On<Remove, Collider>, mut world: DeferredWorld) {
    if world.get::<ShapeFromRapier>(event.entity).is_some() {
        world.commands().entity(event.entity).try_remove::<CollisionShape>();
    }
}

fn drop_shape(mut world: DeferredWorld, context: HookContext) {
    world.commands().entity(context.entity).try_remove::<CollisionShape>();
}
