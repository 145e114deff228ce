//! What stands on what, and on which points.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;
use std::f32::consts::FRAC_PI_4;

use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

/// As seen from the first; from the second, it is the same with the normal turned around.
#[track_caller]
fn manifold(a: (&Shape, Transform), b: (&Shape, Transform)) -> Manifold {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let found = tests.manifold(one, two, &mut workspace).unwrap();
    let back = tests.manifold(two, one, &mut workspace).unwrap();
    assert_eq!(found, back.reversed());
    let contact = tests.contact(one, two, &mut workspace).unwrap();
    assert_eq!(found.normal, contact.normal);
    let depths = found.points().iter().map(|point| point.depth);
    assert!(depths.clone().all(|depth| depth <= contact.depth));
    assert_eq!(found.points()[0].depth, contact.depth);
    assert_eq!(
        found,
        tests.manifold(one, two, &mut Workspace::default()).unwrap()
    );
    found
}

/// The points, and no others, all of one depth.
#[track_caller]
fn assert_points(found: Manifold, expected: &[Vec3], depth: f32, what: &str) {
    let is_close = |point: &ManifoldPoint, expected: &Vec3| {
        point.point.distance(*expected) < 1e-4 && (point.depth - depth).abs() < 1e-4
    };
    let all = |expected: &Vec3| found.points().iter().any(|point| is_close(point, expected));
    assert!(
        found.points().len() == expected.len() && expected.iter().all(all),
        "{what}: {found:?}, expected {expected:?} {depth}"
    );
}

fn corners(middle: Vec3, half: Vec3) -> [Vec3; 4] {
    [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
        .map(|[x, z]| middle + half * Vec3::new(x, 0.0, z))
}

fn convex(half: Vec3) -> Shape {
    let Shape::Mesh(mesh) = mesh_of(half) else {
        unreachable!()
    };
    ConvexMesh::new((*mesh).clone()).unwrap().into()
}

/// Two triangles, and a fan of four, from (-4, 0, -4) to (4, 0, 4).
fn floors() -> [Shape; 3] {
    let corners = [[-4., -4.], [-4., 4.], [4., 4.], [4., -4.], [-0.1, 0.1]];
    let corners = corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec();
    let two = [[0, 1, 2], [0, 2, 3]];
    let fan = [[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 3, 0]];
    [
        Shape::mesh(corners.clone(), two).unwrap(),
        Shape::mesh(corners.clone(), two.map(|[a, b, c]| [a, c, b])).unwrap(),
        Shape::mesh(corners, fan).unwrap(),
    ]
}

fn boxes(half: Vec3) -> [Shape; 3] {
    [box_of(half.x, half.y, half.z), convex(half), mesh_of(half)]
}

#[test]
fn a_box_on_two_triangles_stands_on_its_corners() {
    let turned = Quat::from_rotation_y(0.4);
    for floor in &floors() {
        for solid in &boxes(Vec3::splat(0.5)) {
            for (x, z) in [(0.0, 0.0), (0.3, 0.1), (1.0, 1.0)] {
                for turn in [Quat::IDENTITY, turned] {
                    let place = at(x, 0.45, z).with_rotation(turn);
                    let found = manifold((floor, at(0.0, 0.0, 0.0)), (solid, place));
                    let feet = corners(Vec3::ZERO, Vec3::splat(0.5))
                        .map(|foot| turn * foot + Vec3::new(x, -0.025, z));
                    assert_points(found, &feet, 0.05, &format!("{solid:?} at ({x}, {z})"));
                    assert!(found.normal.distance(Vec3::Y) < 1e-5);
                }
            }
            // Half of it over the border.
            let found = manifold((floor, at(0.0, 0.0, 0.0)), (solid, at(4.0, 0.5, 0.0)));
            let feet = corners(Vec3::new(3.75, 0.0, 0.0), Vec3::new(0.25, 0.0, 0.5));
            assert_points(found, &feet, 0.0, "over the border");
        }
    }
}

#[test]
fn a_box_on_a_box_stands_on_what_they_share() {
    for table in boxes(Vec3::new(2.0, 1.0, 2.0)) {
        for solid in boxes(Vec3::splat(0.5)) {
            let here = at(0.0, -1.0, 0.0);
            let found = manifold((&table, here), (&solid, at(1.75, 0.45, 0.3)));
            let feet = corners(Vec3::new(1.625, -0.025, 0.3), Vec3::new(0.375, 0.0, 0.5));
            assert_points(found, &feet, 0.05, "offset");
        }
    }
}

#[test]
fn a_box_on_its_edge_has_two_points_and_on_its_corner_one() {
    let mut grounds = vec![box_of(4.0, 0.0, 4.0), convex(Vec3::new(4.0, 1.0, 4.0))];
    grounds.extend(floors());
    for (i, ground) in grounds.iter().enumerate() {
        for solid in &boxes(Vec3::splat(0.5))[..2] {
            let here = at(0.0, if i == 1 { -1.0 } else { 0.0 }, 0.0);
            let edge =
                at(0.1, 0.5f32.sqrt() - 0.05, 0.2).with_rotation(Quat::from_rotation_z(FRAC_PI_4));
            let found = manifold((ground, here), (solid, edge));
            let ends = [-0.3, 0.7].map(|z| Vec3::new(0.1, -0.025, z));
            assert_points(found, &ends, 0.05, &format!("edge on {i}"));
            let corner = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::NEG_Y);
            let corner = at(0.1, 0.75f32.sqrt() - 0.05, 0.2).with_rotation(corner);
            let found = manifold((ground, here), (solid, corner));
            assert_points(
                found,
                &[Vec3::new(0.1, -0.025, 0.2)],
                0.05,
                &format!("corner on {i}"),
            );
        }
    }
}

#[test]
fn a_leaning_box_is_deeper_on_one_side() {
    let lean = Quat::from_rotation_z(0.02);
    for solid in &boxes(Vec3::splat(0.5))[..2] {
        for floor in &floors() {
            let place = at(0.2, 0.45, 0.1).with_rotation(lean);
            let found = manifold((floor, at(0.0, 0.0, 0.0)), (solid, place));
            assert_eq!(found.points().len(), 4, "{found:?}");
            for point in found.points() {
                // Below the floor by as much as the place on its bottom is.
                let expected = 0.05 - (point.point.x - 0.2) * 0.02;
                assert!((point.depth - expected).abs() < 1e-3, "{found:?}");
            }
            assert!(found.points()[0].depth > 0.059, "the deepest comes first");
        }
    }
}

#[test]
fn a_ball_has_one_point() {
    let ball = Shape::sphere(0.5);
    for ground in floors() {
        let found = manifold((&ground, at(0.0, 0.0, 0.0)), (&ball, at(0.2, 0.45, 0.1)));
        assert_eq!(found.points().len(), 1);
        assert!((found.points()[0].depth - 0.05).abs() < 1e-5);
    }
}

#[test]
fn crossed_edges_have_one_point() {
    let bar = box_of(2.0, 0.1, 0.1);
    let edge_up = Quat::from_rotation_x(FRAC_PI_4);
    let across = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2) * edge_up;
    let height = 2.0 * 0.1 * 2f32.sqrt() - 0.01;
    let (lower, upper) = (
        at(0.0, 0.0, 0.0).with_rotation(edge_up),
        at(0.3, height, 0.2).with_rotation(across),
    );
    for bars in [
        [&bar, &bar],
        [&bar, &mesh_of(Vec3::new(2.0, 0.1, 0.1))],
        [&mesh_of(Vec3::new(2.0, 0.1, 0.1)); 2],
    ] {
        let found = manifold((bars[0], lower), (bars[1], upper));
        assert_eq!(found.points().len(), 1, "{found:?}");
        let middle = Vec3::new(0.3, height / 2.0, 0.0);
        let off = found.points()[0].point - Vec3::new(0.3, middle.y, 0.0);
        assert!(
            off.length() < 0.25 && (found.points()[0].depth - 0.01).abs() < 1e-3,
            "{found:?}"
        );
    }
}

#[test]
fn large_ones_are_as_small_ones() {
    let (table, solid) = (box_of(4e10, 1e10, 4e10), box_of(1e10, 1e10, 1e10));
    let found = manifold((&table, at(0.0, 0.0, 0.0)), (&solid, at(0.0, 1.5e10, 0.0)));
    assert_eq!(found.points().len(), 4);
    assert!(
        found
            .points()
            .iter()
            .all(|point| (point.depth - 0.5e10).abs() < 1e5)
    );
}
