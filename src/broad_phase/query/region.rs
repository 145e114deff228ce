//! Regions: parts of space that boxes overlap, or not.

use bevy::math::{
    Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{HalfSpace, ViewFrustum},
};
use fearless_simd::{f32x8, mask32x8, prelude::*};

use super::point_distance::PointDistance;
use crate::broad_phase::{
    block::Block,
    boxes::overlap,
    measure::{Bound, Measure},
};

/// A part of space that
/// [`for_each_overlapping`](crate::broad_phase::SpatialIndex::for_each_overlapping) looks into.
/// Touching counts as overlapping.
///
/// - [`Aabb3d`]: a box. One that is inverted along an axis, or NaN, overlaps nothing.
/// - [`BoundingSphere`]: a ball. One with a negative radius, or NaN, overlaps nothing.
/// - [`Vec3`], [`Vec3A`]: a point. NaN is in no box.
/// - [`ViewFrustum`], [`[HalfSpace]`](HalfSpace): what lies on the inner side of all planes. As is
///   usual, a box overlaps it unless it lies beyond a single plane: large boxes near an edge may be
///   found though they are outside. Nothing is inside a plane that is NaN; no planes at all are all
///   of space.
pub trait Region: Measured {}

/// The measure behind a region.
pub trait Measured {
    /// Its type.
    type Measure<'a>: Measure
    where
        Self: 'a;

    /// The measure, and the distance within which boxes overlap the region.
    fn measure(&self) -> (Self::Measure<'_>, f32);
}

impl Region for Aabb3d {}
impl Measured for Aabb3d {
    type Measure<'a> = Overlap;

    fn measure(&self) -> (Overlap, f32) {
        // Lanes without a box are at infinity, where no box is.
        let finite = Self {
            min: self.min.max(Vec3A::MIN),
            max: self.max.min(Vec3A::MAX),
        };
        // An inverted box would overlap those that hold it.
        let is_box = self.min.cmple(self.max).all() && finite.min.cmple(finite.max).all();
        (Overlap(finite), if is_box { 0.0 } else { f32::NAN })
    }
}

impl Region for Vec3A {}
impl Measured for Vec3A {
    type Measure<'a> = Overlap;

    fn measure(&self) -> (Overlap, f32) {
        Aabb3d {
            min: *self,
            max: *self,
        }
        .measure()
    }
}

impl Region for Vec3 {}
impl Measured for Vec3 {
    type Measure<'a> = Overlap;

    fn measure(&self) -> (Overlap, f32) {
        Vec3A::from(*self).measure()
    }
}

impl Region for BoundingSphere {}
impl Measured for BoundingSphere {
    type Measure<'a> = PointDistance<false>;

    fn measure(&self) -> (PointDistance<false>, f32) {
        PointDistance::new(self.center, self.radius())
    }
}

impl Region for [HalfSpace] {}
impl Measured for [HalfSpace] {
    type Measure<'a> = Inside<'a>;

    fn measure(&self) -> (Inside<'_>, f32) {
        (Inside(self), 0.0)
    }
}

impl Region for ViewFrustum {}
impl Measured for ViewFrustum {
    type Measure<'a> = Inside<'a>;

    fn measure(&self) -> (Inside<'_>, f32) {
        self.half_spaces[..].measure()
    }
}

/// Boxes that overlap a box.
pub struct Overlap(Aabb3d);

impl Overlap {
    /// Returns the measure of a box that is finite; boxes that overlap it are at a distance of 0.
    #[inline(always)]
    pub fn new(aabb: Aabb3d) -> Self {
        Self(aabb)
    }
}

impl Measure for Overlap {
    const ORDERED: bool = false;
    const EXACT: bool = true;

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, _: Bound) -> (u32, f32x8<S>) {
        (
            block.overlaps(simd, self.0.min.to_array(), self.0.max.to_array()),
            f32x8::splat(simd, 0.0),
        )
    }

    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, _: f32) -> Option<f32> {
        overlap(&self.0, aabb).then_some(0.0)
    }

    fn anchor(&self, aabb: &Aabb3d, _: f32) -> Vec3A {
        self.0.min.max(aabb.min)
    }
}

/// Boxes with a part on the inner side of each plane.
pub struct Inside<'a>(&'a [HalfSpace]);

/// How far the innermost corner of a box is on the inner side of a plane.
#[inline(always)]
fn depth(plane: &HalfSpace, aabb: &Aabb3d) -> f32 {
    let [x, y, z] = (innermost(plane, aabb) * plane.normal()).to_array();
    x + y + z + plane.d()
}

/// The corner of a box that is farthest on the inner side of a plane.
#[inline(always)]
fn innermost(plane: &HalfSpace, aabb: &Aabb3d) -> Vec3A {
    Vec3A::select(plane.normal().cmpge(Vec3A::ZERO), aabb.max, aabb.min)
}

impl Measure for Inside<'_> {
    const ORDERED: bool = false;
    const EXACT: bool = true;

    #[inline(always)]
    fn test_block<S: Simd>(&self, simd: S, block: &Block, _: Bound) -> (u32, f32x8<S>) {
        let zero = f32x8::splat(simd, 0.0);
        // Lanes without a box are inverted without end.
        let mut hits: mask32x8<S> = block
            .side(simd, false, 0)
            .simd_le(block.side(simd, true, 0));
        for plane in self.0 {
            let normal = plane.normal().to_array();
            let term = |axis: usize| {
                block.side(simd, normal[axis] >= 0.0, axis) * f32x8::splat(simd, normal[axis])
            };
            let depth = term(0) + term(1) + term(2) + f32x8::splat(simd, plane.d());
            hits &= depth.simd_ge(zero);
        }
        (hits.to_bitmask() as u32, zero)
    }

    #[inline(always)]
    fn test_box(&self, aabb: &Aabb3d, _: f32) -> Option<f32> {
        self.0
            .iter()
            .all(|plane| depth(plane, aabb) >= 0.0)
            .then_some(0.0)
    }

    fn anchor(&self, aabb: &Aabb3d, _: f32) -> Vec3A {
        self.0
            .first()
            .map_or(aabb.min, |plane| innermost(plane, aabb))
    }

    /// A box may have its part inside one plane in one cell, and that inside another plane in
    /// another: only the plane that the anchor is chosen by can rule a cell out.
    fn test_cell(&self, cell: &Aabb3d, _: f32) -> bool {
        // Zero times infinity rules nothing out.
        self.0
            .first()
            .map(|plane| depth(plane, cell))
            .is_none_or(|depth| depth >= 0.0 || depth.is_nan())
    }
}
