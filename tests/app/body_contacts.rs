//! Contacts of whole bodies where it is not plain what counts: sensors among the parts, walls between
//! them, what others write, ticks that are interrupted.

use crate::common::{interrupted::*, *};

use bevy::{
    ecs::reflect::{AppTypeRegistry, ReflectComponent},
    prelude::*,
    reflect::structs::DynamicStruct,
};
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
};
use fastrand::Rng;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };
/// A unit of time is a tick.
const STEP: Step = Step::Seconds(1.0);

/// What was told of bodies: whether it is about sensors, and whether it began.
#[derive(Resource, Default)]
struct Told {
    all: Vec<(EntityPair, bool, bool)>,
    open: Vec<(EntityPair, bool)>,
}

fn record(
    mut told: ResMut<Told>,
    mut started: MessageReader<BodyCollisionStarted>,
    mut ended: MessageReader<BodyCollisionEnded>,
) {
    for message in ended.read() {
        let contact = (pair(message.a, message.b), message.is_sensor);
        let place = told.open.iter().position(|other| *other == contact);
        told.open.remove(place.expect("what ends has started"));
        told.all.push((contact.0, contact.1, false));
    }
    for message in started.read() {
        let contact = (pair(message.a, message.b), message.is_sensor);
        assert!(!told.open.contains(&contact), "{contact:?} started twice");
        told.open.push(contact);
        told.all.push((contact.0, contact.1, true));
    }
}

fn bodies_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings { step: STEP })
        .init_resource::<Told>()
        .add_systems(Last, record);
    app
}

fn at(x: f32) -> Transform {
    Transform::from_xyz(x, 0.0, 0.0)
}

fn body(app: &mut App, parts: impl Bundle) -> Entity {
    let body = (CollisionBody::default(), Transform::default(), parts);
    app.world_mut().spawn(body).id()
}

fn part(app: &mut App, body: Entity, x: f32, shape: CollisionShape) -> Entity {
    app.world_mut().spawn((shape, at(x), ChildOf(body))).id()
}

fn wall(app: &mut App, x: f32) -> Entity {
    let wall = (CollisionShape::cuboid(0.01, 50.0, 50.0), StaticShape, at(x));
    app.world_mut().spawn(wall).id()
}

fn x_of(app: &App, entity: Entity) -> f32 {
    get::<Transform>(app, entity).translation.x
}

/// Where a body is; what is told there, of sensors or not, beginnings or ends; and how many contacts
/// there are then of solid parts, and of sensors.
type Moment = (f32, &'static [(bool, bool)], [u32; 2]);

#[test]
fn what_sensors_see_is_told_apart_from_what_solid_parts_touch() {
    let mut app = bodies_app();
    let ship = body(&mut app, CollidingEntities::default());
    part(&mut app, ship, 0.0, CollisionShape::default());
    let radar = part(&mut app, ship, 0.0, CollisionShape::sphere(3.0));
    app.world_mut().entity_mut(radar).insert(Sensor);
    let wall = wall(&mut app, 0.0);
    // It comes, goes through, and away.
    let steps: [Moment; 6] = [
        (-9.0, &[], [0, 0]),
        (-2.0, &[(true, true)], [0, 1]),
        (-0.4, &[(false, true)], [1, 1]),
        (0.3, &[], [1, 1]),
        (2.0, &[(false, false)], [0, 1]),
        (9.0, &[(true, false)], [0, 0]),
    ];
    for (x, told, contacts) in steps {
        get_mut::<Transform>(&mut app, ship).translation.x = x;
        let before = app.world().resource::<Told>().all.len();
        app.update();
        let new: Vec<_> = app.world().resource::<Told>().all[before..]
            .iter()
            .map(|(_, is_sensor, begins)| (*is_sensor, *begins))
            .collect();
        assert_eq!(new, told, "at {x}");
        let all = app.world().resource::<Contacts>();
        let count = |is_sensor| {
            let own = all.body_pairs().filter(|c| c.is_sensor == is_sensor);
            own.map(|c| c.contacts).sum::<u32>()
        };
        assert_eq!([count(false), count(true)], contacts, "at {x}");
        let total = contacts.iter().sum::<u32>() as usize;
        assert_eq!(all.between_bodies(wall, ship).count(), total);
        assert_eq!(all.of_body(ship).count(), total);
        let list = get::<CollidingEntities>(&app, ship);
        assert_eq!(list.len(), usize::from(total > 0), "at {x}");
    }
}

#[test]
fn a_part_that_becomes_a_sensor_no_longer_touches() {
    let mut app = bodies_app();
    let ship = body(&mut app, ());
    let part = part(&mut app, ship, 0.0, CollisionShape::default());
    let wall = wall(&mut app, 0.0);
    app.update();
    app.world_mut().entity_mut(part).insert(Sensor);
    app.update();
    app.world_mut().entity_mut(part).remove::<Sensor>();
    app.update();
    let both = pair(ship, wall);
    let solid = |begins| (both, false, begins);
    let sensor = |begins| (both, true, begins);
    let expected = [
        solid(true),
        solid(false),
        sensor(true),
        sensor(false),
        solid(true),
    ];
    assert_eq!(app.world().resource::<Told>().all, expected);
}

/// A nose that is a sensor goes through what the hull behind it is stopped by.
#[test]
fn a_sensor_among_the_parts_neither_stops_nor_turns_its_body() {
    for (name, speed, turns) in [
        ("reverse", 0.25, true),
        ("reflect", 0.25, true),
        ("swept", 20.0, true),
        ("stopping", 20.0, false),
    ] {
        let mut app = bodies_app();
        let ship = body(&mut app, Velocity(Vec3::X * speed));
        let mut entity = app.world_mut().entity_mut(ship);
        match name {
            "reverse" => _ = entity.insert(Bounce::Reverse),
            "reflect" => _ = entity.insert(ELASTIC),
            "swept" => _ = entity.insert((ELASTIC, Swept::default())),
            _ => _ = entity.insert(Swept::stopping()),
        }
        part(&mut app, ship, 0.0, CollisionShape::default());
        let nose = part(&mut app, ship, 5.0, CollisionShape::default());
        app.world_mut().entity_mut(nose).insert(Sensor);
        // For the nose alone, then for the hull.
        let (first, second) = (wall(&mut app, 8.0), wall(&mut app, 16.0));
        let mut farthest = 0.0_f32;
        for _ in 0..40 {
            app.update();
            farthest = farthest.max(x_of(&app, ship));
            if speed > 1.0 {
                break;
            }
        }
        // The hull has met the first wall, and nothing behind it.
        let velocity = get::<Velocity>(&app, ship).x;
        assert_eq!(velocity < 0.0, turns, "{name}");
        let touches: f32 = 8.0 - 0.005 - 0.5;
        let expected = if name == "swept" {
            touches - (20.0 - touches)
        } else {
            touches
        };
        assert!(
            (farthest - expected.max(0.0)).abs() < 0.3,
            "{name}: {farthest}"
        );
        let told = &app.world().resource::<Told>().all;
        let of = |other, is_sensor| {
            let contact = (pair(ship, other), is_sensor, true);
            told.iter().filter(|told| **told == contact).count()
        };
        assert_eq!(of(first, false), 1, "{name}");
        assert!(of(first, true) >= 1, "{name}: {told:?}");
        assert_eq!((of(second, false), of(second, true)), (0, 0), "{name}");
    }
}

#[test]
fn a_fast_body_astride_a_wall_is_held_by_the_parts_on_both_sides() {
    let mut app = bodies_app();
    let parts = (Velocity(Vec3::X * 100.0), ELASTIC, Swept::default());
    let ship = body(&mut app, parts);
    for x in [-10.0, 10.0] {
        part(&mut app, ship, x, CollisionShape::default());
    }
    wall(&mut app, 5.0);
    app.update();
    // To and fro between 14.495 and -4.495, five times, and on.
    assert_eq!(counters(&app).bounces, 5);
    assert!(
        (x_of(&app, ship) - 4.95).abs() < 1e-2,
        "{}",
        x_of(&app, ship)
    );
    assert_eq!(get::<Velocity>(&app, ship).0, Vec3::X * -100.0);
}

/// Writes that an entity is a part of another, as a scene file or an editor may.
fn write_part_of(app: &mut App, entity: Entity, body: Entity) {
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let of_type = registry.get_with_type_path("bevy_octree::PartOf").unwrap();
    let mut data = DynamicStruct::default();
    data.insert("body", body);
    data.insert("inner_contacts", false);
    let reflected = of_type.data::<ReflectComponent>().unwrap();
    reflected.insert(&mut app.world_mut().entity_mut(entity), &data, &registry);
}

#[test]
fn what_others_write_about_parts_is_undone() {
    let mut app = bodies_app();
    let block = |app: &mut App, x| {
        let block = (CollisionShape::default(), at(x));
        app.world_mut().spawn(block).id()
    };
    let (one, other) = (block(&mut app, 0.0), block(&mut app, 0.5));
    let gone = app.world_mut().spawn_empty().id();
    app.world_mut().despawn(gone);
    // Where there is no body at all.
    for target in [gone, one, other] {
        write_part_of(&mut app, one, target);
        write_part_of(&mut app, other, target);
        app.update();
        for entity in [one, other] {
            assert!(app.world().get::<PartOf>(entity).is_none(), "{target}");
        }
        assert_eq!(contacts(&app), [pair(one, other)]);
        assert!(app.world().resource::<Told>().all.is_empty());
    }
    // Where there is one, to which neither belongs, or both.
    let ship = body(&mut app, ());
    app.update();
    write_part_of(&mut app, one, ship);
    app.update();
    assert!(app.world().get::<PartOf>(one).is_none());
    for entity in [one, other] {
        app.world_mut().entity_mut(entity).insert(ChildOf(ship));
    }
    app.update();
    assert!(contacts(&app).is_empty());
    app.world_mut().entity_mut(one).remove::<PartOf>();
    write_part_of(&mut app, other, one);
    app.update();
    for entity in [one, other] {
        assert_eq!(get::<PartOf>(&app, entity).body(), ship);
    }
    assert!(contacts(&app).is_empty());
}

/// Whatever is skipped, and whenever: each contact starts and ends by turns, and after a whole tick
/// what was told is what there is.
#[test]
fn bodies_are_told_of_once_though_ticks_are_interrupted() {
    let mut seen = 0;
    for seed in 0..60 {
        let mut rng = Rng::with_seed(seed);
        let mut app = bodies_app();
        let_sets_be_skipped(&mut app);
        let ships: Vec<_> = (0..3).map(|_| body(&mut app, ())).collect();
        let mut parts = Vec::new();
        for number in 0..9 {
            let x = rng.f32() * 4.0;
            let part = part(&mut app, ships[number % 3], x, CollisionShape::default());
            parts.push(part);
        }
        for round in 0..40 {
            for _ in 0..rng.usize(0..3) {
                let number = rng.usize(0..parts.len());
                let (own, ship) = (parts[number], ships[rng.usize(0..3)]);
                let x = rng.f32() * 6.0;
                let mut entity = app.world_mut().entity_mut(own);
                match rng.u8(0..9) {
                    0 => _ = entity.insert(ChildOf(ship)),
                    1 => _ = entity.remove::<ChildOf>(),
                    2 => _ = entity.insert(Sensor),
                    3 => _ = entity.remove::<Sensor>(),
                    4 => _ = entity.insert(CollisionBody::default()),
                    5 => _ = entity.remove::<CollisionBody>(),
                    6 => {
                        entity.despawn();
                        let shape = CollisionShape::default();
                        parts[number] = part(&mut app, ship, x, shape);
                    }
                    _ => entity.get_mut::<Transform>().unwrap().translation.x = x,
                }
            }
            if rng.bool() {
                let x = rng.f32() * 6.0;
                let ship = ships[rng.usize(0..3)];
                get_mut::<Transform>(&mut app, ship).translation.x = x;
            }
            let is_whole = rng.bool();
            // In the last one, others keep count.
            let skipped: Vec<_> = SETS[..SETS.len() - 1]
                .iter()
                .copied()
                .filter(|_| !is_whole && rng.u8(0..3) == 0)
                .collect();
            skip(&mut app, &skipped);
            app.update();
            if !is_whole {
                continue;
            }
            let world = app.world();
            let all = world.resource::<Contacts>();
            let mut found: Vec<_> = all
                .body_pairs()
                .map(|c| (pair(c.a, c.b), c.is_sensor))
                .collect();
            let body_of = |entity| world.get::<PartOf>(entity).map_or(entity, PartOf::body);
            let mut expected: Vec<_> = all
                .iter()
                .filter(|c| {
                    let parts = [c.a, c.b];
                    parts
                        .iter()
                        .any(|part| world.get::<PartOf>(*part).is_some())
                })
                .map(|c| {
                    let is_sensor = |part: &Entity| world.get::<Sensor>(*part).is_some();
                    let is_sensor = [c.a, c.b].iter().any(is_sensor);
                    (pair(body_of(c.a), body_of(c.b)), is_sensor)
                })
                .collect();
            expected.sort();
            expected.dedup();
            found.sort();
            assert_eq!(found, expected, "seed {seed}, round {round}");
            let mut open = world.resource::<Told>().open.clone();
            open.sort();
            assert_eq!(open, expected, "seed {seed}, round {round}");
            seen += open.len();
        }
    }
    assert!(seen > 1000, "{seen}");
}
