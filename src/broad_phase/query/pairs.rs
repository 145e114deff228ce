//! Pairs of two groups that are near each other.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;

use super::{flow::Flow, point_distance};
use crate::broad_phase::{boxes::ProxyId, index::SpatialIndex};

/// # Pairs of two groups
impl SpatialIndex {
    /// Calls `found` with every pair of an object of a first group and one of a second whose boxes
    /// are no farther apart than `distance`, in a straight line, and with their distance: 0 for
    /// boxes that overlap or touch.
    ///
    /// The groups are told by predicates, and may share members. No object makes a pair with
    /// itself, and a pair that could be told in either order is told once, by its lower handle
    /// first. [Pair filters](crate::broad_phase::PairFilter) are not asked.
    ///
    /// In the order of the handles of the first group; the partners of one as the broad phase comes
    /// upon them, which depends on the history of the index alone.
    ///
    /// One query for each member of the first group, which had better be the smaller one, around
    /// its grown box; both predicates are asked about the objects that are found there. Allocates
    /// nothing. A distance that is negative or NaN finds nothing; an infinite one, all pairs.
    ///
    /// ```
    /// use bevy::math::{Vec3, bounding::Aabb3d};
    /// use bevy_octree::broad_phase::SpatialIndex;
    ///
    /// let mut index = SpatialIndex::default();
    /// let mut cube = |x: f32| index.insert(Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)));
    /// let (wolf, sheep, other) = (cube(0.0)?, cube(3.0)?, cube(9.0)?);
    /// index.update();
    ///
    /// let mut found = vec![];
    /// index.for_each_pair_within(5.0, |id| id == wolf, |id| id != wolf, |a, b, distance| found.push((a, b, distance)));
    /// assert_eq!(found, [(wolf, sheep, 2.0)]);
    /// # let _ = other;
    /// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
    /// ```
    pub fn for_each_pair_within<F: Flow>(
        &self,
        distance: f32,
        mut is_first: impl FnMut(ProxyId) -> bool,
        mut is_second: impl FnMut(ProxyId) -> bool,
        mut found: impl FnMut(ProxyId, ProxyId, f32) -> F,
    ) {
        if distance.is_nan() || distance < 0.0 {
            return;
        }
        for (a, aabb) in self.proxies().iter() {
            if !is_first(a) {
                continue;
            }
            let mut goes_on = true;
            self.for_each_overlapping(&grown(aabb, distance), |b| {
                let Some(other) = self.proxies().get(b).filter(|_| a != b && is_second(b)) else {
                    return ControlFlow::Continue(());
                };
                let gap = point_distance::distance(aabb, other);
                // The other way round it was told when its turn came.
                if gap <= distance && !(b < a && is_first(b) && is_second(a)) {
                    goes_on = found(a, b, gap).goes_on();
                }
                if goes_on {
                    ControlFlow::Continue(())
                } else {
                    ControlFlow::Break(())
                }
            });
            if !goes_on {
                return;
            }
        }
    }
}

/// A box and all within a distance of it, rounding included.
fn grown(aabb: &Aabb3d, distance: f32) -> Aabb3d {
    let far = aabb.min.abs().max(aabb.max.abs()) + distance;
    let by = far * (2.0 * f32::EPSILON) + distance;
    Aabb3d {
        min: aabb.min - by,
        max: aabb.max + by,
    }
}
