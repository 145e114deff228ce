//! What a broad phase is to know of a placed shape.

use bevy::math::primitives::HalfSpace;
use bevy::math::{Vec3A, bounding::Aabb3d};

use super::error::BoundsError;
use super::frame::placed::{Placed, ROUNDING};
use super::settings::NarrowPhase;
use super::support;

impl NarrowPhase {
    /// Returns the box to feed to a broad phase: that of
    /// [`Shape::world_aabb`](crate::narrow_phase::Shape::world_aabb), grown by half the tolerance
    /// and by rounding. The boxes of two shapes that are in contact are never apart.
    ///
    /// # Errors
    /// As for [`Shape::world_aabb`](crate::narrow_phase::Shape::world_aabb).
    #[doc(alias = "aabb")]
    #[inline]
    pub fn world_aabb(&self, placed: Placed) -> Result<Aabb3d, BoundsError> {
        if let Some((center, reach)) = placed.shape.quick_reach(placed.transform) {
            let grown = self.grown(center - reach, center + reach);
            // Not if one of the two is not.
            if (grown.max - grown.min).is_finite() {
                return Ok(grown);
            }
        }
        self.slow_world_aabb(placed)
    }

    #[cold]
    fn slow_world_aabb(&self, placed: Placed) -> Result<Aabb3d, BoundsError> {
        let Aabb3d { min, max } = placed.shape.world_aabb(placed.transform)?;
        let grown = self.grown(min, max);
        if grown.min.is_finite() && grown.max.is_finite() {
            Ok(grown)
        } else {
            Err(BoundsError::NonFinite)
        }
    }

    /// A box grown by half the tolerance and by rounding.
    #[inline]
    fn grown(&self, min: Vec3A, max: Vec3A) -> Aabb3d {
        // However it is turned, a box is wider than its greatest half extent, from which the
        // tolerance of a pair may come.
        let size = (max - min).max_element();
        let far = min.abs().max(max.abs()).max_element();
        let grown = self.tolerance() * 0.5 + ROUNDING * size + f32::EPSILON * far;
        Aabb3d {
            min: min - grown,
            max: max + grown,
        }
    }

    /// Returns the half-space that holds all that may be in contact with a shape without bounds, if
    /// one does: what a broad phase is to know of it, as of others their
    /// [`world_aabb`](Self::world_aabb). Both are grown by half the tolerance.
    #[must_use]
    pub fn side(&self, placed: Placed) -> Option<HalfSpace> {
        support::side(placed, self.tolerance() * 0.5)
    }
}
