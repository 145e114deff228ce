//! Questions about the world as it was, or would be, with some entities elsewhere.

use bevy::{ecs::entity::EntityHashMap, math::bounding::RayCast3d, prelude::*};

use super::{
    best::Best,
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
    rays::RayHit,
    scratch,
    shape_cast::ShapeHit,
};
use crate::{
    broad_phase::{Flow, ProxyId},
    collision_index::Body,
    narrow_phase::{BoundsError, Placed, RayCastOptions, Shape, ShapeCastOptions},
};

/// Asks as if some entities were elsewhere: see [`SpatialQuery::at`].
pub struct PosedQuery<'q, 'w, 's> {
    spatial: &'q SpatialQuery<'w, 's>,
    /// Those who are elsewhere, in their order.
    posed: Vec<(ProxyId, Body)>,
    entities: EntityHashMap<()>,
}

/// # At other poses
impl<'w, 's> SpatialQuery<'w, 's> {
    /// Returns what asks as if some entities were at other poses in the world, and all others where they are: where those
    /// who are shot at were when the shot was fired, as its owner saw them (*lag compensation*).
    ///
    /// A game keeps where its players were in the last ticks. Their shapes are those of now. Each is alone
    /// elsewhere: what hangs on it, as the parts of a body, is given by itself, at its own pose in the world. Who has no shape
    /// in the index is not found, and neither is who is at a pose that is not finite, or in no box there; who is given twice is
    /// at the last.
    ///
    /// ```
    /// use std::collections::VecDeque;
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// /// Where the player was, the latest first.
    /// #[derive(Component)]
    /// struct Past(VecDeque<Transform>);
    ///
    /// fn is_hit(shot: Ray3d, ticks_ago: usize, players: Query<(Entity, &Past)>, spatial: SpatialQuery) -> Option<Entity> {
    ///     let then = spatial.at(players.iter().filter_map(|(player, past)| Some((player, *past.0.get(ticks_ago)?))));
    ///     // Walls are where they are.
    ///     let hit = then.cast_ray(shot, 100.0, &SpatialQueryFilter::DEFAULT)?;
    ///     players.contains(hit.entity).then_some(hit.entity)
    /// }
    /// ```
    ///
    /// # Cost
    /// Each question asks the index as ever, and looks at each of those entities: meant for tens of them, not for thousands.
    #[doc(alias("lag compensation", "rewind", "hit scan", "past"))]
    #[must_use]
    pub fn at(
        &self,
        poses: impl IntoIterator<Item = (Entity, Transform)>,
    ) -> PosedQuery<'_, 'w, 's> {
        let mut poses: EntityHashMap<Transform> = poses.into_iter().collect();
        let entities = poses.keys().map(|entity| (*entity, ())).collect();
        let mut posed: Vec<_> = poses
            .drain()
            .filter(|(_, pose)| pose.is_finite())
            .filter_map(|(entity, pose)| {
                let id = self.id_of(entity)?;
                let body = self.index.body(id)?.clone();
                let body = Body { pose, ..body };
                // Who has no box is nowhere.
                let bounds = self.tests().world_aabb(body.placed());
                (bounds != Err(BoundsError::NonFinite)).then_some((id, body))
            })
            .collect();
        posed.sort_unstable_by_key(|(id, _)| self.proxies().order(*id));
        PosedQuery {
            spatial: self,
            posed,
            entities,
        }
    }
}

impl PosedQuery<'_, '_, '_> {
    /// Those who are elsewhere and whom the filter lets pass.
    fn elsewhere(&self, filter: &SpatialQueryFilter) -> impl Iterator<Item = (ProxyId, &Body)> {
        let posed = self.posed.iter().map(|(id, body)| (*id, body));
        posed.filter(|(id, _)| self.spatial.candidate(*id, filter).is_some())
    }

    /// One who is where it is.
    fn here(&self, id: ProxyId, filter: &SpatialQueryFilter) -> Option<&Body> {
        let body = self.spatial.candidate(id, filter)?;
        (!self.entities.contains_key(&body.entity)).then_some(body)
    }

    /// Returns the first entity that a ray meets, as [`SpatialQuery::cast_ray`].
    #[must_use]
    pub fn cast_ray(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<RayHit> {
        self.cast_ray_with(ray, max_distance, filter, &RayCastOptions::DEFAULT)
    }

    /// Returns the first entity that a ray meets, by these options, as [`SpatialQuery::cast_ray_with`].
    #[must_use]
    pub fn cast_ray_with(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
    ) -> Option<RayHit> {
        let mut best = Best::within(max_distance, self.spatial.proxies());
        for (id, body) in self.elsewhere(filter) {
            if let Some(hit) = self.spatial.ray_hit(body, ray, best.limit(), options) {
                best.offer(id, hit.distance, hit);
            }
        }
        let cast = RayCast3d::from_ray(ray, best.limit());
        // The answer is in `best`, with those who are elsewhere.
        _ = self.spatial.index.index().cast_with(&cast, |id, _| {
            let body = self.here(id, filter)?;
            let hit = self.spatial.ray_hit(body, ray, best.limit(), options)?;
            best.offer(id, hit.distance, hit)
        });
        best.found()
    }

    /// Returns the first entity that a shape touches on its way, as [`SpatialQuery::cast_shape_with`].
    #[must_use]
    pub fn cast_shape(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &ShapeCastOptions,
    ) -> Option<ShapeHit> {
        let mut best = Best::within(max_distance, self.spatial.proxies());
        let cast = self.spatial.box_cast(moving, direction, max_distance)?;
        let hit = |body: &Body, limit| {
            self.spatial
                .shape_hit(body, moving, direction, limit, options)
        };
        for (id, body) in self.elsewhere(filter) {
            if let Some(hit) = hit(body, best.limit()) {
                best.offer(id, hit.distance, hit);
            }
        }
        _ = self.spatial.index.index().cast_with(&cast, |id, _| {
            let hit = hit(self.here(id, filter)?, best.limit())?;
            best.offer(id, hit.distance, hit)
        });
        best.found()
    }

    /// Calls `found` with every entity whose shape overlaps a placed shape, as
    /// [`SpatialQuery::for_each_shape_intersection`].
    pub fn for_each_shape_intersection<F: Flow>(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(Entity) -> F,
    ) {
        let placed = Placed::new(shape, at);
        let meets = |body: &Body| {
            scratch::with(|scratch| {
                let workspace = &mut scratch.workspace;
                self.spatial
                    .tests()
                    .intersects(placed, body.placed(), workspace)
            })
        };
        for (_, body) in self.elsewhere(filter) {
            if meets(body) && flow(found(body.entity).goes_on()).is_break() {
                return;
            }
        }
        self.spatial.for_each_near_shape(placed, filter, |_, body| {
            let is_here = !self.entities.contains_key(&body.entity);
            !(is_here && meets(body)) || found(body.entity).goes_on()
        });
    }

    /// Fills a vector as [`for_each_shape_intersection`](Self::for_each_shape_intersection) calls back,
    /// by ascending [`Entity`]. They replace what is in `entities`, which is yours to use again.
    pub fn shape_intersections(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        entities.clear();
        self.for_each_shape_intersection(shape, at, filter, |entity| entities.push(entity));
        self.spatial.sort(entities);
    }
}
