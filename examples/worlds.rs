//! Several matches in one app, in the same place: what is in one never meets what is in another.
//!
//! A ship carries its shield with it, changes over to another match, and a match ends. `cargo run
//! --example worlds`

use bevy::prelude::*;
use bevy_octree::{
    collision_index::CollisionIndex,
    contacts::Collision,
    motion::{CollisionClock, MotionSettings, Step},
    prelude::*,
};

fn main() {
    let mut app = App::new();
    // A tick per update, of a second each: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0),
        });

    // A world is an entity like any other.
    let matches =
        ["first match", "second match"].map(|name| app.world_mut().spawn(Name::new(name)).id());
    // The same asteroid in both, each with one of its own.
    for place in matches {
        app.world_mut().spawn((
            Name::new("asteroid"),
            CollisionShape::default(),
            InCollisionWorld(place),
        ));
    }
    // A ship in the first. Its shield is a child: it goes where the ship goes, and says itself
    // which world it is in.
    let ship = (
        Name::new("ship"),
        Velocity(Vec3::X),
        Transform::from_xyz(-4.0, 0.0, 0.0),
    );
    let ship = app.world_mut().spawn(ship).id();
    let shield = CollisionShape::sphere(1.0);
    let shield = (
        Name::new("shield"),
        shield,
        InCollisionWorld(matches[0]),
        Transform::from_xyz(0.0, 0.5, 0.0),
    );
    let shield = app.world_mut().spawn((shield, ChildOf(ship))).id();

    for tick in 1..=9 {
        match tick {
            5 => {
                println!("{tick}  the shield changes over to the second match");
                app.world_mut()
                    .entity_mut(shield)
                    .insert(InCollisionWorld(matches[1]));
            }
            7 => {
                println!("{tick}  the second match ends");
                // Whatever is in it goes with it.
                app.world_mut().entity_mut(matches[1]).despawn();
            }
            _ => {}
        }
        app.update();
        app.world_mut()
            .run_system_cached(print_contacts)
            .expect("the system takes what there is");
    }
    println!(
        "left in the index: {}",
        app.world()
            .resource::<CollisionIndex>()
            .index()
            .proxies()
            .len()
    );
}

fn print_contacts(
    collisions: Collisions,
    clock: Res<CollisionClock>,
    names: Query<&Name>,
    worlds: Query<&InCollisionWorld>,
) {
    for Collision { a, b, .. } in collisions.iter() {
        let place = worlds
            .get(a)
            .and_then(|world| names.get(world.0))
            .map_or("no world", Name::as_str);
        let [a, b] = [a, b].map(|entity| names.get(entity).map_or("(gone)", Name::as_str));
        println!("{}  {a} and {b} touch, in the {place}", clock.tick());
    }
}
