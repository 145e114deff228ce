//! Side by side with Rapier: it makes things fall and stack, this crate tells what they pass.

use bevy::prelude::*;
use bevy_octree::{
    filters::{CollisionLayers, Detector, LayerMask},
    prelude::*,
};
use bevy_rapier3d::prelude as rapier;

use crate::{
    play::{TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, OfScene, Scene, showing},
};

const NAME: &str = "rapier";

/// Adds the scene, and Rapier.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "Rapier makes things fall, gates tell of them",
        "Rapier's bodies fall, roll and stack. This crate has their colliders as shapes, and gates \
         that Rapier knows nothing of: they light up while something passes.",
        spawn,
    );
    app.add_scene(
        scene
            .view(Vec3::new(11.0, 9.0, 19.0), Vec3::new(0.0, 3.5, 0.0))
            .objects(60, 1000)
            .best_tick(110)
            .ends_at(900)
            .caption(say),
    )
    .insert_resource(rapier::TimestepMode::Fixed {
        dt: 1.0 / TICKS_PER_SECOND,
        substeps: 1,
    })
    .add_plugins((
        rapier::RapierPhysicsPlugin::<()>::default().in_schedule(Tick),
        RapierInteropPlugin::default(),
    ))
    .add_systems(
        Tick,
        count.in_set(CollisionSystems::Last).run_if(showing(NAME)),
    );
}

/// A gate, and how many have passed it.
#[derive(Component, Default)]
struct Gate {
    passed: u32,
}

fn spawn(world: &mut World, objects: usize) {
    let mut random = fastrand::Rng::with_seed(2);
    let mut share = || random.f32() * 2.0 - 1.0;
    // What falls and what stands are for Rapier; they only meet gates here.
    let falls = CollisionLayers::new(LayerMask::layer(1), LayerMask::layer(2));
    let gates = CollisionLayers::new(LayerMask::layer(2), LayerMask::layer(1));
    for number in 0..objects {
        let collider = match number % 3 {
            0 => rapier::Collider::ball(0.45),
            1 => rapier::Collider::cuboid(0.4, 0.4, 0.4),
            _ => rapier::Collider::capsule_y(0.35, 0.3),
        };
        let height = 8.0 + 0.35 * number as f32;
        let place = Transform::from_xyz(share() * 3.0, height, share() * 2.0)
            .with_rotation(Quat::from_scaled_axis(Vec3::new(share(), share(), share())));
        world.spawn((
            OfScene,
            rapier::RigidBody::Dynamic,
            collider,
            ShapeFromRapier,
            falls,
            place,
        ));
    }
    let fixed = |half: [f32; 3], place: Transform| {
        let [x, y, z] = half;
        (
            OfScene,
            rapier::RigidBody::Fixed,
            rapier::Collider::cuboid(x, y, z),
            (ShapeFromRapier, StaticShape),
            place,
        )
    };
    world.spawn(fixed(
        [9.0, 0.25, 6.0],
        Transform::from_xyz(0.0, -0.25, 0.0),
    ));
    for side in [-1.0, 1.0] {
        let slope = Transform::from_xyz(side * 4.4, 3.2, 0.0)
            .with_rotation(Quat::from_rotation_z(side * 0.5));
        world.spawn(fixed([2.8, 0.15, 3.0], slope));
        world.spawn(fixed(
            [0.15, 0.6, 6.0],
            Transform::from_xyz(side * 8.9, 0.6, 0.0),
        ));
        world.spawn(fixed(
            [9.0, 0.6, 0.15],
            Transform::from_xyz(0.0, 0.6, side * 5.9),
        ));
    }
    for (at, half) in [
        (Vec3::new(0.0, 6.8, 0.0), Vec3::new(4.6, 0.15, 3.0)),
        (Vec3::new(0.0, 1.7, 0.0), Vec3::new(2.4, 0.15, 3.0)),
    ] {
        world.spawn((
            Gate::default(),
            CollisionShape::from_half_size(half),
            Sensor,
            Detector,
            gates,
            Transform::from_translation(at),
        ));
    }
}

fn count(mut ended: MessageReader<CollisionEnded>, mut gates: Query<&mut Gate>) {
    for message in ended.read() {
        for entity in [message.a, message.b] {
            if let Ok(mut gate) = gates.get_mut(entity) {
                gate.passed += 1;
            }
        }
    }
}

fn say(world: &mut World) -> String {
    let mut gates = world.query::<(&Gate, &Transform)>();
    let mut gates: Vec<_> = gates
        .iter(world)
        .map(|(gate, place)| (place.translation.y, gate.passed))
        .collect();
    gates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [upper, lower] = [0, 1].map(|at| gates.get(at).map_or(0, |gate| gate.1));
    format!("passed the upper gate: {upper}, the lower: {lower}")
}
