//! Bodies that touch one wall of a mesh, and come to another.

use crate::common::*;

use bevy::prelude::*;
use bevy_octree::narrow_phase::{Moving, NarrowPhase, Placed, Workspace};
use bevy_octree::prelude::*;

/// A floor and a wall, as one surface.
fn corner() -> CollisionShape {
    let vertices = [
        (-4., 0., -4.),
        (-4., 0., 4.),
        (40., 0., 4.),
        (40., 0., -4.),
        (-4., 8., -4.),
        (-4., 8., 4.),
    ];
    let polygons = [[0, 1, 2, 3], [0, 4, 5, 1]];
    CollisionShape::mesh(vertices.map(Vec3::from).to_vec(), polygons).unwrap()
}

#[test]
fn the_wall_behind_a_floor_is_met() {
    let (tests, corner) = (NarrowPhase::default(), corner());
    let mut workspace = Workspace::default();
    for shape in [
        CollisionShape::sphere(0.5),
        CollisionShape::cuboid(1., 1., 1.),
    ] {
        for depth in [0.0, 1e-5, 1e-3, 0.1] {
            for turn in [0.0, 1e-3] {
                let start = Transform::from_xyz(0.0, 0.5 - depth, 0.3);
                let end = Transform::from_xyz(-10.0, 0.5 - depth, 0.3)
                    .with_rotation(Quat::from_rotation_y(turn));
                let moving = Moving::new(&shape, &start, &end);
                let here = Transform::IDENTITY;
                let room = Moving::resting(Placed::new(&corner, &here));
                let met = tests
                    .time_of_impact(&moving, &room, &mut workspace)
                    .unwrap();
                let off = (met.time - 0.35)
                    .abs()
                    .max(met.contact.normal.distance(Vec3::NEG_X));
                assert!(off < 2e-3, "{shape:?} {depth} {turn}: {met:?}");
            }
        }
    }
}

#[test]
fn what_is_swept_comes_back_from_the_wall() {
    for speed in [20.0, 60.0, 200.0] {
        for shape in [
            CollisionShape::sphere(0.5),
            CollisionShape::cuboid(1., 1., 1.),
        ] {
            let mut app = app(BroadPhaseMethod::Auto);
            let bounce = || Bounce::Reflect { restitution: 1.0 };
            app.world_mut().spawn((corner(), StaticShape, bounce()));
            let body = (
                shape,
                Transform::from_xyz(10.3, 0.5, 0.0),
                Velocity(Vec3::NEG_X * speed),
                Swept::default(),
                bounce(),
            );
            let body = app.world_mut().spawn(body).id();
            tick(&mut app, 64);
            let velocity = get::<Velocity>(&app, body).0;
            assert!(
                velocity.distance(Vec3::X * speed) < 1e-3,
                "{speed} {velocity}"
            );
        }
    }
}
