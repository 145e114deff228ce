//! Unbounded objects, such as the ground below a plane: kept apart from the broad phase, whose
//! cells are for boxes.

use bevy::math::{Vec3A, bounding::Aabb3d, primitives::HalfSpace};

use super::boxes::ProxyId;

/// Rounding, as a share of the numbers at hand.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// An unbounded object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unbounded {
    pub(super) id: ProxyId,
    /// Where all of it is, if not everywhere.
    pub(super) side: Option<HalfSpace>,
}

impl Unbounded {
    /// Returns `true` if a box has a part on the side of the object. Rounding leaves none out.
    #[inline]
    pub(super) fn may_meet(&self, aabb: &Aabb3d) -> bool {
        self.side.is_none_or(|side| {
            let normal = side.normal();
            let innermost = Vec3A::select(normal.cmpge(Vec3A::ZERO), aabb.max, aabb.min);
            let slack = ROUNDING * (innermost.abs().element_sum() + side.d().abs());
            innermost.dot(normal) + side.d() + slack >= 0.0
        })
    }
}

#[cfg(test)]
mod tests;
