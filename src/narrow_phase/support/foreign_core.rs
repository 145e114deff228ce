//! The cores of convex shapes of Rapier's that are none of ours.

use bevy::math::{DVec3, Vec3};
use bevy_rapier3d::parry::shape::SupportMap;

/// The core of a convex shape.
#[derive(Clone, Copy)]
pub enum ForeignCore<'a> {
    Hull(&'a [Vec3]),
    Support(&'a dyn SupportMap),
}

impl ForeignCore<'_> {
    /// The point that is furthest along a direction.
    pub fn furthest(self, direction: DVec3) -> DVec3 {
        match self {
            Self::Hull(points) => {
                let along = |point: &&Vec3| point.as_dvec3().dot(direction);
                let furthest = points.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
                furthest.copied().map_or(DVec3::ZERO, Vec3::as_dvec3)
            }
            Self::Support(shape) => shape.local_support_point(direction.as_vec3()).as_dvec3(),
        }
    }
}
