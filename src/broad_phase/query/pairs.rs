//! Pairs that are near each other: of two groups, or of one with itself.

use std::{cell::Cell, ops::ControlFlow};

use bevy::math::bounding::Aabb3d;

use super::flow::Flow;
use crate::broad_phase::{
    boxes::{Gap, ProxyId, distance as distance_of},
    index::SpatialIndex,
    linear_octree::{LinearOctree, NeighborBuffers},
};

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
                let gap = distance_of(aabb, other);
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

/// # Pairs within a group
impl SpatialIndex {
    /// Calls `found` with every pair of objects of a group whose boxes are no farther apart than
    /// `distance`, in a straight line, and with their distance: 0 for boxes that overlap or touch.
    ///
    /// The group is told by a predicate, which is asked once about each object. Each pair is told
    /// once, its lower handle first. Unbounded objects make none. [Pair
    /// filters](crate::broad_phase::PairFilter) are not asked.
    ///
    /// In an order that depends on the history of the index alone.
    ///
    /// With a [`LinearOctree`], one join of the tree with itself, on all threads with the feature
    /// `multi_threaded`: some nanoseconds for each object, and for each pair. One query for each
    /// member where these are few among others, or with another broad phase. Pairs are searched for
    /// before the first is told; buffers for them stay with the thread. A distance that is negative
    /// or NaN finds nothing; an infinite one, all pairs.
    ///
    /// ```
    /// use bevy::math::{Vec3, bounding::Aabb3d};
    /// use bevy_octree::broad_phase::SpatialIndex;
    ///
    /// let mut index = SpatialIndex::default();
    /// let mut cube = |x: f32| index.insert(Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)));
    /// let (a, b, c) = (cube(0.0)?, cube(3.0)?, cube(9.0)?);
    /// index.update();
    ///
    /// let mut found = vec![];
    /// index.for_each_pair_among(5.0, |_| true, |a, b, distance| found.push((a, b, distance)));
    /// found.sort_by_key(|(a, b, _)| (*a, *b));
    /// assert_eq!(found, [(a, b, 2.0), (b, c, 5.0)]);
    /// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
    /// ```
    #[doc(alias("neighbors", "boids", "flocking", "self-join", "spatial hash"))]
    pub fn for_each_pair_among<F: Flow>(
        &self,
        distance: f32,
        is_member: impl FnMut(ProxyId) -> bool,
        mut found: impl FnMut(ProxyId, ProxyId, f32) -> F,
    ) {
        with_gaps(|gaps| {
            self.find_gaps(distance, is_member, gaps);
            let mut gaps = gaps.iter();
            while let Some(Gap { a, b, distance }) = gaps.next().copied()
                && found(a, b, distance).goes_on()
            {}
        });
    }

    /// Finds every pair of objects of a group whose boxes are no farther apart than `distance`: see
    /// [`for_each_pair_among`](Self::for_each_pair_among). They replace what is in `gaps`.
    pub(crate) fn find_gaps(
        &self,
        distance: f32,
        mut is_member: impl FnMut(ProxyId) -> bool,
        gaps: &mut Vec<Gap>,
    ) {
        gaps.clear();
        if distance.is_nan() || distance < 0.0 {
            return;
        }
        let mut buffers = BUFFERS.take().unwrap_or_default();
        let Buffers { members, join, .. } = &mut *buffers;
        members.clear();
        members.resize(self.proxies().capacity(), false);
        let mut count = 0;
        for (id, _) in self.proxies().iter() {
            let is_one = is_member(id);
            members[id.index()] = is_one;
            count += usize::from(is_one);
        }
        let is_member = |id: ProxyId| members.get(id.index()).is_some_and(|is_one| *is_one);
        match self.linear() {
            Some(linear)
                if distance < LinearOctree::FARTHEST
                    && count * SEARCHED_SHARE > self.proxies().len() =>
            {
                linear.find_neighbors(self.proxies(), distance, &is_member, join, gaps);
            }
            _ => self.search_gaps(distance, is_member, gaps),
        }
        BUFFERS.set(Some(buffers));
    }

    /// One query for each member.
    fn search_gaps(&self, distance: f32, is_member: impl Fn(ProxyId) -> bool, gaps: &mut Vec<Gap>) {
        let members = || self.proxies().iter().filter(|(id, _)| is_member(*id));
        for (a, aabb) in members() {
            self.for_each_overlapping(&grown(aabb, distance), |b| {
                let other = self.proxies().get(b).filter(|_| a < b && is_member(b));
                let Some(apart) = other.map(|other| distance_of(aabb, other)) else {
                    return;
                };
                if apart <= distance {
                    gaps.push(Gap {
                        a,
                        b,
                        distance: apart,
                    });
                }
            });
        }
    }
}

/// One query for each member takes less than a join of all, if no more than one in so many objects
/// is a member.
const SEARCHED_SHARE: usize = 16;

/// Memory that outlives a search for pairs.
#[derive(Default)]
struct Buffers {
    /// By handle.
    members: Vec<bool>,
    join: NeighborBuffers,
    gaps: Vec<Gap>,
}

thread_local! {
    static BUFFERS: Cell<Option<Box<Buffers>>> = const { Cell::new(None) };
}

/// Lends this thread's list of pairs. A search within a search, from a caller's callback, gets a new
/// one.
pub(crate) fn with_gaps<T>(f: impl FnOnce(&mut Vec<Gap>) -> T) -> T {
    let mut buffers = BUFFERS.take().unwrap_or_default();
    let mut gaps = std::mem::take(&mut buffers.gaps);
    BUFFERS.set(Some(buffers));
    let result = f(&mut gaps);
    let mut buffers = BUFFERS.take().unwrap_or_default();
    buffers.gaps = gaps;
    BUFFERS.set(Some(buffers));
    result
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
