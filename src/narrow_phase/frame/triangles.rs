//! Eight triangles side by side.

use bevy::math::Vec3A;
use fearless_simd::{Level, dispatch, f32x8, prelude::*};

/// How many there are.
const LANES: usize = 8;

/// Eight triangles, coordinate by coordinate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles {
    /// By corner, and by axis.
    corners: [[[f32; LANES]; 3]; 3],
}

impl Triangles {
    /// Puts a triangle in a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, corners: [Vec3A; 3]) {
        for (lanes, corner) in self.corners.iter_mut().zip(corners) {
            for (axis, lanes) in lanes.iter_mut().enumerate() {
                lanes[lane] = corner[axis];
            }
        }
    }

    /// The triangle in a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> [Vec3A; 3] {
        self.corners
            .map(|corner| Vec3A::new(corner[0][lane], corner[1][lane], corner[2][lane]))
    }

    /// The squares of the distances from a point, up to rounding.
    ///
    /// The least of those from the sides, or that from the plane if the point is over the inside.
    #[inline]
    pub fn distances_squared(&self, level: Level, point: Vec3A) -> [f32; LANES] {
        dispatch!(level, simd => self.distances_squared_by(simd, point))
    }

    #[inline(always)]
    fn distances_squared_by<S: Simd>(&self, simd: S, point: Vec3A) -> [f32; LANES] {
        let load = |corner: usize| -> Vectors<S> {
            [0, 1, 2].map(|axis| f32x8::from_slice(simd, &self.corners[corner][axis]))
        };
        let [a, b, c] = [0, 1, 2].map(load);
        let point = [0, 1, 2].map(|axis| f32x8::splat(simd, point[axis]));
        let (ab, bc, ca) = (sub(b, a), sub(c, b), sub(a, c));
        let (ap, bp, cp) = (sub(point, a), sub(point, b), sub(point, c));
        let normal = cross(ca, ab);
        let to_border = to_side(simd, ab, ap)
            .min(to_side(simd, bc, bp))
            .min(to_side(simd, ca, cp));
        let beside = |along, from| dot(normal, cross(along, from));
        let least = beside(ab, ap).min(beside(bc, bp)).min(beside(ca, cp));
        let (height, squared) = (dot(normal, ap), dot(normal, normal));
        let zero = f32x8::splat(simd, 0.0);
        let is_over = least.simd_ge(zero) & squared.simd_gt(zero);
        let to_plane = height * height / squared;
        is_over.select(to_plane, to_border).into()
    }
}

/// Vectors, lane by lane.
type Vectors<S> = [f32x8<S>; 3];

/// The squares of the distances from segments, by the way along these and that from their start.
#[inline(always)]
fn to_side<S: Simd>(simd: S, along: Vectors<S>, from: Vectors<S>) -> f32x8<S> {
    let splat = |value: f32| f32x8::splat(simd, value);
    let length = dot(along, along).max(splat(f32::MIN_POSITIVE));
    let share = (dot(along, from) / length).max(splat(0.0)).min(splat(1.0));
    let aside = [0, 1, 2].map(|axis| from[axis] - along[axis] * share);
    dot(aside, aside)
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
    use super::*;
    use crate::narrow_phase::frame::closest::point_triangle;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn as_one_by_one(
            corners in prop::array::uniform9(-2f32..2.0),
            point in prop::array::uniform3(-4f32..4.0),
            lane in 0..LANES,
            flat in prop::bool::ANY,
        ) {
            let at = |i: usize| Vec3A::new(corners[i], corners[i + 1], corners[i + 2]);
            let triangle = [at(0), at(3), if flat { at(0) } else { at(6) }];
            let point = Vec3A::from_array(point);
            let mut triangles = Triangles::default();
            triangles.set(lane, triangle);
            let found = triangles.distances_squared(Level::new(), point)[lane].sqrt();
            let expected = point_triangle(point, triangle).distance(point);
            prop_assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }
}
