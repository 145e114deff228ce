//! Queries, drawn by whoever makes them.

use bevy::{math::bounding::Aabb3d, prelude::*};

use super::{
    gizmos::{CollisionGizmos, surface_point},
    sweep::swept_box,
};
use crate::spatial_query::RayHit;

/// Draws what queries asked, and what they found, in the colours of the [`CollisionGizmos`].
/// Answers are not kept anywhere, so a system that wants to see its own draws it:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// // Where there is no `CollisionDebugPlugin`, there are no gizmos.
/// fn look_ahead(viewers: Query<&Transform>, spatial: SpatialQuery, mut gizmos: Option<Gizmos<CollisionGizmos>>) {
///     for transform in &viewers {
///         let ray = Ray3d::new(transform.translation, transform.forward());
///         let hit = spatial.cast_ray(ray, 100.0, &SpatialQueryFilter::DEFAULT);
///         if let Some(gizmos) = &mut gizmos {
///             gizmos.ray_hit(ray, hit);
///         }
///     }
/// }
/// # bevy::ecs::system::assert_is_system(look_ahead);
/// ```
pub trait QueryGizmos {
    /// Draws a [ray](CollisionGizmos::rays) as far as its hit, which gets a cross, and an arrow
    /// along the normal; one that hits nothing as far as the
    /// [`ray_length`](CollisionGizmos::ray_length).
    fn ray_hit(&mut self, ray: Ray3d, hit: Option<RayHit>);

    /// Draws a [box on its way](CollisionGizmos::sweeps), as of a shape cast: at its start, at its
    /// end, and the lines of its corners between the two.
    fn swept_box(&mut self, start: &Aabb3d, end: &Aabb3d);
}

impl<Clear: Send + Sync + 'static> QueryGizmos for Gizmos<'_, '_, CollisionGizmos, Clear> {
    fn ray_hit(&mut self, ray: Ray3d, hit: Option<RayHit>) {
        let CollisionGizmos {
            rays: Some(color),
            ray_length,
            ..
        } = *self.config_ext
        else {
            return;
        };
        let Some(RayHit { point, normal, .. }) = hit else {
            return self.ray(ray.origin, ray.direction * ray_length, color);
        };
        self.line(ray.origin, point, color);
        surface_point(self, point, normal, color);
    }

    fn swept_box(&mut self, start: &Aabb3d, end: &Aabb3d) {
        if let Some(color) = self.config_ext.sweeps {
            swept_box(self, start, end, color);
        }
    }
}
