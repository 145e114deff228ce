//! Convex meshes of many faces, against all pairs of them.

use bevy::math::{EulerRot, Quat, Vec3};
use bevy::transform::components::Transform;

use super::*;
use crate::narrow_phase::contact::{large_hull::tests::sphere, support::visited};
use crate::narrow_phase::frame::placed::Placed;
use crate::narrow_phase::shape::Shape;

fn random_turn(random: &mut fastrand::Rng) -> Quat {
    let mut angle = || random.f32() * 6.0;
    Quat::from_euler(EulerRot::XYZ, angle(), angle(), angle())
}

fn random_unit(random: &mut fastrand::Rng) -> Vec3 {
    random_turn(random) * Vec3::X
}

#[test]
fn many_faces_overlap_as_little_as_all_pairs_say() {
    let mut random = fastrand::Rng::with_seed(5);
    let spheres = [(6, 8), (12, 16), (22, 24)].map(|(rings, around)| {
        let mesh = sphere(rings, around);
        Shape::from(mesh)
    });
    let cube = Shape::cuboid(2.0, 1.2, 1.6);
    let mut workspace = Workspace::default();
    let mut checked = 0;
    for round in 0..120 {
        let one = &spheres[random.usize(0..3)];
        let other = if round % 5 == 0 {
            &cube
        } else {
            &spheres[random.usize(0..3)]
        };
        let scale = Vec3::new(1.0, random.f32() + 0.4, random.f32() + 0.4);
        let at_a = Transform::from_rotation(random_turn(&mut random)).with_scale(scale);
        let way = random_unit(&mut random) * (0.4 + 1.6 * random.f32());
        let at_b = Transform::from_translation(way).with_rotation(random_turn(&mut random));
        let pair = PlacedPair::new(Placed::new(one, &at_a), Placed::new(other, &at_b), 1e-6);
        let pair = pair.unwrap();
        if !has_large(&pair) {
            continue;
        }
        let size = pair.box_a.radius + pair.box_b.radius;
        // Without a preference, so that the order does not count.
        let (axis, gap) = least_overlap_near(&pair, 0.0, &mut workspace).unwrap();
        edge_polygon::fill_all(&pair, &mut workspace).unwrap();
        let [a, b] = &workspace.surfaces;
        let (_, all) = least_overlap(a, b, 0.0).unwrap();
        if all > 0.0 {
            continue;
        }
        checked += 1;
        assert!(
            (gap - all).abs() <= 1e-4 * size,
            "{gap}, all {all}, {pair:?}"
        );
        assert!((a.gap(b, axis) - gap).abs() <= 1e-5 * size);
    }
    assert!(checked > 60, "{checked}");
}

#[test]
fn what_is_looked_at_grows_less_than_the_number_of_pairs() {
    let mut workspace = Workspace::default();
    let turn = Quat::from_rotation_x(0.3);
    let mut count = |rings: u32| {
        let shape = Shape::from(sphere(rings, 2 * rings));
        let here = Transform::IDENTITY;
        let there = Transform::from_xyz(1.2, 0.8, 0.7).with_rotation(turn);
        let (a, b) = (Placed::new(&shape, &here), Placed::new(&shape, &there));
        let pair = PlacedPair::new(a, b, 1e-6).unwrap();
        visited::take();
        least_overlap_near(&pair, 1e-3, &mut workspace).unwrap();
        let faces: usize = workspace.surfaces.iter().map(|s| s.faces.len()).sum();
        (
            visited::take(),
            faces,
            shape.polygons().unwrap().0.polygon_count(),
        )
    };
    for rings in [10, 20, 40, 64] {
        let (visited, near, faces) = count(rings);
        assert!(
            visited < 2 * faces && near < 2 * faces,
            "{visited} {near} {faces}"
        );
    }
}
