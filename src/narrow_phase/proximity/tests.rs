//! Closest points of two shapes, checked by single points and by the verdicts of the other tests.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;
use std::f32::consts::FRAC_PI_4;

use crate::narrow_phase::cast::tests::{distance, placed, shapes, vectors};
use crate::narrow_phase::tests::{at, box_of, boxes, l_shape, mesh_of};
use crate::narrow_phase::*;

/// How far results may be off, for shapes of size 1 or so: parry's iterations end early.
fn margin(shapes: [&Shape; 2]) -> f32 {
    let is_own = |shape| {
        matches!(
            shape,
            &&(Shape::Cuboid { .. } | Shape::Sphere { .. } | Shape::Convex(_) | Shape::Mesh(_))
        )
    };
    if shapes.iter().all(is_own) {
        5e-5
    } else {
        2e-2
    }
}

/// The closest points, which must not depend on the order of the two.
#[track_caller]
fn closest(a: (&Shape, Transform), b: (&Shape, Transform)) -> Proximity {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let (tests, workspace) = (NarrowPhase::default(), &mut Workspace::default());
    let found = tests.closest_points(one, two, workspace).unwrap();
    let back = tests.closest_points(two, one, workspace).unwrap();
    let turned = Proximity {
        points: [back.points[1], back.points[0]],
        offset: -back.offset,
        ..back
    };
    assert!(found == turned || a.1 == b.1, "{found:?} {back:?}");
    assert_eq!(found.distance, found.offset.length());
    found
}

fn moved(by: Vec3, at: Transform) -> Transform {
    Transform {
        translation: at.translation + by,
        ..at
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1000, ..ProptestConfig::default() })]

    /// The points are in the shapes, and no others that are known are closer to each other.
    #[test]
    fn points_are_the_closest(
        (a, at_a) in placed(),
        (b, at_b) in placed(),
        away in vectors(4.0),
        samples in prop::collection::vec(vectors(6.0), 16),
    ) {
        let at_b = moved(away, at_b);
        let (one, two) = (Placed::new(&a, &at_a), Placed::new(&b, &at_b));
        let found = closest((&a, at_a), (&b, at_b));
        let ([on_a, on_b], margin) = (found.points, margin([&a, &b]));
        prop_assert!((on_b - on_a).distance(found.offset) < margin, "{found:?}");
        prop_assert!(distance(one, on_a) < margin && distance(two, on_b) < margin, "not on the shapes: {found:?}");
        // Two convex shapes with these distances have none that is less.
        prop_assert!((distance(two, on_a) - found.distance).abs() < margin, "{found:?}");
        prop_assert!((distance(one, on_b) - found.distance).abs() < margin, "{found:?}");
        let near = samples.iter().flat_map(|sample| [*sample, on_a + *sample * 0.05, on_b + *sample * 0.05]);
        for point in near {
            let in_a = NarrowPhase::default().closest_point(one, point, &mut Workspace::default()).unwrap();
            prop_assert!(distance(two, in_a) > found.distance - margin, "{in_a} is closer than {found:?}");
        }
        // As the verdict says.
        let meets = NarrowPhase::default().intersects(one, two, &mut Workspace::default());
        if meets {
            prop_assert!(found.distance <= NarrowPhase::DEFAULT_TOLERANCE + margin, "{found:?}");
        } else {
            prop_assert!(found.distance > NarrowPhase::DEFAULT_TOLERANCE - margin, "{found:?}");
        }
    }

    /// Cuboids, barely turned and flat ones too, as the meshes that they are.
    #[test]
    fn cuboids_are_meshes(a in boxes(), b in boxes(), away in prop_oneof![Just(Vec3::ZERO), vectors(6.0)]) {
        let at_b = moved(away, b.1);
        let Shape::Cuboid { half_size } = a.0 else { unreachable!() };
        let (cuboids, mesh) = (closest((&a.0, a.1), (&b.0, at_b)), closest((&mesh_of(half_size), a.1), (&b.0, at_b)));
        prop_assert!((cuboids.distance - mesh.distance).abs() < 2e-5, "{cuboids:?} {mesh:?}");
        let meets = NarrowPhase::default().intersects(
            Placed::new(&a.0, &a.1),
            Placed::new(&b.0, &at_b),
            &mut Workspace::default(),
        );
        prop_assert!(meets == (cuboids.distance <= NarrowPhase::DEFAULT_TOLERANCE)
            || (cuboids.distance - NarrowPhase::DEFAULT_TOLERANCE).abs() < 1e-5, "{cuboids:?} {meets}");
        // Two points may be rounded to one.
        let rounding = if mesh.points[0] == mesh.points[1] { f32::EPSILON * mesh.points[0].length() } else { 0.0 };
        prop_assert!(mesh.distance <= rounding || mesh.points[0] != mesh.points[1], "{mesh:?}");
        prop_assert!(mesh.distance > 0.0 || mesh.points[0] == mesh.points[1], "{mesh:?}");
    }

    /// What counts is where the two are to each other.
    #[test]
    fn distances_are_the_same_far_away((a, at_a) in placed(), (b, at_b) in placed(), away in vectors(4.0)) {
        for far in [1e3, 1e5, 1e6] {
            let far = Vec3::new(far, -far, far);
            let (there_a, there_b) = (moved(far, at_a), moved(far + away, at_b));
            // Where rounding put them, seen from closer by.
            let (here_a, here_b) = (moved(-far, there_a), moved(-far, there_b));
            let (there, here) = (closest((&a, there_a), (&b, there_b)), closest((&a, here_a), (&b, here_b)));
            prop_assert_eq!((there.distance, there.offset), (here.distance, here.offset));
        }
    }
}

#[test]
fn faces_edges_and_corners() {
    let here = at(0.0, 0.0, 0.0);
    let on_edge = Quat::from_rotation_z(FRAC_PI_4);
    let across = Quat::from_rotation_y(FRAC_PI_4);
    let half_diagonal = 2f32.sqrt();
    for (one, other) in [
        (box_of(1., 1., 1.), box_of(1., 1., 1.)),
        (mesh_of(Vec3::ONE), box_of(1., 1., 1.)),
    ] {
        let apart = |a, b| closest((&one, a), (&other, b));
        // Face to face, edge to edge, corner to corner, all turned alike.
        assert_eq!(apart(here, at(0.0, 5.0, 0.5)).offset, Vec3::Y * 3.0);
        assert_eq!(
            apart(here, at(5.0, 5.0, 0.5)).offset,
            Vec3::new(3.0, 3.0, 0.0)
        );
        assert_eq!(
            apart(here, at(5.0, -5.0, 5.0)).points,
            [Vec3::new(1.0, -1.0, 1.0), Vec3::new(4.0, -4.0, 4.0)]
        );
        // Edge to face, and edge across edge.
        let found = apart(here, at(5.0, 0.0, 0.0).with_rotation(on_edge));
        assert!(
            (found.distance - (4.0 - half_diagonal)).abs() < 1e-5,
            "{found:?}"
        );
        let upright = Quat::from_rotation_x(FRAC_PI_4 * 2.0) * on_edge;
        let found = apart(
            here.with_rotation(on_edge),
            at(5.0, 0.0, 0.0).with_rotation(upright),
        );
        assert!(
            (found.distance - (5.0 - 2.0 * half_diagonal)).abs() < 1e-5,
            "{found:?}"
        );
        assert!(
            found.offset.y.abs().max(found.offset.z.abs()) < 1e-5,
            "{found:?}"
        );
        // Over a face, with no corner above it.
        let found = apart(
            here.with_scale(Vec3::new(0.1, 1.0, 9.0)),
            at(0.0, 5.0, 0.0).with_rotation(across),
        );
        assert!(
            (found.distance - 3.0).abs() < 1e-5 && found.offset.normalize().y > 0.9999,
            "{found:?}"
        );
    }
}

#[test]
fn what_overlaps_has_no_distance() {
    let here = at(0.0, 0.0, 0.0);
    let turned = at(0.3, 0.2, 0.1).with_rotation(Quat::from_rotation_y(1.0));
    let bar = at(0.0, 0.0, 0.0)
        .with_scale(Vec3::new(5.0, 0.1, 0.1))
        .with_rotation(Quat::from_rotation_z(1.0));
    let solids = [
        box_of(1.0, 1.0, 1.0),
        mesh_of(Vec3::ONE),
        Shape::sphere(1.0),
    ];
    for a in &solids {
        for b in &solids {
            // Aside, through and through, inside and around.
            let small = turned.with_scale(Vec3::splat(0.1));
            for there in [turned, bar, small, here] {
                let found = closest((a, here), (b, there));
                assert_eq!(
                    (found.distance, found.points[0]),
                    (0.0, found.points[1]),
                    "{a:?} {b:?} {there:?}"
                );
                let (one, two) = (Placed::new(a, &here), Placed::new(b, &there));
                let off = distance(one, found.points[0]).max(distance(two, found.points[0]));
                assert!(off < 1e-4, "{off}, {a:?} {b:?} {there:?}");
            }
        }
    }
}

#[test]
fn what_is_inside_has_no_distance_however_near_to_the_border() {
    let (around, inside) = ([1.0; 3].into(), [0.25, 0.5, 0.125].into());
    let solids = |size: Vec3| [box_of(size.x, size.y, size.z), mesh_of(size)];
    for around in &solids(around) {
        for inside in &solids(inside) {
            for gap in [1e-6, 5e-5, 1e-3] {
                let there = at(0.75 - gap, 0.0, 0.0);
                let found = closest((around, at(0.0, 0.0, 0.0)), (inside, there));
                assert_eq!(found.distance, 0.0, "{gap} {around:?} {inside:?}");
            }
        }
    }
}

#[test]
fn hollows_and_open_meshes_are_empty() {
    let here = at(0.0, 0.0, 0.0);
    let pea = box_of(0.125, 0.125, 0.125);
    assert_eq!(
        closest((&l_shape(), here), (&pea, at(1.5, 1.5, 0.5))).distance,
        0.375
    );
    assert_eq!(
        closest((&l_shape(), here), (&pea, at(0.5, 0.5, 0.5))).distance,
        0.0
    );
    let Shape::Mesh(cube) = mesh_of(Vec3::ONE) else {
        unreachable!()
    };
    let open = Shape::mesh(cube.vertices(), cube.polygons().skip(1)).unwrap();
    assert!((closest((&open, here), (&pea, at(0.5, 0.25, 0.0))).distance - 0.375).abs() < 1e-6);
    let ball = Shape::sphere(0.25);
    assert!((closest((&open, here), (&ball, at(0.5, 0.25, 0.0))).distance - 0.25).abs() < 1e-6);
}

#[test]
fn flat_shapes_and_points_have_distances() {
    let here = at(0.0, 0.0, 0.0);
    for shape in [
        box_of(1.0, 1.0, 1.0),
        mesh_of(Vec3::ONE),
        Shape::sphere(1.0),
    ] {
        for scale in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0)] {
            let flat = here.with_scale(scale);
            for other in [
                box_of(0.5, 0.5, 0.5),
                mesh_of(Vec3::splat(0.5)),
                Shape::sphere(0.5),
            ] {
                let found = closest((&shape, flat), (&other, at(0.0, 5.0, 0.0)));
                let is_ball = matches!(shape, Shape::Sphere { .. }) && scale != Vec3::ZERO;
                let expected = if is_ball { 3.5 } else { 4.5 };
                assert_eq!(found.distance, expected, "{shape:?} {scale} {other:?}");
            }
        }
    }
}

/// Distances and sizes of which the squares are beyond the largest numbers, or products of four of
/// them.
#[test]
fn distances_are_the_same_at_every_scale() {
    let turned =
        |at: Transform| at.with_rotation(Quat::from_rotation_x(0.3) * Quat::from_rotation_y(0.7));
    let is_own = |shape: &Shape| !format!("{shape:?}").contains("Rapier");
    let shapes: Vec<_> = shapes().into_iter().filter(is_own).collect();
    for (a, b) in shapes
        .iter()
        .flat_map(|a| shapes.iter().map(move |b| (a, b)))
    {
        for at_b in [
            at(4.0, 0.5, -0.25),
            turned(at(-3.0, 4.0, 1.0)),
            turned(at(0.1, 0.2, 0.0)),
        ] {
            let expected = closest((a, at(0.0, 0.0, 0.0)), (b, at_b));
            for exponent in [29, 31, 60, 64, 90, 120] {
                let scale = 2_f32.powi(exponent);
                let here = at(0.0, 0.0, 0.0).with_scale(Vec3::splat(scale));
                let there = Transform {
                    translation: at_b.translation * scale,
                    scale: Vec3::splat(scale),
                    ..at_b
                };
                let tests = NarrowPhase::default();
                let (a, b) = (Placed::new(a, &here), Placed::new(b, &there));
                let found = tests
                    .closest_points(a, b, &mut Workspace::default())
                    .unwrap();
                let error = (found.distance / scale - expected.distance).abs();
                assert!(
                    error < 1e-3,
                    "2^{exponent}, {a:?}, {b:?}: {found:?}, expected {expected:?}"
                );
                // And of the second from a point of the first.
                let from = tests
                    .closest_point(b, Vec3::ZERO, &mut Workspace::default())
                    .unwrap();
                let near = tests.closest_point(
                    Placed::new(b.shape, &at_b),
                    Vec3::ZERO,
                    &mut Workspace::default(),
                );
                assert!(
                    (from / scale).distance(near.unwrap()) < 1e-3,
                    "2^{exponent}: {from}, expected {near:?}"
                );
            }
        }
    }
}

#[test]
fn what_is_not_finite_has_no_distance() {
    let here = at(0.0, 0.0, 0.0);
    for shape in shapes() {
        for bad in [
            at(f32::NAN, 0.0, 0.0),
            at(0.0, f32::INFINITY, 0.0),
            here.with_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        ] {
            for other in shapes() {
                let (good, bad) = (Placed::new(&other, &here), Placed::new(&shape, &bad));
                let (tests, workspace) = (NarrowPhase::default(), &mut Workspace::default());
                assert_eq!(tests.closest_points(good, bad, workspace), None);
                assert_eq!(tests.closest_points(bad, good, workspace), None);
                assert_eq!(tests.closest_points(bad, bad, workspace), None);
            }
        }
    }
}
