//! A server moves things; a client is sent their shapes and places, and finds out by itself what touches
//! what, with normals: none of that has to be sent.
//!
//! `cargo run -p interop --example replicated`

use std::process::ExitCode;

use bevy::{prelude::*, state::app::StatesPlugin};
use bevy_octree::{
    motion::Step,
    plugins::{BouncePlugin, MotionPlugin},
    prelude::*,
};
use bevy_replicon::{prelude::*, test_app::ServerTestAppExt};

const TICKS: u32 = 300;

fn main() -> ExitCode {
    let mut server = app(OctreePlugins::new(Update).build());
    // What moves, and how it bounces, is up to the server.
    let looks_on = OctreePlugins::new(Update).build();
    let mut client = app(looks_on.disable::<MotionPlugin>().disable::<BouncePlugin>());
    spawn(server.world_mut());
    server.connect_client(&mut client);

    let (mut seen, mut started) = (0, 0);
    for tick in 0..TICKS {
        server.update();
        // In a game, a messaging backend of bevy_replicon does this.
        server.exchange_with_client(&mut client);
        client.update();
        server.exchange_with_client(&mut client);
        let [at_server, at_client] = [&mut server, &mut client].map(contacts);
        if at_server != at_client {
            println!("tick {tick}: the server sees {at_server:?}, the client {at_client:?}");
            return ExitCode::FAILURE;
        }
        seen += at_client.len();
        let mut messages = client
            .world_mut()
            .resource_mut::<Messages<CollisionStarted>>();
        started += messages.drain().count();
    }
    println!(
        "in {TICKS} ticks, both saw the same {seen} contacts; the client was told of {started} that started"
    );
    if seen > 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn app(ticks: impl PluginGroup) -> App {
    let mut app = App::new();
    let replication = RepliconPlugins.set(ServerPlugin::new(PostUpdate));
    app.add_plugins((MinimalPlugins, StatesPlugin, replication, ticks.build()))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 60.0),
        })
        // The number by which everybody knows an entity, its shape as plain data, and its place.
        .replicate::<CollisionOrder>()
        .replicate::<ShapeDescription>()
        .replicate::<Transform>();
    app.finish();
    app.cleanup();
    app
}

fn spawn(world: &mut World) {
    let mut number = 0;
    let mut next = || {
        number += 1;
        (Replicated, CollisionOrder(number))
    };
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-4.5, 4.5] {
            let half_size = (Vec3::splat(10.0) * (Vec3::ONE - axis) + axis) * 0.5;
            let wall = ShapeDescription::Cuboid { half_size };
            world.spawn((next(), wall, Transform::from_translation(axis * side)));
        }
    }
    for index in 0..30_u8 {
        let shape = match index % 3 {
            0 => ShapeDescription::Sphere { radius: 0.4 },
            1 => ShapeDescription::Cone {
                radius: 0.4,
                height: 0.9,
            },
            _ => ShapeDescription::Cuboid {
                half_size: Vec3::new(0.5, 0.2, 0.3),
            },
        };
        let share = f32::from(index);
        let way = Vec3::new(
            (share * 2.4).sin(),
            (share * 1.7).cos(),
            (share * 0.9).sin(),
        );
        let bounce = Bounce::Reflect { restitution: 1.0 };
        let place = Transform::from_translation(way * 3.0);
        world.spawn((next(), shape, Velocity(way * 8.0), bounce, place));
    }
}

/// Who touches whom, by numbers, in the order of these.
fn contacts(app: &mut App) -> Vec<[u64; 2]> {
    let world = app.world();
    let number = |entity| world.get::<CollisionOrder>(entity).map(|order| order.0);
    let contacts = world.resource::<Contacts>().iter();
    contacts
        .filter_map(|collision| Some([number(collision.a)?, number(collision.b)?]))
        .collect()
}
