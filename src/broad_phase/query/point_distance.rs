//! Distances from a point.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::{
    block::Block,
    boxes::distance,
    measure::{Bound, Measure},
};

/// How far boxes are from a point: 0 for those that hold it.
#[derive(Clone, Copy)]
pub struct PointDistance<const ORDERED: bool>(Vec3A);

impl<const ORDERED: bool> PointDistance<ORDERED> {
    /// Returns the measure, and the limit if it makes sense; NaN otherwise.
    pub fn new(point: Vec3A, limit: f32) -> (Self, f32) {
        (
            Self(point),
            if point.is_finite() && limit >= 0.0 {
                limit
            } else {
                f32::NAN
            },
        )
    }
}

impl<const ORDERED: bool> Measure for PointDistance<ORDERED> {
    const ORDERED: bool = ORDERED;
    const EXACT: bool = false;

    /// Squared, and so much larger that neither rounding nor underflow leaves a box out.
    #[inline(always)]
    fn bound(&self, limit: f32) -> Bound {
        Bound(if limit >= 0.0 {
            limit * limit * (1.0 + 8.0 * f32::EPSILON) + f32::MIN_POSITIVE
        } else {
            f32::NAN
        })
    }

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, bound: Bound) -> (u32, f32x8<S>) {
        let point = self.0.to_array();
        let square = |axis: usize| {
            let gap = block.gaps_along(simd, axis, point[axis], point[axis]);
            gap * gap
        };
        let squared = square(0) + square(1) + square(2);
        let within = squared.simd_le(bound.splat(simd));
        // Lanes without a box are infinitely far away, which an infinite bound does not leave out.
        (
            (within & block.are_boxes(simd)).to_bitmask() as u32,
            squared,
        )
    }

    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, limit: f32) -> Option<f32> {
        let distance = distance(
            aabb,
            &Aabb3d {
                min: self.0,
                max: self.0,
            },
        );
        (distance <= limit).then_some(distance)
    }

    fn anchor(&self, aabb: &Aabb3d, _: f32) -> Vec3A {
        self.0.max(aabb.min).min(aabb.max)
    }

    fn viewpoint(&self) -> Vec3A {
        self.0
    }
}
