use super::*;
use bevy::math::Vec3;
use proptest::prelude::*;

fn distance(a: [Vec3A; 2], b: [Vec3A; 2]) -> f32 {
    let (p, q) = segments(a, b);
    p.distance(q)
}

#[test]
fn crossing_touching_and_parallel_segments() {
    let x = [Vec3A::NEG_X, Vec3A::X];
    assert_eq!(distance(x, [Vec3A::NEG_Y, Vec3A::Y]), 0.0);
    assert_eq!(
        distance(x, [Vec3A::new(1.0, -1.0, 0.5), Vec3A::new(1.0, 1.0, 0.5)]),
        0.5
    );
    assert_eq!(distance(x, x.map(|p| p + Vec3A::Y)), 1.0);
    assert_eq!(distance(x, x.map(|p| p + Vec3A::X * 5.0)), 3.0);
    assert_eq!(distance(x, [Vec3A::Y; 2]), 1.0);
    assert_eq!(distance([Vec3A::Z; 2], [Vec3A::Y; 2]), 2f32.sqrt());
}

#[test]
fn nearly_parallel_segments_that_cross_are_found() {
    for angle in [1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 1e-2] {
        let tilted = [Vec3A::new(-1.0, -angle, 0.0), Vec3A::new(1.0, angle, 0.0)];
        let tilted = tilted.map(|p| p + Vec3A::X * 0.3);
        assert!(distance([Vec3A::NEG_X, Vec3A::X], tilted) < 2e-6, "{angle}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_sample_is_closer(c in prop::array::uniform12(-1f32..1.0)) {
        let at = |i: usize| Vec3A::new(c[i], c[i + 1], c[i + 2]);
        let (a, b) = ([at(0), at(3)], [at(6), at(9)]);
        let found = distance(a, b);
        for i in 0..=20 {
            let on_a = a[0].lerp(a[1], i as f32 / 20.0);
            let nearest = point_segment(on_a, b[0], b[1]);
            prop_assert!(on_a.distance(nearest) > found - 1e-5);
        }
    }

    /// Both ways to the distance of a triangle are the same, of slivers and points too.
    #[test]
    fn distances_of_triangles_are_those_of_their_closest_points(
        c in prop::array::uniform12(-1f32..1.0),
        flat in prop::sample::select(vec![1.0, 1e-3, 1e-6, 0.0]),
        far in prop::sample::select(vec![0.01, 1.0, 100.0]),
        collapsed in 0..4,
    ) {
        let at = |i: usize| Vec3A::new(c[i], c[i + 1], c[i + 2]);
        let [mut corners, point] = [[at(0), at(3), at(6)], [at(9) * far; 3]];
        corners[2] = corners[0].lerp(corners[1], c[2]) + corners[2] * flat;
        for i in 0..collapsed {
            corners[i as usize] = corners[0];
        }
        for turn in 0..3 {
            corners.rotate_left(turn);
            let closest = point_triangle(point[0], corners).distance(point[0]);
            let found = point_triangle_squared(point[0], corners).sqrt();
            prop_assert!((closest - found).abs() <= 2e-6 * (1.0 + far), "{closest} {found}");
        }
    }
}

#[test]
fn triangles_that_share_the_closest_corner_are_equally_far() {
    let around = |i: u32| Vec3A::from(Vec3::new(1.3, 0.1, -0.7).rotate_y(i as f32));
    let (tip, point) = (Vec3A::new(0.1, 1.7, -0.3), Vec3A::new(0.27, 3.1, 0.13));
    for i in 0..6 {
        let mut corners = [tip, around(i), around(i + 1)];
        for _ in 0..3 {
            corners.rotate_left(1);
            let found = point_triangle_squared(point, corners);
            assert_eq!(found, (tip - point).length_squared(), "{i}");
        }
    }
}
