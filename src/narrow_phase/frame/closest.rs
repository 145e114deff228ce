//! Closest points of points and segments. No input is degenerate: a segment may be a point.

use bevy::math::Vec3A;

/// The square of the sine of the angle below which segments count as parallel.
pub const PARALLEL: f32 = 1e-12;

/// The point of the segment from `a` to `b` that is closest to `point`.
#[inline]
pub fn point_segment(point: Vec3A, a: Vec3A, b: Vec3A) -> Vec3A {
    a + (b - a) * parameter(point, a, b)
}

/// Where along the segment, from 0 at `a` to 1 at `b`, it is closest to `point`.
#[inline]
fn parameter(point: Vec3A, a: Vec3A, b: Vec3A) -> f32 {
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared > 0.0 {
        ((point - a).dot(along) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The point of a triangle that is closest to `point`: by the region of its plane, of a corner, a
/// side or the inside, that the point is over (Ericson, *Real-Time Collision Detection*, 2005,
/// section 5.1.5).
#[inline]
pub fn point_triangle(point: Vec3A, [a, b, c]: [Vec3A; 3]) -> Vec3A {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let normal = ab.cross(ac);
    // The areas beside the sides: the same as of the products above, but exact where these are
    // large and nearly cancel out.
    let beside = |from: Vec3A, along: Vec3A| normal.dot(along.cross(point - from));
    let (over_ab, over_bc, over_ca) = (beside(a, ab), beside(b, c - b), beside(c, a - c));
    if over_ab > 0.0 && over_bc > 0.0 && over_ca > 0.0 {
        let height = ap.dot(normal) / normal.length_squared();
        return point - normal * height;
    }
    let mut best = point_segment(point, a, b);
    let mut squared = best.distance_squared(point);
    for closest in [point_segment(point, b, c), point_segment(point, c, a)] {
        let distance = closest.distance_squared(point);
        if distance < squared {
            (best, squared) = (closest, distance);
        }
    }
    best
}

/// The points of two segments that are closest to each other.
///
/// The crossing of the two lines comes from the cross product of their directions, which stays
/// exact for lines that are nearly parallel where the common formula in dot products does not.
#[inline]
pub fn segments(a: [Vec3A; 2], b: [Vec3A; 2]) -> (Vec3A, Vec3A) {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
    let normal = u.cross(v);
    let normal_squared = normal.length_squared();
    let s = if normal_squared > PARALLEL * u.length_squared() * v.length_squared() {
        (w.cross(v).dot(normal) / normal_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    // With one parameter clamped, the other follows; once more, in case that was clamped as well.
    let on_b = point_segment(a[0] + u * s, b[0], b[1]);
    let on_a = point_segment(on_b, a[0], a[1]);
    (on_a, point_segment(on_a, b[0], b[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
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
    }
}
