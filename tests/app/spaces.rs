//! Velocities are in the space of the parent, and bounces happen in the world.

use crate::common;

use std::f32::consts::FRAC_PI_2;

use bevy::{prelude::*, transform::helper::TransformHelper};
use bevy_octree::prelude::*;
use common::*;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

fn wall(app: &mut App, center: Vec3, half_size: Vec3) -> Entity {
    let shape = CollisionShape::from_half_size(half_size);
    app.world_mut()
        .spawn((shape, StaticShape, Transform::from_translation(center)))
        .id()
}

/// A ball that bounces, of radius 0.25 in the world under a parent of the scale that is given.
fn ball(app: &mut App, at: Transform, velocity: Vec3, swept: bool) -> Entity {
    let ball = (
        CollisionShape::sphere(0.25),
        ELASTIC,
        Velocity(velocity),
        at,
    );
    let ball = app.world_mut().spawn(ball).id();
    if swept {
        app.world_mut().entity_mut(ball).insert(Swept::default());
    }
    ball
}

fn parent(app: &mut App, at: Transform) -> Entity {
    app.world_mut().spawn(at).id()
}

fn adopt(app: &mut App, parent: Entity, child: Entity) -> Entity {
    app.world_mut().entity_mut(parent).add_child(child);
    child
}

fn velocity(app: &App, entity: Entity) -> Vec3 {
    get::<Velocity>(app, entity).0
}

fn in_world(app: &mut App, entity: Entity) -> Vec3 {
    use bevy::ecs::system::RunSystemOnce;
    let look = move |helper: TransformHelper| {
        helper
            .compute_global_transform(entity)
            .unwrap()
            .translation()
    };
    app.world_mut().run_system_once(look).unwrap()
}

fn assert_near(found: Vec3, expected: Vec3, within: f32) {
    assert!(
        found.distance(expected) <= within,
        "{found}, expected {expected}"
    );
}

/// Its way in the world is along y, and so it meets the wall there.
#[test]
fn the_child_of_a_turned_parent_is_thrown_back() {
    for swept in [true, false] {
        let mut app = app(BroadPhaseMethod::default());
        wall(&mut app, Vec3::Y * 2.0, Vec3::new(5.0, 0.5, 5.0));
        let turned = parent(
            &mut app,
            Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_2)),
        );
        let child = ball(&mut app, Transform::IDENTITY, Vec3::X * 16.0, swept);
        adopt(&mut app, turned, child);
        tick(&mut app, 8);
        assert_near(velocity(&app, child), Vec3::X * -16.0, 1e-3);
        let at = in_world(&mut app, child);
        assert!(at.y < 1.3 && at.x.abs() < 1e-3, "{at}");
        if swept {
            assert_near(at, Vec3::Y * (2.0 * 1.25 - 2.0), 1e-2);
        }
    }
}

/// A child hits a ball at rest: what it gives is what it has in the world.
#[test]
fn a_child_gives_what_it_has_in_the_world() {
    let mirrored = Transform::from_scale(Vec3::new(-4.0, 4.0, 4.0));
    let turned = Transform::from_rotation(Quat::from_rotation_y(1.0)).with_scale(Vec3::splat(0.5));
    for (scale, turn, own) in [
        (4.0, Quat::IDENTITY, 4.0),
        (0.5, Quat::from_rotation_y(1.0), 32.0),
    ] {
        for swept in [true, false] {
            let mut app = app(BroadPhaseMethod::default());
            let above = parent(
                &mut app,
                Transform::from_scale(Vec3::splat(scale)).with_rotation(turn),
            );
            let child = ball(
                &mut app,
                Transform::from_scale(Vec3::splat(1.0 / scale)),
                turn.inverse() * Vec3::X * own,
                swept,
            );
            adopt(&mut app, above, child);
            let other = ball(
                &mut app,
                Transform::from_xyz(2.0, 0.0, 0.0),
                Vec3::ZERO,
                swept,
            );
            tick(&mut app, 8);
            assert_near(velocity(&app, other), Vec3::X * 16.0, 1e-2);
            assert_near(velocity(&app, child), Vec3::ZERO, 1e-2);
        }
    }
    for above in [mirrored, turned] {
        let mut app = app(BroadPhaseMethod::default());
        let above = parent(&mut app, above);
        wall(&mut app, Vec3::X * 4.0, Vec3::new(0.5, 9.0, 9.0));
        wall(&mut app, Vec3::X * -4.0, Vec3::new(0.5, 9.0, 9.0));
        let child = ball(
            &mut app,
            Transform::from_scale(Vec3::splat(0.5)),
            Vec3::X * 7.0,
            true,
        );
        adopt(&mut app, above, child);
        tick(&mut app, 200);
        assert!(in_world(&mut app, child).x.abs() < 3.5);
    }
}

/// A child of a child in a space that is stretched and turned and stretched: in the world, as if it
/// hung on nothing.
#[test]
fn a_sheared_space_changes_nothing_in_the_world() {
    let mut app = app(BroadPhaseMethod::default());
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            wall(
                &mut app,
                axis * side * 3.5,
                Vec3::splat(4.0) * (Vec3::ONE - axis) + axis * 0.5,
            );
        }
    }
    let grand = parent(
        &mut app,
        Transform::from_scale(Vec3::new(3.0, 1.0, -0.5)).with_rotation(Quat::from_rotation_x(0.4)),
    );
    let turned = Quat::from_euler(EulerRot::XYZ, 0.5, -1.0, 0.8);
    let above = parent(
        &mut app,
        Transform::from_xyz(0.1, 0.2, 0.3).with_rotation(turned),
    );
    adopt(&mut app, grand, above);
    let frame = in_world_affine(&mut app, above);
    let start = Vec3::new(0.3, -0.4, 0.5);
    let step = Vec3::new(17.0, -23.0, 31.0);
    // One that hangs on it and one that hangs on nothing, which pass through each other. Next to
    // points, for in a sheared space a ball is none.
    let shape = CollisionShape::sphere(0.0001);
    let both = [false, true].map(|hangs| {
        let (at, v) = if hangs {
            (
                frame.inverse().transform_point3(start),
                frame.inverse().transform_vector3(step),
            )
        } else {
            (start, step)
        };
        let ball = (
            shape.clone(),
            ELASTIC,
            Swept::default(),
            CollisionLayers::from_bits(2, 1),
        );
        let ball = app
            .world_mut()
            .spawn((ball, Velocity(v), Transform::from_translation(at)))
            .id();
        if hangs {
            adopt(&mut app, above, ball);
        }
        ball
    });
    for n in 0..300 {
        tick(&mut app, 1);
        let [free, hanging] = both.map(|ball| in_world(&mut app, ball));
        assert!(hanging.distance(free) < 0.05, "tick {n}: {hanging} {free}");
    }
    let hanging = frame.transform_vector3(velocity(&app, both[1]));
    assert_near(hanging, velocity(&app, both[0]), 1e-2);
}

fn in_world_affine(app: &mut App, entity: Entity) -> bevy::math::Affine3A {
    use bevy::ecs::system::RunSystemOnce;
    let look =
        move |helper: TransformHelper| helper.compute_global_transform(entity).unwrap().affine();
    app.world_mut().run_system_once(look).unwrap()
}

/// A paddle without a velocity of its own, on an arm that moves: a ball at rest gets twice the
/// velocity.
#[test]
fn a_paddle_pushes_by_the_motion_of_its_arm() {
    for swept in [true, false] {
        for depth in [1, 2] {
            for of_paddle in [false, true] {
                let mut app = app(BroadPhaseMethod::default());
                let arm = app
                    .world_mut()
                    .spawn((
                        Transform::from_xyz(-2.0, 0.0, 0.0),
                        Velocity(Vec3::X * 16.0),
                    ))
                    .id();
                let turned = Transform::from_rotation(Quat::from_rotation_y(FRAC_PI_2))
                    .with_scale(Vec3::splat(2.0));
                let mut hangs_on = arm;
                if depth == 2 {
                    let hand = parent(&mut app, turned);
                    adopt(&mut app, arm, hand);
                    hangs_on = hand;
                }
                let paddle = wall(&mut app, Vec3::ZERO, Vec3::splat(0.5 / depth as f32));
                app.world_mut().entity_mut(paddle).remove::<StaticShape>();
                if of_paddle && swept {
                    app.world_mut().entity_mut(paddle).insert(Swept::default());
                }
                adopt(&mut app, hangs_on, paddle);
                let ball = ball(&mut app, Transform::IDENTITY, Vec3::ZERO, swept);
                tick(&mut app, 12);
                assert_near(velocity(&app, ball), Vec3::X * 32.0, 1e-2);
            }
        }
    }
}

/// In a cart that moves as fast as the ball in it, the other way.
#[test]
fn a_ball_in_a_moving_cart() {
    for swept in [true, false] {
        let mut app = app(BroadPhaseMethod::default());
        let cart = app
            .world_mut()
            .spawn((Transform::IDENTITY, Velocity(Vec3::X * 4.0)))
            .id();
        for side in [-1.0, 1.0] {
            let end = wall(&mut app, Vec3::X * side * 2.0, Vec3::new(0.5, 2.0, 2.0));
            adopt(&mut app, cart, end);
            if swept {
                app.world_mut().entity_mut(end).insert(Swept::default());
            }
        }
        let ball = ball(&mut app, Transform::IDENTITY, Vec3::X * 7.0, swept);
        adopt(&mut app, cart, ball);
        for n in 0..400 {
            tick(&mut app, 1);
            let (at, v) = (
                get::<Transform>(&app, ball).translation.x,
                velocity(&app, ball),
            );
            assert!(
                at.abs() < 1.4 && (v.x.abs() - 7.0).abs() < 1e-2,
                "swept {swept}, tick {n}: {at} {v}"
            );
        }
    }
}

/// What hangs on one that bounces on its way goes with it, and meets nothing behind the wall.
#[test]
fn a_child_of_one_that_bounces_goes_with_it() {
    let mut app = app(BroadPhaseMethod::default());
    wall(&mut app, Vec3::X * 5.5, Vec3::new(0.5, 1.0, 1.0));
    wall(&mut app, Vec3::new(7.5, 2.0, 0.0), Vec3::splat(0.5));
    let above = ball(&mut app, Transform::IDENTITY, Vec3::X * 64.0 * 8.0, true);
    let child = ball(
        &mut app,
        Transform::from_xyz(0.0, 2.0, 0.0),
        Vec3::ZERO,
        true,
    );
    adopt(&mut app, above, child);
    tick(&mut app, 1);
    assert_near(
        in_world(&mut app, above),
        Vec3::X * (2.0 * 4.75 - 8.0),
        1e-3,
    );
    assert_near(
        in_world(&mut app, child),
        Vec3::new(2.0 * 4.75 - 8.0, 2.0, 0.0),
        1e-3,
    );
    assert_eq!(
        (
            velocity(&app, child),
            get::<Transform>(&app, child).translation
        ),
        (Vec3::ZERO, Vec3::Y * 2.0)
    );
    assert_eq!(app.world().resource::<Contacts>().len(), 1);
}

/// What is flat has no way back: it is a wall, and keeps its velocity.
#[test]
fn a_space_without_a_way_back_is_left_alone() {
    for swept in [true, false] {
        let mut app = app(BroadPhaseMethod::default());
        wall(&mut app, Vec3::X * 2.0, Vec3::new(0.5, 5.0, 5.0));
        let flat = parent(&mut app, Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)));
        let child = ball(
            &mut app,
            Transform::IDENTITY,
            Vec3::new(16.0, 3.0, 0.0),
            swept,
        );
        adopt(&mut app, flat, child);
        tick(&mut app, 20);
        assert_eq!(velocity(&app, child), Vec3::new(16.0, 3.0, 0.0));
    }
}
