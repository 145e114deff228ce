//! The stress scenes, by which broad phases are measured: up to 50 000 moving cubes.

use bevy::{
    math::{
        Vec3A,
        bounding::{Aabb3d, BoundingVolume},
    },
    prelude::*,
};
use bevy_octree::{
    prelude::*,
    scene::stress::{StressScene, StressSimulation},
};

use crate::{
    play::Tick,
    scene::{AddScene as _, OfScene, Scene, View},
    settings::Leaves,
};

const SEED: u64 = 7;
/// What is larger is no object to look at, but a ground below them.
const LARGEST: f32 = 2000.0;
/// What is farther from the first object is in another room.
const ROOM: f32 = 5000.0;

/// Adds a scene for each rule.
pub fn plugin(app: &mut App) {
    for scene in StressScene::ALL {
        // The report's planes have scenes of their own.
        if scene != StressScene::Planes {
            app.add_scene(of(scene));
        }
    }
    app.add_systems(
        Tick,
        (step, follow).chain().in_set(CollisionSystems::Motion),
    );
}

fn of(scene: StressScene) -> Scene {
    let (title, about) = match scene {
        StressScene::Brownian => (
            "cubes in random motion",
            "Everything moves, and little changes from tick to tick. Let there be 50 000, and choose \
             exhaustive search.",
        ),
        StressScene::Freefall => (
            "cubes fall, pile up, and rest",
            "What has come to rest costs next to nothing.",
        ),
        StressScene::Gravity => (
            "a cloud about a moving attractor",
            "Everything moves fast, and the crowd is elsewhere in each tick.",
        ),
        StressScene::Planes => ("two planes of cubes", "As in the report."),
        StressScene::Static90 => (
            "nine cubes in ten rest",
            "Only what moves is looked at: the rest costs a look at its change tick.",
        ),
        StressScene::Sizes => (
            "sides from 1 to 1 000",
            "Small ones among large ones: no grid has cells for all of them.",
        ),
        StressScene::Clusters => (
            "nine cubes in ten in a hundredth of the space",
            "The leaves of the octree are a map of where objects crowd.",
        ),
        StressScene::Ground => (
            "cubes over one large ground",
            "One box that is much larger than all others.",
        ),
        StressScene::Outlier => (
            "one cube goes far away",
            "In the fourth tick, one goes a million away; the octree grows towards it, and the others \
             hardly notice.",
        ),
        StressScene::Rooms => (
            "rooms far from each other",
            "Four rooms, ten thousand apart; here is one of them.",
        ),
    };
    let leaves = match scene {
        StressScene::Clusters => Leaves::Fill,
        _ => Leaves::None,
    };
    Scene::new(scene.name(), title, about, move |world, objects| {
        spawn(world, scene, objects);
    })
    .view_of(move |objects| view(scene, objects))
    .objects(2000, 50_000)
    .octree(32, leaves)
    .best_tick(if scene == StressScene::Freefall {
        160
    } else {
        64
    })
}

/// From where all boxes of a room are seen.
fn view(scene: StressScene, objects: usize) -> View {
    let simulation = StressSimulation::new(scene, objects, SEED);
    let boxes = || simulation.boxes().iter().filter(|aabb| is_object(aabb));
    let first = boxes().next().map_or(Vec3A::ZERO, BoundingVolume::center);
    let is_near =
        |aabb: &&Aabb3d| scene != StressScene::Rooms || first.distance(aabb.center()) < ROOM;
    let near = boxes().filter(is_near);
    let room = near.copied().reduce(|room, aabb| room.merge(&aabb));
    let mut room = room.unwrap_or_else(|| Aabb3d::new(Vec3::ZERO, Vec3::ONE));
    if scene == StressScene::Freefall {
        // Where they come to rest, not from where they fall.
        room.max.y = room.min.y + (room.max.x - room.min.x) * 0.7;
    }
    let target = Vec3::from(room.center());
    let reach = room.half_size().length() + 1.0;
    View {
        eye: target + Vec3::new(0.55, 0.45, 1.0).normalize() * reach * 2.6,
        target,
    }
}

fn is_object(aabb: &Aabb3d) -> bool {
    aabb.half_size().max_element() * 2.0 < LARGEST
}

#[derive(Component)]
struct Simulation(StressSimulation);

/// The index of the entity's box in the simulation.
#[derive(Component, Clone, Copy)]
struct Object(usize);

fn spawn(world: &mut World, scene: StressScene, objects: usize) {
    let simulation = StressSimulation::new(scene, objects, SEED);
    // One shape for all, so that they are drawn together.
    let shape = CollisionShape::cuboid(1.0, 1.0, 1.0);
    let boxes = simulation.boxes().iter().enumerate();
    let entities = boxes.map(|(object, aabb)| {
        let place = Transform::from_translation(aabb.center().into())
            .with_scale(Vec3::from(aabb.half_size()) * 2.0);
        (Object(object), shape.clone(), place)
    });
    let entities: Vec<_> = world.spawn_batch(entities.collect::<Vec<_>>()).collect();
    for (entity, aabb) in entities.into_iter().zip(simulation.boxes()) {
        if !is_object(aabb) {
            world.entity_mut(entity).insert(StaticShape);
        }
    }
    world.spawn((OfScene, Simulation(simulation)));
}

fn step(mut simulations: Query<&mut Simulation>) {
    for mut simulation in &mut simulations {
        simulation.0.step();
    }
}

/// Entities go where their boxes are. What does not move must not count as changed.
fn follow(simulations: Query<&Simulation>, mut entities: Query<(&Object, &mut Transform)>) {
    let Ok(Simulation(simulation)) = simulations.single() else {
        return;
    };
    entities.par_iter_mut().for_each(|(object, mut place)| {
        let center = simulation.boxes()[object.0].center().into();
        if place.translation != center {
            place.translation = center;
        }
    });
}
