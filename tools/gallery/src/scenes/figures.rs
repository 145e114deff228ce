//! The report's Figures 5 to 7: a split and a merge of the octree, in three dimensions.

use bevy::prelude::*;
use bevy_octree::scene::SceneDescription;

use crate::{
    scene::{AddScene as _, Scene},
    settings::Leaves,
};

const FILE: &str = include_str!("../../../../assets/scenes/figures_5_7.scene.ron");

/// Adds the sequence.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        "figures",
        "a node splits, and its leaves merge",
        "Figures 5 to 7 of the report, N = 2: the outer objects travel to the one in the middle. When \
         the right one crosses the middle plane, the left half has three objects, and splits; when it \
         has bounced back, the leaves merge.",
        |world, _| spawn(world, FILE),
    );
    app.add_scene(
        scene
            .view(Vec3::new(4.2, 3.8, 11.5), Vec3::new(0.4, 0.0, 0.0))
            .octree(2, Leaves::Generation)
            .best_tick(24)
            .ends_at(64),
    );
}

/// Spawns the objects of a scene file.
pub fn spawn(world: &mut World, file: &str) {
    let scene = SceneDescription::parse(file);
    let spawned = scene.and_then(|scene| scene.spawn(&mut world.commands()));
    if let Err(error) = spawned {
        error!("{error}");
    }
    world.flush();
}
