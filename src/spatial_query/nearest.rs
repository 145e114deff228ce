//! What is near a point.

use std::mem::take;

use bevy::prelude::*;

use super::{
    best::{Best, BestFew},
    filter::SpatialQueryFilter,
    query::SpatialQuery,
    scratch,
};
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
    /// Returns the entity whose shape is nearest to a point, no farther than `max_distance`, which
    /// may be infinite.
    #[must_use]
    #[doc(alias("closest", "project point", "nearest neighbor"))]
    pub fn nearest(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<PointHit> {
        let mut best = Best::within(max_distance);
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
    #[doc(alias("knn", "k nearest neighbors"))]
    pub fn k_nearest(
        &self,
        point: Vec3,
        k: usize,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<PointHit>,
    ) {
        hits.clear();
        if k == 0 {
            return;
        }
        let (mut nearest, mut answers) = scratch::with(|scratch| {
            (
                take(&mut scratch.nearest),
                take(&mut scratch.closest_points),
            )
        });
        let mut best = BestFew::within(k, max_distance, &mut answers);
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
