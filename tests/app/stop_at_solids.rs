//! What stops at the first solid: it meets what is before that, and nothing of what is behind.

use crate::{bullets::*, common};

use bevy::prelude::*;
use bevy_octree::prelude::*;
use common::*;
use fastrand::Rng;

/// A bullet along the x axis that stops at what is solid.
fn stopping_bullet(app: &mut App, x: f32, step: f32) -> Entity {
    let bullet = bullet(app, Vec3::X * x, Vec3::X * step);
    app.world_mut().entity_mut(bullet).insert(Swept::stopping());
    bullet
}

/// Across the x axis, and passed through.
fn sensor(app: &mut App, x: f32) -> Entity {
    let sensor = paper(app, x);
    app.world_mut().entity_mut(sensor).insert(Sensor);
    sensor
}

#[track_caller]
fn assert_at(app: &App, bullet: Entity, x: f32) {
    let at = place(app, bullet).x;
    assert!((at - x).abs() < 1e-3, "{at}, not {x}");
}

#[test]
fn what_is_behind_the_wall_is_not_met() {
    let mut app = app(BroadPhaseMethod::default());
    let behind = [paper(&mut app, 5.0), sensor(&mut app, 4.0)];
    let (wall, before) = (paper(&mut app, 3.0), sensor(&mut app, 1.0));
    let bullet = stopping_bullet(&mut app, 0.0, 10.0);
    tick(&mut app, 1);
    let expected = [pair(bullet, wall), pair(bullet, before)];
    assert_eq!(contacts(&app), expected, "not {behind:?}");
    assert_at(&app, bullet, 3.0 - 0.051);
    assert_eq!(
        get::<Velocity>(&app, bullet).0,
        Vec3::X * 10.0 * TICKS_PER_SECOND
    );
    // It stays there, in touch with the wall, for as long as there is one.
    tick(&mut app, 5);
    assert_eq!(contacts(&app), [pair(bullet, wall)]);
    assert_at(&app, bullet, 3.0 - 0.051);
    assert_eq!(messages_about(&app, pair(bullet, before)), (1, 1));
    assert_eq!(messages_about(&app, pair(bullet, wall)), (1, 0));
    app.world_mut().despawn(wall);
    tick(&mut app, 1);
    assert_at(&app, bullet, 5.0 - 0.051);
    assert_eq!(messages_about(&app, pair(bullet, wall)), (1, 1));
    for behind in behind {
        assert_eq!(messages_about(&app, pair(bullet, behind)).0, 1);
    }
}

/// A bullet that its mover moves stays where that puts it; it is told of what is before the wall.
#[test]
fn who_is_moved_by_others_is_told_no_more() {
    let mut app = app(BroadPhaseMethod::default());
    let (behind, wall, before) = (
        paper(&mut app, 5.0),
        paper(&mut app, 3.0),
        sensor(&mut app, 1.0),
    );
    let bullet = stopping_bullet(&mut app, 0.0, 0.0);
    app.world_mut().entity_mut(bullet).remove::<Velocity>();
    tick(&mut app, 1);
    app.world_mut()
        .get_mut::<Transform>(bullet)
        .unwrap()
        .translation
        .x = 10.0;
    tick(&mut app, 1);
    let expected = [pair(bullet, wall), pair(bullet, before)];
    assert_eq!(contacts(&app), expected, "not {behind}");
    assert_at(&app, bullet, 10.0);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
}

#[test]
fn a_bounce_says_nothing_about_what_stops() {
    for bounce in [Bounce::Reverse, ELASTIC] {
        let mut app = app(BroadPhaseMethod::default());
        let (wall, _back) = (paper(&mut app, 3.0), paper(&mut app, -1.0));
        let bullet = stopping_bullet(&mut app, 0.0, 10.0);
        app.world_mut().entity_mut(bullet).insert(bounce);
        tick(&mut app, 2);
        assert_eq!(contacts(&app), [pair(bullet, wall)]);
        assert_at(&app, bullet, 3.0 - 0.051);
        assert_eq!(get::<Velocity>(&app, bullet).0.x, 10.0 * TICKS_PER_SECOND);
    }
}

#[test]
fn a_ball_answers_to_the_bullet_that_stops_at_it() {
    let mut app = app(BroadPhaseMethod::default());
    let shape = CollisionShape::sphere(0.5);
    let ball = (
        shape,
        Velocity::default(),
        ELASTIC,
        Swept::default(),
        Transform::from_xyz(3.0, 0.0, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    let behind = paper(&mut app, 20.0);
    let bullet = stopping_bullet(&mut app, 0.0, 10.0);
    tick(&mut app, 1);
    // After 0.245 of the tick, the ball goes off at twice the speed of the wall that has come.
    assert_eq!(contacts(&app), [pair(bullet, ball)], "not {behind}");
    assert_at(&app, bullet, 3.0 - 0.55);
    assert_at(&app, ball, 3.0 + 20.0 * (1.0 - 0.245));
}

#[test]
fn of_several_bullets_each_stops_where_it_should() {
    let mut app = app(BroadPhaseMethod::default());
    let wall = paper(&mut app, 3.0);
    let bullets = [0.0, 1.0, 2.0].map(|y| {
        let bullet = bullet(&mut app, Vec3::Y * y, Vec3::X * (5.0 + y));
        app.world_mut().entity_mut(bullet).insert(Swept::stopping());
        bullet
    });
    // Head-on, they stop each other.
    let left = stopping_bullet(&mut app, -20.0, 5.0);
    let right = stopping_bullet(&mut app, -10.0, -15.0);
    // One that comes behind another stops behind it.
    let second = stopping_bullet(&mut app, -30.0, 20.0);
    tick(&mut app, 1);
    for bullet in bullets {
        assert_at(&app, bullet, 3.0 - 0.051);
        assert!(contacts(&app).contains(&pair(bullet, wall)));
    }
    assert_at(&app, left, -20.0 + 9.9 / 4.0);
    assert_at(&app, right, -10.0 - 9.9 * 0.75);
    assert_at(&app, second, -20.0 + 9.9 / 4.0 - 0.1);
    let mut expected = bullets.map(|bullet| pair(bullet, wall)).to_vec();
    expected.extend([pair(left, right), pair(left, second)]);
    expected.sort_unstable();
    let mut found = contacts(&app);
    found.sort_unstable();
    assert_eq!(found, expected);
}

/// What it does not hear of, as layers and detectors have it, does not stop it.
#[test]
fn what_is_not_heard_of_stops_nothing() {
    let mut app = app(BroadPhaseMethod::default());
    let (deaf, wall) = (paper(&mut app, 1.0), paper(&mut app, 3.0));
    let bullet = stopping_bullet(&mut app, 0.0, 10.0);
    let of_bullet = CollisionLayers::new(LayerMask::layer(1), LayerMask::layer(0));
    app.world_mut().entity_mut(bullet).insert(of_bullet);
    let of_detector = CollisionLayers::new(LayerMask::layer(2), LayerMask::layer(1));
    app.world_mut()
        .entity_mut(deaf)
        .insert((of_detector, Detector));
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(deaf, bullet), pair(wall, bullet)]);
    assert_at(&app, bullet, 3.0 - 0.051);
}

/// What grazes a wall, or leaves it, goes on.
#[test]
fn what_comes_no_nearer_stops_nothing() {
    let mut app = app(BroadPhaseMethod::default());
    let floor = wall(
        &mut app,
        Vec3::new(5.0, -1.05, 0.0),
        Vec3::new(10.0, 1.0, 1.0),
    );
    let bullet = stopping_bullet(&mut app, 0.0, 2.0);
    tick(&mut app, 3);
    assert_eq!(contacts(&app), [pair(floor, bullet)]);
    assert_at(&app, bullet, 6.0);
}

/// With many bullets and walls: those that stop meet what those that go on meet up to the first
/// solid, in the order of time.
#[test]
fn it_meets_what_one_that_goes_on_meets_up_to_the_first_solid() {
    let scene = |swept: Swept| {
        let mut app = app(BroadPhaseMethod::default());
        let mut rng = Rng::with_seed(5);
        let mut vector = |reach: f32| Vec3::from([(); 3].map(|()| (rng.f32() - 0.5) * reach));
        let things: Vec<_> = (0..1000)
            .map(|number| {
                let (at, axis) = (vector(25.0), vector(6.0));
                let shape = if number % 3 == 0 {
                    CollisionShape::sphere(0.7)
                } else {
                    CollisionShape::cuboid(0.1, 3.0, 4.0)
                };
                let pose =
                    Transform::from_translation(at).with_rotation(Quat::from_scaled_axis(axis));
                let thing = app.world_mut().spawn((shape, pose)).id();
                if number % 4 == 0 {
                    app.world_mut().entity_mut(thing).insert(Sensor);
                }
                thing
            })
            .collect();
        let bullets: Vec<_> = (0..200)
            .map(|_| {
                let (from, way) = (vector(25.0), vector(120.0));
                let bullet = bullet(&mut app, from, way);
                let layers = CollisionLayers::new(LayerMask::layer(1), LayerMask::layer(0));
                app.world_mut().entity_mut(bullet).insert((swept, layers));
                bullet
            })
            .collect();
        tick(&mut app, 1);
        let messages = app.world().resource::<Messages<CollisionStarted>>();
        let told: Vec<_> = { messages.get_cursor().read(messages).copied().collect() };
        assert!(told.is_sorted_by_key(|message| message.time));
        let met = bullets.iter().map(|bullet| {
            let told = told.iter().filter(|told| told.other(*bullet).is_some());
            let what = told.map(|told| {
                let other = told.other(*bullet).unwrap();
                let number = things.iter().position(|thing| *thing == other).unwrap();
                (number, told.time)
            });
            what.collect::<Vec<_>>()
        });
        met.collect::<Vec<_>>()
    };
    let (mut stopped, mut passed) = (0, 0);
    for (stops, goes_on) in scene(Swept::stopping()).iter().zip(scene(Swept::default())) {
        let is_solid = |number: usize| !number.is_multiple_of(4);
        let first = goes_on.iter().position(|(number, _)| is_solid(*number));
        let expected = &goes_on[..first.map_or(goes_on.len(), |first| first + 1)];
        let numbers = |met: &[(usize, f32)]| met.iter().map(|met| met.0).collect::<Vec<_>>();
        // At the place where it has stopped, it may touch something else.
        assert!(
            numbers(stops).starts_with(&numbers(expected)),
            "{stops:?} {goes_on:?}"
        );
        let last = expected.last().map_or(1.0, |(_, time)| *time);
        assert!(
            stops.iter().all(|(_, time)| *time <= last + 1e-6),
            "{stops:?} {goes_on:?}"
        );
        stopped += usize::from(first.is_some());
        passed += goes_on.len() - expected.len();
    }
    assert!(stopped > 50 && passed > 50, "{stopped} {passed}");
}
