//! What a query asks of a box.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use super::block::Block;

/// How far away boxes are, in the sense of a query, and whether they are of interest at all.
///
/// A box inside another is never nearer than that one, to the last bit: bounds of many boxes are
/// tested like boxes.
///
/// There are two kinds of numbers, for single boxes and for blocks:
///
/// | | said of | near a point | along a cast | in a region |
/// |---|---|---|---|---|
/// | *distance*, with a *limit* | a box, an object | in a straight line | along the way | 0, within 0 |
/// | *nearness*, with a [`Bound`] | a box in a block, a block | the distance, squared | the distance | 0, within 0 |
///
/// Nearness is quick to compute for eight boxes at once, and puts boxes in the same order;
/// [`bound`](Self::bound) leads from a limit to the bound that goes with it.
pub trait Measure {
    /// Are near boxes to be visited first?
    const ORDERED: bool;

    /// Does [`test_block`](Self::test_block) give the very verdicts of
    /// [`test_box`](Self::test_box), and is nearness distance?
    const EXACT: bool;

    /// Returns the bound that leaves out no box within a distance, whatever rounding does.
    #[inline(always)]
    fn bound(&self, limit: f32) -> Bound {
        Bound(limit)
    }

    /// Returns which of eight boxes are within the bound, a bit for each, and how near they are.
    /// None of that is NaN or minus zero.
    fn test_block<S: Simd>(&self, simd: S, block: &Block, bound: Bound) -> (u32, f32x8<S>);

    /// Returns the distance of a box, if it is no farther than `limit`.
    fn test_box(&self, aabb: &Aabb3d, limit: f32) -> Option<f32>;

    /// Returns a point of a box that is within `limit`, by which the box is known among the cells
    /// that list it. The cell in which it lies passes [`test_cell`](Self::test_cell).
    fn anchor(&self, aabb: &Aabb3d, distance: f32) -> Vec3A;

    /// Returns `true` if the anchor of a box that is no farther than `limit` may lie in this cell.
    /// Its corners may be infinite.
    fn test_cell(&self, cell: &Aabb3d, limit: f32) -> bool {
        self.test_box(cell, limit).is_some()
    }

    /// Returns the point from which to look: see
    /// [`Visitor::viewpoint`](crate::broad_phase::Visitor::viewpoint).
    fn viewpoint(&self) -> Vec3A {
        Vec3A::NEG_INFINITY
    }
}

/// The greatest nearness that is of interest, in the unit of the [`Measure`] that it comes from.
#[derive(Clone, Copy, Debug)]
pub struct Bound(pub f32);

impl Bound {
    /// Returns `true` if what is so near is beyond the bound.
    #[inline(always)]
    pub fn excludes(self, nearness: f32) -> bool {
        nearness > self.0
    }

    /// Returns the bound of eight boxes.
    #[inline(always)]
    pub fn splat<S: Simd>(self, simd: S) -> f32x8<S> {
        f32x8::splat(simd, self.0)
    }
}
