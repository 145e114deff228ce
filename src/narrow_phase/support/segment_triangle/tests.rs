//! The closed form against the steps that find the gap of any two convex shapes.

use super::*;
use crate::narrow_phase::support::{
    convex::{Convex, Isometry},
    gjk,
    parts::near_from,
};

/// A point of a lattice, so that much is in one plane or on one line, or of the whole cube.
fn point(random: &mut fastrand::Rng, lattice: bool) -> DVec3 {
    let mut number = || {
        if lattice {
            f64::from(random.i8(-2..=2))
        } else {
            random.f64() * 4.0 - 2.0
        }
    };
    DVec3::new(number(), number(), number())
}

/// The least and the greatest of some points along a direction.
fn extent(points: &[DVec3], along: DVec3) -> [f64; 2] {
    points
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point.dot(along)), high.max(point.dot(along))]
        })
}

#[test]
fn gaps_are_those_found_by_steps() {
    let mut random = fastrand::Rng::with_seed(1);
    let (mut apart, mut crossed) = (0, 0);
    for i in 0..40_000 {
        let lattice = i % 2 == 0;
        let corners = [0; 3].map(|_| point(&mut random, lattice));
        let start = point(&mut random, lattice);
        let end = if i % 5 == 0 {
            start
        } else {
            point(&mut random, lattice)
        };
        let found = gap([start, end], corners, f64::INFINITY, true);
        let found = found.expect("nothing is farther than that");
        let names = format!("{start} {end} and {corners:?}: {found:?}");
        assert!((found.normal.length() - 1.0).abs() < 1e-9, "{names}");
        let triangle = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
        let segment = Convex::segment([start, end], 0.0, Isometry::IDENTITY);
        let steps = gjk::by_steps(&segment, &triangle, f64::INFINITY, true);
        let steps = steps.expect("nothing is farther than that");
        // What touches may count as overlapping by nothing.
        let off = (found.distance.max(-1e-9) - steps.distance.max(-1e-9)).abs();
        assert!(off < 1e-7, "{names}, not {steps:?}");
        // It parts the two: along the normal, the triangle begins that much after the segment ends.
        let [_, last] = extent(&[start, end], found.normal);
        let [first, _] = extent(&corners, found.normal);
        if found.distance > 1e-6 {
            apart += 1;
            assert!((first - last - found.distance).abs() < 1e-7, "{names}");
            let [on_segment, on_triangle] = found.points;
            let way = on_triangle - on_segment;
            assert!(
                way.distance(found.normal * found.distance) < 1e-7,
                "{names}"
            );
        } else if found.distance < -1e-6 {
            crossed += 1;
            assert!((last - first + found.distance).abs() < 1e-7, "{names}");
            // No other way is shorter.
            assert!(
                (found.distance - steps.distance).abs() < 1e-6,
                "{names}, {steps:?}"
            );
        }
        // What is asked for less exactly is answered alike.
        let limit = random.f64() * 2.0;
        let within = gap([start, end], corners, limit, false);
        assert_eq!(within.is_some(), found.distance <= limit, "{names}");
    }
    assert!(apart > 10_000 && crossed > 1000, "{apart} {crossed}");
}

#[test]
fn what_lies_on_a_triangle_is_pushed_to_its_front() {
    let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
    let inside = DVec3::new(1.0, 1.0, 0.0);
    for end in [inside, inside + DVec3::X, inside + DVec3::Z] {
        let found = gap([inside, end], corners, 0.0, true).unwrap();
        assert_eq!(found.normal, DVec3::NEG_Z);
        assert!(found.distance.abs() < 1e-12, "{found:?}");
    }
    // Through it, nearer to its back than to its front, and to its side than to both.
    let through = |point: DVec3, back: f64, front: f64| {
        let ends = [point - DVec3::Z * back, point + DVec3::Z * front];
        gap(ends, corners, 0.0, true).unwrap()
    };
    let found = through(inside, 0.2, 0.5);
    assert!(found.normal == DVec3::NEG_Z && (found.distance + 0.2).abs() < 1e-12);
    let found = through(inside, 0.5, 0.2);
    assert!(found.normal == DVec3::Z && (found.distance + 0.2).abs() < 1e-12);
    let found = through(DVec3::new(1.0, 0.1, 0.0), 0.5, 0.5);
    assert!(found.normal == DVec3::Y && (found.distance + 0.1).abs() < 1e-12);
}

#[test]
fn nothing_touches_a_triangle_before_it_is_near_its_plane() {
    let mut random = fastrand::Rng::with_seed(2);
    let (mut early, mut never) = (0, 0);
    for _ in 0..20_000 {
        let corners = [0; 3].map(|_| point(&mut random, false));
        let segment = [0; 2].map(|_| point(&mut random, false) * 2.0);
        let direction = point(&mut random, false).normalize();
        let radius = random.f64() * 0.5;
        let body = Convex::segment(segment, 0.0, Isometry::IDENTITY);
        let from =
            near_from(&body, corners, direction, [radius, 1e-9], 6.0).map(|parted| parted.until);
        early += usize::from(from.is_some_and(|from| from > 0.0));
        never += usize::from(from.is_none());
        for step in 0..60 {
            let time = f64::from(step) * 0.1;
            if from.is_some_and(|from| from <= time) {
                break;
            }
            let moved = segment.map(|end| end + direction * time);
            let found = gap(moved, corners, f64::INFINITY, false).unwrap();
            assert!(
                found.distance > radius,
                "{segment:?} {corners:?} {direction} {time}"
            );
        }
    }
    assert!(early > 1000 && never > 1000, "{early} {never}");
}
