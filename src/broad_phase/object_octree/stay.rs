//! The fast test: can an object's list of leaves have changed?

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::cell::Cell;

/// Where a box may go while the leaves that it overlaps stay the same.
///
/// The report tests whether a box lies completely within its node; this is the same test for boxes
/// that straddle borders too. The lower corner may move between the nearest plane below it that it
/// must not cross and the nearest inner plane that it must not pass; the upper corner likewise.
/// Both limits come from the cells of the leaves.
///
/// Why it is enough: each of the leaves still overlaps the box, by the inner limits. And the region
/// between the outer limits is covered by the leaves: from any point of it, the nearest point of
/// the old box lies in one of them, and that one reaches as far as the outer limit on each axis
/// that the point had to be moved along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StayRegion {
    /// The lower corner stays at or above this,
    outer_min: Vec3A,
    /// and below this.
    inner_min: Vec3A,
    /// The upper corner stays at or above this,
    inner_max: Vec3A,
    /// and below this.
    outer_max: Vec3A,
}

impl StayRegion {
    /// No box stays here.
    pub(super) const NOWHERE: Self = Self {
        outer_min: Vec3A::INFINITY,
        inner_min: Vec3A::NEG_INFINITY,
        inner_max: Vec3A::INFINITY,
        outer_max: Vec3A::NEG_INFINITY,
    };

    /// The region of a box that overlaps these cells and no others.
    pub(super) fn new<'a>(aabb: &Aabb3d, cells: impl Iterator<Item = &'a Cell>) -> Self {
        let mut region = Self {
            outer_min: Vec3A::NEG_INFINITY,
            inner_min: Vec3A::INFINITY,
            inner_max: Vec3A::NEG_INFINITY,
            outer_max: Vec3A::INFINITY,
        };
        for cell in cells {
            let Aabb3d { min: lo, max: hi } = cell.bounds();
            let reaches_below = lo.cmple(aabb.min);
            let reaches_above = hi.cmpgt(aabb.max);
            region.outer_min =
                region
                    .outer_min
                    .max(Vec3A::select(reaches_below, lo, Vec3A::NEG_INFINITY));
            region.outer_max =
                region
                    .outer_max
                    .min(Vec3A::select(reaches_above, hi, Vec3A::INFINITY));
            region.inner_min = region.inner_min.min(hi);
            region.inner_max = region.inner_max.max(lo);
        }
        region
    }

    /// The part of the region in which the box does not leave another, the root, if that is to grow
    /// with it.
    pub(super) fn within(mut self, root: Option<&Aabb3d>) -> Self {
        if let Some(root) = root {
            self.outer_min = self.outer_min.max(root.min);
            self.outer_max = self.outer_max.min(root.max);
        }
        self
    }

    /// Returns `true` if the object keeps its leaves with this box.
    #[inline]
    pub(super) fn holds(&self, aabb: &Aabb3d) -> bool {
        (aabb.min.cmpge(self.outer_min)
            & aabb.min.cmplt(self.inner_min)
            & aabb.max.cmpge(self.inner_max)
            & aabb.max.cmplt(self.outer_max))
        .all()
    }
}
