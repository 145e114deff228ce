//! Distances from a box where lengths along the axes are stretched.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::{
    block::Block,
    measure::{Bound, Measure},
};

/// How far boxes are from a box, or a point, each axis stretched by a factor: what a shape with a
/// scale is asked, in its own space. Distances and limits are squared, for nothing else is needed.
///
/// Where nothing is `SCALED`, the factors are 1, and no square may overflow.
#[derive(Clone, Copy)]
pub struct ScaledDistance<const SCALED: bool = true> {
    from: Aabb3d,
    scale: Vec3A,
}

impl ScaledDistance {
    /// Returns the measure. All has to be finite.
    #[inline(always)]
    pub fn new(from: Aabb3d, scale: Vec3A) -> Self {
        let scale = scale.abs();
        Self { from, scale }
    }
}

impl ScaledDistance<false> {
    /// Returns the measure of what has no scale. All has to be less than 10¹⁸.
    #[inline(always)]
    pub fn unscaled(from: Aabb3d) -> Self {
        let scale = Vec3A::ONE;
        Self { from, scale }
    }
}

impl<const SCALED: bool> ScaledDistance<SCALED> {
    #[inline(always)]
    fn gap_squared(&self, aabb: &Aabb3d) -> f32 {
        let gap = (aabb.min - self.from.max)
            .max(self.from.min - aabb.max)
            .max(Vec3A::ZERO);
        (gap * self.scale).length_squared()
    }
}

impl<const SCALED: bool> Measure for ScaledDistance<SCALED> {
    const ORDERED: bool = true;
    const EXACT: bool = true;

    /// So much larger that rounding leaves no box out.
    #[inline(always)]
    fn bound(&self, limit: f32) -> Bound {
        let bound = limit * (1.0 + 16.0 * f32::EPSILON) + f32::MIN_POSITIVE;
        // What is not scaled is less than infinitely far away, but for lanes without a box.
        let most = if SCALED { f32::INFINITY } else { f32::MAX };
        Bound(if limit >= 0.0 {
            bound.min(most)
        } else {
            f32::NAN
        })
    }

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, bound: Bound) -> (u32, f32x8<S>) {
        let (min, max) = (self.from.min.to_array(), self.from.max.to_array());
        let scale = self.scale.to_array();
        let square = |axis: usize| {
            let gap = block.gaps_along(simd, axis, min[axis], max[axis]);
            let gap = if SCALED {
                gap * f32x8::splat(simd, scale[axis])
            } else {
                gap
            };
            gap * gap
        };
        let squared = square(0) + square(1) + square(2);
        let within = squared.simd_le(bound.splat(simd));
        let within = if SCALED {
            // Lanes without a box are infinitely far away, or NaN where the scale is zero.
            within & block.are_boxes(simd)
        } else {
            within
        };
        (within.to_bitmask() as u32, squared)
    }

    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, limit: f32) -> Option<f32> {
        let squared = self.gap_squared(aabb);
        (squared <= self.bound(limit).0).then_some(squared)
    }

    fn anchor(&self, aabb: &Aabb3d, _: f32) -> Vec3A {
        self.from.min.clamp(aabb.min, aabb.max)
    }
}
