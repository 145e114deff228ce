//! Casts: what a ray, or a box that moves without turning, meets along its way.

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, AabbCast3d, RayCast3d},
};
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::{
    block::Block,
    measure::{Bound, Measure},
};

/// What [`SpatialIndex::cast`](crate::broad_phase::SpatialIndex::cast) and its kin send through
/// space: a [`RayCast3d`], or an [`AabbCast3d`], which is a box that moves without turning.
/// Distances are along the ray, so that for a moving box they are the way that it goes before it
/// touches.
///
/// Touching counts: a ray within the side of a box meets it. A cast that is not finite, but for
/// `max`, meets nothing, and so does one with a `max` that is negative or NaN, or a moving box that
/// is inverted.
pub trait Cast: Sweeping {}

/// The measure behind a cast.
pub trait Sweeping {
    /// The measure, and how far the cast goes.
    fn sweep(&self) -> (Sweep, f32);
}

impl Cast for RayCast3d {}
impl Sweeping for RayCast3d {
    fn sweep(&self) -> (Sweep, f32) {
        Sweep::new(self, Vec3A::ZERO, Vec3A::ZERO)
    }
}

impl Cast for AabbCast3d {}
impl Sweeping for AabbCast3d {
    fn sweep(&self) -> (Sweep, f32) {
        Sweep::new(&self.ray, self.aabb.min, self.aabb.max)
    }
}

/// A box on its way, or a point: the slab test, for axes along which it moves, and an overlap for
/// those along which it does not.
pub struct Sweep {
    origin: Vec3A,
    direction: Vec3A,
    reciprocal: [f32; 3],
    /// By axis: the sides of the moving box, at the origin, that are ahead and behind on its way.
    ahead: [f32; 3],
    behind: [f32; 3],
    /// Along which axes does it move backwards, and along which not at all?
    backward: [bool; 3],
    still: [bool; 3],
    any_still: bool,
}

impl Sweep {
    fn new(ray: &RayCast3d, min: Vec3A, max: Vec3A) -> (Self, f32) {
        Self::along(ray.origin, ray.direction.into(), min, max, ray.max)
    }

    /// A box around a point that moves by `direction` in each unit of distance.
    pub(crate) fn along(
        origin: Vec3A,
        direction: Vec3A,
        min: Vec3A,
        max: Vec3A,
        limit: f32,
    ) -> (Self, f32) {
        let reciprocal = direction.recip();
        let is_still = !reciprocal.is_finite_mask();
        let is_backward = reciprocal.cmplt(Vec3A::ZERO);
        let (min, max) = (origin + min, origin + max);
        let sweep = Self {
            origin,
            direction,
            reciprocal: reciprocal.to_array(),
            ahead: Vec3A::select(is_backward, min, max).to_array(),
            behind: Vec3A::select(is_backward, max, min).to_array(),
            backward: is_backward.into(),
            still: is_still.into(),
            any_still: is_still.any(),
        };
        let is_finite = min.is_finite_mask() & max.is_finite_mask() & direction.is_finite_mask();
        let is_fine = (is_finite & min.cmple(max)).all();
        (sweep, if is_fine { limit } else { f32::NAN })
    }
}

impl Sweep {
    fn low(&self, axis: usize) -> f32 {
        self.ahead[axis].min(self.behind[axis])
    }

    fn high(&self, axis: usize) -> f32 {
        self.ahead[axis].max(self.behind[axis])
    }
}

impl Measure for Sweep {
    const ORDERED: bool = true;
    const EXACT: bool = true;

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, bound: Bound) -> (u32, f32x8<S>) {
        let splat = |value: f32| f32x8::splat(simd, value);
        let (mut enter, mut leave) = (splat(0.0), bound.splat(simd));
        let mut slab = |axis: usize| {
            let (backward, reciprocal) = (self.backward[axis], splat(self.reciprocal[axis]));
            enter = enter
                .max((block.side(simd, backward, axis) - splat(self.ahead[axis])) * reciprocal);
            leave = leave
                .min((block.side(simd, !backward, axis) - splat(self.behind[axis])) * reciprocal);
        };
        let mut hits = u32::MAX;
        if self.any_still {
            for axis in 0..3 {
                if self.still[axis] {
                    hits &= block.overlaps_along(simd, axis, self.low(axis), self.high(axis));
                } else {
                    slab(axis);
                }
            }
        } else {
            slab(0);
            slab(1);
            slab(2);
        }
        let hits = hits & enter.simd_le(leave).to_bitmask() as u32;
        // Which zero is the larger one, is not the same on all machines.
        (hits, enter + splat(0.0))
    }

    /// The same operations as for eight, so that a box is met if its bounds are.
    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, limit: f32) -> Option<f32> {
        let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
        let (mut enter, mut leave) = (0.0_f32, limit);
        for axis in 0..3 {
            if self.still[axis] {
                if !(min[axis] <= self.high(axis) && max[axis] >= self.low(axis)) {
                    return None;
                }
            } else {
                let (near, far) = if self.backward[axis] {
                    (max[axis], min[axis])
                } else {
                    (min[axis], max[axis])
                };
                enter = enter.max((near - self.ahead[axis]) * self.reciprocal[axis]);
                leave = leave.min((far - self.behind[axis]) * self.reciprocal[axis]);
            }
        }
        // Not -0.
        (enter <= leave).then_some(enter + 0.0)
    }

    fn anchor(&self, aabb: &Aabb3d, distance: f32) -> Vec3A {
        let corner = Vec3A::from_array(self.behind) + self.direction * distance.min(f32::MAX);
        corner.max(aabb.min).min(aabb.max)
    }

    /// The anchor is a rounded point of the way, so that its cell may be next to one that the way
    /// goes through.
    fn test_cell(&self, cell: &Aabb3d, limit: f32) -> bool {
        let size = self.origin.abs()
            + Vec3A::from_array(self.ahead).abs()
            + Vec3A::from_array(self.behind).abs();
        let slack = |corner: Vec3A| (size + corner.abs()) * (16.0 * f32::EPSILON);
        self.test_box(
            &Aabb3d {
                min: cell.min - slack(cell.min),
                max: cell.max + slack(cell.max),
            },
            limit,
        )
        .is_some()
    }

    fn viewpoint(&self) -> Vec3A {
        Vec3A::select(
            self.direction.cmpge(Vec3A::ZERO),
            Vec3A::NEG_INFINITY,
            Vec3A::INFINITY,
        )
    }
}
