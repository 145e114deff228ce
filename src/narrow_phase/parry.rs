//! Shapes of `bevy_rapier3d`, decided by parry.

use std::sync::OnceLock;

use bevy::math::Vec3A;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::shape::SharedShape;

use super::{BoundsError, Shape};

/// A mesh as parry knows it, made when it first meets a Rapier shape.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache(OnceLock<Option<SharedShape>>);

/// Half extents beyond this stand for infinity: parry gives endless shapes boxes of this order.
const ENDLESS: f32 = f32::MAX / 8.0;

/// Centre, half extents and bounding radius of the unplaced shape.
pub(super) fn local_bounds(shape: &SharedShape) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
    let aabb = shape.compute_local_aabb();
    let (min, max) = (Vec3A::from(aabb.mins), Vec3A::from(aabb.maxs));
    if min.is_nan() || max.is_nan() {
        return Err(BoundsError::NonFinite);
    }
    let half = (max * 0.5 - min * 0.5).max(Vec3A::ZERO);
    if half.max_element() > ENDLESS {
        return Err(BoundsError::Unbounded);
    }
    Ok((min * 0.5 + max * 0.5, half, half.length()))
}

impl From<SharedShape> for Shape {
    fn from(shape: SharedShape) -> Self {
        Self::Rapier(shape)
    }
}

impl From<&Collider> for Shape {
    /// The collider as `bevy_rapier3d` has it now, its scale baked in.
    fn from(collider: &Collider) -> Self {
        Self::Rapier(collider.raw.clone())
    }
}
