//! Shapes that move without turning.

use bevy::{
    math::bounding::{Aabb3d, AabbCast3d},
    prelude::*,
};

use super::{
    best::Best,
    filter::SpatialQueryFilter,
    query::{self, SpatialQuery},
    scratch,
};
use crate::narrow_phase::{Impact, Placed, Shape, ShapeCastOptions};

/// Where a moving shape first touches an entity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// The entity.
    pub entity: Entity,
    /// How far the shape goes until it touches; 0 if it does so from the start.
    pub distance: f32,
    /// A point where the two touch.
    pub point: Vec3,
    /// A unit vector from the entity to the moving shape, across the surfaces that touch.
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
    /// bounds (some of Rapier's) meets nothing.
    #[must_use]
    #[doc(alias("shapecast", "shape cast", "sweep", "ccd"))]
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
        // The boxes of two shapes in contact are not apart: so neither are they on the way.
        let aabb = self.tests().world_aabb(moving).ok()?;
        let cast = AabbCast3d::new(aabb, Vec3::ZERO, direction, max_distance);
        let sweep = |target: Placed, limit: f32| {
            scratch::with(|scratch| {
                let workspace = &mut scratch.workspace;
                self.tests()
                    .sweep_with(moving, direction, limit, target, options, workspace)
            })
        };
        let mut best = Best::within(max_distance);
        let nearest = self.index.index().cast_with(&cast, |id, _| {
            let body = self.candidate(id, filter)?;
            let Impact {
                distance,
                point,
                normal,
                face_normal,
                polygon,
                depth,
            } = sweep(body.placed(), best.limit())?;
            let hit = ShapeHit {
                entity: body.entity,
                distance,
                point,
                normal,
                face_normal,
                polygon,
                depth,
            };
            best.offer(id, distance, hit)
        });
        best.answer(nearest.map(|hit| hit.proxy))
    }

    /// Casts a box along the world's axes as [`cast_shape`](Self::cast_shape) does. One that is
    /// inverted meets nothing.
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
