//! Characters that walk: on the ground, up and down slopes and stairs, on platforms, along walls, and through nothing.
//!
//! There is no physics engine behind it: a character goes where its velocity says, as far as it may.
//! [`KinematicCharacter`] is a component that walks in each tick; [`walk`] is the same as a function, for a system of your
//! own, which may decide about each [hit](crate::move_and_slide::MoveHit) by a callback.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(1.0 / 60.0) });
//! // A floor, and a kerb of 0.2 at x = 2.
//! app.world_mut().spawn((CollisionShape::cuboid(20.0, 1.0, 20.0), Transform::from_xyz(0.0, -0.5, 0.0)));
//! app.world_mut().spawn((CollisionShape::cuboid(4.0, 0.2, 20.0), Transform::from_xyz(4.0, 0.1, 0.0)));
//! let character = (KinematicCharacter::default(), CollisionShape::capsule(0.4, 1.0), Transform::from_xyz(0.0, 1.0, 0.0));
//! let character = app.world_mut().spawn(character).id();
//! for _ in 0..60 {
//!     let mut walking = app.world_mut().get_mut::<KinematicCharacter>(character).unwrap();
//!     // Ahead, and down by gravity; what is on the ground loses that again.
//!     walking.velocity = Vec3::new(4.0, walking.velocity.y - 9.8 / 60.0, 0.0);
//!     app.update();
//! }
//! let at = app.world().get::<Transform>(character).unwrap().translation;
//! assert!((at.x - 4.0).abs() < 0.2 && (at.y - 1.11).abs() < 0.02, "{at}");
//! assert!(app.world().get::<KinematicCharacter>(character).unwrap().is_on_ground());
//! ```
//!
//! # When
//!
//! In the set [`CharacterSystems`], after [`Maintenance`](crate::CollisionSystems::Maintenance) and before
//! [`BroadPhase`](crate::CollisionSystems::BroadPhase): a character sees all that has moved in this tick, platforms
//! included, where it is by now; and what is found out about it in this tick, contacts with triggers and bullets,
//! is about where it has come to. What gives it its velocity is to run before
//! [`Motion`](crate::CollisionSystems::Motion), or anywhere else but in between.
//!
//! # What it meets
//!
//! Whatever it may come into contact with by [layers, worlds and bodies](crate::filters), but for
//! [sensors](crate::filters::Sensor) and what is in a list to [ignore](crate::filters::IgnoreCollisions). It keeps a
//! [skin](crate::move_and_slide::MoveSettings::skin) off all that: so it is not in [contact](crate::contacts::Contacts)
//! with walls and floors. Who wants to know what it runs against gives it [`CharacterHits`].
//!
//! # Ground
//!
//! | what | how |
//! |---|---|
//! | slopes | what is no steeper than [`max_slope`](WalkSettings::max_slope) is ground: it goes up and down as fast as along the level, and stands still on it; what is steeper stops it like a wall, and it slides down there |
//! | steps | up to [`step_height`](WalkSettings::step_height) it climbs as it walks; down to [`snap`](WalkSettings::snap) it stays on the ground |
//! | edges | it stands on the edge of what is flat on top; seams between the triangles of a floor, and between floors, do not hold it |
//! | platforms | what it stands on takes it along as it moves, turns and is scaled, by itself or with whatever it hangs on, as far as there is room |
//! | ledges | it falls, or [stops](WalkSettings::stop_at_ledges) |
//!
//! # Crowds
//!
//! Characters are solid to each other. Each sees where the others are at the start of the tick, and where they are to go; of
//! two that have come into each other, each gives way by half. So the outcome does not depend on their order, nor on the
//! number of threads, on all of which they walk (feature `multi_threaded`).
//!
//! # Limits
//!
//! Shapes that hang on a character, as parts of it, are where it was before it walked until the next tick. One that hangs
//! on another character goes with it in the next.

mod component;
mod gone;
mod ground;
mod room;
mod settings;
mod systems;
mod walk;

use bevy::prelude::*;

pub use component::{CharacterHits, KinematicCharacter};
pub use ground::Ground;
pub use room::{change_shape, has_room};
pub use settings::WalkSettings;
pub use walk::{Walked, walk};

use crate::{
    bounds,
    disabled::see_disabled,
    move_and_slide::{MoveEnd, MoveHit},
    schedule::{CollisionSystems, add_to_tick},
    swept,
};

/// The set of systems in which each [`KinematicCharacter`] walks: between
/// [`Maintenance`](CollisionSystems::Maintenance) and [`BroadPhase`](CollisionSystems::BroadPhase).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterSystems;

/// The plugin for [`KinematicCharacter`]s. Who has none pays nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct CharacterPlugin;

impl Plugin for CharacterPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<KinematicCharacter>()
            .register_type::<CharacterHits>()
            .register_type::<WalkSettings>()
            .register_type::<Ground>()
            .register_type::<MoveHit>()
            .register_type::<MoveEnd>();
        add_to_tick(app, |app, schedule| {
            let place = CharacterSystems
                .after(CollisionSystems::Maintenance)
                .before(CollisionSystems::BroadPhase);
            let some = any_with_component::<KinematicCharacter>;
            let reach = systems::reach
                .in_set(CollisionSystems::Bounds)
                .after(bounds::update_children)
                .after(swept::stretch_boxes)
                .run_if(some);
            let world = app.world_mut();
            let walk = see_disabled(world, systems::walk);
            let settle = see_disabled(world, systems::settle);
            let walk = (walk, settle).chain().in_set(CharacterSystems).run_if(some);
            app.configure_sets(schedule, place)
                .add_systems(schedule, (reach, walk));
        });
    }
}
