//! Meshes with a tree are asked what the same meshes are asked polygon by polygon.

use std::f32::consts::TAU;

use bevy::math::{Dir3, EulerRot, Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;

use crate::narrow_phase::*;

/// Squares of a height that waves, two triangles each.
fn terrain(n: u32) -> PolygonMesh {
    let height = |x: f32, z: f32| 0.4 * (x * 1.3).sin() + 0.3 * (z * 0.9 + 0.5 * x).cos();
    let (mut vertices, mut polygons) = (Vec::new(), Vec::new());
    for i in 0..(n + 1) * (n + 1) {
        let (x, z) = ((i % (n + 1)) as f32, (i / (n + 1)) as f32);
        vertices.push(Vec3::new(x, height(x, z), z) - Vec3::new(1.0, 0.0, 1.0) * n as f32 * 0.5);
    }
    for i in 0..n * n {
        let first = i / n * (n + 1) + i % n;
        let (right, below) = (first + 1, first + n + 1);
        polygons.extend([[first, below, right], [right, below, below + 1]]);
    }
    PolygonMesh::new(vertices, polygons).unwrap()
}

/// A closed surface of circles around the origin, with bumps.
fn blob(n: u32) -> PolygonMesh {
    let point = |around: f32, up: f32| {
        let radius = 2.0 + 0.3 * (3.0 * around).sin() * up.cos();
        radius * Vec3::new(up.cos() * around.cos(), up.sin(), up.cos() * around.sin())
    };
    let mut vertices = vec![Vec3::Y * -2.0, Vec3::Y * 2.0];
    for ring in 1..n {
        let up = (ring as f32 / n as f32 - 0.5) * TAU * 0.5;
        vertices.extend((0..n).map(|i| point(i as f32 / n as f32 * TAU, up)));
    }
    let at = |ring: u32, i: u32| 2 + (ring - 1) * n + i % n;
    let mut polygons = Vec::new();
    for i in 0..n {
        polygons.push([0, at(1, i), at(1, i + 1)]);
        polygons.push([1, at(n - 1, i + 1), at(n - 1, i)]);
        for ring in 1..n - 1 {
            polygons.push([at(ring, i), at(ring + 1, i), at(ring, i + 1)]);
            polygons.push([at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)]);
        }
    }
    PolygonMesh::new(vertices, polygons).unwrap()
}

fn with_and_without(mesh: &PolygonMesh) -> [Shape; 2] {
    [mesh.clone(), mesh.clone().without_tree()].map(Shape::from)
}

fn transform() -> impl Strategy<Value = Transform> {
    let scale = prop_oneof![
        Just(Vec3::ONE),
        Just(Vec3::new(-1.0, 1.0, 1.0)),
        Just(Vec3::new(0.5, 2.0, 1.2)),
        Just(Vec3::new(1.0, 0.0, 1.0)),
    ];
    (
        prop::array::uniform3(-4f32..4.0),
        prop::array::uniform3(0f32..TAU),
        scale,
    )
        .prop_map(|(position, turn, scale)| {
            Transform::from_translation(position.into())
                .with_rotation(Quat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]))
                .with_scale(scale)
        })
}

/// How two are to each other: in contact, how far apart, and how far the first goes until it meets
/// the second.
fn answers(a: Placed, b: Placed, way: Dir3) -> (bool, f32, Option<f32>) {
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let touch = tests.intersects(a, b, &mut workspace);
    let distance = tests.closest_points(a, b, &mut workspace).unwrap().distance;
    let impact = tests.sweep(a, way, 20.0, b, &mut workspace);
    (touch, distance, impact.map(|impact| impact.distance))
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 2e-4
}

fn same(with: (bool, f32, Option<f32>), without: (bool, f32, Option<f32>)) -> bool {
    (with.0 == without.0 || with.1.max(without.1) < 2e-4) && close(with.1, without.1)
}

/// Whether two impacts are the same. What comes closer than the tolerance may count as meeting or
/// not: if one does and the other does not, it is among those of the same mesh a tolerance aside.
fn same_impact(
    impacts: [Option<f32>; 2],
    aside: impl Fn(Vec3) -> [Option<f32>; 2],
    way: Dir3,
) -> bool {
    match impacts {
        [Some(a), Some(b)] if close(a, b) => return true,
        [None, None] => return true,
        _ => {}
    }
    let (right, up) = way.any_orthonormal_pair();
    let aside: Vec<_> = (0..8)
        .map(|i| {
            let (sin, cos) = (i as f32 / 8.0 * TAU).sin_cos();
            aside((right * cos + up * sin) * NarrowPhase::DEFAULT_TOLERANCE)
        })
        .collect();
    let is_among = |one: usize, other: usize| {
        let far = |impact: [Option<f32>; 2], i: usize| impact[i].unwrap_or(f32::INFINITY);
        let all = || aside.iter().map(|impacts| far(*impacts, other));
        let (first, last) = (
            all().fold(f32::INFINITY, f32::min),
            all().fold(0.0, f32::max),
        );
        (first..=last).contains(&far(impacts, one))
    };
    is_among(0, 1) || is_among(1, 0)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_tree_changes_nothing(
        at in transform(),
        at_other in transform(),
        way in prop::array::uniform3(-1f32..1.0),
        point in prop::array::uniform3(-4f32..4.0),
    ) {
        let Ok(way) = Dir3::new(way.into()) else {
            return Ok(());
        };
        let (terrain, blob) = (terrain(7), blob(8));
        let others = [
            [(); 2].map(|()| Shape::cuboid(1.0, 0.5, 2.0)),
            [(); 2].map(|()| Shape::sphere(0.7)),
            with_and_without(&blob),
        ];
        for mesh in [&terrain, &blob] {
            let [with, without] = with_and_without(mesh);
            for [other, other_without] in &others {
                let plain = Transform { scale: Vec3::ONE, ..at_other };
                for at_other in [plain, at_other] {
                    let asked = |at: Transform, mesh: &Shape, other: &Shape| {
                        let (mesh, other) = (Placed::new(mesh, &at), Placed::new(other, &at_other));
                        [answers(mesh, other, way), answers(other, mesh, way)]
                    };
                    let both = |at| {
                        let answers = [asked(at, &with, other), asked(at, &without, other_without)];
                        [0, 1].map(|order| answers.map(|answers| answers[order]))
                    };
                    for (order, [by_tree, one_by_one]) in both(at).into_iter().enumerate() {
                        let aside = |by: Vec3| {
                            let moved = at.with_translation(at.translation + by);
                            both(moved)[order].map(|(.., impact)| impact)
                        };
                        prop_assert!(
                            same(by_tree, one_by_one)
                                && same_impact([by_tree.2, one_by_one.2], aside, way),
                            "{by_tree:?} {one_by_one:?}"
                        );
                    }
                }
            }
            let mut workspace = Workspace::default();
            let closest = [&with, &without].map(|mesh| {
                NarrowPhase::default()
                    .closest_point(Placed::new(mesh, &at), point.into(), &mut workspace)
                    .unwrap()
                    .distance(point.into())
            });
            prop_assert!((closest[0] - closest[1]).abs() < 1e-5, "{closest:?}");
        }
    }
}
