//! The stages against each other, and on the cases that are hard.

use bevy::math::{Dir3, Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;
use std::f32::consts::FRAC_PI_4;

use super::frame::placed::{PlacedPair, in_order};
use super::mesh::polygon_mesh::tests::cube;
use super::*;

pub(super) fn box_of(x: f32, y: f32, z: f32) -> Shape {
    Shape::from_half_size(Vec3::new(x, y, z))
}

pub(super) fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

fn verdict(exactness: Exactness, a: (&Shape, Transform), b: (&Shape, Transform)) -> bool {
    let tests = NarrowPhase::default().with_exactness(exactness);
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let found = tests.intersects(one, two, &mut workspace);
    assert_eq!(found, tests.intersects(two, one, &mut workspace), "order");
    assert_eq!(found, tests.contact(one, two, &mut workspace).is_some());
    found
}

/// The verdict of both ways to decide cuboids, which must be one.
#[track_caller]
pub(super) fn meets(a: (&Shape, Transform), b: (&Shape, Transform)) -> bool {
    let cheapest = verdict(Exactness::Cheapest, a, b);
    let polygons = verdict(Exactness::EdgePolygon, a, b);
    assert_eq!(
        cheapest, polygons,
        "cheapest {cheapest}, by polygons {polygons}: {a:?} {b:?}"
    );
    cheapest
}

/// A cuboid as a mesh, so that the last stage has to decide.
pub(super) fn mesh_of(half_size: Vec3) -> Shape {
    let cube = cube();
    let vertices: Vec<_> = cube.vertices().iter().map(|v| *v * half_size).collect();
    Shape::mesh(vertices, cube.polygons()).unwrap()
}

/// An L of two unit squares wide and high, without the upper right, and one deep.
pub(super) fn l_shape() -> Shape {
    let outline = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    prism(&outline)
}

fn prism(outline: &[[f32; 2]]) -> Shape {
    let n = outline.len() as u32;
    let level = |z: f32| outline.iter().map(move |&[x, y]| Vec3::new(x, y, z));
    let vertices: Vec<_> = level(0.0).chain(level(1.0)).collect();
    let mut polygons = vec![(0..n).rev().collect::<Vec<_>>(), (n..2 * n).collect()];
    polygons.extend((0..n).map(|i| vec![i, (i + 1) % n, (i + 1) % n + n, i + n]));
    Shape::mesh(vertices, polygons).unwrap()
}

#[test]
fn equal_cubes_face_to_face() {
    let cube = box_of(0.5, 0.5, 0.5);
    let turned = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.3, 0.4, 0.5);
    for far in [0.0, 1000.0, 4096.0 * 1024.0] {
        for rotation in [Quat::IDENTITY, Quat::from_rotation_y(FRAC_PI_4), turned] {
            // Far away, turned cubes cannot be put where they should be; upright ones can.
            if far > 0.0 && rotation != Quat::IDENTITY {
                continue;
            }
            for (offset, expected) in [(0.999, true), (1.0, true), (0.5, true), (1.5, false)] {
                if far > 1e6 && offset == 0.999 {
                    continue;
                }
                for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                    let here =
                        Transform::from_translation(Vec3::splat(far)).with_rotation(rotation);
                    let there = here.with_translation(here.translation + rotation * axis * offset);
                    let found = meets((&cube, here), (&cube, there));
                    assert_eq!(found, expected, "{far} {rotation} {offset} {axis}");
                }
            }
        }
    }
}

#[test]
fn tolerance_is_the_distance_whatever_touches() {
    let cube = box_of(1.0, 1.0, 1.0);
    let tolerance = NarrowPhase::DEFAULT_TOLERANCE;
    let on_edge = Quat::from_rotation_z(FRAC_PI_4);
    let on_corner = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::X);
    // Face, edge and corner of the second cube towards the first; and corner to corner.
    for (rotation, reach) in [
        (Quat::IDENTITY, 1.0),
        (on_edge, 2f32.sqrt()),
        (on_corner, 3f32.sqrt()),
    ] {
        for (gap, expected) in [(0.9, true), (1.1, false), (-0.9, true), (0.0, true)] {
            let offset = 1.0 + reach + gap * tolerance;
            let there = at(offset, 0.0, 0.0).with_rotation(rotation);
            assert_eq!(
                meets((&cube, at(0.0, 0.0, 0.0)), (&cube, there)),
                expected,
                "{rotation} {gap}"
            );
            let mesh = mesh_of(Vec3::ONE);
            assert_eq!(
                meets((&cube, at(0.0, 0.0, 0.0)), (&mesh, there)),
                expected,
                "{rotation} {gap}"
            );
        }
    }
    for (gap, expected) in [(0.5, true), (0.65, false)] {
        let corner = 2.0 + gap * tolerance;
        let there = at(corner, corner, corner);
        assert_eq!(meets((&cube, at(0.0, 0.0, 0.0)), (&cube, there)), expected);
    }
}

#[test]
fn edges_that_cross_without_a_corner_inside() {
    // Two bars crossed like swords: no vertex of one is in the other.
    let bar = box_of(5.0, 0.2, 0.2);
    let upright = Transform::from_rotation(Quat::from_rotation_z(1.2));
    assert!(meets((&bar, at(0.0, 0.0, 0.0)), (&bar, upright)));
    assert!(!meets((&bar, at(0.0, 0.0, 0.5)), (&bar, upright)));
    // Edge against edge at right angles: only the cross product of the two parts them.
    let roof = Transform::from_rotation(Quat::from_rotation_x(FRAC_PI_4));
    let other = |z: f32| at(0.0, 0.0, z).with_rotation(Quat::from_rotation_z(1.0) * roof.rotation);
    let touching = 2.0 * 0.2 * 2f32.sqrt();
    assert!(meets((&bar, roof), (&bar, other(touching - 1e-3))));
    assert!(!meets((&bar, roof), (&bar, other(touching + 1e-3))));
}

#[test]
fn long_edges_that_are_nearly_parallel() {
    // Only the product of two edges that are left out as parallel parts these.
    let bar = box_of(0.5, 0.5, 50.0);
    let on_edge = Quat::from_rotation_z(FRAC_PI_4);
    // Turned as a whole, so that the boxes along the axes of the world do not part them.
    let askew = Quat::from_rotation_y(0.5);
    let here = Transform::from_rotation(askew * on_edge);
    let tilted = askew * Quat::from_rotation_x(5e-3) * on_edge;
    for (gap, expected) in [(1e-2, false), (1e-3, false), (-1e-3, true)] {
        let offset = askew * Vec3::X * (2f32.sqrt() + gap);
        let there = Transform::from_translation(offset).with_rotation(tilted);
        assert_eq!(meets((&bar, here), (&bar, there)), expected, "{gap}");
    }
}

#[test]
fn one_inside_the_other() {
    let (large, small) = (box_of(2.0, 2.0, 2.0), box_of(0.1, 0.1, 0.1));
    let turned = at(0.3, -0.7, 0.9).with_rotation(Quat::from_rotation_y(0.7));
    let here = at(0.0, 0.0, 0.0);
    assert!(meets((&large, here), (&small, turned)));
    let large = mesh_of(Vec3::splat(2.0));
    assert!(meets((&large, here), (&small, turned)));
    assert!(meets(
        (&large, here.with_scale(Vec3::new(-1.0, 1.0, 1.0))),
        (&small, turned)
    ));
    assert!(meets((&large, here), (&Shape::sphere(0.1), turned)));
    assert!(!meets(
        (&large, here),
        (&Shape::sphere(0.1), at(2.2, 0.0, 0.0))
    ));

    // Without a lid there is no inside.
    let cube = cube();
    let vertices: Vec<_> = cube.vertices().iter().map(|v| *v * 2.0).collect();
    let open = Shape::mesh(vertices, cube.polygons().skip(1)).unwrap();
    assert!(!meets((&open, here), (&small, turned)));
    assert!(meets((&open, here), (&small, at(2.0, 0.0, 0.0))));
}

#[test]
fn hollows_are_empty() {
    let l = l_shape();
    let pea = box_of(0.2, 0.2, 0.2);
    let here = at(0.0, 0.0, 0.0);
    assert!(!meets((&l, here), (&pea, at(1.5, 1.5, 0.5))));
    assert!(meets((&l, here), (&pea, at(0.5, 0.5, 0.5))));
    assert!(meets((&l, here), (&pea, at(1.1, 1.5, 0.5))));
    assert!(!meets((&l, here), (&Shape::sphere(0.3), at(1.5, 1.5, 0.5))));
    assert!(meets((&l, here), (&Shape::sphere(0.6), at(1.5, 1.5, 0.5))));
    // A post through the opening, longer than the L is deep.
    let post = box_of(0.2, 0.2, 3.0);
    assert!(!meets((&l, here), (&post, at(1.5, 1.5, 0.5))));
    assert!(meets((&l, here), (&post, at(0.5, 1.5, 0.5))));
}

#[test]
fn cavity_whose_walls_face_each_other_is_empty() {
    let cube = cube();
    let (count, mut vertices) = (cube.vertices().len() as u32, cube.vertices().to_vec());
    vertices.extend(cube.vertices().iter().map(|v| *v * 0.5));
    let outer = cube.polygons().map(<[u32]>::to_vec);
    let inner = cube
        .polygons()
        .map(|p| p.iter().rev().map(|v| v + count).collect());
    let shell = Shape::mesh(vertices, outer.chain(inner)).unwrap();
    let pea = box_of(0.1, 0.1, 0.1);
    let here = at(0.0, 0.0, 0.0);
    assert!(!meets((&shell, here), (&pea, here)));
    assert!(meets((&shell, here), (&pea, at(0.75, 0.0, 0.0))));
    // A mesh of two parts is in contact if one of them is inside.
    let two_parts = {
        let mut vertices = cube.vertices().iter().map(|v| *v * 0.1).collect::<Vec<_>>();
        vertices.extend(vertices.clone().iter().map(|v| *v + Vec3::X * 0.75));
        let moved = cube
            .polygons()
            .map(|p| p.iter().map(|v| v + count).collect());
        let polygons: Vec<Vec<u32>> = cube.polygons().map(<[u32]>::to_vec).chain(moved).collect();
        Shape::mesh(vertices, polygons).unwrap()
    };
    assert!(meets((&shell, here), (&two_parts, here)));
}

#[test]
fn flat_and_empty_cuboids() {
    let cube = box_of(1.0, 1.0, 1.0);
    let here = at(0.0, 0.0, 0.0);
    let turned = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.3, 0.4, 0.5);
    for flat in [
        box_of(0.5, 0.5, 0.0),
        box_of(0.5, 0.0, 0.0),
        box_of(0.0, 0.0, 0.0),
    ] {
        for rotation in [Quat::IDENTITY, turned] {
            assert!(meets(
                (&cube, here),
                (&flat, at(0.2, 0.3, 0.1).with_rotation(rotation))
            ));
            assert!(meets(
                (&cube, here),
                (&flat, at(1.0, 0.0, 0.0).with_rotation(rotation))
            ));
            assert!(!meets(
                (&cube, here),
                (&flat, at(2.0, 0.0, 0.0).with_rotation(rotation))
            ));
            let placed = here.with_rotation(rotation);
            assert!(meets((&flat, placed), (&flat, placed)));
            assert!(!meets(
                (&flat, placed),
                (&flat, at(0.0, 0.0, 1.1).with_rotation(rotation))
            ));
        }
    }
    // A mesh flattened by its scale.
    let sheet = at(0.0, 0.0, 0.5).with_scale(Vec3::new(1.0, 1.0, 0.0));
    assert!(meets((&mesh_of(Vec3::ONE), sheet), (&cube, here)));
    assert!(!meets(
        (&mesh_of(Vec3::ONE), sheet),
        (&cube, at(0.0, 0.0, 2.0))
    ));
}

#[test]
fn what_is_not_finite_meets_nothing() {
    let cube = box_of(1.0, 1.0, 1.0);
    let mesh = mesh_of(Vec3::ONE);
    let here = at(0.0, 0.0, 0.0);
    for bad in [
        at(f32::NAN, 0.0, 0.0),
        at(0.0, f32::INFINITY, 0.0),
        here.with_scale(Vec3::splat(f32::NAN)),
        here.with_scale(Vec3::splat(f32::INFINITY)),
        here.with_scale(Vec3::splat(f32::MAX)),
        here.with_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        here.with_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ] {
        for shape in [&cube, &mesh, &Shape::sphere(1.0)] {
            // The largest scale there is still gives a cuboid whose half extents are finite.
            if bad.scale.x != f32::MAX {
                assert_eq!(
                    shape.world_aabb(&bad),
                    Err(BoundsError::NonFinite),
                    "{bad:?}"
                );
                assert!(!meets((shape, bad), (&cube, here)), "{bad:?}");
                assert!(!meets((shape, bad), (&mesh, bad)), "{bad:?}");
            }
        }
    }
    for half_size in [Vec3::new(-1.0, 1.0, 1.0), Vec3::NAN, Vec3::INFINITY] {
        assert!(matches!(
            Shape::try_from_half_size(half_size),
            Err(ShapeError::HalfSize(_))
        ));
    }
    for radius in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(
            Shape::try_sphere(radius),
            Err(ShapeError::Radius(_))
        ));
    }
    for tolerance in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(NarrowPhase::new(tolerance).is_err());
    }
}

/// Those that nobody checks, and those that somebody was warned of.
fn shapes_that_are_not_finite() -> Vec<Shape> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let own = bad.map(|bad| {
        let half_sizes = [Vec3::splat(bad), Vec3::new(1.0, bad, 1.0)];
        let cuboids = half_sizes.map(|half_size| Shape::Cuboid { half_size });
        let [sphere, made] = [Shape::Sphere { radius: bad }, Shape::cuboid(1.0, bad, 1.0)];
        cuboids.into_iter().chain([sphere, made])
    });
    let own = own.into_iter().flatten();
    #[cfg(feature = "rapier")]
    let own = own.chain(bad.into_iter().flat_map(|bad| {
        use bevy_rapier3d::parry::shape::SharedShape;
        [
            SharedShape::ball(bad),
            SharedShape::cuboid(1.0, bad, 1.0),
            SharedShape::capsule_y(bad, 1.0),
            SharedShape::capsule_y(1.0, bad),
            SharedShape::cylinder(bad.abs(), 1.0),
            SharedShape::cone(1.0, bad.abs()),
        ]
        .map(Shape::from)
    }));
    own.collect()
}

#[test]
fn nothing_is_known_of_shapes_that_are_not_finite() {
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let (here, there) = (Transform::IDENTITY, Transform::from_xyz(5.0, 0.0, 0.0));
    let mut found = Vec::new();
    for shape in shapes_that_are_not_finite() {
        let bad = Placed::new(&shape, &here);
        for origin in [Vec3::ZERO, Vec3::X * 5.0] {
            let ray = tests.cast_ray(bad, origin, Dir3::NEG_X, f32::INFINITY);
            let closest = tests.closest_point(bad, origin, &mut workspace);
            found.push((shape.clone(), "ray", ray.is_some()));
            found.push((shape.clone(), "closest point", closest.is_some()));
        }
        for other in [
            box_of(1.0, 1.0, 1.0),
            Shape::sphere(1.0),
            mesh_of(Vec3::ONE),
        ] {
            for at in [&here, &there] {
                let good = Placed::new(&other, at);
                for (a, b) in [(bad, good), (good, bad)] {
                    let met = tests.sweep(a, Dir3::X, 100.0, b, &mut workspace);
                    let near = tests.closest_points(a, b, &mut workspace);
                    let contact = tests.contact(a, b, &mut workspace);
                    let [one, two] = [a, b].map(|a| Moving::new(a.shape, a.transform, &there));
                    let timed = tests.time_of_impact(&one, &two, &mut workspace);
                    let touch = tests.intersects(a, b, &mut workspace);
                    found.extend(
                        [
                            ("sweep", met.is_some()),
                            ("closest points", near.is_some()),
                            ("contact", contact.is_some()),
                            ("time of impact", timed.is_some()),
                            ("intersects", touch),
                        ]
                        .map(|(asked, is_known)| (shape.clone(), asked, is_known)),
                    );
                }
            }
        }
    }
    let known: std::collections::BTreeSet<_> = found
        .into_iter()
        .filter(|(.., is_known)| *is_known)
        .map(|(shape, asked, _)| format!("{asked}: {shape:?}"))
        .collect();
    assert!(known.is_empty(), "{known:#?}");
}

#[test]
fn bounds_are_tight() {
    let placed = at(1.0, 2.0, 3.0).with_scale(Vec3::new(2.0, 1.0, -1.0));
    let aabb = box_of(1.0, 1.0, 1.0).world_aabb(&placed).unwrap();
    assert_eq!(
        (aabb.min, aabb.max),
        (
            Vec3::new(-1.0, 1.0, 2.0).into(),
            Vec3::new(3.0, 3.0, 4.0).into()
        )
    );
    let spun = placed.with_rotation(Quat::from_rotation_y(1.0));
    let aabb = Shape::sphere(1.0).world_aabb(&spun).unwrap();
    assert_eq!(
        (aabb.min, aabb.max),
        (
            Vec3::new(-1.0, 0.0, 1.0).into(),
            Vec3::new(3.0, 4.0, 5.0).into()
        )
    );
    let turned =
        at(0.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
    let aabb = l_shape().world_aabb(&turned).unwrap();
    assert!(
        (Vec3::from(aabb.min) - Vec3::new(-2.0, 0.0, 0.0)).length() < 1e-6,
        "{aabb:?}"
    );
    let sphere = l_shape().bounding_sphere(&turned).unwrap();
    assert!((sphere.center - bevy::math::Vec3A::new(-1.0, 1.0, 0.5)).length() < 1e-6);
    assert!(sphere.radius() >= 1.5 && sphere.radius() < 1.51);
}

#[test]
fn counters_tell_where_pairs_leave() {
    let (cube, ball) = (box_of(1.0, 1.0, 1.0), Shape::sphere(1.0));
    let tests = NarrowPhase::default();
    let run = |a: &Shape, b: &Shape, there: Transform| {
        let mut workspace = Workspace::default();
        let here = at(0.0, 0.0, 0.0);
        let _ = tests.intersects(
            Placed::new(a, &here),
            Placed::new(b, &there),
            &mut workspace,
        );
        Stage::ALL.map(|stage| {
            let count = workspace.counters[stage];
            (count.reached, count.rejected, count.accepted)
        })
    };
    let turned = |x: f32, y: f32| at(x, y, 0.0).with_rotation(Quat::from_rotation_z(FRAC_PI_4));
    let (skipped, passed, no, yes) = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 0, 1));
    // Edge across edge: parted by no face.
    let across = Quat::from_rotation_z(FRAC_PI_4) * Quat::from_rotation_y(FRAC_PI_4);
    let across = at(2.05, 2.05, 0.0).with_rotation(across);
    assert_eq!(run(&cube, &cube, across), [passed, passed, no, skipped]);
    assert_eq!(
        run(&cube, &cube, at(1.0, 0.0, 0.0)),
        [skipped, skipped, yes, skipped]
    );
    assert_eq!(
        run(&cube, &cube, turned(5.0, 0.0)),
        [no, skipped, skipped, skipped]
    );
    assert_eq!(
        run(&cube, &cube, turned(2.0, 0.0)),
        [passed, passed, yes, skipped]
    );
    assert_eq!(
        run(&cube, &cube, turned(1.8, 1.8)),
        [passed, passed, no, skipped]
    );
    assert_eq!(
        run(&ball, &ball, at(1.0, 1.0, 0.0)),
        [passed, yes, skipped, skipped]
    );
    assert_eq!(
        run(&ball, &ball, at(1.5, 1.5, 0.0)),
        [passed, no, skipped, skipped]
    );
    assert_eq!(
        run(&ball, &cube, at(1.5, 0.0, 0.0)),
        [passed, passed, yes, skipped]
    );
    assert_eq!(
        run(&cube, &mesh_of(Vec3::ONE), at(1.0, 0.0, 0.0)),
        [passed, passed, passed, yes]
    );
}

fn rotations() -> impl Strategy<Value = Quat> {
    let quarter = std::f32::consts::FRAC_PI_2;
    prop_oneof![
        Just(Quat::IDENTITY),
        (0..4i32, 0..4i32).prop_map(move |(x, y)| {
            Quat::from_rotation_x(x as f32 * quarter) * Quat::from_rotation_y(y as f32 * quarter)
        }),
        // Barely turned, where edges are nearly parallel.
        (prop::array::uniform3(-1f32..1.0), -6f32..-1.0).prop_map(|(axis, exponent)| {
            Quat::from_scaled_axis(Vec3::from(axis) * 10f32.powf(exponent))
        }),
        prop::array::uniform3(-3f32..3.0).prop_map(|axis| Quat::from_scaled_axis(axis.into())),
        prop::array::uniform3(-3f32..3.0).prop_map(|axis| Quat::from_scaled_axis(axis.into())),
    ]
}

pub(super) fn boxes() -> impl Strategy<Value = (Shape, Transform)> {
    let extent = || prop_oneof![Just(0.5f32), 0.01f32..2.0];
    let scale = prop_oneof![
        Just(Vec3::ONE),
        prop::array::uniform3(-2f32..2.0).prop_map(Vec3::from)
    ];
    let half_size = (extent(), extent(), extent());
    let coordinate = || prop_oneof![Just(0f32), Just(1.0), -2f32..2.0];
    let place = (coordinate(), coordinate(), coordinate());
    (half_size, place, rotations(), scale).prop_map(|((x, y, z), place, rotation, scale)| {
        let translation = Vec3::from(place);
        (
            box_of(x, y, z),
            Transform {
                translation,
                rotation,
                scale,
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        max_global_rejects: 20_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn axes_and_polygons_agree(a in boxes(), b in boxes()) {
        let found = meets((&a.0, a.1), (&b.0, b.1));
        let Shape::Cuboid { half_size } = a.0 else { unreachable!() };
        prop_assert_eq!(meets((&mesh_of(half_size), a.1), (&b.0, b.1)), found);
    }

    /// Moves the second cuboid along the axis of least overlap until it is some tolerances from
    /// touching.
    #[test]
    fn they_agree_where_they_touch(a in boxes(), b in boxes(), gap in -3f32..3.0) {
        let tests = NarrowPhase::default();
        let mut workspace = Workspace::default();
        let (one, two) = (Placed::new(&a.0, &a.1), Placed::new(&b.0, &b.1));
        let contact = tests.contact(one, two, &mut workspace);
        prop_assume!(contact.is_some());
        let contact = contact.unwrap();
        let mut moved = b.1;
        moved.translation += contact.normal * (contact.depth + gap * tests.tolerance());
        // The distance is not exactly the gap: skip what is within rounding of the tolerance.
        prop_assume!((gap - 1.0).abs() > 0.1);
        let _ = meets((&a.0, a.1), (&b.0, moved));
    }

    #[test]
    fn no_stage_rejects_what_a_later_one_accepts(
        a in boxes(),
        b in boxes(),
        far in prop_oneof![Just(0f32), Just(1e3), Just(1e6)],
    ) {
        let far = Vec3::new(far, -far, far);
        let (mut a, mut b) = (a, b);
        a.1.translation += far;
        b.1.translation += far;
        let (one, two) = (Placed::new(&a.0, &a.1), Placed::new(&b.0, &b.1));
        let tests = NarrowPhase::default();
        let (first, second, _) = in_order(one, two);
        let pair = PlacedPair::new(first, second, tests.tolerance()).unwrap();
        let ([bounds, spheres, boxes], complete) = decide::stages(&pair, &mut Workspace::default());
        if complete {
            prop_assert_eq!((bounds, spheres), (None, None));
            prop_assert!(boxes != Some(false));
            let (a, b) = (tests.world_aabb(one).unwrap(), tests.world_aabb(two).unwrap());
            prop_assert!(a.min.cmple(b.max).all() && b.min.cmple(a.max).all());
        } else {
            prop_assert!(boxes != Some(true));
        }
    }

    #[test]
    fn spheres_agree_with_meshes_of_boxes(a in boxes(), radius in 0f32..1.5, b in boxes()) {
        let Shape::Cuboid { half_size } = a.0 else { unreachable!() };
        let ball = Shape::sphere(radius);
        let exact = meets((&a.0, a.1), (&ball, b.1));
        prop_assert_eq!(exact, meets((&mesh_of(half_size), a.1), (&ball, b.1)));
    }

    #[test]
    fn contacts_turn_around_and_push_apart(a in boxes(), b in boxes()) {
        let tests = NarrowPhase::default();
        let mut workspace = Workspace::default();
        let (one, two) = (Placed::new(&a.0, &a.1), Placed::new(&b.0, &b.1));
        let Some(contact) = tests.contact(one, two, &mut workspace) else { return Ok(()) };
        let back = tests.contact(two, one, &mut workspace).unwrap();
        let turned = Contact { normal: -back.normal, ..back };
        prop_assert!(contact == turned || a.1 == b.1, "{:?} {:?}", contact, back);
        prop_assert!((contact.normal.length() - 1.0).abs() < 1e-4 && contact.depth >= 0.0);
        let mut parted = b.1;
        parted.translation += contact.normal * (contact.depth + 1e-3);
        prop_assert!(!tests.intersects(one, Placed::new(&b.0, &parted), &mut workspace));
        // The point is in both, or in between.
        let point = Shape::sphere(0.0);
        let there = Transform::from_translation(contact.point);
        let loose = NarrowPhase::new(0.02).unwrap();
        for placed in [one, two] {
            prop_assert!(loose.intersects(placed, Placed::new(&point, &there), &mut workspace));
        }
    }
}
