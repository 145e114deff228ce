//! The report's test sets: two planes of cubes that meet and bounce (its section 3.1, Figure 8).

use bevy::prelude::*;
use bevy_octree::{prelude::*, scene::TestSet};

use crate::{
    play::TICKS_PER_SECOND,
    scene::{AddScene as _, Scene},
    settings::Leaves,
};

const ABOUT: &str = "Two planes of cubes move towards each other and bounce off in the middle, \
                     the central cubes first, ring after ring.";

/// Adds t0 to t10 of the report, and two that are larger than any of it.
pub fn plugin(app: &mut App) {
    for rings in (0..=10).chain([20, 40]) {
        app.add_scene(scene(rings));
    }
}

fn scene(rings: u32) -> Scene {
    let set = TestSet::new(rings);
    let title = format!("two planes of {} cubes", set.object_count() / 2);
    // The larger the planes, the farther away the eye; from a little aside and above.
    let reach = 1.5 * (rings as f32 + 0.5) + 2.0;
    let eye = Vec3::new(0.85, 0.62, 1.55) * reach * 1.7;
    // All rings have met, or most.
    let best = 20 + 4 * u64::from(rings.min(10));
    Scene::new(set.name(), title, ABOUT, move |world, _| {
        spawn(world, &set);
    })
    .view(eye, Vec3::ZERO)
    .octree(
        8,
        if rings <= 5 {
            Leaves::Generation
        } else {
            Leaves::None
        },
    )
    .best_tick(best)
    .ends_at(90 + 4 * u64::from(rings))
}

fn spawn(world: &mut World, set: &TestSet) {
    let cubes = set.cubes().map(|cube| {
        (
            CollisionShape::cuboid(set.side, set.side, set.side),
            Velocity(cube.velocity * TICKS_PER_SECOND),
            Bounce::Reverse,
            Transform::from_translation(cube.position),
        )
    });
    world.spawn_batch(cubes.collect::<Vec<_>>());
}
