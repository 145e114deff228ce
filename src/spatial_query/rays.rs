//! Rays.

use bevy::{math::bounding::RayCast3d, prelude::*};

use super::{
    best::Best,
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
};
use crate::{broad_phase::Flow, collision_index::Body, narrow_phase::Impact, parallel};

/// So many rays are cast by one job.
const RAYS_PER_JOB: usize = 64;

/// Where a ray meets an entity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The entity.
    pub entity: Entity,
    /// How far along the ray; 0 if it starts inside.
    pub distance: f32,
    /// The point of the ray.
    pub point: Vec3,
    /// A unit vector out of the shape, towards where the ray comes from: that of the surface, or
    /// the ray's direction reversed if it starts inside.
    pub normal: Vec3,
}

impl RayHit {
    fn new(entity: Entity, impact: Impact) -> Self {
        let Impact {
            distance,
            point,
            normal,
        } = impact;
        Self {
            entity,
            distance,
            point,
            normal,
        }
    }
}

/// # Rays
impl SpatialQuery<'_> {
    /// Returns the first entity that a ray meets within `max_distance`.
    #[must_use]
    #[doc(alias("raycast", "ray cast", "intersect ray", "line of sight"))]
    pub fn cast_ray(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<RayHit> {
        let mut best = Best::within(max_distance);
        let nearest =
            self.index
                .index()
                .cast_with(&RayCast3d::from_ray(ray, max_distance), |id, _| {
                    let hit = self.ray_hit(self.candidate(id, filter)?, ray, best.limit())?;
                    best.offer(id, hit.distance, hit)
                });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Finds all entities that a ray meets within `max_distance`: nearest first, those as near by
    /// ascending [`Entity`]. They replace what is in `hits`, which is yours to use again.
    #[doc(alias = "raycast all")]
    pub fn ray_hits(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<RayHit>,
    ) {
        hits.clear();
        self.for_each_ray_hit(ray, max_distance, filter, |hit| hits.push(hit));
        hits.sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then(a.entity.cmp(&b.entity))
        });
    }

    /// Calls `found` with every entity that a ray meets within `max_distance`, in no particular
    /// order. It may return a [`ControlFlow`](std::ops::ControlFlow) to stop.
    pub fn for_each_ray_hit<F: Flow>(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(RayHit) -> F,
    ) {
        self.index
            .index()
            .for_each_hit(&RayCast3d::from_ray(ray, max_distance), |hit| {
                let body = self.candidate(hit.proxy, filter);
                let hit = body.and_then(|body| self.ray_hit(body, ray, max_distance));
                flow(hit.is_none_or(|hit| found(hit).goes_on()))
            });
    }

    /// Casts many rays at once, each as [`cast_ray`](Self::cast_ray), side by side on the threads
    /// of the [`ComputeTaskPool`](bevy::tasks::ComputeTaskPool), with the feature `multi_threaded`.
    /// The answers replace what is in `hits`, in the order of the rays; they do not depend on the
    /// number of threads.
    pub fn cast_rays(
        &self,
        rays: &[Ray3d],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<Option<RayHit>>,
    ) {
        hits.clear();
        hits.resize(rays.len(), None);
        parallel::for_each(
            rays.chunks(RAYS_PER_JOB).zip(hits.chunks_mut(RAYS_PER_JOB)),
            |(rays, hits)| {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.cast_ray(*ray, max_distance, filter);
                }
            },
        );
    }

    fn ray_hit(&self, body: &Body, ray: Ray3d, max_distance: f32) -> Option<RayHit> {
        let impact =
            self.tests()
                .cast_ray(body.placed(), ray.origin, ray.direction, max_distance)?;
        Some(RayHit::new(body.entity, impact))
    }
}
