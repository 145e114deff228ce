use super::*;
use crate::narrow_phase::frame::closest::{point_triangle, segments};
use proptest::prelude::*;

fn edges(half: Vec3A) -> Vec<[Vec3A; 2]> {
    let corner = |i: usize| {
        let side = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        half * Vec3A::new(side(1), side(2), side(4))
    };
    let all = (0..8).flat_map(|i| [1, 2, 4].map(|bit| (i, i | bit)));
    all.filter(|(from, to)| from != to)
        .map(|(from, to)| [corner(from), corner(to)])
        .collect()
}

/// The distance by all pairs of what the two consist of, given that they do not overlap.
fn brute_force(half: Vec3A, [a, b, c]: [Vec3A; 3]) -> f32 {
    let mut least = f32::INFINITY;
    for [from, to] in edges(half) {
        for side in [[a, b], [b, c], [c, a]] {
            let (on_edge, on_side) = segments([from, to], side);
            least = least.min(on_edge.distance(on_side));
        }
        least = least.min(from.distance(point_triangle(from, [a, b, c])));
        least = least.min(to.distance(point_triangle(to, [a, b, c])));
    }
    for corner in [a, b, c] {
        least = least.min(corner.distance(corner.clamp(-half, half)));
    }
    least
}

fn vector(reach: f32) -> impl Strategy<Value = Vec3A> {
    prop::array::uniform3(-reach..reach).prop_map(Vec3A::from_array)
}

fn triangle() -> impl Strategy<Value = [Vec3A; 3]> {
    let corner = prop_oneof![
        3 => vector(3.0),
        // Edges along the axes of the cuboid, and degenerate ones.
        1 => vector(3.0).prop_map(Vec3A::round),
    ];
    [
        corner.clone().boxed(),
        corner.clone().boxed(),
        corner.boxed(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2048,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn distance_is_that_of_the_closest_parts(corners in triangle(), half in vector(1.5)) {
        let half = half.abs();
        let overlap = gap(half, corners, f32::INFINITY).unwrap();
        let ([on_box, on_triangle], squared) = closest(half, corners, f32::INFINITY).unwrap();
        let distance = squared.sqrt();
        prop_assert!(on_box.distance(on_box.clamp(-half, half)) < 1e-5);
        prop_assert!(on_triangle.distance(point_triangle(on_triangle, corners)) < 1e-5);
        prop_assert!(distance >= overlap.widest - 1e-5, "{distance} {overlap:?}");
        if overlap.widest < -overlap.doubt - 1e-5 {
            prop_assert!(distance < 1e-5, "{distance} {overlap:?}");
        } else if overlap.widest > 1e-5 {
            let expected = brute_force(half, corners);
            prop_assert!((distance - expected).abs() < 2e-5, "{distance} {expected}");
        }
    }

    #[test]
    fn a_way_ends_where_the_two_touch(
        corners in triangle(),
        half in vector(1.5),
        start in vector(6.0),
        direction in prop_oneof![vector(1.0), vector(1.4).prop_map(Vec3A::round)],
    ) {
        let half = half.abs();
        let Some(direction) = direction.try_normalize() else {
            return Ok(());
        };
        let at = |distance: f32| corners.map(|corner| corner - start - direction * distance);
        let apart = |distance: f32| {
            closest(half, at(distance), f32::INFINITY).unwrap().1.sqrt()
        };
        prop_assume!(apart(0.0) > 1e-3);
        let met = sweep(
            half.as_dvec3(),
            at(0.0).map(Vec3A::as_dvec3),
            direction.as_dvec3(),
            20.0,
        );
        if let Some(met) = met {
            let distance = met.distance as f32;
            prop_assert!(apart(distance) < 1e-4, "{met:?} {}", apart(distance));
            // Not before.
            for share in [0.25, 0.5, 0.75, 0.9] {
                prop_assert!(apart(distance * share) > 0.0);
            }
        } else {
            for step in 0..200 {
                prop_assert!(apart(step as f32 * 0.1) > 0.0, "{step}");
            }
        }
    }
}
