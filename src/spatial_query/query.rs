//! The system parameter that is asked.

use std::ops::ControlFlow;

use bevy::{
    ecs::{entity_disabling::Disabled, system::SystemParam},
    math::bounding::Aabb3d,
    prelude::*,
};

use super::filter::SpatialQueryFilter;
use crate::{
    broad_phase::ProxyId,
    collision_index::{Body, CollisionIndex},
    components::BroadPhaseProxy,
    filters::Sensor,
    narrow_phase::{NarrowPhase, Shape},
    parts::PartOf,
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
/// boxes) finds nothing, and does not panic. What several entities are equally far from is decided
/// by the order of their handles in the [`CollisionIndex`].
#[derive(SystemParam)]
#[doc(alias(
    "raycast",
    "shapecast",
    "scene query",
    "overlap",
    "spatial query pipeline"
))]
pub struct SpatialQuery<'w, 's> {
    pub(super) index: Res<'w, CollisionIndex>,
    tests: Res<'w, NarrowPhase>,
    entries: Query<'w, 's, &'static BroadPhaseProxy>,
    sensors: Query<'w, 's, (), With<Sensor>>,
    // What is disabled is not found, but may ask.
    parts: Query<'w, 's, &'static PartOf, Allow<Disabled>>,
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
        self.parts.get(entity).map_or(entity, PartOf::body)
    }

    pub(super) fn tests(&self) -> &NarrowPhase {
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

    /// What is behind the handle of an entity.
    pub(super) fn entry_of(&self, entity: Entity) -> Option<&Body> {
        let id = self.entries.get(entity).ok()?.id()?;
        self.index.body(id).filter(|body| body.entity == entity)
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
