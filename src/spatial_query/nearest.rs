//! What is near a point.

use std::mem::take;

use bevy::prelude::*;

use super::{
    best::{Best, BestFew},
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
    scratch,
};
use crate::{
    broad_phase::{Flow, Hit, HitLists, answer_each},
    collision_index::Body,
};

/// An entity near a point.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct PointHit {
    /// The entity.
    pub entity: Entity,
    /// How far its shape is from the point, in a straight line; 0 if the point is inside.
    pub distance: f32,
    /// The point of its shape that is closest.
    pub point: Vec3,
}

/// # What is near
impl SpatialQuery<'_, '_> {
    /// Returns the entity whose shape is nearest to a point, no farther than `max_distance`, which
    /// may be infinite.
    #[doc(alias(
        "closest",
        "project point",
        "nearest neighbor",
        "closest point",
        "nearest neighbour"
    ))]
    #[must_use]
    pub fn nearest(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<PointHit> {
        let mut best = Best::within(max_distance, self.proxies());
        let nearest = self
            .index
            .index()
            .nearest_with(point, max_distance, |id, _| {
                let hit = self.point_hit(self.candidate(id, filter)?, point)?;
                best.offer(id, hit.distance, hit)
            });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Finds the `k` entities whose shapes are nearest to a point, no farther than `max_distance`,
    /// nearest first. They replace what is in `hits`, which is yours to use again. Meant for a few:
    /// O(k) for each candidate.
    #[doc(alias("knn", "k nearest neighbors", "k-nearest", "k nearest neighbours"))]
    pub fn k_nearest(
        &self,
        point: Vec3,
        k: usize,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        hits.clear();
        self.append_nearest(point, k, max_distance, filter, hits);
    }

    /// Calls `found` with every entity whose shape is no farther from a point than `max_distance`,
    /// with the distance and the closest point, in no particular order; it may return a
    /// [`ControlFlow`](std::ops::ControlFlow) to stop.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// /// A blast hurts what is near, the less the farther away it is, and throws it outwards.
    /// fn blast(center: Vec3, radius: f32, spatial: &SpatialQuery, mut hurt: impl FnMut(Entity, f32, Vec3)) {
    ///     spatial.for_each_within(center, radius, &SpatialQueryFilter::DEFAULT.without_sensors(), |hit| {
    ///         hurt(hit.entity, 1.0 - hit.distance / radius, hit.point - center);
    ///     });
    /// }
    /// ```
    #[doc(alias("radius", "range search", "blast", "explosion", "overlap sphere"))]
    pub fn for_each_within<F: Flow>(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(PointHit) -> F,
    ) {
        self.index
            .index()
            .for_each_within(point, max_distance, |hit| {
                let body = self.candidate(hit.proxy, filter);
                let hit = body
                    .and_then(|body| self.point_hit(body, point))
                    .filter(|hit| hit.distance <= max_distance);
                flow(hit.is_none_or(|hit| found(hit).goes_on()))
            });
    }

    /// Finds the entities whose shapes are no farther from a point than `max_distance`: nearest
    /// first, those as near by ascending [`Entity`]. They replace what is in `hits`, which is yours
    /// to use again.
    #[doc(alias("radius", "range search", "within distance", "OverlapSphere"))]
    pub fn within(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        hits.clear();
        self.append_within(point, max_distance, filter, hits);
    }

    fn append_within(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        let start = hits.len();
        self.for_each_within(point, max_distance, filter, |hit| hits.push(hit));
        hits[start..].sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then_with(|| self.order_of(a.entity).cmp(&self.order_of(b.entity)))
        });
    }

    fn append_nearest(
        &self,
        point: Vec3,
        k: usize,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        if k == 0 {
            return;
        }
        let (mut nearest, mut answers) = scratch::with(|scratch| {
            (
                take(&mut scratch.nearest),
                take(&mut scratch.closest_points),
            )
        });
        let mut best = BestFew::within(k, max_distance, self.proxies(), &mut answers);
        self.index
            .index()
            .k_nearest_with(point, k, max_distance, &mut nearest, |proxy, _| {
                let PointHit {
                    distance, point, ..
                } = self.point_hit(self.candidate(proxy, filter)?, point)?;
                best.offer(Hit { proxy, distance }, point);
                Some(distance)
            });
        debug_assert!(
            nearest.iter().eq(answers.iter().map(|(hit, _)| hit)),
            "the index goes by the same rule"
        );
        hits.extend(
            answers
                .iter()
                .filter_map(|&(Hit { proxy, distance }, point)| {
                    Some(PointHit {
                        entity: self.index.body(proxy)?.entity,
                        distance,
                        point,
                    })
                }),
        );
        scratch::with(|scratch| (scratch.nearest, scratch.closest_points) = (nearest, answers));
    }

    fn point_hit(&self, body: &Body, from: Vec3) -> Option<PointHit> {
        let closest = |scratch: &mut scratch::Scratch| {
            self.tests()
                .closest_point(body.placed(), from, &mut scratch.workspace)
        };
        let point = scratch::with(closest)?;
        let distance = match point.distance(from) {
            // In double precision, no square overflows.
            f32::INFINITY => point.as_dvec3().distance(from.as_dvec3()) as f32,
            distance => distance,
        };
        Some(PointHit {
            entity: body.entity,
            distance,
            point,
        })
    }
}

/// # What is near many points
///
/// Each point is asked about by itself, side by side on the threads of the
/// [`ComputeTaskPool`](bevy::tasks::ComputeTaskPool) with the feature `multi_threaded`. The answers
/// come in the order of the points; they do not depend on the number of threads.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_octree::prelude::*;
/// fn flock(birds: Query<&Transform>, spatial: SpatialQuery, mut near: Local<HitLists<PointHit>>) {
///     let points: Vec<_> = birds.iter().map(|bird| bird.translation).collect();
///     // Each is its own nearest neighbour.
///     spatial.k_nearest_of_each(&points, 8, 10.0, &SpatialQueryFilter::DEFAULT, &mut near);
///     for (point, near) in points.iter().zip(near.iter()) {
///         println!("{} are near {point}", near.len());
///     }
/// }
/// # bevy::ecs::system::assert_is_system(flock);
/// ```
impl SpatialQuery<'_, '_> {
    /// Finds the entity nearest to each of many points, as [`nearest`](Self::nearest). The answers
    /// replace what is in `hits`.
    #[doc(alias = "batch")]
    pub fn nearest_of_each(
        &self,
        points: &[Vec3],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<Option<PointHit>>,
    ) {
        answer_each(points, hits, |point| {
            self.nearest(*point, max_distance, filter)
        });
    }

    /// Finds the `k` entities nearest to each of many points, as [`k_nearest`](Self::k_nearest).
    /// The answers replace what is in `hits`.
    #[doc(alias("knn", "batch"))]
    pub fn k_nearest_of_each(
        &self,
        points: &[Vec3],
        k: usize,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut HitLists<PointHit>,
    ) {
        hits.fill(points, |point, hits| {
            self.append_nearest(*point, k, max_distance, filter, hits);
        });
    }

    /// Finds the entities near each of many points, as [`within`](Self::within). The answers replace
    /// what is in `hits`. For entities that are near each other, see
    /// [`for_each_pair_among`](Self::for_each_pair_among), which takes a fraction of the time.
    #[doc(alias = "batch")]
    pub fn within_of_each(
        &self,
        points: &[Vec3],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut HitLists<PointHit>,
    ) {
        hits.fill(points, |point, hits| {
            self.append_within(*point, max_distance, filter, hits);
        });
    }
}
