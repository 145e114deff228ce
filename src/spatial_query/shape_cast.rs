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
use crate::narrow_phase::{Impact, Placed, Shape};

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
    /// The unit normal of the face of the entity that is touched, whichever side of it that is, or
    /// as `normal`. See [`Impact::face_normal`].
    pub face_normal: Vec3,
    /// Which polygon of a mesh is touched: of a Bevy mesh, which triangle. See
    /// [`Impact::polygon`].
    pub polygon: Option<u32>,
}

/// # Moving shapes
impl SpatialQuery<'_> {
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
        let moving = Placed::new(shape, start);
        // The boxes of two shapes in contact are not apart: so neither are they on the way.
        let aabb = self.tests().world_aabb(moving).ok()?;
        let cast = AabbCast3d::new(aabb, Vec3::ZERO, direction, max_distance);
        let sweep = |target: Placed, limit: f32| {
            scratch::with(|scratch| {
                self.tests()
                    .sweep(moving, direction, limit, target, &mut scratch.workspace)
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
            } = sweep(body.placed(), best.limit())?;
            best.offer(
                id,
                distance,
                ShapeHit {
                    entity: body.entity,
                    distance,
                    point,
                    normal,
                    face_normal,
                    polygon,
                },
            )
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
