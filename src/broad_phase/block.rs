//! Eight boxes at once: the unit in which boxes are compared.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, mask32x8, prelude::*};

/// How many boxes a block holds.
pub const WIDTH: usize = 8;

/// All lanes of a block.
pub(super) const ALL: u32 = (1 << WIDTH) - 1;

/// Eight boxes, coordinate by coordinate.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Block {
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
}

impl Block {
    /// Eight boxes that overlap nothing.
    pub(super) const EMPTY: Self = Self {
        min: [[f32::INFINITY; WIDTH]; 3],
        max: [[f32::NEG_INFINITY; WIDTH]; 3],
    };

    /// The boxes around the first so many of eight triangles, by corner and axis.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "plain loops become eight lanes; calls with closures did not, and took twice as long"
    )]
    pub(super) fn around(corners: &[[[f32; WIDTH]; 3]; 3], count: usize) -> Self {
        let mut block = Self::EMPTY;
        let lower = |a: f32, b: f32| if a < b { a } else { b };
        let upper = |a: f32, b: f32| if a > b { a } else { b };
        for axis in 0..3 {
            for lane in 0..WIDTH {
                let [a, b, c] = [0, 1, 2].map(|corner| corners[corner][axis][lane]);
                block.min[axis][lane] = lower(lower(a, b), c);
                block.max[axis][lane] = upper(upper(a, b), c);
            }
            for lane in count..WIDTH {
                block.min[axis][lane] = f32::INFINITY;
                block.max[axis][lane] = f32::NEG_INFINITY;
            }
        }
        block
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, aabb: &Aabb3d) {
        let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
        for axis in 0..3 {
            self.min[axis][lane] = min[axis];
            self.max[axis][lane] = max[axis];
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Aabb3d {
        let corner =
            |side: &[[f32; WIDTH]; 3]| Vec3A::new(side[0][lane], side[1][lane], side[2][lane]);
        Aabb3d {
            min: corner(&self.min),
            max: corner(&self.max),
        }
    }

    /// Returns `true` if a box is within the one in a lane.
    #[inline(always)]
    pub(super) fn holds(&self, lane: usize, aabb: &Aabb3d) -> bool {
        let outer = self.get(lane);
        (outer.min.cmple(aabb.min) & outer.max.cmpge(aabb.max)).all()
    }

    /// Which of the eight hold the box in the same lane of another block: a bit for each.
    #[inline(always)]
    pub(super) fn holds_all<S: Simd>(&self, simd: S, inner: &Self) -> u32 {
        let lanes = |side: &[[f32; WIDTH]; 3], axis: usize| f32x8::from_slice(simd, &side[axis]);
        let min = |axis| lanes(&self.min, axis).simd_le(lanes(&inner.min, axis));
        let max = |axis| lanes(&self.max, axis).simd_ge(lanes(&inner.max, axis));
        ((min(0) & min(1) & min(2)) & (max(0) & max(1) & max(2))).to_bitmask() as u32
    }

    /// The bounds of all eight.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Aabb3d {
        let fold = |lanes: &[f32; WIDTH], pick: fn(f32, f32) -> f32| {
            let four: [f32; 4] = std::array::from_fn(|lane| pick(lanes[lane], lanes[lane + 4]));
            pick(pick(four[0], four[2]), pick(four[1], four[3]))
        };
        let lower = |a: f32, b: f32| if a < b { a } else { b };
        let upper = |a: f32, b: f32| if a > b { a } else { b };
        Aabb3d {
            min: Vec3A::from_array(std::array::from_fn(|axis| fold(&self.min[axis], lower))),
            max: Vec3A::from_array(std::array::from_fn(|axis| fold(&self.max[axis], upper))),
        }
    }

    /// The sum of each box's sides, of which each may be too large a number; nothing for one that
    /// is empty.
    #[inline(always)]
    pub(super) fn side_sums(&self) -> [f32; WIDTH] {
        let side = |axis: usize, lane: usize| self.max[axis][lane] - self.min[axis][lane];
        std::array::from_fn(|lane| {
            (side(0, lane) + side(1, lane) + side(2, lane)).clamp(0.0, f32::MAX)
        })
    }

    /// How many of the eight are not empty.
    pub(super) fn count(&self) -> u32 {
        (0..WIDTH)
            .map(|lane| u32::from(self.min[0][lane] <= self.max[0][lane]))
            .sum()
    }

    /// The lower or the upper sides of all eight along an axis.
    #[inline(always)]
    pub(super) fn side<S: Simd>(&self, simd: S, upper: bool, axis: usize) -> f32x8<S> {
        let sides = if upper { &self.max } else { &self.min };
        f32x8::from_slice(simd, &sides[axis])
    }

    /// How far each of the eight is from an interval along an axis; 0 if they overlap.
    #[inline(always)]
    pub(super) fn gaps_along<S: Simd>(
        &self,
        simd: S,
        axis: usize,
        low: f32,
        high: f32,
    ) -> f32x8<S> {
        let below = self.side(simd, false, axis) - f32x8::splat(simd, high);
        let above = f32x8::splat(simd, low) - self.side(simd, true, axis);
        below.max(above).max(f32x8::splat(simd, 0.0))
    }

    /// Which lanes hold a box, as a mask: those without one are infinitely far away.
    #[inline(always)]
    pub(super) fn are_boxes<S: Simd>(&self, simd: S) -> mask32x8<S> {
        self.side(simd, false, 0).simd_le(self.side(simd, true, 0))
    }

    /// Which of the eight overlap an interval along an axis, touching included: a bit for each.
    #[inline(always)]
    pub(super) fn overlaps_along<S: Simd>(&self, simd: S, axis: usize, low: f32, high: f32) -> u32 {
        let below = self
            .side(simd, false, axis)
            .simd_le(f32x8::splat(simd, high));
        let above = self.side(simd, true, axis).simd_ge(f32x8::splat(simd, low));
        (below & above).to_bitmask() as u32
    }

    /// Which of the eight a box overlaps, touching included: a bit for each.
    #[inline(always)]
    pub(super) fn overlaps<S: Simd>(&self, simd: S, min: [f32; 3], max: [f32; 3]) -> u32 {
        let below = |axis: usize| {
            f32x8::from_slice(simd, &self.min[axis]).simd_le(f32x8::splat(simd, max[axis]))
        };
        let above = |axis: usize| {
            f32x8::from_slice(simd, &self.max[axis]).simd_ge(f32x8::splat(simd, min[axis]))
        };
        let x = below(0) & above(0);
        let y = below(1) & above(1);
        let z = below(2) & above(2);
        (x & y & z).to_bitmask() as u32
    }

    /// Which of the eight the box in a lane of another block overlaps.
    #[inline(always)]
    pub(super) fn overlaps_lane<S: Simd>(&self, simd: S, other: &Self, lane: usize) -> u32 {
        let corner = |side: &[[f32; WIDTH]; 3]| std::array::from_fn(|axis| side[axis][lane]);
        self.overlaps(simd, corner(&other.min), corner(&other.max))
    }
    /// Which of the eight are within a distance of the box in a lane of another block, axis by
    /// axis; rounding leaves none out. The distance is to be less than 10³⁰, so that lanes without
    /// a box are near none.
    #[inline(always)]
    pub(super) fn within_lane<S: Simd>(
        &self,
        simd: S,
        other: &Self,
        lane: usize,
        distance: f32,
    ) -> u32 {
        let by =
            |side: f32| (side.abs().min(f32::MAX) + distance) * (2.0 * f32::EPSILON) + distance;
        let below = |axis: usize| other.min[axis][lane] - by(other.min[axis][lane]);
        let above = |axis: usize| other.max[axis][lane] + by(other.max[axis][lane]);
        self.overlaps(simd, std::array::from_fn(below), std::array::from_fn(above))
    }
}
