//! Rays, sweeps and closest points, each checked by tests that know nothing of how they are
//! computed.

use std::f32::consts::TAU;

use bevy::math::{Dir3, Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;

use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

/// How far results may be off, for shapes of size 1 or so.
const MARGIN: f32 = 2e-3;

/// A pyramid, an L that is not convex, an open square, and the usual ones.
pub fn shapes() -> Vec<Shape> {
    let pyramid = [
        Vec3::new(-1., 0., -1.),
        Vec3::new(1., 0., -1.),
        Vec3::new(0., 0., 1.),
        Vec3::Y,
    ];
    let outline = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    let level = |z: f32| outline.iter().map(move |&[x, y]| Vec3::new(x, y, z));
    let mut sides = vec![vec![5, 4, 3, 2, 1, 0], vec![6, 7, 8, 9, 10, 11]];
    sides.extend((0..6).map(|i| vec![i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6]));
    let square = [Vec3::NEG_X, Vec3::Y, Vec3::X, Vec3::NEG_Y];
    let mut shapes = vec![
        box_of(1.0, 0.5, 0.25),
        Shape::sphere(0.75),
        Shape::convex(pyramid, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]).unwrap(),
        Shape::mesh(level(0.0).chain(level(1.0)).collect::<Vec<_>>(), sides).unwrap(),
        Shape::mesh(square, [[0, 1, 2, 3]]).unwrap(),
    ];
    if cfg!(feature = "rapier") {
        shapes.extend(rapier());
    }
    shapes
}

#[cfg(feature = "rapier")]
fn rapier() -> Vec<Shape> {
    use bevy_rapier3d::geometry::Collider;
    [
        Collider::cuboid(0.5, 1.0, 0.5),
        Collider::capsule_y(0.5, 0.5),
        Collider::ball(0.5),
    ]
    .iter()
    .map(Into::into)
    .collect()
}

#[cfg(not(feature = "rapier"))]
fn rapier() -> Vec<Shape> {
    vec![]
}

pub fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-reach..reach).prop_map(Vec3::from)
}

pub fn placed() -> impl Strategy<Value = (Shape, Transform)> {
    let scale = prop::array::uniform3(prop_oneof![0.5f32..1.5, -1.5f32..-0.5]).prop_map(Vec3::from);
    let rotation = (vectors(1.0), 0f32..3.0).prop_map(|(axis, angle)| {
        axis.try_normalize()
            .map_or(Quat::IDENTITY, |axis| Quat::from_axis_angle(axis, angle))
    });
    (
        prop::sample::select(shapes()),
        vectors(2.0),
        rotation,
        scale,
    )
        .prop_map(|(shape, translation, rotation, scale)| {
            (
                shape,
                Transform {
                    translation,
                    rotation,
                    scale,
                },
            )
        })
}

fn directions() -> impl Strategy<Value = Dir3> {
    vectors(1.0).prop_filter_map("no direction", |v| Dir3::new(v).ok())
}

pub fn distance(target: Placed, point: Vec3) -> f32 {
    NarrowPhase::default()
        .closest_point(target, point, &mut Workspace::default())
        .unwrap()
        .distance(point)
}

fn is_away(impact: Impact, direction: Dir3) -> bool {
    (impact.normal.length() - 1.0).abs() < 1e-4 && impact.normal.dot(*direction) <= 1e-4
}

/// Along a way of `length`, at up to 64 places short of it.
fn places(length: f32) -> impl Iterator<Item = f32> {
    (0..64)
        .map(move |i| length * i as f32 / 64.0)
        .filter(move |_| length > 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 512, ..ProptestConfig::default() })]

    /// Where a ray hits, the shape is; before that, it is not.
    #[test]
    fn rays_end_at_the_shape((shape, transform) in placed(), origin in vectors(5.0), direction in directions()) {
        let target = Placed::new(&shape, &transform);
        let impact = NarrowPhase::default().cast_ray(target, origin, direction, 10.0);
        if let Some(impact) = impact {
            prop_assert!(distance(target, impact.point) < MARGIN, "{impact:?}");
            prop_assert!(impact.point.distance(origin + direction * impact.distance) < MARGIN);
            prop_assert!(is_away(impact, direction), "{impact:?}");
        }
        for t in places(impact.map_or(10.0, |impact| impact.distance - 2.0 * MARGIN)) {
            prop_assert!(distance(target, origin + direction * t) > 0.0, "missed at {t}");
        }
    }

    /// Rays at a point of a shape hit it there or before.
    #[test]
    fn rays_at_a_point_of_the_shape_hit((shape, transform) in placed(), origin in vectors(5.0)) {
        let target = Placed::new(&shape, &transform);
        let closest = NarrowPhase::default().closest_point(target, origin, &mut Workspace::default()).unwrap();
        let inwards = closest.lerp(transform.translation, 1e-3);
        if let Ok(direction) = Dir3::new(closest - origin)
            && closest.distance(origin) > 0.1
            && matches!(shape, Shape::Cuboid { .. } | Shape::Sphere { .. })
        {
            let towards = Dir3::new(inwards - origin).unwrap();
            let impact = NarrowPhase::default().cast_ray(target, origin, towards, 20.0);
            prop_assert!(impact.is_some_and(|hit| (hit.distance - origin.distance(closest)).abs() < 0.02), "{impact:?}");
            let short = NarrowPhase::default().cast_ray(target, origin, direction, origin.distance(closest) - MARGIN);
            prop_assert_eq!(short, None);
        }
    }

    /// A shape on its way is apart from the other up to the impact, and in contact there.
    #[test]
    fn sweeps_end_at_contact(
        (a, at_a) in placed(),
        (b, at_b) in placed(),
        offset in vectors(4.0),
        direction in directions(),
    ) {
        let at_a = Transform { translation: at_a.translation + offset, ..at_a };
        let (target, workspace) = (Placed::new(&b, &at_b), &mut Workspace::default());
        let impact = NarrowPhase::default().sweep(Placed::new(&a, &at_a), direction, 10.0, target, workspace);
        let loose = NarrowPhase::new(MARGIN).unwrap();
        let mut meets = |tests: NarrowPhase, t: f32| {
            let moved = Transform { translation: at_a.translation + direction * t, ..at_a };
            tests.intersects(Placed::new(&a, &moved), target, workspace)
        };
        if let Some(impact) = impact {
            prop_assert!(meets(loose, impact.distance), "apart at {impact:?}");
            // Those that overlap from the start meet somewhere in between.
            let is_on_target = impact.distance == 0.0 || distance(target, impact.point) < 2.0 * MARGIN;
            prop_assert!(is_on_target && is_away(impact, direction), "{impact:?}");
        }
        for t in places(impact.map_or(10.0, |impact| impact.distance)) {
            // Not for those that only graze.
            let slid = impact.map_or(f32::INFINITY, |impact| impact.distance) - t < 0.02;
            if !slid && meets(NarrowPhase::default(), t) {
                let moved = Transform { translation: at_a.translation + direction * t, ..at_a };
                let contact = NarrowPhase::default().contact(Placed::new(&a, &moved), target, &mut Workspace::default()).unwrap();
                prop_assert!(contact.depth < MARGIN, "in contact at {t} already: {impact:?}");
            }
        }
    }
}

#[test]
fn rays_through_edges_and_corners_do_not_slip_through() {
    let (mesh, here) = (mesh_of(Vec3::ONE), at(0.0, 0.0, 0.0));
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_x(0.3) * Quat::from_rotation_y(1.1),
    ] {
        let placed = here.with_rotation(turn);
        for corner in [
            Vec3::ONE,
            Vec3::new(1.0, 1.0, 0.3),
            Vec3::new(-0.2, 1.0, 1.0),
            Vec3::new(1.0, 0.1, 0.2),
        ] {
            let origin = turn * (corner * 4.0);
            let hit = NarrowPhase::default().cast_ray(
                Placed::new(&mesh, &placed),
                origin,
                Dir3::new(-origin).unwrap(),
                100.0,
            );
            let expected = corner.length() * 3.0;
            assert!(
                hit.is_some_and(|hit| (hit.distance - expected).abs() < 1e-4),
                "{corner} {hit:?}"
            );
        }
    }
}

#[test]
fn rays_from_inside_and_afar_and_at_flat_shapes() {
    let inside = |shape: &Shape| {
        NarrowPhase::default().cast_ray(
            Placed::new(shape, &at(1.0, 0.0, 0.0)),
            Vec3::X,
            Dir3::Z,
            0.0,
        )
    };
    for solid in [
        box_of(1.0, 1.0, 1.0),
        Shape::sphere(1.0),
        mesh_of(Vec3::ONE),
    ] {
        let hit = inside(&solid).unwrap();
        assert_eq!(
            (hit.distance, hit.point, hit.normal),
            (0.0, Vec3::X, Vec3::NEG_Z)
        );
        // A million sides away.
        let far = at(0.0, 0.0, 1e6);
        let hit = NarrowPhase::default()
            .cast_ray(
                Placed::new(&solid, &far),
                Vec3::new(0.5, 0.25, 0.0),
                Dir3::Z,
                f32::INFINITY,
            )
            .unwrap();
        assert!(
            (hit.distance - 1e6).abs() <= 1.0 && hit.normal.z < -0.8,
            "{hit:?}"
        );
        if !matches!(solid, Shape::Sphere { .. }) {
            let flat = at(0.0, 0.0, 5.0).with_scale(Vec3::new(1.0, 1.0, 0.0));
            let hit = NarrowPhase::default()
                .cast_ray(Placed::new(&solid, &flat), Vec3::splat(0.5), Dir3::Z, 10.0)
                .unwrap();
            assert!(
                (hit.distance - 4.5).abs() < 1e-5 && hit.normal == Vec3::NEG_Z,
                "{hit:?}"
            );
        }
        let point = at(0.0, 0.0, 5.0).with_scale(Vec3::ZERO);
        assert_eq!(
            NarrowPhase::default().cast_ray(Placed::new(&solid, &point), Vec3::ZERO, Dir3::Z, 10.0),
            None
        );
    }
}

#[test]
fn equal_cubes_turned_alike_meet_face_to_face() {
    let turn = Quat::from_rotation_x(0.3) * Quat::from_rotation_y(1.1);
    for shape in [box_of(1.0, 1.0, 1.0), mesh_of(Vec3::ONE)] {
        let here = at(3.0, 4.0, 5.0).with_rotation(turn);
        let there = here.with_translation(here.translation + turn * Vec3::X * 50.0);
        let (moving, target) = (Placed::new(&shape, &here), Placed::new(&shape, &there));
        let way = Dir3::new(turn * Vec3::X).unwrap();
        let hit = NarrowPhase::default()
            .sweep(moving, way, 100.0, target, &mut Workspace::default())
            .unwrap();
        assert!(
            (hit.distance - 48.0).abs() < 1e-3 && hit.normal.distance(-*way) < 1e-3,
            "{hit:?}"
        );
        assert_eq!(
            NarrowPhase::default().sweep(moving, -way, 100.0, target, &mut Workspace::default()),
            None
        );
        assert_eq!(
            NarrowPhase::default().sweep(moving, way, 47.9, target, &mut Workspace::default()),
            None
        );
    }
}

#[test]
fn the_way_may_be_unbounded() {
    let (here, turn) = (at(0.0, 0.0, 0.0), Quat::from_rotation_y(1.0));
    let there = at(50.0, 0.3, 0.3).with_rotation(turn);
    let ball = Shape::sphere(0.5);
    for shape in shapes() {
        let target = Placed::new(&shape, &there);
        let towards = Dir3::new(there.translation + turn * Vec3::splat(0.1)).unwrap();
        let ray = NarrowPhase::default().cast_ray(target, Vec3::ZERO, towards, f32::INFINITY);
        assert!(
            ray.is_some_and(|hit| (47.0..51.0).contains(&hit.distance)),
            "{ray:?} {shape:?}"
        );
        for (a, b) in [(&ball, &shape), (&shape, &ball), (&shape, &shape)] {
            let (moving, target) = (Placed::new(a, &here), Placed::new(b, &there));
            let workspace = &mut Workspace::default();
            let hit =
                NarrowPhase::default().sweep(moving, towards, f32::INFINITY, target, workspace);
            assert!(
                hit.is_some_and(|hit| (45.0..51.0).contains(&hit.distance)),
                "{hit:?} {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn bad_input_meets_nothing() {
    let nan = at(f32::NAN, 0.0, 0.0);
    let here = at(0.0, 0.0, 0.0);
    for shape in shapes() {
        let (good, bad) = (Placed::new(&shape, &here), Placed::new(&shape, &nan));
        let workspace = &mut Workspace::default();
        assert_eq!(
            NarrowPhase::default().cast_ray(bad, Vec3::ZERO, Dir3::X, 1.0),
            None
        );
        assert_eq!(
            NarrowPhase::default().cast_ray(good, Vec3::NAN, Dir3::X, 1.0),
            None
        );
        for max in [-1.0, f32::NAN] {
            assert_eq!(
                NarrowPhase::default().cast_ray(good, Vec3::ZERO, Dir3::X, max),
                None
            );
            assert_eq!(
                NarrowPhase::default().sweep(good, Dir3::X, max, good, workspace),
                None
            );
        }
        assert_eq!(
            NarrowPhase::default().sweep(bad, Dir3::X, 1.0, good, workspace),
            None
        );
        assert_eq!(
            NarrowPhase::default().sweep(good, Dir3::X, 1.0, bad, workspace),
            None
        );
        assert_eq!(
            NarrowPhase::default().closest_point(good, Vec3::INFINITY, workspace),
            None
        );
        assert_eq!(
            NarrowPhase::default().closest_point(bad, Vec3::ZERO, workspace),
            None
        );
    }
}

/// A ring of many polygons, and an open sheet of as many, with bumps.
pub fn large() -> [Shape; 2] {
    let turned = |share: f32, radius: f32| {
        let (sin, cos) = (TAU * share).sin_cos();
        (radius * cos, radius * sin)
    };
    let (around, across) = (24u32, 10u32);
    let ring = (0..around * across).map(|i| {
        let (x, z) = turned((i % across) as f32 / across as f32, 0.3);
        let (x, y) = turned((i / across) as f32 / around as f32, 1.0 + x);
        Vec3::new(x, y, z)
    });
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quads =
        |rows: u32, columns: u32| (0..rows).flat_map(move |i| (0..columns).map(move |j| (i, j)));
    let triangles = quads(around, across).flat_map(|(i, j)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(k, l)| number(i + k, j + l));
        [[a, b, c], [a, c, d]]
    });
    let ring = Shape::mesh(ring.collect::<Vec<_>>(), triangles).unwrap();
    let side = 12;
    let height = |i: u32, j: u32| ((i * 7 + j * 5) % 4) as f32 * 0.1;
    let sheet = quads(side, side)
        .map(|(i, j)| Vec3::new(i as f32 * 0.2 - 1.1, height(i, j), j as f32 * 0.2 - 1.1));
    let triangles = quads(side - 1, side - 1).flat_map(|(i, j)| {
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(k, l)| (i + k) * side + j + l);
        [[a, b, c], [a, c, d]]
    });
    [
        ring,
        Shape::mesh(sheet.collect::<Vec<_>>(), triangles).unwrap(),
    ]
}

#[test]
fn a_ray_as_long_as_its_way_meets_what_it_met() {
    let tests = NarrowPhase::default();
    let (mut met, options) = (0, RayCastOptions::DEFAULT.ignore_start());
    for shape in large().iter().chain(&shapes()) {
        let place = Transform::from_xyz(3.3, -1.7, 0.9).with_rotation(Quat::from_rotation_y(0.7));
        let place = Placed::new(shape, &place);
        for i in 0..500_u16 {
            let (sin, cos) = (f32::from(i) * 2.4).sin_cos();
            let from = Vec3::new(7.0 * cos, 3.0 * (f32::from(i) * 0.7).sin(), 7.0 * sin);
            let aim = place.transform.translation + Vec3::new(sin, cos, sin * cos) * 0.9;
            let way = Dir3::new(aim - from).unwrap();
            let within = |most: f32| {
                [
                    tests.cast_ray(place, from, way, most),
                    tests.cast_ray_with(place, from, way, most, &options),
                    tests
                        .cast_ray_through(place, from, way, most)
                        .and_then(|found| found.enter),
                ]
                .map(|hit| hit.map(|hit| hit.distance))
            };
            for (way, hit) in within(100.0).into_iter().enumerate() {
                let Some(distance) = hit else { continue };
                met += 1;
                assert_eq!(within(distance)[way], hit, "{shape:?} by {way}, ray {i}");
                assert_eq!(
                    within(distance.next_down())[way],
                    None,
                    "{shape:?} by {way}, ray {i}"
                );
            }
        }
    }
    assert!(met > 1000, "{met}");
}
