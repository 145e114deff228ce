//! Side by side with `bevy_rapier3d`: Rapier moves bodies, this crate detects contacts of its own.
//! Needs the feature `rapier`.
//!
//! An entity opts in by [`ShapeFromRapier`]: the shape of its Rapier `Collider` is its
//! [`CollisionShape`](crate::components::CollisionShape) from then on. All that this crate does for
//! shapes it then does for the entity: contacts, events for observers, queries, bounces.
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
//! The two crates use some names for components of their own: `Velocity`, `Sensor`,
//! `CollidingEntities`. Import one prelude under a name, as above. They are different components: a
//! Rapier `Sensor` says nothing to this crate, and neither do `CollisionGroups`,
//! `ColliderDisabled`, and the body that a collider is part of: colliders of one body are entities
//! like others. For what may meet, see [`filters`](crate::filters).
//!
//! # Which schedule
//!
//! The plugin is at work in the schedule of the [`OctreePlugins`](crate::OctreePlugins).
//!
//! | Rapier in | this crate in | contacts are those of |
//! |---|---|---|
//! | `FixedUpdate` (`in_fixed_schedule()`) | `FixedPostUpdate`, the default | the step just made, in every step |
//! | any schedule | the same | the step just made: all sets run after `PhysicsSet::Writeback` |
//! | `PostUpdate`, its default | `FixedPostUpdate` | the frame before; steps between two fixed ticks are seen as one |
//!
//! Where Rapier interpolates (`TimestepMode::Interpolated`), contacts are those of the places that
//! it writes, between two steps.
//!
//! Rapier looks for its own contacts at the start of a step, before bodies move, so that its events
//! and pairs tell in the next step what is found here in this one.
//!
//! # Scale
//!
//! Rapier bakes the scale of an entity into its collider, in `PhysicsSet::SyncBackend`. A collider
//! is taken up once Rapier has done so for the first time, and again whenever it changes.
//!
//! # Bounces
//!
//! An entity with a Rapier `Velocity` that has [`ShapeFromRapier`] or
//! [`Bounce`](crate::response::Bounce), and no [`Velocity`](crate::motion::Velocity) of ours, gets
//! one, which mirrors that of Rapier, and [`MovedElsewhere`](crate::motion::MovedElsewhere), so
//! that only Rapier moves it. What bounces off it answers to how fast it is; a body that Rapier
//! does not move, because it is fixed or disabled, is at rest, whatever velocity it was given. Both
//! components go with the last of what they came for.
//!
//! Where there is a `Bounce` too, contacts change the linear velocity, by the same rules as all
//! others. Rapier takes it up in its next step. Rapier itself parts bodies that are solid to it:
//! bounces are for sensors and kinematic bodies.

mod shape;
mod velocity;

use bevy::prelude::*;
use bevy_rapier3d::{
    geometry::Collider,
    plugin::{PhysicsSet, RapierContextInitialization, systems::sync_removals},
};

pub use shape::ShapeFromRapier;

use crate::schedule::{CollisionSystems, add_to_tick, expect_ticks};

/// Keeps shapes, order of systems and velocities in step with `bevy_rapier3d`: see the
/// [module](self).
///
/// Add it beside [`OctreePlugins`](crate::OctreePlugins) and `RapierPhysicsPlugin`, in any order.
/// Colliders without [`ShapeFromRapier`] cost nothing per tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct RapierInteropPlugin {
    all: bool,
}

impl RapierInteropPlugin {
    /// Gives [`ShapeFromRapier`] to every entity that gets a `Collider` from now on. Remove it from
    /// those that are not to take part.
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
        shape::register(app);
        add_to_tick(app, |app, schedule| {
            // Where Rapier runs in another schedule, its set is empty here, and orders nothing. What
            // was removed, it then notices in `PostUpdate`: before the tick, as in its own schedule.
            app.configure_sets(
                schedule,
                CollisionSystems::First
                    .after(PhysicsSet::Writeback)
                    .after(sync_removals),
            );
            shape::add_systems(app, schedule);
            velocity::add_systems(app, schedule);
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "RapierInteropPlugin");
        if !app
            .world()
            .contains_resource::<RapierContextInitialization>()
        {
            tracing::warn!("there is no `RapierPhysicsPlugin`: no collider becomes a shape");
        }
    }
}
