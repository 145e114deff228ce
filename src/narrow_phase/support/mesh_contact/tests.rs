//! Floors, ridges and boxes, as meshes of ours.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::shape::SharedShape;

use crate::narrow_phase::support::query::tests::{Random, contact};
use crate::narrow_phase::tests::mesh_of;
use crate::narrow_phase::*;

/// A level floor of squares of about two units, cut along either diagonal; wound upwards or
/// downwards.
fn floor(random: &mut Random, is_up: bool) -> Shape {
    let side = 9u32;
    let mut vertices = vec![];
    for z in 0..side {
        for x in 0..side {
            let shaken = random.point() * 0.5;
            let place = Vec3::new(x as f32 * 2.0 - 8.0, 0.0, z as f32 * 2.0 - 8.0);
            vertices.push(place + shaken.with_y(0.0));
        }
    }
    let mut triangles = vec![];
    for z in 0..side - 1 {
        for x in 0..side - 1 {
            let a = z * side + x;
            let [b, c, d] = [a + side, a + side + 1, a + 1];
            let cut = if (x + z) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            triangles.extend(cut);
        }
    }
    if !is_up {
        triangles.iter_mut().for_each(|triangle| triangle.reverse());
    }
    Shape::mesh(vertices, triangles).expect("it is fine")
}

fn solids() -> Vec<(&'static str, SharedShape)> {
    let parts = vec![
        (Pose::translation(0.0, 0.5, 0.0), SharedShape::ball(0.4)),
        (
            Pose::translation(0.0, -0.5, 0.0),
            SharedShape::cuboid(0.4, 0.4, 0.4),
        ),
    ];
    vec![
        ("capsule", SharedShape::capsule_y(0.6, 0.3)),
        ("long capsule", SharedShape::capsule_x(1.5, 0.05)),
        ("cylinder", SharedShape::cylinder(0.6, 0.4)),
        ("cone", SharedShape::cone(0.6, 0.5)),
        (
            "round cuboid",
            SharedShape::round_cuboid(0.4, 0.3, 0.5, 0.1),
        ),
        ("compound", SharedShape::compound(parts)),
    ]
}

/// How far a shape reaches up and down along a direction, from its position.
fn reach(shape: &SharedShape, turn: Quat, up: Vec3) -> [f32; 2] {
    let at = |pose: &Pose, shape: &SharedShape, direction: Vec3| {
        let local = pose.rotation.inverse() * (turn.inverse() * direction);
        let point = match shape.as_ball() {
            Some(ball) => local.normalize() * ball.radius,
            None => shape
                .as_support_map()
                .expect("it is convex")
                .local_support_point(local),
        };
        (turn * (pose.translation + pose.rotation * point)).dot(direction)
    };
    [up, -up].map(|direction| match shape.as_compound() {
        Some(compound) => compound
            .shapes()
            .iter()
            .map(|(pose, shape)| at(pose, shape, direction))
            .fold(f32::NEG_INFINITY, f32::max),
        None => at(&Pose::IDENTITY, shape, direction),
    })
}

#[test]
fn a_level_floor_has_no_normals_but_up_and_down() {
    let mut random = Random::new(11);
    let mut from_below = 0;
    for i in 0..1500 {
        let mesh = floor(&mut random, i % 2 == 0);
        let sign = |random: &mut Random| 1f32.copysign(random.between(-1.0, 1.0));
        let scale = Vec3::new(
            sign(&mut random) * random.between(0.8, 1.5),
            sign(&mut random),
            sign(&mut random) * random.between(0.8, 1.5),
        );
        let at_mesh = Transform::from_translation(random.point() * 3.0)
            .with_rotation(random.turn())
            .with_scale(scale);
        let up = at_mesh.rotation * Vec3::Y;
        let shapes = solids();
        let (name, shape) = &shapes[i % shapes.len()];
        let turn = if i % 3 == 0 {
            at_mesh.rotation
        } else {
            random.turn()
        };
        // Its middle over the floor or below it, and something of it through it.
        let [high, low] = reach(shape, turn, up);
        let height = random.between(-0.8 * high, 0.8 * low);
        let aside = at_mesh.rotation * (random.point() * 4.0).with_y(0.0);
        let at_shape = Transform::from_translation(at_mesh.translation + aside + up * height)
            .with_rotation(turn);
        let found = contact((&mesh, at_mesh), (&shape.clone().into(), at_shape));
        let found = found.unwrap_or_else(|| panic!("{name} at {height}"));
        let expected = if shape.as_compound().is_some() {
            // Each part goes to the side that is nearer to it.
            None
        } else {
            Some((low - height, height + high))
        };
        assert!(
            found.normal.dot(up).abs() > 0.999,
            "{name} at {height}: {found:?}, not along {up}"
        );
        let Some((upwards, downwards)) = expected else {
            continue;
        };
        let least = upwards.min(downwards);
        assert!(
            (found.depth - least).abs() < 2e-3,
            "{name} at {height}: {found:?}, not {least}"
        );
        if (upwards - downwards).abs() > 1e-2 {
            from_below += usize::from(downwards < upwards);
            assert_eq!(
                found.normal.dot(up) > 0.0,
                upwards < downwards,
                "{name} at {height}: {found:?}"
            );
        }
        let off = (found.point - at_mesh.translation).dot(up);
        assert!(
            off.abs() <= least + 1e-3,
            "{name}: {found:?}, {off} off the floor"
        );
    }
    assert!(from_below > 200, "{from_below}");
}

#[test]
fn a_capsule_across_an_edge_of_a_box_goes_out_over_the_edge() {
    let cube = mesh_of(Vec3::ONE);
    let capsule: Shape = SharedShape::capsule_y(2.0, 0.1).into();
    let here = Transform::IDENTITY;
    // Across the upper right edge of the box, a tenth inside.
    let out = Vec3::new(1.0, 1.0, 0.0).normalize();
    let place = Vec3::new(1.0, 1.0, 0.2) - out * 0.1;
    for turn in [0.0, 0.2, -0.2] {
        let across = Quat::from_axis_angle(out, turn) * Quat::from_rotation_z(45f32.to_radians());
        let there = Transform::from_translation(place).with_rotation(across);
        for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::NEG_ONE] {
            let found = contact((&cube, here.with_scale(scale)), (&capsule, there)).unwrap();
            assert!(
                found.normal.dot(out) > 0.9999 && (found.depth - 0.2).abs() < 1e-3,
                "{turn} {scale}: {found:?}"
            );
        }
    }
}

#[test]
fn what_is_in_a_solid_goes_out_of_it() {
    let cube = mesh_of(Vec3::ONE);
    let here = Transform::IDENTITY;
    for (name, shape) in [
        ("capsule", SharedShape::capsule_y(0.2, 0.1)),
        ("cylinder", SharedShape::cylinder(0.3, 0.1)),
        ("cone", SharedShape::cone(0.3, 0.2)),
    ] {
        let shape: Shape = shape.into();
        // Wholly inside, or its middle inside or outside and something of it through the right side.
        for x in [0.7, 0.95, 0.98, 1.02, 1.05] {
            let at = Transform::from_xyz(x, 0.2, 0.1);
            let found = contact((&cube, here), (&shape, at)).unwrap();
            let width = match &shape {
                Shape::Rapier(shape) => shape.raw().compute_local_aabb().maxs.x,
                _ => unreachable!(),
            };
            let expected = 1.0 - x + width;
            assert!(
                found.normal.x > 0.999 && (found.depth - expected).abs() < 2e-3,
                "{name} at {x}: {found:?}, not {expected}"
            );
        }
    }
}
