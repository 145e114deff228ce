//! An app without a window, a tick per update.

use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
    scene::{Cube, TestSet},
};

/// Ticks per second: a power of two, so that velocities per tick become velocities per second and
/// back without rounding.
const TICKS_PER_SECOND: f32 = 64.0;

/// An app in which each [`App::update`] is one tick, whatever the real time, with the cubes of a
/// test set in it.
pub fn app_with(set: &TestSet, method: BroadPhaseMethod) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings {
            method,
            ..default()
        })
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / TICKS_PER_SECOND),
        });
    app.finish();
    app.cleanup();
    let side = Vec3::splat(set.side);
    app.world_mut().spawn_batch(
        set.cubes()
            .map(|cube| {
                let place = Transform::from_translation(cube.position).with_scale(side);
                (Cube, place, Velocity(cube.velocity * TICKS_PER_SECOND))
            })
            .collect::<Vec<_>>(),
    );
    app
}
