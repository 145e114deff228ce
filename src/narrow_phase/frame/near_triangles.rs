//! How far eight triangles are from a point, at once.

use bevy::math::Vec3A;
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::TriangleBlock;

/// Vectors, eight side by side.
type Vectors<S> = [f32x8<S>; 3];

/// The squares of the distances of triangles from a point, as
/// `closest::point_triangle_squared` has them; `None` if all are above `most` for sure.
#[inline(always)]
pub fn squared_distances<S: Simd>(
    simd: S,
    triangles: &TriangleBlock,
    point: Vec3A,
    most: f32,
) -> Option<f32x8<S>> {
    let corners = [0, 1, 2].map(|corner| triangles.corners(simd, corner));
    let point = point.to_array().map(|axis| f32x8::splat(simd, axis));
    let [a, b, c] = corners;
    let gaps = [0, 1, 2].map(|axis| {
        let (low, high) = (
            a[axis].min(b[axis]).min(c[axis]),
            a[axis].max(b[axis]).max(c[axis]),
        );
        (low - point[axis])
            .max(point[axis] - high)
            .max(f32x8::splat(simd, 0.0))
    });
    // No rounding leaves one out.
    let bound = f32x8::splat(simd, most * (1.0 + 16.0 * f32::EPSILON) + f32::MIN_POSITIVE);
    if dot(gaps, gaps).simd_le(bound).all_false() {
        return None;
    }
    let along = [
        sub(corners[1], corners[0]),
        sub(corners[2], corners[1]),
        sub(corners[0], corners[2]),
    ];
    let from = corners.map(|corner| sub(corner, point));
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let least = f32x8::splat(simd, f32::MIN_POSITIVE);
    let mut best = f32x8::splat(simd, f32::INFINITY);
    for (from, along) in from.into_iter().zip(along) {
        let share = (-dot(from, along) / dot(along, along).max(least)).max(zero);
        let closest = [0, 1, 2].map(|axis| from[axis] + along[axis] * share);
        // What is beyond the end of a side is nearer to the next one.
        best = share
            .simd_lt(one)
            .select(best.min(dot(closest, closest)), best);
    }
    let normal = cross(along[2], along[0]);
    // The areas beside the sides, seen along the normal.
    let [ab, bc, ca] = [0, 1, 2].map(|side| {
        let beside = dot(normal, cross(along[side], from[side]));
        beside.simd_lt(zero)
    });
    let height = dot(normal, from[0]);
    let over = height * (height / dot(normal, normal));
    Some((ab & bc & ca).select(over, best))
}

#[inline(always)]
fn sub<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;
    use crate::{broad_phase::levels, narrow_phase::frame::closest::point_triangle_squared};
    use fearless_simd::dispatch;

    #[test]
    fn eight_at_once_are_as_far_as_one_by_one() {
        let at = |i: usize| {
            let coordinate = |step: f32| (i as f32 * step).fract() * 2.0 - 1.0;
            Vec3::new(coordinate(0.754), coordinate(0.569), coordinate(0.43))
        };
        let triangle = |i: usize| [at(3 * i), at(3 * i + 1), at(3 * i + 2)];
        let blocks = TriangleBlock::of((0..13).map(triangle));
        assert_eq!(blocks.len(), 2);
        for point in (100..300).map(|i| Vec3A::from(at(i)) * 2.0) {
            for (first, block) in blocks.iter().enumerate() {
                let found = |level| -> [f32; 8] {
                    dispatch!(level, simd => {
                        let found = squared_distances(simd, block, point, f32::INFINITY);
                        found.unwrap().into()
                    })
                };
                let levels = levels::all();
                let same = found(levels[0].1);
                for (name, level) in levels {
                    let bits = |found: [f32; 8]| found.map(f32::to_bits);
                    assert_eq!(bits(found(level)), bits(same), "{name}");
                }
                let found = same;
                for (lane, found) in found.into_iter().enumerate() {
                    let corners = triangle((8 * first + lane).min(12)).map(Vec3A::from);
                    let single = point_triangle_squared(point, corners);
                    assert!((found - single).abs() <= 1e-6, "{found} {single}");
                }
            }
        }
    }
}
