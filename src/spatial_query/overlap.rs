//! Parts of space.

use bevy::{
    math::{
        bounding::Aabb3d,
        primitives::{HalfSpace, ViewFrustum},
    },
    prelude::*,
};

use super::{
    filter::SpatialQueryFilter,
    query::{self, SpatialQuery, flow},
    scratch,
};
use crate::{
    broad_phase::{EVERYWHERE, Flow, ProxyId, Region},
    collision_index::Body,
    narrow_phase::{BoundsError, Placed, Shape},
};

/// # What is in a part of space
///
/// Each question comes in two forms. `for_each_…` calls `found` with each entity once, in no
/// particular order; it may return a [`ControlFlow`](std::ops::ControlFlow) to stop. The plural
/// fills a vector with all of them, by ascending [`Entity`]; they replace what is in it, and it is
/// yours to use again.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_octree::prelude::*;
/// fn blast(center: Vec3, spatial: SpatialQuery, mut commands: Commands) {
///     spatial.for_each_sphere_intersection(center, 5.0, &SpatialQueryFilter::default(), |entity| {
///         commands.entity(entity).despawn();
///     });
/// }
///
/// fn crowd(spatial: SpatialQuery, mut near: Local<Vec<Entity>>) {
///     spatial.sphere_intersections(Vec3::ZERO, 5.0, &SpatialQueryFilter::default(), &mut near);
///     println!("{} are near: {near:?}", near.len());
/// }
/// # bevy::ecs::system::assert_is_system(crowd);
/// ```
impl SpatialQuery<'_, '_> {
    /// Finds the entities whose shapes overlap a box along the world's axes. One that is inverted
    /// overlaps nothing.
    #[doc(alias("aabb", "overlap box", "OverlapBox"))]
    pub fn for_each_box_intersection<F: Flow>(
        &self,
        aabb: &Aabb3d,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        if let Some((cuboid, at)) = query::cuboid(aabb) {
            self.for_each_shape_intersection(&cuboid, &at, filter, found);
        }
    }

    /// Fills a vector as [`for_each_box_intersection`](Self::for_each_box_intersection) calls back.
    #[doc(alias("OverlapBox", "overlap box", "aabb"))]
    pub fn box_intersections(
        &self,
        aabb: &Aabb3d,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_box_intersection(aabb, filter, found);
        });
    }

    /// Finds the entities whose shapes overlap a ball. One with a negative radius overlaps nothing.
    #[doc(alias("overlap sphere", "within distance", "radius", "OverlapSphere"))]
    pub fn for_each_sphere_intersection<F: Flow>(
        &self,
        center: Vec3,
        radius: f32,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        if let Ok(ball) = Shape::try_sphere(radius) {
            self.for_each_shape_intersection(
                &ball,
                &Transform::from_translation(center),
                filter,
                found,
            );
        }
    }

    /// Fills a vector as [`for_each_sphere_intersection`](Self::for_each_sphere_intersection) calls
    /// back.
    #[doc(alias("OverlapSphere", "overlap sphere", "radius"))]
    pub fn sphere_intersections(
        &self,
        center: Vec3,
        radius: f32,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_sphere_intersection(center, radius, filter, found);
        });
    }

    /// Finds the entities whose shapes hold a point, or are no farther from it than the tolerance.
    #[doc(alias = "contains point")]
    pub fn for_each_point_intersection<F: Flow>(
        &self,
        point: Vec3,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.for_each_sphere_intersection(point, 0.0, filter, found);
    }

    /// Fills a vector as [`for_each_point_intersection`](Self::for_each_point_intersection) calls
    /// back.
    #[doc(alias("OverlapPoint", "contains point"))]
    pub fn point_intersections(
        &self,
        point: Vec3,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_point_intersection(point, filter, found);
        });
    }

    /// Finds the entities whose shapes are in contact with a shape at a place, by
    /// [`NarrowPhase::intersects`](crate::narrow_phase::NarrowPhase::intersects). A shape without
    /// bounds, such as a half-space, is tested against all entities. Where they touch is told by
    /// [`for_each_shape_contact`](Self::for_each_shape_contact).
    #[doc(alias("overlap shape", "intersection test"))]
    pub fn for_each_shape_intersection<F: Flow>(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(Entity) -> F,
    ) {
        let placed = Placed::new(shape, at);
        self.for_each_near_shape(placed, filter, |_, body| {
            let met = scratch::with(|scratch| {
                self.tests()
                    .intersects(placed, body.placed(), &mut scratch.workspace)
            });
            !met || found(body.entity).goes_on()
        });
    }

    /// Everything whose box a placed shape may touch, until `found` returns `false`.
    pub(crate) fn for_each_near_shape(
        &self,
        shape: Placed,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(ProxyId, &Body) -> bool,
    ) {
        let aabb = match self.tests().world_aabb(shape) {
            Ok(aabb) => aabb,
            Err(BoundsError::Unbounded) => EVERYWHERE,
            Err(BoundsError::NonFinite) => return,
        };
        self.index.index().for_each_overlapping(&aabb, |id| {
            flow(
                self.candidate(id, filter)
                    .is_none_or(|body| found(id, body)),
            )
        });
    }

    /// Fills a vector as [`for_each_shape_intersection`](Self::for_each_shape_intersection) calls
    /// back.
    #[doc(alias("overlap shape", "intersection test", "intersect_shape"))]
    pub fn shape_intersections(
        &self,
        shape: &Shape,
        at: &Transform,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_shape_intersection(shape, at, filter, found);
        });
    }

    /// Finds the entities whose *boxes* are in a view frustum, as far as its planes tell: see
    /// [`Region`]. Those without an end are in all of them.
    #[doc(alias = "culling")]
    pub fn for_each_frustum_intersection<F: Flow>(
        &self,
        frustum: &ViewFrustum,
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.for_each_box_in(frustum, filter, found);
    }

    /// Fills a vector as [`for_each_frustum_intersection`](Self::for_each_frustum_intersection)
    /// calls back.
    #[doc(alias("culling", "frustum culling"))]
    pub fn frustum_intersections(
        &self,
        frustum: &ViewFrustum,
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_frustum_intersection(frustum, filter, found);
        });
    }

    /// Finds the entities whose *boxes* have a part on the inner side of each plane, and those
    /// without an end.
    pub fn for_each_half_space_intersection<F: Flow>(
        &self,
        planes: &[HalfSpace],
        filter: &SpatialQueryFilter,
        found: impl FnMut(Entity) -> F,
    ) {
        self.for_each_box_in(planes, filter, found);
    }

    /// Fills a vector as
    /// [`for_each_half_space_intersection`](Self::for_each_half_space_intersection) calls back.
    pub fn half_space_intersections(
        &self,
        planes: &[HalfSpace],
        filter: &SpatialQueryFilter,
        entities: &mut Vec<Entity>,
    ) {
        self.fill(entities, |found| {
            self.for_each_half_space_intersection(planes, filter, found);
        });
    }

    fn for_each_box_in<F: Flow>(
        &self,
        region: &(impl Region + ?Sized),
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(Entity) -> F,
    ) {
        self.index.index().for_each_overlapping(region, |id| {
            let body = self.candidate(id, filter);
            flow(body.is_none_or(|body| found(body.entity).goes_on()))
        });
    }

    /// Fills a vector with all that a search finds, in an order that depends on nothing else.
    fn fill(&self, entities: &mut Vec<Entity>, search: impl FnOnce(&mut dyn FnMut(Entity))) {
        entities.clear();
        search(&mut |entity| entities.push(entity));
        self.sort(entities);
    }
}
