//! Closed forms against what they are the end of, and 32-bit answers against 64-bit ones.

use bevy::math::{Quat, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::{Bodies, QuickPair, segments::*};
use crate::narrow_phase::{
    NarrowPhase, Placed, Shape, Workspace, frame::placed::PlacedPair, gjk::Polytope, support,
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

#[test]
fn points_of_convex_meshes_are_the_closest() {
    let mut random = Random(fastrand::Rng::with_seed(3));
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    for round in 0..400 {
        let corners = [0; 4].map(|_| random.vector() * 1.5);
        let Ok(shape) = Shape::tetrahedron(corners) else {
            continue;
        };
        let scale = if round % 2 == 0 {
            Vec3::ONE
        } else {
            Vec3::new(1.06, 1.48, -1.11)
        };
        let at = random.at(1.0).with_scale(scale);
        let placed = Placed::new(&shape, &at);
        for _ in 0..20 {
            let point = random.vector() * 3.0;
            let found = tests.closest_point(placed, point, &mut workspace).unwrap();
            let exact = support::closest_point(placed, point).unwrap();
            let (found, exact) = (found.distance(point), exact.distance(point));
            assert!(
                (found - exact).abs() < 3e-5,
                "{found}, not {exact}: {corners:?} {at:?} {point}"
            );
        }
    }
}
