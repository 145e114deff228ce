//! What a query asks of a box.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use super::block::Block;

/// How far away boxes are, in the sense of a query, and whether they are of interest at all.
///
/// A box inside another is never nearer than that one, to the last bit: bounds of many boxes are tested like boxes.
pub trait Measure {
    /// Are near boxes to be visited first? If not, all distances are 0.
    const ORDERED: bool;

    /// Does [`eight`](Self::eight) give the very verdicts and distances of [`one`](Self::one)?
    const EXACT: bool;

    /// What [`eight`](Self::eight) compares with, for boxes within a distance. Never too small for rounding.
    #[inline(always)]
    fn bound(&self, distance: f32) -> f32 {
        distance
    }

    /// Which of eight boxes are within the bound, a bit for each, and numbers that put them in order and can be compared
    /// with a bound. None are NaN.
    fn eight<S: Simd>(&self, simd: S, block: &Block, bound: f32) -> (u32, f32x8<S>);

    /// The distance of a box, if it is no farther than `limit`.
    fn one(&self, aabb: &Aabb3d, limit: f32) -> Option<f32>;

    /// A point of a box that is within `limit`, by which the box is known among the cells that list it. The cell in
    /// which it lies passes [`cell`](Self::cell).
    fn anchor(&self, aabb: &Aabb3d, distance: f32) -> Vec3A;

    /// May the anchor of a box that is no farther than `limit` lie in this cell? Its corners may be infinite.
    fn cell(&self, cell: &Aabb3d, limit: f32) -> bool {
        self.one(cell, limit).is_some()
    }

    /// The place from which to look: see [`Visitor::viewpoint`](crate::broad_phase::Visitor::viewpoint).
    fn viewpoint(&self) -> Vec3A {
        Vec3A::NEG_INFINITY
    }
}
