//! The system parameter that is asked.

use std::ops::ControlFlow;

use bevy::{ecs::system::SystemParam, math::bounding::Aabb3d, prelude::*};

use super::filter::SpatialQueryFilter;
use crate::{
    broad_phase::{Proxies, ProxyId},
    collision_index::{Body, CollisionIndex},
    components::BroadPhaseProxy,
    filters::Sensor,
    narrow_phase::{NarrowPhase, Shape},
    parts::KnownParts,
};

/// Asks about entities with a [`CollisionShape`](crate::components::CollisionShape): what a ray or
/// a moving shape meets, what is in a part of space, what is near.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// fn look_ahead(viewers: Query<(Entity, &Transform)>, spatial: SpatialQuery) {
///     for (viewer, transform) in &viewers {
///         let ray = Ray3d::new(transform.translation, transform.forward());
///         if let Some(hit) = spatial.cast_ray(ray, 100.0, &SpatialQueryFilter::DEFAULT.except(viewer)) {
///             println!("{viewer} sees {} at {}", hit.entity, hit.point);
///         }
///     }
/// }
/// # bevy::ecs::system::assert_is_system(look_ahead);
/// ```
///
/// # All questions
///
/// A [`SpatialQueryFilter`] says who is seen, wherever one is taken. `for_each_…` calls back with each
/// answer, and allocates nothing; its plural fills a vector of yours, in an order that is stated.
///
/// **Rays**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`cast_ray`](Self::cast_ray), [`cast_ray_with`](Self::cast_ray_with) | what is the first that a ray meets? | [`RayHit`](super::RayHit): who, how far, where, the normal, which triangle |
/// | [`ray_hits`](Self::ray_hits), [`ray_hits_with`](Self::ray_hits_with) | what are all that it meets? | `RayHit`s, nearest first |
/// | [`for_each_ray_hit`](Self::for_each_ray_hit), [`for_each_ray_hit_with`](Self::for_each_ray_hit_with) | the same | each, in no order |
/// | [`ray_meets_any`](Self::ray_meets_any), [`ray_meets_any_with`](Self::ray_meets_any_with) | is anything in the way? | `bool`, at the first that is met |
/// | [`cast_ray_through`](Self::cast_ray_through) | where does it enter the first, and where leave it? | [`RayPassage`](super::RayPassage) |
/// | [`ray_passages`](Self::ray_passages) | the same of all | `RayPassage`s, first entered first |
/// | [`for_each_ray_passage`](Self::for_each_ray_passage) | the same | each, in no order |
///
/// `…_with` takes [`RayCastOptions`](super::RayCastOptions): hollow solids, front or back faces, not
/// what the ray starts on.
///
/// **Shapes on their way**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`cast_shape`](Self::cast_shape) | what does a shape meet first as it moves along? | [`ShapeHit`](super::ShapeHit): who, how far, where, the normals |
/// | [`cast_shape_with`](Self::cast_shape_with) | the same, by [`ShapeCastOptions`](super::ShapeCastOptions): not what it starts in touch with, which triangle | `ShapeHit` |
/// | [`cast_box`](Self::cast_box), [`cast_sphere`](Self::cast_sphere) | the same of a box along the axes, of a ball | `ShapeHit` |
/// | [`shape_hits`](Self::shape_hits) | what are all that it meets? | `ShapeHit`s, nearest first |
/// | [`for_each_shape_hit`](Self::for_each_shape_hit) | the same | each, in no order |
///
/// **Overlaps**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`box_intersections`](Self::box_intersections), [`for_each_box_intersection`](Self::for_each_box_intersection) | what is in a box along the axes? | entities |
/// | [`sphere_intersections`](Self::sphere_intersections), [`for_each_sphere_intersection`](Self::for_each_sphere_intersection) | what is in a ball? | entities |
/// | [`point_intersections`](Self::point_intersections), [`for_each_point_intersection`](Self::for_each_point_intersection) | what is at a point? | entities |
/// | [`shape_intersections`](Self::shape_intersections), [`for_each_shape_intersection`](Self::for_each_shape_intersection) | what does a shape overlap? | entities |
/// | [`shape_contacts`](Self::shape_contacts), [`for_each_shape_contact`](Self::for_each_shape_contact) | where, which way and how deep? | [`ShapeContact`](super::ShapeContact)s, the deepest first |
/// | [`frustum_intersections`](Self::frustum_intersections), [`for_each_frustum_intersection`](Self::for_each_frustum_intersection) | whose box is in a view frustum? | entities |
/// | [`half_space_intersections`](Self::half_space_intersections), [`for_each_half_space_intersection`](Self::for_each_half_space_intersection) | whose box is on the inner side of some planes? | entities |
///
/// **Distances**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`nearest`](Self::nearest) | who is nearest to a point? | [`PointHit`](super::PointHit): who, how far, which point of it |
/// | [`k_nearest`](Self::k_nearest) | who are the k nearest? | `PointHit`s, nearest first |
/// | [`within`](Self::within), [`for_each_within`](Self::for_each_within) | who is within a distance of a point? | `PointHit`s, nearest first; each, in no order |
/// | [`distance_between`](Self::distance_between) | how far are two entities apart? | [`PairHit`](super::PairHit): how far, and where they are closest |
///
/// **Many at once**, on all threads with the feature `multi_threaded`
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`cast_rays`](Self::cast_rays), [`cast_rays_with`](Self::cast_rays_with) | what does each of many rays meet first? | an `Option<RayHit>` for each |
/// | [`rays_meet_any`](Self::rays_meet_any) | is anything in the way of each? | a `bool` for each |
/// | [`nearest_of_each`](Self::nearest_of_each) | who is nearest to each of many points? | an `Option<PointHit>` for each |
/// | [`k_nearest_of_each`](Self::k_nearest_of_each) | who are the k nearest to each? | [`HitLists`](super::HitLists), a list for each |
/// | [`within_of_each`](Self::within_of_each) | who is within a distance of each? | `HitLists` |
///
/// **Pairs**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`pairs_among`](Self::pairs_among), [`for_each_pair_among`](Self::for_each_pair_among) | which of a group are near each other? | `PairHit`s, nearest first; each, in no order |
/// | [`pairs_within`](Self::pairs_within), [`for_each_pair_within`](Self::for_each_pair_within) | who of one group is near whom of another? | the same |
///
/// **Elsewhere**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`at`](Self::at) | what if some entities were at other poses, as they were some ticks ago? | a [`PosedQuery`](super::PosedQuery), for rays, shapes and overlaps |
///
/// **Entities**
///
/// | method | the question | the answer |
/// |---|---|---|
/// | [`body_of`](Self::body_of) | what is an entity a part of? | its [body](crate::parts), or itself |
/// | [`filter_of`](Self::filter_of) | what may it come into contact with? | a [`SpatialQueryFilter`] |
/// | [`index`](Self::index) | what is in the index, by handle and box? | [`CollisionIndex`] |
///
/// # Exactness
///
/// All answers but those about frustums are about the shapes themselves, not their boxes: oriented
/// cuboids, spheres, convex and general meshes as they are, Rapier colliders by what they consist
/// of. What touches counts as met: see [`NarrowPhase::intersects`],
/// [`cast_ray`](NarrowPhase::cast_ray), [`sweep`](NarrowPhase::sweep),
/// [`closest_point`](NarrowPhase::closest_point). Solids are solid: a ray that starts inside one
/// meets it at a distance of 0, unless its [options](super::RayCastOptions) say otherwise.
///
/// # What is seen
///
/// Entities where they were at the last tick: after the set
/// [`Maintenance`](crate::CollisionSystems::Maintenance), that of this tick.
/// [`update_spatial_index`](super::update_spatial_index) brings the index up to date at any other
/// moment: in the frame of a spawn, or while time is paused. Despawned and disabled entities, and
/// those without a valid box, are never found. [`Sensor`]s are found like all others: what is to go
/// through triggers and pickups says so by
/// [`without_sensors`](SpatialQueryFilter::without_sensors).
///
/// # Cost
///
/// Nothing is allocated per query, but for what a caller's vector grows by, and buffers for meshes
/// that stay with the thread. Bad input (what is not finite, negative distances and radii, inverted
/// boxes) finds nothing, and does not panic. Of several entities that are equally far away, the first counts: by the index of
/// the [`Entity`], or by its [`CollisionOrder`](crate::collision_order::CollisionOrder).
#[doc(alias(
    "raycast",
    "shapecast",
    "scene query",
    "overlap",
    "spatial query pipeline",
    "physics query",
    "space state",
    "PhysicsDirectSpaceState3D"
))]
#[derive(SystemParam)]
pub struct SpatialQuery<'w, 's> {
    pub(super) index: Res<'w, CollisionIndex>,
    tests: Res<'w, NarrowPhase>,
    entries: Query<'w, 's, &'static BroadPhaseProxy>,
    sensors: Query<'w, 's, (), With<Sensor>>,
    // What is disabled is not found, but may ask.
    parts: Res<'w, KnownParts>,
}

impl SpatialQuery<'_, '_> {
    /// Returns the index that is asked: its boxes, by handle.
    #[must_use]
    pub fn index(&self) -> &CollisionIndex {
        &self.index
    }

    /// Returns the [body](crate::parts) that an entity is a part of; what is part of none is its
    /// own.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_octree::prelude::*;
    /// fn aim(ray: Ray3d, own: Entity, spatial: SpatialQuery) -> Option<Entity> {
    ///     let filter = SpatialQueryFilter::DEFAULT.without_body(own);
    ///     let hit = spatial.cast_ray(ray, 100.0, &filter)?;
    ///     Some(spatial.body_of(hit.entity))
    /// }
    /// ```
    #[must_use]
    pub fn body_of(&self, entity: Entity) -> Entity {
        self.parts.body_of(entity)
    }

    /// Returns the filter that lets pass what an entity may come into contact with, by its layers and theirs, its world and
    /// its [body](crate::parts); [sensors](Sensor), which nothing is stopped by, not included. An entity that is not in
    /// the index sees the default world, without itself.
    ///
    /// What is in a list of [`IgnoreCollisions`](crate::filters::IgnoreCollisions), or is ruled out by a
    /// [hook](crate::filters::PairHook), is seen.
    #[must_use]
    pub fn filter_of(&self, entity: Entity) -> SpatialQueryFilter<'static> {
        let all = SpatialQueryFilter::DEFAULT.except(entity).without_sensors();
        let id = self.entries.get(entity).ok().and_then(BroadPhaseProxy::id);
        match id.filter(|id| self.index.is_entry_of(*id, entity)) {
            Some(id) => all.met_by(self.index.index().proxies().filter(id)),
            None => all,
        }
    }

    pub(super) fn proxies(&self) -> &Proxies {
        self.index.index().proxies()
    }

    /// Where an entity stands among those that are as near.
    pub(crate) fn order_of(&self, entity: Entity) -> (u64, Entity) {
        let order = || {
            let id = self.entries.get(entity).ok()?.id()?;
            Some(self.index.order_of(id, entity))
        };
        let order = if self.index.is_ordered() {
            order()
        } else {
            None
        };
        (order.unwrap_or(0), entity)
    }

    /// Puts entities in their order.
    pub(super) fn sort(&self, entities: &mut [Entity]) {
        if self.index.is_ordered() {
            entities.sort_by_cached_key(|entity| self.order_of(*entity));
        } else {
            entities.sort_unstable();
        }
    }

    pub(crate) fn tests(&self) -> &NarrowPhase {
        &self.tests
    }

    /// What is behind a handle, if the filter lets it pass.
    pub(super) fn candidate(&self, id: ProxyId, filter: &SpatialQueryFilter) -> Option<&Body> {
        let object = self.index.index().proxies().filter(id);
        self.index.body(id).filter(|body| {
            filter.accepts(body.entity, &object)
                && !(filter.skips_sensors() && self.sensors.contains(body.entity))
                && filter
                    .excluded_body()
                    .is_none_or(|own| self.body_of(own) != self.body_of(body.entity))
        })
    }

    /// The handle of an entity.
    pub(super) fn id_of(&self, entity: Entity) -> Option<ProxyId> {
        let id = self.entries.get(entity).ok()?.id()?;
        self.index.is_entry_of(id, entity).then_some(id)
    }

    /// What is behind the handle of an entity.
    pub(crate) fn entry_of(&self, entity: Entity) -> Option<&Body> {
        self.index.body(self.id_of(entity)?)
    }
}

pub(super) fn flow(goes_on: bool) -> ControlFlow<()> {
    if goes_on {
        ControlFlow::Continue(())
    } else {
        ControlFlow::Break(())
    }
}

/// A box along the world's axes as a shape, if it is a box.
pub(super) fn cuboid(aabb: &Aabb3d) -> Option<(Shape, Transform)> {
    let center = aabb.min * 0.5 + aabb.max * 0.5;
    let shape = Shape::try_from_half_size((aabb.max * 0.5 - aabb.min * 0.5).into()).ok()?;
    Some((shape, Transform::from_translation(center.into())))
}
