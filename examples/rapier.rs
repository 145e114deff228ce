//! Side by side with Rapier: it makes balls fall, and this crate tells what they meet, and makes
//! them bounce.
//!
//! `cargo run --features rapier --example rapier`

use bevy::prelude::*;
use bevy_octree::prelude::*;
// Both crates have a `Velocity` and a `Sensor`: those of Rapier go by a longer name here.
use bevy_rapier3d::prelude as rapier;

fn main() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin))
        // Twenty steps a second, one per update: the example needs no clock.
        .insert_resource(rapier::TimestepMode::Fixed {
            dt: 0.05,
            substeps: 1,
        })
        .add_plugins(rapier::RapierPhysicsPlugin::<()>::default())
        // In Rapier's schedule, so that contacts are those of the step just made.
        .add_plugins((
            OctreePlugins::new(PostUpdate),
            RapierInteropPlugin::default(),
        ))
        .add_systems(Startup, spawn);
    // As a runner would.
    app.finish();
    app.cleanup();
    for step in 1..=60 {
        app.world_mut().insert_resource(StepNumber(step));
        app.update();
    }
}

/// The number of the step, for the printout.
#[derive(Resource, Clone, Copy, Deref)]
struct StepNumber(u32);

fn spawn(mut commands: Commands) {
    // Bodies of Rapier's. `ShapeFromRapier` gives them the shape of their collider, whatever
    // becomes of it; by `Bounce`, contacts that Rapier does not answer to change the velocity that
    // it moves them by.
    for (name, x) in [("red", -2.0), ("blue", 2.0)] {
        commands.spawn((
            Name::new(name),
            (
                rapier::RigidBody::Dynamic,
                rapier::Collider::ball(0.5),
                rapier::Velocity::default(),
            ),
            (ShapeFromRapier, Bounce::Reflect { restitution: 0.8 }),
            Transform::from_xyz(x, 5.0 + x, 0.0),
        ));
    }

    // A gate that Rapier does not know: it needs neither collider nor body. Nothing bounces off a
    // sensor.
    let gate = CollisionShape::cuboid(8.0, 0.4, 2.0);
    commands
        .spawn((
            Name::new("gate"),
            gate,
            Sensor,
            Transform::from_xyz(0.0, 2.0, 0.0),
            CollisionEventsEnabled,
        ))
        .observe(print_start)
        .observe(print_end);

    // A floor without an end. To Rapier it is a sensor, so that only this crate makes the balls
    // bounce.
    let floor = rapier::Collider::halfspace(Vec3::Y).expect("the normal has a length");
    commands
        .spawn((
            Name::new("floor"),
            floor,
            rapier::Sensor,
            ShapeFromRapier,
            CollisionEventsEnabled,
        ))
        .observe(print_start)
        .observe(print_end);
}

fn print_start(
    event: On<CollisionStarted>,
    names: Query<&Name>,
    velocities: Query<&rapier::Velocity>,
    step: Res<StepNumber>,
) {
    let contact = event.contact.expect("events come with the contact");
    // After its bounce, if it bounced.
    let speed = velocities
        .get(event.b)
        .map_or(0.0, |velocity| velocity.linear.y);
    let (a, b) = (name(&names, event.a), name(&names, event.b));
    println!(
        "{:2}  {b} touches the {a} at {:.2}, and goes on at {speed:+.2}",
        **step, contact.point
    );
}

fn print_end(event: On<CollisionEnded>, names: Query<&Name>, step: Res<StepNumber>) {
    println!(
        "{:2}  {} leaves the {}",
        **step,
        name(&names, event.b),
        name(&names, event.a)
    );
}

fn name<'a>(names: &'a Query<&Name>, entity: Entity) -> &'a str {
    names.get(entity).map_or("(gone)", Name::as_str)
}
