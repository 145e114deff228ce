//! What contacts do to velocities.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{prelude::*, scene::Cube};
use common::*;

const REFLECT: fn(f32) -> Bounce = |restitution| Bounce::Reflect { restitution };

/// A unit cube on the x axis that moves along it, by `step` per tick.
fn mover(app: &mut App, x: f32, step: f32) -> Entity {
    let velocity = Velocity(Vec3::X * step * TICKS_PER_SECOND);
    app.world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(x, 0.0, 0.0),
            velocity,
        ))
        .id()
}

fn bouncer(app: &mut App, x: f32, step: f32, bounce: Bounce) -> Entity {
    let entity = mover(app, x, step);
    app.world_mut().entity_mut(entity).insert(bounce);
    entity
}

fn wall(app: &mut App, x: f32) -> Entity {
    app.world_mut()
        .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)))
        .id()
}

fn x(app: &App, entity: Entity) -> f32 {
    get::<Transform>(app, entity).translation.x
}

/// The distance per tick along x.
fn step(app: &App, entity: Entity) -> f32 {
    get::<Velocity>(app, entity).x / TICKS_PER_SECOND
}

fn bounces(app: &App) -> u64 {
    app.world().resource::<CollisionCounters>().total.bounces
}

/// 3 1/16 apart, closing by 1/8 per tick: half a step deep in each other after tick 25.
#[test]
fn two_cubes_bounce_off_each_other() {
    let mut app = app(BroadPhaseMethod::default());
    let start = 2.0 + 1.0 / 32.0;
    let cubes =
        [-1.0, 1.0].map(|side: f32| bouncer(&mut app, side * start, -side / 16.0, Bounce::Reverse));
    for n in 1..=60 {
        tick(&mut app, 1);
        let covered = if n <= 25 { n } else { 50 - n } as f32 / 16.0;
        assert_eq!(
            cubes.map(|cube| x(&app, cube)),
            [covered - start, start - covered],
            "tick {n}"
        );
        let outward = if n < 25 { -1.0 } else { 1.0 } / 16.0;
        assert_eq!(
            cubes.map(|cube| step(&app, cube)),
            [-outward, outward],
            "tick {n}"
        );
        assert_eq!(contacts(&app).len(), usize::from(n == 25), "tick {n}");
    }
    let log = app.world().resource::<Log>();
    assert_eq!(
        (&log.started, &log.ended),
        (&vec![(25, cubes)], &vec![(26, cubes)])
    );
    assert_eq!(bounces(&app), 2);
}

#[test]
fn touching_is_contact() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [-1.0, 1.0].map(|side: f32| bouncer(&mut app, side, -side / 16.0, Bounce::Reverse));
    tick(&mut app, 7);
    assert!(contacts(&app).is_empty());
    tick(&mut app, 1);
    assert_eq!((x(&app, cubes[0]), x(&app, cubes[1])), (-0.5, 0.5));
    assert_eq!(contacts(&app), [cubes]);
}

#[test]
fn a_static_wall_stays_and_throws_back() {
    let mut app = app(BroadPhaseMethod::default());
    let cube = bouncer(&mut app, 0.0, 0.25, Bounce::Reverse);
    let wall = wall(&mut app, 2.125);
    tick(&mut app, 5);
    assert_eq!((x(&app, cube), step(&app, cube)), (1.25, -0.25));
    tick(&mut app, 5);
    assert_eq!((x(&app, cube), step(&app, cube)), (0.0, -0.25));
    assert_eq!(x(&app, wall), 2.125);
    assert_eq!(
        (messages_about(&app, [cube, wall]), bounces(&app)),
        ((1, 1), 1)
    );
}

#[test]
fn without_bounce_they_pass_through_and_are_reported() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [-1.0, 1.0].map(|side: f32| mover(&mut app, side * 2.03125, -side / 16.0));
    tick(&mut app, 60);
    assert_eq!(
        cubes.map(|cube| step(&app, cube)),
        [1.0 / 16.0, -1.0 / 16.0]
    );
    let log = app.world().resource::<Log>();
    // Within one side of each other: from 25 to 40 steps of 1/8 out of 4 1/16.
    assert_eq!(
        (&log.started, &log.ended),
        (&vec![(25, cubes)], &vec![(41, cubes)])
    );
    assert_eq!(bounces(&app), 0);
}

#[test]
fn only_the_one_with_a_bounce_turns_around() {
    let mut app = app(BroadPhaseMethod::default());
    let with = bouncer(&mut app, -1.0, 0.125, Bounce::Reverse);
    let without = mover(&mut app, 1.0, -0.0625);
    tick(&mut app, 6);
    assert_eq!((step(&app, with), step(&app, without)), (-0.125, -0.0625));
}

#[test]
fn two_contacts_at_once_reverse_once() {
    let mut app = app(BroadPhaseMethod::default());
    let falling = Transform::from_xyz(0.0, 2.0, 0.0);
    let velocity = Velocity(Vec3::NEG_Y * 0.25 * TICKS_PER_SECOND);
    let cube = app.world_mut().spawn((Cube, falling, velocity)).id();
    let ground = [-0.75, 0.75].map(|x| wall(&mut app, x));
    tick(&mut app, 4);
    assert_eq!(contacts(&app), ground.map(|block| pair(cube, block)));
    assert_eq!(counters(&app).bounces, 1);
    assert_eq!(
        *get::<Velocity>(&app, cube),
        Velocity(Vec3::Y * 0.25 * TICKS_PER_SECOND)
    );
}

/// Steps before and after a head-on contact; `None` has no `Bounce`, `0.0` and `None` is a static
/// wall.
#[test]
fn reflection_keeps_what_restitution_says() {
    let r = |restitution| Some(REFLECT(restitution));
    let reverse = Some(Bounce::Reverse);
    let cases = [
        // Equal masses exchange velocities, lose half, or stop each other.
        ([(0.25, r(1.0)), (-0.25, r(1.0))], [-0.25, 0.25]),
        ([(0.25, r(0.5)), (-0.25, r(0.5))], [-0.125, 0.125]),
        ([(0.25, r(0.0)), (-0.25, r(0.0))], [0.0, 0.0]),
        ([(0.25, r(1.0)), (0.125, r(1.0))], [0.125, 0.25]),
        ([(0.25, r(1.0)), (-0.125, r(0.0))], [0.0625, 0.0625]),
        // A wall, at rest or on its way, gives back all or nothing.
        ([(0.25, r(1.0)), (0.0, None)], [-0.25, 0.0]),
        ([(0.25, r(0.5)), (0.0, None)], [-0.125, 0.0]),
        ([(0.25, r(0.0)), (0.0, None)], [0.0, 0.0]),
        ([(0.25, r(1.0)), (-0.125, None)], [-0.5, -0.125]),
        // Out of range.
        ([(0.25, r(f32::NAN)), (0.0, None)], [0.0, 0.0]),
        ([(0.25, r(-3.0)), (0.0, None)], [0.0, 0.0]),
        ([(0.25, r(7.0)), (0.0, None)], [-0.25, 0.0]),
        // Each by its own rule: the other is reversed first.
        ([(0.0625, r(1.0)), (-0.125, reverse)], [0.0625, 0.125]),
        ([(0.25, r(1.0)), (-0.125, reverse)], [0.0, 0.125]),
    ];
    for (number, (movers, expected)) in cases.into_iter().enumerate() {
        let mut app = app(BroadPhaseMethod::default());
        let entities = [0, 1].map(|i| {
            let (start, (step, bounce)) = ([-0.6, 0.6][i], movers[i]);
            let entity = if step == 0.0 {
                wall(&mut app, start)
            } else {
                mover(&mut app, start, step)
            };
            app.world_mut()
                .entity_mut(entity)
                .insert_if_new(Velocity::default());
            if let Some(bounce) = bounce {
                app.world_mut().entity_mut(entity).insert(bounce);
            }
            entity
        });
        while contacts(&app).is_empty() {
            tick(&mut app, 1);
        }
        for (entity, expected) in entities.into_iter().zip(expected) {
            assert!(
                (step(&app, entity) - expected).abs() < 1e-5,
                "case {number}: {}",
                step(&app, entity)
            );
        }
    }
}

#[test]
fn reflection_acts_on_approaching_objects_only() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = [-0.25, 0.25].map(|x: f32| bouncer(&mut app, x, x / 4.0, REFLECT(1.0)));
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes]);
    assert_eq!(cubes.map(|cube| step(&app, cube)), [-0.0625, 0.0625]);
    tick(&mut app, 4);
    assert_eq!((messages_about(&app, cubes), bounces(&app)), ((1, 1), 0));
}

/// With half the speed back they are still in each other one tick after the bounce, and must not
/// bounce again.
#[test]
fn a_slow_return_is_one_bounce() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes =
        [-1.0, 1.0].map(|side: f32| bouncer(&mut app, side * 0.75, -side * 0.1875, REFLECT(0.5)));
    tick(&mut app, 20);
    assert_eq!((messages_about(&app, cubes), bounces(&app)), ((1, 1), 2));
    assert!(x(&app, cubes[1]) > 1.5);
}
