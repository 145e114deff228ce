//! What lies on what of round shapes and of shapes of many, and on which points.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use bevy::math::primitives::Cuboid;
use bevy::math::{IVec3, Isometry3d, Quat, Vec2, Vec3};
use bevy::transform::components::Transform;
use fastrand::Rng;

use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

const DEPTH: f32 = 0.02;
const LYING: Quat = Quat::from_xyzw(
    0.0,
    0.0,
    std::f32::consts::FRAC_1_SQRT_2,
    std::f32::consts::FRAC_1_SQRT_2,
);

/// As seen from the first; from the second, it is the same with the normal turned around.
#[track_caller]
fn manifold(a: (&Shape, Transform), b: (&Shape, Transform)) -> Option<Manifold> {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let contact = tests.contact(one, two, &mut workspace);
    let found = tests.manifold(one, two, &mut workspace);
    assert_eq!(found.is_some(), contact.is_some());
    let (found, contact) = (found?, contact?);
    let back = tests.manifold(two, one, &mut workspace).unwrap();
    assert_eq!(found, back.reversed());
    let anew = tests.manifold(one, two, &mut Workspace::default());
    assert_eq!(Some(found), anew);
    assert_eq!(found.normal, contact.normal);
    assert_eq!(found.points()[0].depth, contact.depth);
    let depths = found.points().iter().map(|point| point.depth);
    assert!(depths.clone().all(|depth| depth <= contact.depth));
    Some(found)
}

/// Grounds whose surface is y = 0, around the origin.
fn grounds() -> Vec<(&'static str, Shape, Transform)> {
    let level = at(0.0, 0.0, 0.0);
    let field = |cell: f32, count: usize| {
        let heights = vec![0.0; count * count];
        let field = HeightField::new(count, count, heights, Vec2::splat(cell));
        Shape::from(field.unwrap())
    };
    let cells = |size: f32, count: i32| {
        let all = (-count..count).flat_map(move |x| {
            (-count..count).flat_map(move |z| [-1, -2].map(|y| IVec3::new(x, y, z)))
        });
        Shape::from(Voxels::from_cells(size, all).unwrap())
    };
    let corners = [[-8., -8.], [-8., 8.], [8., 8.], [8., -8.], [-0.1, 0.1]];
    let corners = corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec();
    let fan = [[4, 0, 1], [4, 1, 2], [4, 2, 3], [4, 3, 0]];
    let tiles = [[-4.0, -4.0], [-4.0, 4.0], [4.0, -4.0], [4.0, 4.0]].map(|[x, z]| {
        let tile = box_of(4.0, 0.5, 4.0);
        (Isometry3d::from_translation(Vec3::new(x, -0.5, z)), tile)
    });
    vec![
        ("a cuboid", box_of(8.0, 0.5, 8.0), at(0.0, -0.5, 0.0)),
        (
            "a large cuboid",
            box_of(800.0, 0.5, 800.0),
            at(300.0, -0.5, 0.0),
        ),
        (
            "a rounded cuboid",
            Shape::rounded(&box_of(8.0, 0.5, 8.0), 0.25).unwrap(),
            at(0.0, -0.75, 0.0),
        ),
        ("a half-space", Shape::half_space(Vec3::Y).unwrap(), level),
        ("large cells of heights", field(3.0, 6), level),
        ("small cells of heights", field(0.17, 80), level),
        ("large voxels", cells(1.0, 8), level),
        ("small voxels", cells(0.13, 60), level),
        ("a fan", Shape::mesh(corners, fan).unwrap(), level),
        (
            "a closed mesh",
            mesh_of(Vec3::new(8.0, 0.5, 8.0)),
            at(0.0, -0.5, 0.0),
        ),
        ("four tiles", Shape::compound(tiles).unwrap(), level),
        ("a drum", Shape::cylinder(8.0, 1.0), at(0.0, -0.5, 0.0)),
    ]
}

/// What stands or lies at a place in DEPTH, and on which points, but for their height.
#[track_caller]
fn assert_on_grounds(shape: &Shape, height: f32, turn: Quat, feet: &[Vec3], what: &str) {
    for (name, ground, here) in grounds() {
        for (x, z, spin) in [(0.0, 0.0, 0.0), (0.3, 0.2, 0.4), (-0.7, 1.1, 2.0)] {
            let spin = Quat::from_rotation_y(spin);
            let place = at(x, height - DEPTH, z).with_rotation(spin * turn);
            let found = manifold((&ground, here), (shape, place));
            let found = found.unwrap_or_else(|| panic!("{what} on {name}"));
            assert!(
                found.normal.distance(Vec3::Y) < 1e-3,
                "{what} on {name}: {found:?}"
            );
            let feet = feet
                .iter()
                .map(|foot| Vec3::new(x, -0.5 * DEPTH, z) + spin * *foot);
            let is_there = |foot: Vec3| {
                let is_it = |point: &ManifoldPoint| {
                    point.point.distance(foot) < 2e-3 && (point.depth - DEPTH).abs() < 1e-4
                };
                found.points().iter().any(is_it)
            };
            assert!(
                found.points().len() == feet.len() && feet.clone().all(is_there),
                "{what} on {name} at ({x}, {z}): {found:?}, expected {:?}",
                feet.collect::<Vec<_>>()
            );
        }
    }
}

fn corners(x: f32, z: f32) -> [Vec3; 4] {
    [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
        .map(|[one, other]| Vec3::new(one * x, 0.0, other * z))
}

#[test]
fn what_lies_has_two_points() {
    let ends = |half: f32| [Vec3::X * half, Vec3::NEG_X * half];
    let capsule = Shape::capsule(0.3, 1.4);
    assert_on_grounds(&capsule, 0.3, LYING, &ends(0.7), "a capsule");
    let cylinder = Shape::cylinder(0.4, 1.2);
    assert_on_grounds(&cylinder, 0.4, LYING, &ends(0.6), "a cylinder");
    let round = Shape::rounded(&Shape::cylinder(0.3, 1.2), 0.1).unwrap();
    assert_on_grounds(&round, 0.4, LYING, &ends(0.6), "a rounded cylinder");
    let between = Shape::capsule_between(Vec3::NEG_X, Vec3::X, 0.2).unwrap();
    assert_on_grounds(&between, 0.2, Quat::IDENTITY, &ends(1.0), "a bar");
    let edge = Quat::from_rotation_x(FRAC_PI_4);
    let round = Shape::rounded(&box_of(0.5, 0.3, 0.3), 0.1).unwrap();
    let height = 0.3 * 2f32.sqrt() + 0.1;
    assert_on_grounds(&round, height, edge, &ends(0.5), "a rounded cuboid");
}

#[test]
fn a_cone_lies_on_its_side() {
    // From its tip to its border.
    let (radius, height) = (0.5f32, 1.2f32);
    let slope = (radius / height).atan();
    let lean = Quat::from_rotation_z(-FRAC_PI_2 - slope);
    let middle = height * 0.5 * slope.sin();
    let [tip, rim] = [
        Vec3::Y * 0.5 * height,
        Vec3::new(radius, -0.5 * height, 0.0),
    ];
    let feet = [tip, rim].map(|point| (lean * point).with_y(0.0));
    let cone = Shape::cone(radius, height);
    assert_on_grounds(&cone, middle, lean, &feet, "a cone");
}

#[test]
fn faces_have_four_points() {
    let upright = Quat::IDENTITY;
    let cuboid = box_of(0.5, 0.4, 0.7);
    let halves = corners(0.5, 0.7);
    for (name, ground, here) in grounds() {
        let found = manifold((&ground, here), (&cuboid, at(0.2, 0.38, 0.1))).unwrap();
        assert_eq!(found.points().len(), 4, "on {name}: {found:?}");
    }
    assert_on_grounds(&cuboid, 0.4, upright, &halves, "a cuboid");
    let round = Shape::rounded(&box_of(0.5, 0.3, 0.7), 0.1).unwrap();
    assert_on_grounds(&round, 0.4, upright, &halves, "a rounded cuboid");
    let legs = [-0.6, 0.6].map(|x| {
        let leg = Cuboid::new(0.2, 0.8, 0.6).into();
        (Isometry3d::from_translation(Vec3::X * x), leg)
    });
    let table: Shape = Shape::compound(legs).unwrap();
    assert_on_grounds(&table, 0.4, upright, &corners(0.7, 0.3), "a compound");
    let balls =
        corners(0.5, 0.4).map(|place| (Isometry3d::from_translation(place), Shape::sphere(0.2)));
    let wheels = Shape::compound(balls).unwrap();
    assert_on_grounds(&wheels, 0.2, upright, &corners(0.5, 0.4), "four balls");
    let axles = [-0.5, 0.5].map(|z| {
        let at = Isometry3d::new(Vec3::Z * z, LYING);
        (at, Shape::cylinder(0.2, 1.0))
    });
    let rollers = Shape::compound(axles).unwrap();
    assert_on_grounds(&rollers, 0.2, upright, &corners(0.5, 0.5), "two rollers");
    let bricks = (-2..2).flat_map(|x| (-3..3).map(move |z| IVec3::new(x, 0, z)));
    let voxels = Voxels::from_cells(0.25, bricks).unwrap().into();
    assert_on_grounds(&voxels, 0.0, upright, &corners(0.5, 0.75), "voxels");
}

#[test]
fn what_stands_on_a_cap_has_four_points_on_its_border() {
    let round = Shape::rounded(&Shape::cylinder(0.4, 0.6), 0.1).unwrap();
    for (shape, half, radius) in [
        (Shape::cylinder(0.4, 0.8), 0.4, 0.4),
        (Shape::cone(0.4, 0.8), 0.4, 0.4),
        (Shape::conical_frustum(0.2, 0.4, 0.8), 0.4, 0.4),
        (round, 0.4, 0.4),
    ] {
        for (name, ground, here) in grounds() {
            for (x, z, spin) in [(0.0, 0.0, 0.0), (0.3, 0.2, 0.4)] {
                let place = at(x, half - DEPTH, z).with_rotation(Quat::from_rotation_y(spin));
                let found = manifold((&ground, here), (&shape, place)).unwrap();
                let arms = found.points().iter();
                let arms: Vec<_> = arms
                    .map(|p| p.point - Vec3::new(x, -0.5 * DEPTH, z))
                    .collect();
                assert_eq!(arms.len(), 4, "{shape:?} on {name}: {found:?}");
                for (i, arm) in arms.iter().enumerate() {
                    assert!(
                        (arm.length() - radius).abs() < 2e-3,
                        "{shape:?} on {name}: {found:?}"
                    );
                    for other in &arms[..i] {
                        let angle = arm.angle_between(*other);
                        assert!(angle > FRAC_PI_2 - 0.01, "{shape:?} on {name}: {found:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn what_leans_is_deeper_on_one_side() {
    // A cylinder by one degree: its cap is lowest at its border.
    let cylinder = Shape::cylinder(0.5, 1.0);
    for (name, ground, here) in grounds() {
        let place = at(0.2, 0.47, 0.1).with_rotation(Quat::from_rotation_z(0.02));
        let found = manifold((&ground, here), (&cylinder, place)).unwrap();
        let lowest = 0.5 * 0.02f32.cos() + 0.5 * 0.02f32.sin() - 0.47;
        assert!(
            (found.points()[0].depth - lowest).abs() < 1e-3,
            "{name}: {found:?}"
        );
        assert_eq!(found.points().len(), 4, "{name}: {found:?}");
        for point in found.points() {
            let expected = 0.03 - (point.point.x - 0.2) * 0.02;
            assert!((point.depth - expected).abs() < 1e-3, "{name}: {found:?}");
        }
        // More than it is deep, and one point is left.
        let place = at(0.2, 0.6, 0.1).with_rotation(Quat::from_rotation_z(0.4));
        let found = manifold((&ground, here), (&cylinder, place)).unwrap();
        assert_eq!(found.points().len(), 1, "{name}: {found:?}");
    }
}

#[test]
fn of_two_edges_what_is_side_by_side() {
    let (long, short) = (Shape::capsule(0.3, 4.0), Shape::capsule(0.2, 1.0));
    let here = at(0.0, 0.0, 0.0).with_rotation(LYING);
    let over = at(1.8, 0.5 - DEPTH, 0.0).with_rotation(LYING);
    let found = manifold((&long, here), (&short, over)).unwrap();
    // Over the end of the other, the last of it is not.
    let x: Vec<_> = found.points().iter().map(|point| point.point.x).collect();
    assert!(
        x.len() == 2 && x.contains(&1.3) && x.iter().any(|x| (x - 2.0).abs() < 1e-5),
        "{found:?}"
    );
    // Across each other, they meet at one point.
    let across = over.with_rotation(Quat::from_rotation_y(0.5) * LYING);
    let across = across.with_translation(Vec3::new(1.5, 0.5 - DEPTH, 0.0));
    let found = manifold((&long, here), (&short, across)).unwrap();
    assert_eq!(found.points().len(), 1, "{found:?}");
    // Two legs across a bar.
    let legs = [-0.5, 0.5].map(|x| {
        let turn = Quat::from_rotation_x(FRAC_PI_2);
        (Isometry3d::new(Vec3::X * x, turn), Shape::capsule(0.1, 1.0))
    });
    let legs = Shape::compound(legs).unwrap();
    let found = manifold((&long, here), (&legs, at(0.2, 0.4 - DEPTH, 0.1))).unwrap();
    let x: Vec<_> = found.points().iter().map(|point| point.point.x).collect();
    assert!(x.len() == 2 && (x[0] - x[1]).abs() > 0.999, "{found:?}");
    // A capsule along the upper edge of a roof.
    let roof = box_of(3.0, 1.0, 1.0);
    let there = at(0.0, -(2f32.sqrt()), 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_4));
    let over = at(0.4, 0.2 - DEPTH, 0.0).with_rotation(LYING);
    let found = manifold((&roof, there), (&short, over)).unwrap();
    let x: Vec<_> = found.points().iter().map(|point| point.point.x).collect();
    assert!(x.len() == 2 && (x[0] - x[1]).abs() > 0.999, "{found:?}");
}

/// Hidden faces say nothing: beside a wall and on a floor that are one, the feet are those on what
/// is deeper.
#[test]
fn hidden_faces_have_no_points() {
    let cells = (0..8).flat_map(|x| {
        let wall = (0..4).map(move |y| IVec3::new(-1, y, x - 4));
        wall.chain((-4..4).map(move |z| IVec3::new(x - 1, -1, z)))
    });
    let ground: Shape = Voxels::from_cells(0.5, cells).unwrap().into();
    let body = box_of(0.4, 0.4, 0.4);
    let found = manifold(
        (&ground, at(0.0, 0.0, 0.0)),
        (&body, at(0.39, 0.4 - DEPTH, 0.0)),
    )
    .unwrap();
    assert!(found.normal.distance(Vec3::Y) < 1e-3, "{found:?}");
    assert_eq!(found.points().len(), 4, "{found:?}");
    for point in found.points() {
        assert!((point.depth - DEPTH).abs() < 1e-4, "{found:?}");
        assert!(
            (point.point.x - 0.39).abs() > 0.38 && point.point.z.abs() > 0.39,
            "{found:?}"
        );
    }
}

#[test]
fn size_does_not_count() {
    for size in [1e-6f32, 1.0, 1e8, 1e14] {
        let tests = NarrowPhase::new(1e-5 * size).unwrap();
        let (table, can) = (
            Shape::cylinder(2.0 * size, size),
            Shape::cylinder(0.5 * size, size),
        );
        let (here, there) = (at(0.0, 0.0, 0.0), at(0.5 * size, 0.95 * size, 0.0));
        let (one, two) = (Placed::new(&table, &here), Placed::new(&can, &there));
        let found = tests.manifold(one, two, &mut Workspace::default()).unwrap();
        assert_eq!(found.points().len(), 4, "{size}: {found:?}");
        for point in found.points() {
            assert!(
                (point.depth - 0.05 * size).abs() < 1e-4 * size,
                "{size}: {found:?}"
            );
        }
    }
}

/// Shapes of all kinds.
fn shapes(rng: &mut Rng) -> Vec<(&'static str, Shape)> {
    let mut size = || 0.2 + 0.8 * rng.f32();
    let cuboid = Shape::from_half_size(Vec3::new(size(), size(), size()));
    let capsule = Shape::capsule(size() * 0.5, size() * 2.0);
    let cylinder = Shape::cylinder(size(), size() * 2.0);
    let cone = Shape::cone(size(), size() * 2.0);
    let frustum = Shape::conical_frustum(size(), size(), size());
    let mut point = || Vec3::new(size(), size(), size()) * 2.0 - 1.2;
    let points: Vec<_> = (0..12).map(|_| point()).collect();
    let hull = Shape::convex_hull(points.iter().copied()).unwrap();
    let [a, b, c] = [points[0], points[1], points[2]];
    let round = |core: &Shape| Shape::rounded(core, 0.15).unwrap();
    let turn = Quat::from_scaled_axis(a * 2.0);
    let compound = Shape::compound([
        (Isometry3d::new(a, turn), cuboid.clone()),
        (Isometry3d::new(b, turn.inverse()), capsule.clone()),
        (Isometry3d::from_translation(c), cylinder.clone()),
    ]);
    let cells = (0..60).map(|_| IVec3::new(rng.i32(-2..3), rng.i32(-2..3), rng.i32(-2..3)));
    let voxels = Voxels::from_cells(0.4, cells).unwrap();
    let heights: Vec<_> = (0..64).map(|_| rng.f32() * 0.2).collect();
    let field = HeightField::new(8, 8, heights, Vec2::splat(0.5)).unwrap();
    vec![
        ("ball", Shape::sphere(0.6)),
        ("rounded cuboid", round(&cuboid)),
        ("rounded cylinder", round(&cylinder)),
        ("rounded hull", round(&hull)),
        ("cuboid", cuboid),
        ("capsule", capsule),
        ("cylinder", cylinder),
        ("cone", cone),
        ("frustum", frustum),
        ("hull", hull),
        ("bar", Shape::capsule_between(a, b, 0.2).unwrap()),
        ("plate", round(&Shape::triangle(a, b, c).unwrap())),
        ("compound", compound.unwrap()),
        ("voxels", voxels.into()),
        ("height field", field.into()),
        ("mesh", mesh_of(Vec3::new(0.9, 0.5, 0.7))),
        ("half-space", Shape::half_space(Vec3::Y).unwrap()),
    ]
}

#[test]
fn points_are_between_the_surfaces() {
    let tests = NarrowPhase::default();
    let mut rng = Rng::with_seed(7);
    let mut workspace = Workspace::default();
    let (mut counts, mut failures) = ([0; 5], vec![]);
    for round in 0..24 {
        let all = shapes(&mut rng);
        for (i, (name, a)) in all.iter().enumerate() {
            for (other, b) in &all[i..] {
                let (at_a, at_b) = (pose(&mut rng, round), pose(&mut rng, round));
                let Some(found) = manifold((a, at_a), (b, at_b)) else {
                    continue;
                };
                // Two made of polygons are cut in another way.
                let are_polygons =
                    [name, other].map(|name| ["cuboid", "hull", "mesh"].contains(name));
                if are_polygons == [true; 2] {
                    continue;
                }
                counts[found.points().len()] += 1;
                for point in found.points() {
                    for (shape, at) in [(a, &at_a), (b, &at_b)] {
                        let placed = Placed::new(shape, at);
                        let closest = tests.closest_point(placed, point.point, &mut workspace);
                        let distance = closest.map_or(0.0, |at| at.distance(point.point));
                        if distance > 2e-4 + 0.52 * point.depth {
                            failures.push(format!(
                                "{distance} from {:?} in round {round}, {name} and {other}: {point:?} of {found:?}",
                                shape.kind(),
                            ));
                        }
                    }
                }
            }
        }
    }
    assert!(
        failures.is_empty(),
        "{} {:#?}",
        failures.len(),
        &failures[..failures.len().min(12)]
    );
    assert!(counts[1..].iter().all(|count| *count > 20), "{counts:?}");
}

/// A pose near the origin: some of them lie flat, or nearly so, and some are stretched.
fn pose(rng: &mut Rng, round: usize) -> Transform {
    let mut point = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) * 2.0 - 1.0;
    let place = Transform::from_translation(point());
    let turn = match round % 3 {
        0 => Quat::from_rotation_y((point().x * 3.0).round() * FRAC_PI_2),
        1 => Quat::from_scaled_axis(point() * 0.05) * Quat::from_rotation_z(FRAC_PI_2),
        _ => Quat::from_scaled_axis(point() * 3.0),
    };
    let scale = match round % 4 {
        3 => (point() * 0.5).map(|x| x + 0.7f32.copysign(x)),
        _ => Vec3::ONE,
    };
    place.with_rotation(turn).with_scale(scale)
}
