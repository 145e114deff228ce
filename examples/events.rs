//! Four ways to learn of contacts: observers, messages, a list on the entity, and a look at all of
//! them.
//!
//! A ball rolls through a gate, breaks a vase, and rolls on. `cargo run --example events`

use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
};

fn main() {
    let mut app = App::new();
    // Ten ticks a second, one per update: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(0.1),
        })
        .add_systems(Startup, spawn)
        .add_systems(
            Update,
            (print_messages, print_list, print_contacts)
                .chain()
                .in_set(CollisionSystems::Last),
        );
    for tick in 1..=30 {
        app.world_mut().insert_resource(Tick(tick));
        app.update();
    }
}

/// The number of the tick, for the printout.
#[derive(Resource, Clone, Copy, Deref)]
struct Tick(u32);

fn spawn(mut commands: Commands) {
    let ball = CollisionShape::sphere(0.5);
    commands.spawn((
        Name::new("ball"),
        ball,
        Velocity(Vec3::X * 4.0),
        Transform::from_xyz(-4.0, 0.0, 0.0),
        // Without it the ball takes part all the same, but keeps no list.
        CollidingEntities::default(),
    ));

    // An observer on one entity. It is told because the entity opts in.
    let gate = CollisionShape::cuboid(0.5, 4.0, 4.0);
    commands
        .spawn((
            Name::new("gate"),
            gate,
            Transform::from_xyz(-1.0, 0.0, 0.0),
            CollisionEventsEnabled,
        ))
        .observe(
            |event: On<CollisionStarted>, names: Query<&Name>, tick: Res<Tick>| {
                // `event.a` is the entity that is observed, `event.b` the other one.
                println!(
                    "{:2}  observer: {} enters the {}",
                    **tick,
                    name(&names, event.b),
                    name(&names, event.a)
                );
            },
        )
        .observe(
            |event: On<CollisionEnded>, names: Query<&Name>, tick: Res<Tick>| {
                println!(
                    "{:2}  observer: {} leaves the {}",
                    **tick,
                    name(&names, event.b),
                    name(&names, event.a)
                );
            },
        );

    // An observer may despawn what it is told about. The contact still ends, once.
    commands
        .spawn((
            Name::new("vase"),
            CollisionShape::default(),
            Transform::from_xyz(3.0, 0.0, 0.0),
            CollisionEventsEnabled,
        ))
        .observe(
            |event: On<CollisionStarted>, mut commands: Commands, tick: Res<Tick>| {
                let contact = event.contact.expect("events come with the contact");
                println!(
                    "{:2}  observer: the vase breaks at {}, hit from {}",
                    **tick, contact.point, contact.normal
                );
                commands.entity(event.a).despawn();
            },
        );
}

/// Messages: about all contacts, for systems that look at many.
fn print_messages(
    mut started: MessageReader<CollisionStarted>,
    mut ended: MessageReader<CollisionEnded>,
    names: Query<&Name>,
    tick: Res<Tick>,
) {
    for CollisionEnded { a, b, .. } in ended.read() {
        // Either may be gone by now.
        println!(
            "{:2}  message:  {} and {} part",
            **tick,
            name(&names, *a),
            name(&names, *b)
        );
    }
    for CollisionStarted { a, b, .. } in started.read() {
        println!(
            "{:2}  message:  {} and {} meet",
            **tick,
            name(&names, *a),
            name(&names, *b)
        );
    }
}

/// A list on the entity: what does it touch now? It counts as changed only if the list changed.
fn print_list(
    lists: Query<(&Name, &CollidingEntities), Changed<CollidingEntities>>,
    names: Query<&Name>,
    tick: Res<Tick>,
) {
    for (entity, list) in &lists {
        let others: Vec<_> = list.iter().map(|other| name(&names, *other)).collect();
        println!("{:2}  list:     {entity} touches {others:?}", **tick);
    }
}

/// All contacts, or those of one entity, whenever you like.
fn print_contacts(collisions: Collisions, names: Query<&Name>, tick: Res<Tick>) {
    for collision in collisions.iter() {
        let depth = collision.contact.map_or(0.0, |contact| contact.depth);
        println!(
            "{:2}  contacts: {} in {}, {depth:.2} deep",
            **tick,
            name(&names, collision.a),
            name(&names, collision.b)
        );
    }
}

fn name<'a>(names: &'a Query<&Name>, entity: Entity) -> &'a str {
    names.get(entity).map_or("(gone)", Name::as_str)
}
