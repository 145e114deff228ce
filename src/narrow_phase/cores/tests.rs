//! Closed forms against what they are the end of, and 32-bit answers against 64-bit ones.

use bevy::math::{Quat, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::{Bodies, QuickPair, segments::*};
use crate::narrow_phase::{
    Contact, NarrowPhase, Placed, Shape, Workspace, frame::placed::PlacedPair, gjk::Polytope,
    support,
};

struct Random(fastrand::Rng);

impl Random {
    fn vector(&mut self) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.0.f32() * 2.0 - 1.0))
    }

    fn at(&mut self, reach: f32) -> Transform {
        Transform::from_translation(self.vector() * reach)
            .with_rotation(Quat::from_scaled_axis(self.vector() * 3.0))
    }
}

fn distance_to_box(point: Vec3A, half: Vec3A) -> f32 {
    point.distance(point.clamp(-half, half))
}

#[test]
fn nothing_on_a_segment_is_nearer_to_a_box() {
    let mut random = Random(fastrand::Rng::with_seed(1));
    let (mut apart, mut inside) = (0, 0);
    for round in 0..3000 {
        let half = Vec3A::from(random.vector().abs() + 0.05);
        let center = Vec3A::from(random.vector() * 1.2);
        let mut way = Vec3A::from(random.vector() * 1.5);
        // Along a side, or of no length.
        if round % 7 == 0 {
            way[round % 3] = 0.0;
        }
        if round % 31 == 0 {
            way = Vec3A::ZERO;
        }
        let segment = Segment { center, half: way };
        let [on_segment, on_box] = segment_box(&segment, half);
        assert!((on_box.abs() - half).max_element() <= 1e-6);
        let found = on_segment.distance(on_box);
        let least = (0..=400)
            .map(|i| distance_to_box(center + way * (i as f32 / 200.0 - 1.0), half))
            .fold(f32::INFINITY, f32::min);
        assert!(
            found <= least + 1e-5,
            "{segment:?} {half}: {found}, {least}"
        );
        if found > 0.0 {
            apart += 1;
            continue;
        }
        inside += 1;
        let (out, depth) = way_out(&segment, half);
        let beyond = |way: Vec3A, by: f32| {
            let moved = Segment {
                center: center + way * by,
                ..segment
            };
            let [a, b] = segment_box(&moved, half);
            a.distance(b)
        };
        assert!(beyond(out, depth + 1e-3) > 0.0, "{segment:?} {half}");
        assert!(
            beyond(out, depth * 0.98 - 1e-4) == 0.0,
            "{segment:?} {half}"
        );
        // No direction takes it out with much less.
        for _ in 0..60 {
            let other = Vec3A::from(random.vector()).normalize_or(Vec3A::X);
            let less = depth * 0.99 - 2e-4;
            assert!(beyond(other, less) == 0.0, "{segment:?} {half}: {other}");
        }
    }
    assert!(apart > 500 && inside > 500, "{apart} {inside}");
}

#[test]
fn segments_alongside_are_closest_in_the_middle_of_what_they_share() {
    let along = |center: Vec3A, length: f32| Segment {
        center,
        half: Vec3A::X * length,
    };
    let one = along(Vec3A::ZERO, 1.0);
    for (other, middle) in [
        (along(Vec3A::new(0.0, 1.0, 0.0), 3.0), 0.0),
        (along(Vec3A::new(1.5, 1.0, 0.0), 1.0), 0.75),
        (along(Vec3A::new(-1.5, 1.0, 0.0), -1.0), -0.75),
        (along(Vec3A::new(4.0, 1.0, 0.0), 1.0), 1.0),
    ] {
        let [a, b] = segments(&one, &other);
        assert!((a.x - middle).abs() < 1e-6, "{a} {b}");
        assert!((segments(&other, &one)[1].x - middle).abs() < 1e-6);
    }
}

fn convex_shapes(random: &mut Random) -> Vec<Shape> {
    let points: Vec<_> = (0..14).map(|_| random.vector()).collect();
    let hull = Shape::convex_hull(points).unwrap();
    vec![
        Shape::sphere(0.6),
        Shape::capsule(0.3, 1.2),
        Shape::cuboid(1.0, 0.7, 1.6),
        Shape::cylinder(0.5, 1.1),
        Shape::cone(0.7, 1.0),
        Shape::rounded(&Shape::cuboid(0.8, 0.3, 0.6), 0.2).unwrap(),
        Shape::segment(Vec3::ZERO, random.vector()).unwrap(),
        Shape::triangle(random.vector(), random.vector(), random.vector()).unwrap(),
        Shape::rounded(&hull, 0.1).unwrap(),
        hull,
    ]
}

#[test]
fn both_precisions_say_the_same() {
    let mut random = Random(fastrand::Rng::with_seed(2));
    let shapes = convex_shapes(&mut random);
    let scales = [
        Vec3::ONE,
        Vec3::splat(-1.7),
        Vec3::new(0.4, 2.0, -1.0),
        Vec3::splat(40.0),
    ];
    let (mut told, mut deep) = (0, 0);
    for (a, b) in shapes
        .iter()
        .flat_map(|a| shapes.iter().map(move |b| (a, b)))
    {
        for round in 0..40 {
            let (scale_a, scale_b) = (scales[round % 4], scales[round / 4 % 4]);
            let reach = 0.4 * (scale_a.abs().max_element() + scale_b.abs().max_element());
            let (at_a, at_b) = (
                random.at(reach).with_scale(scale_a),
                random.at(reach).with_scale(scale_b),
            );
            let (a, b) = (Placed::new(a, &at_a), Placed::new(b, &at_b));
            let pair = PlacedPair::new(a, b, 1e-6).unwrap();
            let Some(points) = support::closest_points(a, b) else {
                panic!("two convex shapes are known")
            };
            let distance = points[0].distance(points[1]);
            let off = 1e-5 * pair.size;
            let mut check = |found: f32| {
                told += 1;
                assert!(
                    (found - distance).abs() <= off,
                    "{found}, not {distance}: {a:?} {b:?}"
                );
            };
            if let Some(quick) = QuickPair::of(a, b) {
                check(quick.closest_points().distance);
            }
            let bodies = Bodies::of(&pair).unwrap();
            if let Some(found) = bodies.closest_points() {
                check(found.distance);
            }
            if let Some(meet) = bodies.intersects()
                && (distance > pair.tolerance + off || distance == 0.0)
            {
                assert_eq!(meet, distance == 0.0, "{a:?} {b:?}");
            }
            let (Some(Some(found)), Some(exact)) = (
                bodies.contact(&mut Polytope::default()),
                support::contact(a, b, pair.tolerance),
            ) else {
                continue;
            };
            deep += 1;
            // Normals of faces are preferred to what is better by a thousandth.
            let bias = 2e-3 * (pair.box_a.radius + pair.box_b.radius);
            assert!(
                found.depth >= exact.depth - 2.0 * off && found.depth <= exact.depth + bias,
                "{found:?}, not {exact:?}: {a:?} {b:?}"
            );
        }
    }
    assert!(told > 2000 && deep > 1000, "{told} {deep}");
}

fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Option<Contact> {
    let (a, b) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    NarrowPhase::default().contact(a, b, &mut Workspace::default())
}

fn box_hull(half: Vec3) -> Shape {
    let corners = (0..8).map(|bits| {
        let sign = |bit: u32| if bits >> bit & 1 == 0 { -1.0 } else { 1.0 };
        half * Vec3::new(sign(0), sign(1), sign(2))
    });
    Shape::convex_hull(corners).unwrap()
}

#[test]
fn a_pebble_leaves_a_plate_where_it_lies_on_it() {
    let pebble = box_hull(Vec3::splat(0.005));
    let half = Vec3::new(500.0, 0.5, 500.0);
    for plate in [Shape::from_half_size(half), box_hull(half)] {
        // Near the border.
        for x in [0.0, 499.6, 499.9, -499.7] {
            for side in [1.0, -1.0] {
                let at = Transform::from_xyz(x, 0.504 * side, 0.3);
                let found = contact((&plate, Transform::IDENTITY), (&pebble, at)).unwrap();
                assert!(
                    found.normal.dot(Vec3::Y * side) > 0.999,
                    "{x} {side}: {found:?}"
                );
                assert!((found.depth - 1e-3).abs() < 2e-4, "{found:?}");
            }
        }
    }
    // What is hardly there.
    let half = Vec3::new(1.0, 1e-4, 1.0);
    for plate in [Shape::from_half_size(half), box_hull(half)] {
        for side in [1.0, -1.0] {
            let at = Transform::from_xyz(0.3, 0.00509 * side, 0.1);
            let found = contact((&plate, Transform::IDENTITY), (&pebble, at)).unwrap();
            assert!(
                found.normal.dot(Vec3::Y * side) > 0.999,
                "{side}: {found:?}"
            );
            assert!(found.depth < 2e-5, "{found:?}");
        }
    }
}

#[test]
fn edges_that_hardly_miss_each_other_are_not_deep() {
    use std::f32::consts::{FRAC_PI_4, SQRT_2};
    let (hull, cuboid) = (box_hull(Vec3::ONE), Shape::from_half_size(Vec3::ONE));
    for above in [-1e-5, 0.0, 2e-6, 1e-5, 4e-5, 9e-5] {
        let low = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
        let high = Transform::from_xyz(0.2, 2.0 * SQRT_2 + above, 0.1)
            .with_rotation(Quat::from_rotation_x(FRAC_PI_4));
        for other in [&hull, &cuboid] {
            let found = contact((&hull, low), (other, high)).unwrap();
            assert!(found.depth < 3e-5, "{above}: {found:?}");
            assert!(found.normal.y > 0.99, "{above}: {found:?}");
        }
    }
}

/// Where the numbers are so near to the limit that each way of computing them says something else.
#[test]
fn whatever_is_at_the_tolerance_has_a_contact_if_it_intersects() {
    let mut random = Random(fastrand::Rng::with_seed(3));
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let shapes = convex_shapes(&mut random);
    for (a, b) in shapes
        .iter()
        .flat_map(|a| shapes.iter().map(move |b| (a, b)))
    {
        for scale in [1.0, 1000.0] {
            let at_a = random.at(0.0).with_scale(Vec3::splat(scale));
            let at_b = random.at(0.0).with_scale(Vec3::splat(random.0.f32() + 0.1));
            let way = random.vector().normalize_or(Vec3::X);
            let there = |far: f32| at_b.with_translation(way * far);
            let a = Placed::new(a, &at_a);
            let (mut near, mut far) = (0.0, 10.0 * scale);
            for _ in 0..60 {
                let middle = 0.5 * (near + far);
                let at_b = there(middle);
                if tests.intersects(a, Placed::new(b, &at_b), &mut workspace) {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            let ulp = f32::from_bits(near.to_bits() + 1) - near;
            for step in -40..40 {
                let at_b = there(near + step as f32 * ulp);
                let b = Placed::new(b, &at_b);
                let meets = tests.intersects(a, b, &mut workspace);
                let found = tests.contact(a, b, &mut workspace);
                assert_eq!(found.is_some(), meets, "{a:?} {b:?}");
                assert!(found.is_none_or(|found| found.depth >= 0.0), "{found:?}");
            }
        }
    }
}

#[test]
fn what_lies_on_a_large_box_is_as_deep_as_it_is() {
    let plate = Shape::cuboid(1000.0, 1.0, 1000.0);
    for (small, turn) in [
        (Shape::sphere(0.01), 0.0),
        (Shape::capsule(0.01, 0.02), 0.0),
        (Shape::capsule(0.01, 0.02), std::f32::consts::FRAC_PI_2),
    ] {
        let reach = if turn == 0.0 && matches!(small, Shape::Capsule { .. }) {
            0.02
        } else {
            0.01
        };
        for depth in [0.0, 1e-3, 5e-3] {
            let at = Transform::from_xyz(70.3, 0.5 + reach - depth, -12.9)
                .with_rotation(Quat::from_rotation_z(turn));
            let found = contact((&plate, Transform::IDENTITY), (&small, at)).unwrap();
            assert!((found.depth - depth).abs() < 2e-6, "{depth}: {found:?}");
            assert!(found.normal.y > 0.999, "{depth}: {found:?}");
        }
    }
}

#[test]
fn how_large_something_is_may_be_said_by_its_scale() {
    let usual = Shape::conical_frustum(0.3, 0.5, 1.0);
    let cuboid = Shape::cuboid(1.0, 1.0, 1.0);
    let at = Transform::from_xyz(0.9, 0.1, 0.2).with_rotation(Quat::from_rotation_z(1.0));
    let tests = NarrowPhase::default();
    let nearest = |shape: &Shape, scale: f32, offset: f32| {
        let at = Transform {
            translation: at.translation * offset,
            ..at.with_scale(Vec3::splat(scale))
        };
        let (a, b) = (
            Placed::new(&cuboid, &Transform::IDENTITY),
            Placed::new(shape, &at),
        );
        let near = tests.closest_points(a, b, &mut Workspace::default());
        near.unwrap().distance
    };
    for power in [15, 22, 30] {
        let huge = 10f32.powi(power);
        let large = Shape::conical_frustum(0.3 * huge, 0.5 * huge, huge);
        let small = Shape::conical_frustum(0.3 / huge, 0.5 / huge, 1.0 / huge);
        for offset in [1.3, 2.0] {
            let expected = nearest(&usual, 1.0, offset);
            for found in [
                nearest(&large, 1.0 / huge, offset),
                nearest(&small, huge, offset),
            ] {
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{power}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn a_small_ball_in_what_is_rounded_widely_meets_it_in_itself() {
    let rounded = Shape::rounded(&box_hull(Vec3::ONE), 0.5).unwrap();
    let ball = Shape::sphere(0.1);
    for height in [1.55, 1.2, 0.9, 0.4] {
        let at = Transform::from_xyz(0.1, height, 0.2);
        let found = contact((&rounded, Transform::IDENTITY), (&ball, at)).unwrap();
        assert!(
            found.point.distance(at.translation) < 0.1 + 1e-5,
            "{found:?}"
        );
        assert!((found.depth - (1.6 - height)).abs() < 1e-5, "{found:?}");
    }
}
