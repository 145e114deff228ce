//! Parts of space.

use bevy::{
    math::{
        bounding::Aabb3d,
        primitives::{HalfSpace, ViewFrustum},
    },
    prelude::*,
};

use super::{SpatialQuery, SpatialQueryFilter, flow, scratch};
use crate::{
    broad_phase::{EVERYWHERE, Flow, Region},
    narrow_phase::{BoundsError, Placed, Shape},
};

/// # What is in a part of space
///
/// All of these call `found` with each entity once, in no particular order; it may return a
/// [`ControlFlow`](std::ops::ControlFlow) to stop.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_octree::prelude::*;
/// fn blast(center: Vec3, spatial: SpatialQuery, mut commands: Commands) {
///     spatial.sphere_intersections(center, 5.0, &SpatialQueryFilter::default(), |entity| {
///         commands.entity(entity).despawn();
///     });
/// }
/// ```
impl SpatialQuery<'_> {
    /// The entities whose shapes overlap a box along the world's axes. One that is inverted overlaps nothing.
    pub fn box_intersections<F: Flow>(
        &self,
        aabb: &Aabb3d,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        if let Some((cuboid, at)) = super::cuboid(aabb) {
            self.shape_intersections(&cuboid, &at, filter, found);
        }
    }

    /// The entities whose shapes overlap a ball. One with a negative radius overlaps nothing.
    pub fn sphere_intersections<F: Flow>(
        &self,
        center: Vec3,
        radius: f32,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        if let Ok(ball) = Shape::try_sphere(radius) {
            self.shape_intersections(&ball, &Transform::from_translation(center), filter, found);
        }
    }

    /// The entities whose shapes hold a point, or are no farther from it than the tolerance.
    pub fn point_intersections<F: Flow>(
        &self,
        point: Vec3,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.sphere_intersections(point, 0.0, filter, found);
    }

    /// The entities whose shapes are in contact with a shape at a place, by
    /// [`NarrowPhase::intersects`](crate::narrow_phase::NarrowPhase::intersects). A shape without bounds (some of
    /// Rapier's) is tested against all entities.
    pub fn shape_intersections<F: Flow>(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(Entity) -> F,
    ) {
        let placed = Placed::new(shape, at);
        let aabb = match self.tests().world_aabb(placed) {
            Ok(aabb) => aabb,
            Err(BoundsError::Unbounded) => EVERYWHERE,
            Err(BoundsError::NonFinite) => return,
        };
        self.index.index().overlapping(&aabb, |id| {
            let met = self.candidate(id, filter).filter(|body| {
                scratch::with(|scratch| self.tests().intersects(placed, body.placed(), &mut scratch.workspace))
            });
            flow(met.is_none_or(|body| found(body.entity).goes_on()))
        });
    }

    /// The entities whose *boxes* are in a view frustum, as far as its planes tell: see [`Region`]. Those without an end
    /// are in all of them.
    pub fn frustum_intersections<F: Flow>(
        &self,
        frustum: &ViewFrustum,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.boxes_in(frustum, filter, found);
    }

    /// The entities whose *boxes* have a part on the inner side of each plane, and those without an end.
    pub fn half_space_intersections<F: Flow>(
        &self,
        planes: &[HalfSpace],
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.boxes_in(planes, filter, found);
    }

    fn boxes_in<F: Flow>(
        &self,
        region: &(impl Region + ?Sized),
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(Entity) -> F,
    ) {
        self.index.index().overlapping(region, |id| {
            let body = self.candidate(id, filter);
            flow(body.is_none_or(|body| found(body.entity).goes_on()))
        });
    }
}
