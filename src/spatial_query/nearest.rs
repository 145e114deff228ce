//! What is near a point.

use bevy::prelude::*;

use super::{SpatialQuery, SpatialQueryFilter, scratch};
use crate::{broad_phase::Hit, collision_index::Body};

/// An entity near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The entity.
    pub entity: Entity,
    /// How far its shape is from the point, in a straight line; 0 if the point is inside.
    pub distance: f32,
    /// The point of its shape that is closest.
    pub point: Vec3,
}

/// # What is near
impl SpatialQuery<'_> {
    /// The entity whose shape is nearest to a point, no farther than `max_distance`, which may be infinite.
    #[must_use]
    pub fn nearest(&self, point: Vec3, max_distance: f32, filter: &SpatialQueryFilter) -> Option<PointHit> {
        let hit = self.index.index().nearest_with(point, max_distance, |id, _| {
            Some(self.point_hit(self.candidate(id, filter)?, point)?.distance)
        })?;
        self.point_hit(self.index.body(hit.proxy)?, point)
    }

    /// The `k` entities whose shapes are nearest to a point, no farther than `max_distance`, nearest first. They replace
    /// what is in `hits`, which is yours to use again. Meant for a few: O(k) for each candidate.
    pub fn k_nearest(
        &self,
        point: Vec3,
        k: usize,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        hits.clear();
        let mut found = scratch::with(|scratch| std::mem::take(&mut scratch.hits));
        self.index.index().k_nearest_with(point, k, max_distance, &mut found, |id, _| {
            Some(self.point_hit(self.candidate(id, filter)?, point)?.distance)
        });
        let exact = |hit: &Hit| self.index.body(hit.proxy).and_then(|body| self.point_hit(body, point));
        hits.extend(found.iter().filter_map(exact));
        scratch::with(|scratch| scratch.hits = found);
    }

    fn point_hit(&self, body: &Body, from: Vec3) -> Option<PointHit> {
        let closest =
            |scratch: &mut scratch::Scratch| self.tests().closest_point(body.placed(), from, &mut scratch.workspace);
        let point = scratch::with(closest)?;
        let distance = match point.distance(from) {
            // In double precision, no square overflows.
            f32::INFINITY => point.as_dvec3().distance(from.as_dvec3()) as f32,
            distance => distance,
        };
        Some(PointHit { entity: body.entity, distance, point })
    }
}
