//! Scenes at the ends of what there is: of number, size, place and order. Contacts are those of
//! brute force, and the work is counted: within what comes out and the number of objects.
//!
//! The large ones are `#[ignore]`d: `cargo test --test app -- --ignored extremes::`.

use bevy::prelude::*;
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    motion::{MotionSettings, Step},
    prelude::*,
};
use fastrand::Rng;

use crate::common::*;

fn methods() -> [BroadPhaseMethod; 5] {
    let octree = |n| BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(n));
    [
        BroadPhaseMethod::LinearOctree,
        BroadPhaseMethod::Auto,
        octree(1),
        octree(256),
        octree(1_000_000),
    ]
}

/// An app without a log, which would take longer than what it logs.
fn plain_app(method: BroadPhaseMethod) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 64.0),
        });
    app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
    app
}

fn spawn(app: &mut App, shape: CollisionShape, at: Vec3) -> Entity {
    app.world_mut()
        .spawn((shape, Transform::from_translation(at)))
        .id()
}

/// Contacts are those of brute force now, and after all have moved.
fn check(what: &str, objects: &[(CollisionShape, Vec3)], by: Vec3) {
    for method in methods() {
        let mut app = plain_app(method.clone());
        let all: Vec<_> = objects
            .iter()
            .map(|(shape, at)| spawn(&mut app, shape.clone(), *at))
            .collect();
        tick(&mut app, 1);
        let expected = brute_force_contacts(&mut app);
        assert_eq!(contacts(&app), expected, "{what}, {method}");
        let before = expected.len();
        for entity in &all[..all.len() / 2] {
            get_mut::<Transform>(&mut app, *entity).translation += by;
        }
        tick(&mut app, 2);
        let expected = brute_force_contacts(&mut app);
        assert_eq!(contacts(&app), expected, "{what}, moved, {method}");
        assert!(before + expected.len() > 0, "{what}: nothing touches");
        for entity in all {
            app.world_mut().despawn(entity);
        }
        tick(&mut app, 1);
        assert_eq!((contacts(&app).len(), index(&app).proxies().len()), (0, 0));
    }
}

#[test]
fn all_in_one_point_on_a_line_or_in_a_plane() {
    let mut rng = Rng::with_seed(1);
    let kinds = [
        CollisionShape::sphere(0.0),
        CollisionShape::sphere(0.25),
        CollisionShape::cuboid(0.5, 0.5, 0.5),
        CollisionShape::cuboid(0.0, 0.0, 0.0),
        CollisionShape::cuboid(0.5, 0.0, 0.0),
    ];
    for (what, axes) in [
        ("a point", Vec3::ZERO),
        ("a line", Vec3::X),
        ("a slanted line", Vec3::ONE),
        ("a plane", Vec3::new(1.0, 0.0, 1.0)),
    ] {
        let objects: Vec<_> = (0..90)
            .map(|number| {
                // In a plane two numbers, else one.
                let [a, b] = [(); 2].map(|()| f32::from(rng.i8(-20..21)) * 0.5);
                let at = if what == "a plane" {
                    Vec3::new(a, 0.0, b)
                } else {
                    axes * a
                };
                (kinds[number % kinds.len()].clone(), at)
            })
            .collect();
        check(what, &objects, Vec3::new(0.5, 0.0, 0.0));
    }
}

#[test]
fn grids_that_touch() {
    let objects: Vec<_> = (0..125)
        .map(|number| {
            let at = [number % 5, number / 5 % 5, number / 25].map(|n| n as f32);
            (CollisionShape::default(), Vec3::from_array(at))
        })
        .collect();
    check("a grid", &objects, Vec3::Y);
}

#[test]
fn sizes_of_all_orders() {
    let mut rng = Rng::with_seed(2);
    let objects: Vec<_> = (0..90)
        .map(|number| {
            // From a thousandth to a hundred thousand.
            let size = 10_f32.powi(number % 9 - 3);
            let at = [(); 3].map(|()| (rng.f32() * 2.0 - 1.0) * size * 3.0);
            let shape = if number % 2 == 0 {
                CollisionShape::sphere(size)
            } else {
                CollisionShape::cuboid(size, size, size)
            };
            (shape, Vec3::from_array(at))
        })
        .collect();
    check("sizes", &objects, Vec3::splat(0.01));
}

#[test]
fn places_far_away_and_close_together() {
    let mut rng = Rng::with_seed(3);
    for (what, size, center) in [
        ("around 1e6", 1.0, 1e6),
        ("around -1e6", 2.0, -1e6),
        ("within 1e-6", 1e-6, 0.0),
        ("up to 1e6", 1e5, 0.0),
        ("up to 1e18", 1e17, 0.0),
    ] {
        let objects: Vec<_> = (0..60)
            .map(|_| {
                let at = [(); 3].map(|()| center + (rng.f32() * 2.0 - 1.0) * size * 4.0);
                (CollisionShape::sphere(size * 0.5), Vec3::from_array(at))
            })
            .collect();
        check(what, &objects, Vec3::splat(size * 0.25));
    }
}

/// The largest numbers: whatever is said of those themselves, all others are as ever.
#[test]
fn the_largest_numbers_do_others_no_harm() {
    for method in methods() {
        for most in [f32::MAX, f32::MAX * 0.25, 1e30, f32::MIN_POSITIVE, 1e-45] {
            let mut app = plain_app(method.clone());
            let pair = [0.0, 0.9].map(|x| spawn(&mut app, CollisionShape::default(), Vec3::X * x));
            let mut all = Vec::new();
            for axis in [Vec3::X, Vec3::NEG_Y, Vec3::ONE] {
                all.push(spawn(&mut app, CollisionShape::default(), axis * most));
                all.push(spawn(
                    &mut app,
                    CollisionShape::sphere(most),
                    Vec3::splat(most),
                ));
                all.push(spawn(
                    &mut app,
                    CollisionShape::cuboid(most, 1.0, most),
                    axis * most,
                ));
                let fast = (Velocity(axis * most), Swept::default(), Bounce::Reverse);
                let fast = (
                    CollisionShape::sphere(0.5),
                    fast,
                    Transform::from_xyz(0.0, 9.0, 0.0),
                );
                all.push(app.world_mut().spawn(fast).id());
                let at = Transform::from_translation(axis * 50.0).with_scale(axis * most);
                all.push(app.world_mut().spawn((CollisionShape::default(), at)).id());
            }
            tick(&mut app, 4);
            assert!(contacts(&app).contains(&pair), "{most}, {method}");
            for entity in all {
                app.world_mut().despawn(entity);
            }
            tick(&mut app, 1);
            assert_eq!(
                (contacts(&app), index(&app).proxies().len()),
                (vec![pair], 2)
            );
        }
    }
}

/// All leave at once, in one direction, and come back.
#[test]
fn all_may_leave_at_once() {
    for method in methods() {
        let mut app = plain_app(method.clone());
        let mut rng = Rng::with_seed(4);
        let all: Vec<_> = (0..150)
            .map(|_| {
                let at = [(); 3].map(|()| rng.f32() * 6.0);
                spawn(&mut app, CollisionShape::default(), Vec3::from_array(at))
            })
            .collect();
        tick(&mut app, 1);
        let before = contacts(&app);
        assert!(before.len() > 50);
        // As far as a place can be told to some decimals, so that they are where they were.
        for by in [
            Vec3::splat(4096.0),
            Vec3::NEG_X * 4096.0,
            Vec3::new(0.0, -4096.0, 0.0),
        ] {
            for way in [by, -by] {
                for entity in &all {
                    get_mut::<Transform>(&mut app, *entity).translation += way;
                }
                tick(&mut app, 1);
                assert_eq!(
                    contacts(&app),
                    brute_force_contacts(&mut app),
                    "{by}, {method}"
                );
            }
        }
    }
}

/// Pairs that are compared for each object and pair that comes out, of so many objects.
fn work(
    method: &BroadPhaseMethod,
    shape: &CollisionShape,
    places: impl Iterator<Item = Vec3>,
) -> f64 {
    let mut app = plain_app(method.clone());
    for at in places {
        spawn(&mut app, shape.clone(), at);
    }
    tick(&mut app, 1);
    let counters = counters(&app);
    counters.pairs_tested as f64 / (counters.objects + counters.candidates) as f64
}

/// Four times as many objects take no more work each, where they lie on a line or in a plane, or are
/// of all sizes, or nearly all in one place but for a few that are far away.
#[test]
fn work_is_linear_in_what_comes_out() {
    let ball = CollisionShape::sphere(0.25);
    for method in [BroadPhaseMethod::LinearOctree, BroadPhaseMethod::default()] {
        for scene in ["a line", "a slanted line", "a plane", "a heap and outliers"] {
            let place = |count: usize, number: usize| {
                let (side, n) = ((count as f32).sqrt() as usize, number as f32);
                match scene {
                    "a line" => Vec3::X * n,
                    "a slanted line" => Vec3::ONE * n,
                    "a plane" => Vec3::new((number % side) as f32, 0.0, (number / side) as f32),
                    _ if number % 1000 == 999 => Vec3::splat(n * 1e3),
                    _ => Vec3::new(
                        (number % 20) as f32,
                        (number / 20 % 20) as f32,
                        (number / 400) as f32,
                    ),
                }
            };
            let of = |count: usize| work(&method, &ball, (0..count).map(|n| place(count, n)));
            let (few, many) = (of(4000), of(16_000));
            assert!(
                many < few * 1.5 + 4.0,
                "{scene}, {method}: {few}, {many} for each"
            );
        }
    }
}

/// A chain of so many, each the child of the one before.
fn chain(length: usize) {
    let mut app = plain_app(BroadPhaseMethod::default());
    let mut last = spawn(&mut app, CollisionShape::default(), Vec3::ZERO);
    let first = last;
    for _ in 1..length {
        let child = spawn(&mut app, CollisionShape::default(), Vec3::X * 1.5);
        app.world_mut().entity_mut(child).insert(ChildOf(last));
        last = child;
    }
    tick(&mut app, 1);
    assert_eq!(
        (counters(&app).objects as usize, counters(&app).contacts),
        (length, 0)
    );
    // The first takes all with it; the last is where it is to be.
    get_mut::<Transform>(&mut app, first).translation.y = 3.0;
    let beside = Vec3::new((length - 1) as f32 * 1.5 + 0.75, 3.0, 0.0);
    let beside = spawn(&mut app, CollisionShape::default(), beside);
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), counters(&app).moved as usize),
        (vec![[last, beside]], length + 1)
    );
    tick(&mut app, 1);
    assert_eq!(counters(&app).moved, 0);
}

#[test]
fn a_chain_of_a_thousand() {
    chain(1000);
}

#[test]
#[ignore = "a chain of ten thousand, for a release build"]
fn a_chain_of_ten_thousand() {
    chain(10_000);
}

/// So many swept balls in a room, that hold no more than they touch, and none of which gets out.
fn room(count: usize) {
    let mut app = plain_app(BroadPhaseMethod::default());
    let side = (count as f32).cbrt() * 1.5;
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for end in [-1.0, 1.0] {
            let wall = (Vec3::ONE - axis) * (side + 4.0) + axis * 2.0;
            let wall = CollisionShape::cuboid(wall.x, wall.y, wall.z);
            spawn(&mut app, wall, axis * end * (side * 0.5 + 1.0));
        }
    }
    let mut rng = Rng::with_seed(5);
    let mut vector = |reach: f32| Vec3::from_array([(); 3].map(|()| (rng.f32() - 0.5) * reach));
    let balls: Vec<_> = (0..count)
        .map(|_| {
            let at = Transform::from_translation(vector(side - 1.0));
            let moves = (
                Velocity(vector(60.0)),
                Bounce::Reflect { restitution: 1.0 },
                Swept::default(),
            );
            app.world_mut()
                .spawn((CollisionShape::sphere(0.2), at, moves))
                .id()
        })
        .collect();
    for _ in 0..10 {
        tick(&mut app, 1);
        let counters = counters(&app);
        assert!(counters.candidates < 20 * count as u64, "{counters:?}");
        assert!(counters.pairs_tested < 400 * count as u64, "{counters:?}");
    }
    for ball in balls {
        let at = get::<Transform>(&app, ball).translation;
        assert!(at.abs().max_element() < side * 0.5, "{at} is out of {side}");
    }
}

#[test]
fn a_thousand_swept_bodies_in_a_room() {
    room(1000);
}

#[test]
#[ignore = "ten thousand swept bodies, for a release build"]
fn ten_thousand_swept_bodies_in_a_room() {
    room(10_000);
}

/// A million at rest, of which a few move.
#[test]
#[ignore = "a million objects, for a release build"]
fn a_million_objects() {
    let mut app = plain_app(BroadPhaseMethod::default());
    let shape = CollisionShape::default();
    let at = |n: u32| {
        Vec3::new(
            (n % 100) as f32,
            (n / 100 % 100) as f32,
            (n / 10_000) as f32,
        ) * 1.5
    };
    let all: Vec<_> = (0..1_000_000)
        .map(|n| spawn(&mut app, shape.clone(), at(n)))
        .collect();
    tick(&mut app, 1);
    assert_eq!(
        (counters(&app).objects, counters(&app).contacts),
        (1_000_000, 0)
    );
    assert!(counters(&app).pairs_tested < 100_000_000);
    for entity in &all[..50] {
        get_mut::<Transform>(&mut app, *entity).translation.x += 0.75;
    }
    tick(&mut app, 1);
    assert_eq!((counters(&app).moved, counters(&app).contacts), (50, 1));
    for entity in all {
        app.world_mut().despawn(entity);
    }
    tick(&mut app, 1);
    assert_eq!((counters(&app).objects, counters(&app).contacts), (0, 0));
}
