//! How far boxes reach along a direction.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::{
    block::Block,
    measure::{Bound, Measure},
};

/// How much less far than a given height boxes reach along a direction, those first that reach
/// furthest: a search for what is highest.
#[derive(Clone, Copy)]
pub struct Height {
    up: Vec3A,
    from: f32,
}

impl Height {
    /// Returns the measure below a height that no box is beyond, or hardly. All has to be finite.
    #[inline(always)]
    pub fn new(up: Vec3A, from: f32) -> Self {
        Self { up, from }
    }

    #[inline(always)]
    fn below(&self, aabb: &Aabb3d) -> f32 {
        let corner = Vec3A::select(self.up.cmpge(Vec3A::ZERO), aabb.max, aabb.min);
        let [x, y, z] = (corner * self.up).to_array();
        (self.from - (x + y + z)).max(0.0)
    }
}

impl Measure for Height {
    const ORDERED: bool = true;
    const EXACT: bool = true;

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, bound: Bound) -> (u32, f32x8<S>) {
        let up = self.up.to_array();
        let along =
            |axis: usize| block.side(simd, up[axis] >= 0.0, axis) * f32x8::splat(simd, up[axis]);
        let height = along(0) + along(1) + along(2);
        let zero = f32x8::splat(simd, 0.0);
        let below = (f32x8::splat(simd, self.from) - height).max(zero) + zero;
        let within = below.simd_le(bound.splat(simd));
        // Lanes without a box are infinitely far below, or NaN.
        let is_box = block
            .side(simd, false, 0)
            .simd_le(block.side(simd, true, 0));
        ((within & is_box).to_bitmask() as u32, below)
    }

    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, limit: f32) -> Option<f32> {
        let below = self.below(aabb);
        (below <= limit).then_some(below)
    }

    fn anchor(&self, aabb: &Aabb3d, _: f32) -> Vec3A {
        Vec3A::select(self.up.cmpge(Vec3A::ZERO), aabb.max, aabb.min)
    }
}
