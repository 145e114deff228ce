//! Shapes that move without turning.

use bevy::{
    ecs::entity::MapEntities,
    math::bounding::{Aabb3d, AabbCast3d},
    prelude::*,
};

use super::{
    best::Best,
    filter::SpatialQueryFilter,
    query::{self, SpatialQuery, flow},
    scratch,
};
use crate::{
    broad_phase::{Flow, ProxyId},
    collision_index::Body,
    narrow_phase::{Impact, Placed, Shape, ShapeCastOptions},
};

/// Where a moving shape first touches an entity.
#[derive(Clone, Copy, Debug, PartialEq, MapEntities, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ShapeHit {
    /// The entity.
    #[entities]
    pub entity: Entity,
    /// How far the shape goes until it touches; 0 if it does so from the start.
    pub distance: f32,
    /// A point where the two touch.
    pub point: Vec3,
    /// A unit vector from the entity to the moving shape, across the surfaces that touch, and never along
    /// the way: where the shape touches from the start and goes away, it is turned against that; the
    /// `face_normal` is not, and is the one along which to push the shape out.
    pub normal: Vec3,
    /// The unit normal of the face of the entity that is touched, whichever side of it that is, if
    /// it was [asked for](ShapeCastOptions::find_polygon); as `normal` otherwise. See
    /// [`Impact::face_normal`].
    pub face_normal: Vec3,
    /// Which polygon of a mesh is touched: of a Bevy mesh, which triangle; if it was [asked
    /// for](ShapeCastOptions::find_polygon). See [`Impact::polygon`].
    pub polygon: Option<u32>,
    /// How deep the shape is in the entity at the start, along `face_normal`; 0 if it is not.
    pub depth: f32,
}

/// # Moving shapes
impl SpatialQuery<'_, '_> {
    /// Returns the first entity that a shape touches as it moves from `start` along `direction`,
    /// for `max_distance` at most: the first time of impact, at one unit of length per unit of
    /// time. The shape does not turn on its way.
    ///
    /// Exact: see [`NarrowPhase::sweep`](crate::narrow_phase::NarrowPhase::sweep). A shape without
    /// bounds, such as a half-space, meets nothing.
    #[doc(alias(
        "shapecast",
        "shape cast",
        "sweep",
        "ccd",
        "sweep test",
        "time of impact",
        "convex cast"
    ))]
    #[must_use]
    pub fn cast_shape(
        &self,
        shape: &Shape,
        start: &Transform,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<ShapeHit> {
        let (moving, options) = (Placed::new(shape, start), ShapeCastOptions::DEFAULT);
        self.cast_shape_with(moving, direction, max_distance, filter, &options)
    }

    /// Returns the first entity that a placed shape touches, as [`cast_shape`](Self::cast_shape), by
    /// these options: boxes and balls, too.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::{narrow_phase::{Placed, Shape}, prelude::*};
    ///
    /// /// How far may a character go, whatever it stands on and leans against?
    /// fn free_way(at: &Transform, way: Dir3, spatial: &SpatialQuery) -> f32 {
    ///     let body = Shape::cuboid(0.6, 1.8, 0.6);
    ///     let options = ShapeCastOptions::DEFAULT.ignore_start();
    ///     let hit = spatial.cast_shape_with(Placed::new(&body, at), way, 10.0, &SpatialQueryFilter::DEFAULT, &options);
    ///     hit.map_or(10.0, |hit| hit.distance)
    /// }
    /// ```
    #[must_use]
    pub fn cast_shape_with(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &ShapeCastOptions,
    ) -> Option<ShapeHit> {
        let cast = self.box_cast(moving, direction, max_distance)?;
        self.first_met(&cast, max_distance, filter, |_, body, limit| {
            let hit = self.shape_hit(body, moving, direction, limit, options)?;
            Some((hit.distance, hit))
        })
    }

    /// What a box meets first on its way, where `meet` says how far each goes that it may meet, given how far is of
    /// interest.
    pub(crate) fn first_met<T>(
        &self,
        cast: &AabbCast3d,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        mut meet: impl FnMut(ProxyId, &Body, f32) -> Option<(f32, T)>,
    ) -> Option<T> {
        let mut best = Best::within(max_distance, self.proxies());
        let nearest = self.index.index().cast_with(cast, |id, _| {
            let body = self.candidate(id, filter)?;
            let (distance, found) = meet(id, body, best.limit())?;
            best.offer(id, distance, found)
        });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Finds all entities that a placed shape touches on its way, by these options: nearest first,
    /// those as near by ascending [`Entity`]. They replace what is in `hits`, which is yours to use
    /// again.
    ///
    /// It goes through all of them: each is met as though it were alone.
    #[doc(alias("shapecast all", "sweep all"))]
    pub fn shape_hits(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &ShapeCastOptions,
        hits: &mut Vec<ShapeHit>,
    ) {
        hits.clear();
        self.for_each_shape_hit(moving, direction, max_distance, filter, options, |hit| {
            hits.push(hit);
        });
        hits.sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then_with(|| self.order_of(a.entity).cmp(&self.order_of(b.entity)))
        });
    }

    /// Calls `found` with every entity that a placed shape touches on its way, as
    /// [`shape_hits`](Self::shape_hits) finds them, in no particular order. It may return a
    /// [`ControlFlow`](std::ops::ControlFlow) to stop.
    pub fn for_each_shape_hit<F: Flow>(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
        options: &ShapeCastOptions,
        mut found: impl FnMut(ShapeHit) -> F,
    ) {
        let Some(cast) = self.box_cast(moving, direction, max_distance) else {
            return;
        };
        self.index.index().for_each_hit(&cast, |hit| {
            let body = self.candidate(hit.proxy, filter);
            let hit = body
                .and_then(|body| self.shape_hit(body, moving, direction, max_distance, options));
            flow(hit.is_none_or(|hit| found(hit).goes_on()))
        });
    }

    /// The way of a shape's box; `None` if it has none. The boxes of two shapes in contact are not
    /// apart: so neither are they on the way.
    pub(super) fn box_cast(
        &self,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
    ) -> Option<AabbCast3d> {
        let aabb = self.tests().world_aabb(moving).ok()?;
        Some(AabbCast3d::new(aabb, Vec3::ZERO, direction, max_distance))
    }

    pub(super) fn shape_hit(
        &self,
        body: &Body,
        moving: Placed,
        direction: Dir3,
        max_distance: f32,
        options: &ShapeCastOptions,
    ) -> Option<ShapeHit> {
        let Impact {
            distance,
            point,
            normal,
            face_normal,
            polygon,
            depth,
        } = scratch::with(|scratch| {
            let workspace = &mut scratch.workspace;
            self.tests().sweep_with(
                moving,
                direction,
                max_distance,
                body.placed(),
                options,
                workspace,
            )
        })?;
        Some(ShapeHit {
            entity: body.entity,
            distance,
            point,
            normal,
            face_normal,
            polygon,
            depth,
        })
    }

    /// Casts a box along the world's axes as [`cast_shape`](Self::cast_shape) does. One that is
    /// inverted meets nothing.
    #[doc(alias("BoxCast", "box cast", "aabb"))]
    #[must_use]
    pub fn cast_box(
        &self,
        start: &Aabb3d,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<ShapeHit> {
        let (cuboid, at) = query::cuboid(start)?;
        self.cast_shape(&cuboid, &at, direction, max_distance, filter)
    }

    /// Casts a ball as [`cast_shape`](Self::cast_shape) does. One with a negative radius meets
    /// nothing.
    #[doc(alias("SphereCast", "sphere cast", "ball cast"))]
    #[must_use]
    pub fn cast_sphere(
        &self,
        center: Vec3,
        radius: f32,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<ShapeHit> {
        let ball = Shape::try_sphere(radius).ok()?;
        self.cast_shape(
            &ball,
            &Transform::from_translation(center),
            direction,
            max_distance,
            filter,
        )
    }
}
