//! What is allocated: in a program of its own, for its allocator counts for all that runs in it.

#[path = "../common/allocator.rs"]
mod allocator;
#[expect(dead_code, reason = "shared with other tests")]
#[path = "../common/mod.rs"]
mod common;
mod counted;
mod soak;
mod swept;
mod walking;

use std::time::Duration;

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
};

/// An app that moves by `seconds` in each update.
fn app(seconds: f32) -> App {
    // Bevy keeps messages until a fixed timestep has passed. By the clock of the machine, their
    // buffers would grow with its load.
    let longer_than_a_timestep = Duration::from_millis(20);
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(TimeUpdateStrategy::ManualDuration(longer_than_a_timestep))
        .insert_resource(MotionSettings {
            step: Step::Seconds(seconds),
        });
    app
}
