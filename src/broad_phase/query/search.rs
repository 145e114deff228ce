//! The queries of an index.

use std::{any::Any, ops::ControlFlow};

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

use super::{
    cast::Cast,
    flow::Flow,
    hit::Hit,
    lists::{self, HitLists},
    point_distance::PointDistance,
    region::Region,
};
use crate::broad_phase::{
    boxes::ProxyId, engine::Visitor, index::SpatialIndex, linear_octree::LinearOctree,
    measure::Measure,
};

/// # Queries
///
/// Written once, with the same answers whatever the broad phase. None allocates, and none panics:
/// bad input finds nothing. They are fastest with a [`LinearOctree`], whose blocks they search
/// eight boxes at a time.
///
/// Unbounded objects are found by each, at a distance of 0, wherever they are: what lies where is
/// for `distance`, or `found`, to say.
///
/// They see the boxes as of the last [`update`](Self::update). Of an object that changed since, a
/// query may see the old box, the new one, or none.
///
/// ```
/// use bevy::math::{Dir3, Vec3, bounding::{Aabb3d, AabbCast3d, BoundingSphere, RayCast3d}};
/// use bevy_octree::broad_phase::SpatialIndex;
///
/// let mut index = SpatialIndex::default();
/// let mut cube = |x: f32| index.insert(Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)));
/// let (a, b, c) = (cube(2.0)?, cube(4.0)?, cube(8.0)?);
/// index.update();
///
/// // What is in a ball? A box, a point or a view frustum would do as well.
/// let mut found = vec![];
/// index.for_each_overlapping(&BoundingSphere::new(Vec3::X * 3.0, 1.0), |id| found.push(id));
/// found.sort();
/// assert_eq!(found, [a, b]);
///
/// // What does a ray meet first? And if it goes through `a`? And a box?
/// let ray = RayCast3d::new(Vec3::ZERO, Dir3::X, 100.0);
/// let hit = index.cast(&ray).unwrap();
/// assert_eq!((hit.proxy, hit.distance), (a, 1.5));
/// let hit = index.cast_with(&ray, |id, distance| (id != a).then_some(distance)).unwrap();
/// assert_eq!((hit.proxy, hit.distance), (b, 3.5));
/// let cube = Aabb3d::new(Vec3::ZERO, Vec3::ONE);
/// let hit = index.cast(&AabbCast3d::new(cube, Vec3::X * 20.0, Dir3::NEG_X, 100.0)).unwrap();
/// assert_eq!((hit.proxy, hit.distance), (c, 10.5));
///
/// // Which are nearest to a point?
/// assert_eq!(index.nearest(Vec3::X * 7.0, f32::INFINITY).unwrap().proxy, c);
/// let mut hits = vec![];
/// index.k_nearest(Vec3::ZERO, 2, f32::INFINITY, &mut hits);
/// assert_eq!(hits.iter().map(|hit| hit.distance).collect::<Vec<_>>(), [1.5, 3.5]);
/// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
/// ```
impl SpatialIndex {
    /// Calls `found` with every object whose box overlaps a region, each once, in no particular
    /// order.
    #[doc(alias = "aabb")]
    #[doc(alias = "intersections")]
    pub fn for_each_overlapping<F: Flow>(
        &self,
        region: &(impl Region + ?Sized),
        mut found: impl FnMut(ProxyId) -> F,
    ) {
        let (measure, limit) = region.measure();
        self.search(&measure, limit, |id, _| {
            if found(id).goes_on() {
                ControlFlow::Continue(limit)
            } else {
                ControlFlow::Break(())
            }
        });
    }

    /// Returns the first box that a cast meets; of several at the same distance, that of the lowest
    /// handle.
    #[doc(alias = "raycast")]
    #[doc(alias = "shapecast")]
    #[must_use]
    pub fn cast(&self, cast: &impl Cast) -> Option<Hit> {
        self.cast_with(cast, |_, distance| Some(distance))
    }

    /// Returns the first object that a cast meets, by a distance of your own.
    ///
    /// `distance` gets an object and the distance of its box, and returns that of the object
    /// itself, which is no smaller; `None` if the cast passes it by, or is not to see it: this is
    /// both a filter and the way to cast against exact shapes. It is called only for objects whose
    /// boxes are not beyond the best hit so far.
    #[doc(alias = "raycast")]
    #[doc(alias = "shapecast")]
    #[must_use]
    pub fn cast_with(
        &self,
        cast: &impl Cast,
        distance: impl FnMut(ProxyId, f32) -> Option<f32>,
    ) -> Option<Hit> {
        let (sweep, limit) = cast.sweep();
        self.first(&sweep, limit, distance)
    }

    /// Calls `found` with every box that a cast meets, each once, in no particular order.
    #[doc(alias = "raycast")]
    #[doc(alias = "shapecast")]
    pub fn for_each_hit<F: Flow>(&self, cast: &impl Cast, mut found: impl FnMut(Hit) -> F) {
        let (sweep, limit) = cast.sweep();
        self.search(&sweep, limit, |proxy, distance| {
            if found(Hit { proxy, distance }).goes_on() {
                ControlFlow::Continue(limit)
            } else {
                ControlFlow::Break(())
            }
        });
    }

    /// Returns `true` if a cast meets anything that `is_met` says it meets, given an object and the
    /// distance of its box. The first that is met ends the search: for a line of sight, this takes
    /// less than to find what is first.
    #[doc(alias("occlusion", "shadow ray", "line of sight", "intersects"))]
    #[must_use]
    pub fn meets_any(
        &self,
        cast: &impl Cast,
        mut is_met: impl FnMut(ProxyId, f32) -> bool,
    ) -> bool {
        let mut found = false;
        self.for_each_hit(cast, |hit| {
            found = is_met(hit.proxy, hit.distance);
            if found {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        found
    }

    /// Calls `found` with every box that is no farther from a point than `max_distance`, each once,
    /// in no particular order. None if the point is not finite, or `max_distance` negative or NaN.
    #[doc(alias("radius", "range search", "within distance"))]
    pub fn for_each_within<F: Flow>(
        &self,
        point: impl Into<Vec3A>,
        max_distance: f32,
        mut found: impl FnMut(Hit) -> F,
    ) {
        let (measure, limit) = PointDistance::<false>::new(point.into(), max_distance);
        self.search(&measure, limit, |proxy, distance| {
            if found(Hit { proxy, distance }).goes_on() {
                ControlFlow::Continue(limit)
            } else {
                ControlFlow::Break(())
            }
        });
    }

    /// Returns the box nearest to a point, no farther than `max_distance`; of several as near, that
    /// of the lowest [order](Self::set_order), then handle. `None` too if the point is not finite, or `max_distance` negative or
    /// NaN.
    #[must_use]
    pub fn nearest(&self, point: impl Into<Vec3A>, max_distance: f32) -> Option<Hit> {
        self.nearest_with(point, max_distance, |_, distance| Some(distance))
    }

    /// Returns the object nearest to a point, by a distance of your own: as with
    /// [`cast_with`](Self::cast_with), `distance` gets an object and the distance of its box, and
    /// returns that of the object, which is no smaller, or `None`.
    #[must_use]
    pub fn nearest_with(
        &self,
        point: impl Into<Vec3A>,
        max_distance: f32,
        distance: impl FnMut(ProxyId, f32) -> Option<f32>,
    ) -> Option<Hit> {
        let (measure, limit) = PointDistance::<true>::new(point.into(), max_distance);
        self.first(&measure, limit, distance)
    }

    /// Finds the `k` boxes nearest to a point, no farther than `max_distance`, nearest first, those
    /// as near by ascending [order](Self::set_order), then handle. They replace what is in `hits`, which grows to at most `k` and
    /// is yours to use again. Meant for a few: O(k) for each candidate.
    #[doc(alias = "knn")]
    pub fn k_nearest(
        &self,
        point: impl Into<Vec3A>,
        k: usize,
        max_distance: f32,
        hits: &mut Vec<Hit>,
    ) {
        self.k_nearest_with(point, k, max_distance, hits, |_, distance| Some(distance));
    }

    /// Finds the `k` objects nearest to a point, by a distance of your own: see
    /// [`nearest_with`](Self::nearest_with).
    #[doc(alias = "knn")]
    pub fn k_nearest_with(
        &self,
        point: impl Into<Vec3A>,
        k: usize,
        max_distance: f32,
        hits: &mut Vec<Hit>,
        distance: impl FnMut(ProxyId, f32) -> Option<f32>,
    ) {
        hits.clear();
        self.append_nearest(point, k, max_distance, hits, distance);
    }

    /// Appends the nearest `k` objects: see [`k_nearest_with`](Self::k_nearest_with).
    fn append_nearest(
        &self,
        point: impl Into<Vec3A>,
        k: usize,
        max_distance: f32,
        hits: &mut Vec<Hit>,
        mut distance: impl FnMut(ProxyId, f32) -> Option<f32>,
    ) {
        if k == 0 {
            return;
        }
        let start = hits.len();
        let (measure, mut limit) = PointDistance::<true>::new(point.into(), max_distance);
        let proxies = self.proxies();
        self.search(&measure, limit, |proxy, bound| {
            if let Some(distance) = distance(proxy, bound)
                && distance <= limit
            {
                let hit = Hit { proxy, distance };
                let rank = hits[start..].partition_point(|other| other.is_before(&hit, proxies));
                if rank < k {
                    hits.truncate(start.saturating_add(k - 1));
                    hits.insert(start + rank, hit);
                }
                if let Some(last) = hits[start..].get(k - 1) {
                    limit = last.distance;
                }
            }
            ControlFlow::Continue(limit)
        });
    }

    /// Casts many at once, each as [`cast`](Self::cast), side by side on the threads of the
    /// [`ComputeTaskPool`](bevy::tasks::ComputeTaskPool) with the feature `multi_threaded`. The
    /// answers replace what is in `hits`, in the order of the casts, whatever the number of threads.
    #[doc(alias = "batch")]
    pub fn cast_each(&self, casts: &[impl Cast + Sync], hits: &mut Vec<Option<Hit>>) {
        lists::answer_each(casts, hits, |cast| self.cast(cast));
    }

    /// Finds the box nearest to each of many points, as [`nearest`](Self::nearest), side by side as
    /// [`cast_each`](Self::cast_each).
    #[doc(alias = "batch")]
    pub fn nearest_of_each(&self, points: &[Vec3], max_distance: f32, hits: &mut Vec<Option<Hit>>) {
        lists::answer_each(points, hits, |point| self.nearest(*point, max_distance));
    }

    /// Finds the `k` boxes nearest to each of many points, as [`k_nearest`](Self::k_nearest), side
    /// by side as [`cast_each`](Self::cast_each).
    #[doc(alias("knn", "batch"))]
    pub fn k_nearest_of_each(
        &self,
        points: &[Vec3],
        k: usize,
        max_distance: f32,
        hits: &mut HitLists<Hit>,
    ) {
        hits.fill(points, |point, hits| {
            self.append_nearest(*point, k, max_distance, hits, |_, distance| Some(distance));
        });
    }

    /// The linear octree, if that is at work.
    pub(super) fn linear(&self) -> Option<&LinearOctree> {
        // The engine, or the one that it hands its work to.
        let engine = self.engine();
        let engine: &dyn Any = engine.inner().unwrap_or(engine);
        engine.downcast_ref()
    }

    /// The object with the smallest distance.
    #[inline(always)]
    fn first(
        &self,
        measure: &impl Measure,
        limit: f32,
        mut distance: impl FnMut(ProxyId, f32) -> Option<f32>,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.search(measure, limit, |proxy, bound| {
            if let Some(distance) = distance(proxy, bound)
                && distance <= limit
            {
                let hit = Hit { proxy, distance };
                if best.is_none_or(|best| hit.is_before(&best, self.proxies())) {
                    best = Some(hit);
                }
            }
            ControlFlow::Continue(best.map_or(limit, |best| best.distance))
        });
        best
    }

    /// Calls `visit` with each object within the limit, and its distance; it tells the limit from
    /// then on.
    #[inline(always)]
    fn search<M: Measure>(
        &self,
        measure: &M,
        mut limit: f32,
        mut visit: impl FnMut(ProxyId, f32) -> ControlFlow<(), f32>,
    ) {
        if limit.is_nan() || limit < 0.0 {
            return;
        }
        for id in self.proxies().unbounded() {
            match visit(id, 0.0) {
                ControlFlow::Continue(new) => limit = new,
                ControlFlow::Break(()) => return,
            }
        }
        match self.linear() {
            Some(linear) => linear.search(self.proxies(), measure, limit, visit),
            None => self.traverse(&mut Walk {
                measure,
                limit,
                visit,
                is_over: false,
            }),
        }
    }
}

/// A query on its way through an index that has cells.
struct Walk<'a, M, V> {
    measure: &'a M,
    limit: f32,
    visit: V,
    is_over: bool,
}

impl<M: Measure, V: FnMut(ProxyId, f32) -> ControlFlow<(), f32>> Visitor for Walk<'_, M, V> {
    fn enter(&mut self, bounds: &Aabb3d) -> bool {
        !self.is_over && self.measure.test_cell(bounds, self.limit)
    }

    fn object(&mut self, id: ProxyId, aabb: &Aabb3d, cell: &Aabb3d) {
        if self.is_over {
            return;
        }
        let Some(distance) = self.measure.test_box(aabb, self.limit) else {
            return;
        };
        // Of the cells that list an object, one has its anchor.
        let anchor = self.measure.anchor(aabb, distance);
        if !(anchor.cmpge(cell.min) & anchor.cmplt(cell.max)).all() {
            return;
        }
        match (self.visit)(id, distance) {
            ControlFlow::Continue(limit) => self.limit = limit,
            ControlFlow::Break(()) => self.is_over = true,
        }
    }

    fn viewpoint(&self) -> Vec3A {
        self.measure.viewpoint()
    }
}
