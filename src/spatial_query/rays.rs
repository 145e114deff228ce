//! Rays.

use bevy::{ecs::entity::MapEntities, math::bounding::RayCast3d, prelude::*};

use super::{
    best::Best,
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
};
use crate::{
    broad_phase::{Flow, answer_each},
    collision_index::Body,
    narrow_phase::{Impact, Passage, RayCastOptions},
};

/// Where a ray meets an entity.
#[derive(Clone, Copy, Debug, PartialEq, MapEntities, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct RayHit {
    /// The entity.
    #[entities]
    pub entity: Entity,
    /// How far along the ray; 0 if it starts inside.
    pub distance: f32,
    /// The point of the ray.
    pub point: Vec3,
    /// A unit vector out of the shape, towards where the ray comes from: that of the surface, or
    /// the ray's direction reversed if it starts inside.
    pub normal: Vec3,
    /// The unit normal of the face that is met, whichever side of it that is; as `normal`, if it
    /// starts inside. See [`Impact::face_normal`].
    pub face_normal: Vec3,
    /// Which polygon of a mesh is met: of a Bevy mesh, which triangle. See [`Impact::polygon`].
    pub polygon: Option<u32>,
}

impl RayHit {
    fn new(entity: Entity, impact: Impact) -> Self {
        let Impact {
            distance,
            point,
            normal,
            face_normal,
            polygon,
            ..
        } = impact;
        Self {
            entity,
            distance,
            point,
            normal,
            face_normal,
            polygon,
        }
    }

    /// Returns `true` if the face that is met faces away from the ray: the wall of a solid from
    /// inside, a polygon from behind.
    #[must_use]
    pub fn is_back_face(&self) -> bool {
        self.face_normal.dot(self.normal) < 0.0
    }
}

/// Where a ray enters an entity, and where it leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct RayPassage {
    /// The entity.
    pub entity: Entity,
    /// Where it enters; `None` if it starts inside.
    pub enter: Option<RayHit>,
    /// Where it leaves; `None` if it does not within its length, or from a mesh that bounds no
    /// solid.
    pub leave: Option<RayHit>,
}

impl RayPassage {
    fn new(entity: Entity, passage: Passage) -> Self {
        let hit = |impact: Option<Impact>| impact.map(|impact| RayHit::new(entity, impact));
        Self {
            entity,
            enter: hit(passage.enter),
            leave: hit(passage.leave),
        }
    }

    /// Returns where it begins, as a distance along the ray: 0 if the ray starts inside.
    #[must_use]
    pub fn start(&self) -> f32 {
        self.enter.map_or(0.0, |enter| enter.distance)
    }

    /// Returns how far the ray goes within the entity, if it leaves it.
    #[must_use]
    pub fn length(&self) -> Option<f32> {
        Some(self.leave?.distance - self.start())
    }
}

/// A ray of a batch: a [`Ray3d`], which is as long as the batch says, or a `Ray3d` and the most that
/// it may be long by itself.
///
/// These two, and no others: the trait is sealed.
pub trait BatchRay: Limited + Sync {}

impl BatchRay for Ray3d {}
impl BatchRay for (Ray3d, f32) {}

/// What a batch reads from a [`BatchRay`].
pub trait Limited {
    /// The ray, and its length, given that of the batch.
    fn up_to(&self, max_distance: f32) -> (Ray3d, f32);
}

impl Limited for Ray3d {
    fn up_to(&self, max_distance: f32) -> (Ray3d, f32) {
        (*self, max_distance)
    }
}

impl Limited for (Ray3d, f32) {
    fn up_to(&self, max_distance: f32) -> (Ray3d, f32) {
        let &(ray, own) = self;
        // NaN stays NaN, and meets nothing.
        let is_longer = own > max_distance || max_distance.is_nan();
        (ray, if is_longer { max_distance } else { own })
    }
}

/// # Rays
///
/// Each question has a form that takes [`RayCastOptions`]: which faces are met, whether solids are
/// hollow, and whether what the ray starts on counts.
impl SpatialQuery<'_, '_> {
    /// Returns the first entity that a ray meets within `max_distance`.
    #[must_use]
    #[doc(alias("raycast", "ray cast", "intersect ray", "line of sight"))]
    pub fn cast_ray(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<RayHit> {
        self.cast_ray_with(ray, max_distance, filter, &RayCastOptions::DEFAULT)
    }

    /// Returns the first entity that a ray meets within `max_distance`, by these options.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// /// A laser is reflected by what it meets, and begins anew on its surface.
    /// fn reflected(hit: &RayHit, ray: Ray3d, spatial: &SpatialQuery) -> Option<RayHit> {
    ///     let direction = Dir3::new(ray.direction.reflect(hit.normal)).ok()?;
    ///     let (ray, onward) = (Ray3d::new(hit.point, direction), RayCastOptions::DEFAULT.ignore_start());
    ///     spatial.cast_ray_with(ray, 100.0, &SpatialQueryFilter::DEFAULT, &onward)
    /// }
    /// ```
    #[must_use]
    pub fn cast_ray_with(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
    ) -> Option<RayHit> {
        let mut best = Best::within(max_distance, self.proxies());
        let nearest =
            self.index
                .index()
                .cast_with(&RayCast3d::from_ray(ray, max_distance), |id, _| {
                    let body = self.candidate(id, filter)?;
                    let hit = self.ray_hit(body, ray, best.limit(), options)?;
                    best.offer(id, hit.distance, hit)
                });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Finds all entities that a ray meets within `max_distance`: nearest first, those as near by
    /// ascending [`Entity`]. They replace what is in `hits`, which is yours to use again.
    #[doc(alias("raycast all", "RaycastAll"))]
    pub fn ray_hits(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<RayHit>,
    ) {
        self.ray_hits_with(ray, max_distance, filter, &RayCastOptions::DEFAULT, hits);
    }

    /// Finds all entities that a ray meets, as [`ray_hits`](Self::ray_hits), by these options.
    pub fn ray_hits_with(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
        hits: &mut Vec<RayHit>,
    ) {
        hits.clear();
        self.for_each_ray_hit_with(ray, max_distance, filter, options, |hit| hits.push(hit));
        hits.sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then_with(|| self.order_of(a.entity).cmp(&self.order_of(b.entity)))
        });
    }

    /// Calls `found` with every entity that a ray meets within `max_distance`, in no particular
    /// order. It may return a [`ControlFlow`](std::ops::ControlFlow) to stop.
    pub fn for_each_ray_hit<F: Flow>(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        found: impl FnMut(RayHit) -> F,
    ) {
        self.for_each_ray_hit_with(ray, max_distance, filter, &RayCastOptions::DEFAULT, found);
    }

    /// Calls `found` with every entity that a ray meets, as
    /// [`for_each_ray_hit`](Self::for_each_ray_hit), by these options.
    pub fn for_each_ray_hit_with<F: Flow>(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
        mut found: impl FnMut(RayHit) -> F,
    ) {
        self.for_each_on_ray(ray, max_distance, filter, |body| {
            let hit = self.ray_hit(body, ray, max_distance, options);
            hit.is_none_or(|hit| found(hit).goes_on())
        });
    }

    /// Returns `true` if a ray meets any entity within `max_distance`. The first that is found to be
    /// met ends the search, whether or not there is a nearer one: for lines of sight, shadows, and
    /// whatever else is free or not.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// fn sees(from: Vec3, to: Vec3, spatial: &SpatialQuery) -> bool {
    ///     let Ok((direction, distance)) = Dir3::new_and_length(to - from) else { return true };
    ///     let solid = SpatialQueryFilter::DEFAULT.without_sensors();
    ///     !spatial.ray_meets_any(Ray3d::new(from, direction), distance, &solid)
    /// }
    /// ```
    #[must_use]
    #[doc(alias("line of sight", "occlusion", "shadow ray", "any hit", "linecast"))]
    pub fn ray_meets_any(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> bool {
        self.ray_meets_any_with(ray, max_distance, filter, &RayCastOptions::DEFAULT)
    }

    /// Returns `true` if a ray meets any entity, as [`ray_meets_any`](Self::ray_meets_any), by these
    /// options.
    #[must_use]
    pub fn ray_meets_any_with(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
    ) -> bool {
        let cast = RayCast3d::from_ray(ray, max_distance);
        self.index.index().meets_any(&cast, |id, _| {
            self.candidate(id, filter)
                .is_some_and(|body| self.ray_hit(body, ray, max_distance, options).is_some())
        })
    }

    /// Casts many rays at once, each as [`cast_ray`](Self::cast_ray), side by side on the threads
    /// of the [`ComputeTaskPool`](bevy::tasks::ComputeTaskPool), with the feature `multi_threaded`.
    /// The answers replace what is in `hits`, in the order of the rays; they do not depend on the
    /// number of threads. Each ray may have a length of its own: see [`BatchRay`].
    #[doc(alias("batch", "raycast batch"))]
    pub fn cast_rays(
        &self,
        rays: &[impl BatchRay],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<Option<RayHit>>,
    ) {
        self.cast_rays_with(rays, max_distance, filter, &RayCastOptions::DEFAULT, hits);
    }

    /// Casts many rays at once, as [`cast_rays`](Self::cast_rays), by these options.
    pub fn cast_rays_with(
        &self,
        rays: &[impl BatchRay],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &RayCastOptions,
        hits: &mut Vec<Option<RayHit>>,
    ) {
        answer_each(rays, hits, |ray| {
            let (ray, max_distance) = ray.up_to(max_distance);
            self.cast_ray_with(ray, max_distance, filter, options)
        });
    }

    /// Tells of many rays whether they meet anything, each as
    /// [`ray_meets_any`](Self::ray_meets_any), side by side as [`cast_rays`](Self::cast_rays). The
    /// answers replace what is in `are_met`, in the order of the rays.
    #[doc(alias("batch", "line of sight"))]
    pub fn rays_meet_any(
        &self,
        rays: &[impl BatchRay],
        max_distance: f32,
        filter: &SpatialQueryFilter,
        are_met: &mut Vec<bool>,
    ) {
        answer_each(rays, are_met, |ray| {
            let (ray, max_distance) = ray.up_to(max_distance);
            self.ray_meets_any(ray, max_distance, filter)
        });
    }

    fn ray_hit(
        &self,
        body: &Body,
        ray: Ray3d,
        max_distance: f32,
        options: &RayCastOptions,
    ) -> Option<RayHit> {
        let Ray3d { origin, direction } = ray;
        let impact =
            self.tests()
                .cast_ray_with(body.placed(), origin, direction, max_distance, options)?;
        Some(RayHit::new(body.entity, impact))
    }

    /// Everything that a ray may meet, until `found` returns `false`.
    fn for_each_on_ray(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(&Body) -> bool,
    ) {
        self.index
            .index()
            .for_each_hit(&RayCast3d::from_ray(ray, max_distance), |hit| {
                flow(self.candidate(hit.proxy, filter).is_none_or(&mut found))
            });
    }
}

/// # Rays through entities
///
/// Where a ray enters a solid, and where it leaves it: see
/// [`NarrowPhase::cast_ray_through`](crate::narrow_phase::NarrowPhase::cast_ray_through).
impl SpatialQuery<'_, '_> {
    /// Returns where a ray passes through the first entity that it meets within `max_distance`.
    ///
    /// A ray that is to go on from `leave.point` starts on what it has left, and so would meet the
    /// same entity again. All that it passes through is told at once by
    /// [`ray_passages`](Self::ray_passages); the next entity alone, by
    /// [`cast_ray_with`](Self::cast_ray_with) from there and
    /// [`RayCastOptions::ignore_start`].
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// /// How thick is the wall?
    /// fn thickness(ray: Ray3d, spatial: SpatialQuery) -> Option<f32> {
    ///     spatial.cast_ray_through(ray, 100.0, &SpatialQueryFilter::DEFAULT)?.length()
    /// }
    /// ```
    #[must_use]
    #[doc(alias("exit point", "thickness", "penetration"))]
    pub fn cast_ray_through(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<RayPassage> {
        let mut best = Best::within(max_distance, self.proxies());
        let nearest =
            self.index
                .index()
                .cast_with(&RayCast3d::from_ray(ray, max_distance), |id, _| {
                    let passage =
                        self.ray_passage(self.candidate(id, filter)?, ray, max_distance)?;
                    best.offer(id, passage.start(), passage)
                });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Finds all entities that a ray passes through within `max_distance`: those that it enters
    /// first come first, those as near by ascending [`Entity`]. They replace what is in `passages`,
    /// which is yours to use again.
    pub fn ray_passages(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        passages: &mut Vec<RayPassage>,
    ) {
        passages.clear();
        self.for_each_ray_passage(ray, max_distance, filter, |passage| passages.push(passage));
        passages.sort_unstable_by(|a, b| {
            a.start()
                .total_cmp(&b.start())
                .then_with(|| self.order_of(a.entity).cmp(&self.order_of(b.entity)))
        });
    }

    /// Calls `found` with every entity that a ray passes through within `max_distance`, in no
    /// particular order. It may return a [`ControlFlow`](std::ops::ControlFlow) to stop.
    pub fn for_each_ray_passage<F: Flow>(
        &self,
        ray: Ray3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(RayPassage) -> F,
    ) {
        self.for_each_on_ray(ray, max_distance, filter, |body| {
            let passage = self.ray_passage(body, ray, max_distance);
            passage.is_none_or(|passage| found(passage).goes_on())
        });
    }

    fn ray_passage(&self, body: &Body, ray: Ray3d, max_distance: f32) -> Option<RayPassage> {
        let Ray3d { origin, direction } = ray;
        let passage =
            self.tests()
                .cast_ray_through(body.placed(), origin, direction, max_distance)?;
        Some(RayPassage::new(body.entity, passage))
    }
}
