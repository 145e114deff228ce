//! A thing made of parts: a ship of five shapes flies, bounces as one, and loses a wing.
//!
//! It is much faster than walls are thick, and is looked at all along its way. `cargo run --example
//! ship`

use bevy::prelude::*;
use bevy_octree::{
    motion::{CollisionClock, MotionSettings, Step},
    prelude::*,
};

fn main() {
    let mut app = App::new();
    // A tick per update, of a second each: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0),
        })
        .add_systems(Startup, spawn)
        .add_systems(
            Update,
            (report_bodies, report_parts, lose_wing, report_place)
                .chain()
                .in_set(CollisionSystems::Last),
        );
    for _ in 0..10 {
        app.update();
    }
}

#[derive(Component)]
struct Ship;

fn spawn(mut commands: Commands) {
    let bounce = Bounce::Reflect { restitution: 1.0 };
    let ship = (
        Ship,
        CollisionBody::default(),
        Velocity(Vec3::X * 8.0),
        bounce,
        Swept::default(),
    );
    let ship = commands.spawn((Name::new("ship"), ship)).id();
    let turned = Quat::from_rotation_y;
    // Its parts overlap each other, which nobody hears of.
    for (name, size, at, turn) in [
        ("hull", [3.0, 1.0, 1.0], [0.0, 0.0, 0.0], 0.0),
        ("nose", [1.0, 0.5, 0.5], [1.8, 0.0, 0.0], 0.0),
        ("left wing", [0.8, 0.1, 2.0], [-0.5, 0.0, -1.2], 0.4),
        ("right wing", [0.8, 0.1, 2.0], [-0.5, 0.0, 1.2], -0.4),
        ("fin", [0.8, 1.0, 0.1], [-1.2, 0.8, 0.0], 0.0),
    ] {
        let [x, y, z] = size;
        let place = Transform::from_translation(at.into()).with_rotation(turned(turn));
        let shape = CollisionShape::cuboid(x, y, z);
        commands.spawn((Name::new(name), shape, place, ChildOf(ship)));
    }
    for (name, x) in [("front wall", 20.0), ("back wall", -10.0)] {
        let paper = CollisionShape::cuboid(0.01, 50.0, 50.0);
        let place = Transform::from_xyz(x, 0.0, 0.0);
        commands.spawn((Name::new(name), paper, StaticShape, place));
    }
    // One that only the left wing passes.
    let mast = CollisionShape::cuboid(0.2, 9.0, 0.2);
    let place = Transform::from_xyz(10.0, 0.0, -1.8);
    commands.spawn((Name::new("mast"), mast, StaticShape, Sensor, place));
}

/// Told once for all parts.
fn report_bodies(
    mut started: MessageReader<BodyCollisionStarted>,
    clock: Res<CollisionClock>,
    names: Query<&Name>,
) {
    for message in started.read() {
        if let Ok([a, b]) = names.get_many([message.a, message.b]) {
            println!("{}  {a} meets {b}", clock.tick());
        }
    }
}

/// Told for each part, and whose it is.
fn report_parts(
    mut started: MessageReader<CollisionStarted>,
    ships: Query<(), With<Ship>>,
    clock: Res<CollisionClock>,
    names: Query<&Name>,
) {
    for message in started.read() {
        let message = if ships.contains(message.bodies[0]) {
            *message
        } else {
            message.reversed()
        };
        if let Ok([part, body, other]) = names.get_many([message.a, message.bodies[0], message.b]) {
            println!(
                "{}    by the {part} of the {body}, the {other}",
                clock.tick()
            );
        }
    }
}

/// A wing that meets the mast comes off, and stays where it is.
fn lose_wing(
    mut started: MessageReader<CollisionStarted>,
    parts: Query<(&Name, &PartOf)>,
    places: Query<&Transform>,
    sensors: Query<(), With<Sensor>>,
    mut commands: Commands,
) {
    for message in started.read() {
        for (part, mast) in [(message.a, message.b), (message.b, message.a)] {
            if sensors.contains(mast)
                && let Ok((name, part_of)) = parts.get(part)
                && let Ok([ship, own]) = places.get_many([part_of.body(), part])
            {
                println!("     the {name} comes off");
                commands
                    .entity(part)
                    .remove::<ChildOf>()
                    .insert(*ship * *own);
            }
        }
    }
}

fn report_place(
    ship: Single<(&Transform, &Velocity, &BodyParts), With<Ship>>,
    clock: Res<CollisionClock>,
) {
    let (place, velocity, parts) = *ship;
    println!(
        "{}  at {:.2}, {} per tick, {} parts",
        clock.tick(),
        place.translation.x,
        velocity.x,
        parts.entities().len()
    );
}
