//! Boxes with axes of their own: the frame in which every test of a pair is computed.

use bevy::math::bounding::{Aabb3d, BoundingSphere};
use bevy::math::{Mat3A, Quat, Vec3, Vec3A};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    error::BoundsError,
    shape::{Shape, larger},
};

/// The box around a placed shape, turned with it; the shape itself, if that is a cuboid.
///
/// Positions are relative to an origin of the caller's choice: for a pair, the position of one of
/// the two, so that 32-bit floats are as exact far from the world's origin as close to it.
#[derive(Clone, Copy, Debug)]
pub struct OrientedBox {
    pub center: Vec3A,
    /// Unit vectors, at right angles to each other.
    pub axes: Mat3A,
    /// Half the side along each axis.
    pub half: Vec3A,
    /// Around `center`; no larger than half the diagonal, smaller for shapes that miss the corners.
    pub radius: f32,
}

impl OrientedBox {
    /// That of a point at the origin.
    pub const POINT: Self = Self {
        center: Vec3A::ZERO,
        axes: Mat3A::IDENTITY,
        half: Vec3A::ZERO,
        radius: 0.0,
    };

    #[inline]
    pub fn of(shape: &Shape, transform: &Transform, origin: Vec3) -> Result<Self, BoundsError> {
        let rotation = transform.rotation.normalize();
        let is_finite = || transform.is_finite() && rotation.is_finite();
        let of_unbounded = |error| {
            if is_finite() {
                error
            } else {
                BoundsError::NonFinite
            }
        };
        let scale = shape.effective_scale(transform.scale);
        let (local_center, half, radius) = shape.bounds_at(scale).map_err(of_unbounded)?;
        let axes = match shape {
            // The box around a ball need not turn with it.
            Shape::Sphere { .. } if rotation.is_finite() => Mat3A::IDENTITY,
            _ => Mat3A::from_quat(rotation),
        };
        let placed = Self {
            center: Vec3A::from(transform.translation - origin) + axes * local_center,
            axes,
            half,
            // Where the square of the first is beyond all numbers, the second is not.
            radius: half.length().min(radius),
        };
        // A NaN anywhere in axes or extents shows in the reach.
        if (placed.center.abs() + placed.reach()).is_finite() && placed.radius.is_finite() {
            Ok(placed)
        } else {
            Err(BoundsError::NonFinite)
        }
    }

    /// Half extents of the axis-aligned box around this one.
    #[inline]
    pub fn reach(&self) -> Vec3A {
        self.axes.abs() * self.half
    }

    /// How far the box reaches from its centre along a unit vector.
    #[inline]
    pub fn extent(&self, direction: Vec3A) -> f32 {
        (self.axes.transpose() * direction).abs().dot(self.half)
    }

    /// The point of the box closest to `point`; `point` itself if inside.
    #[inline]
    pub fn closest_point(&self, point: Vec3A) -> Vec3A {
        let local = self.axes.transpose() * (point - self.center);
        self.center + self.axes * local.clamp(-self.half, self.half)
    }
}

/// Is there a turn left when it is normalised? In doubt, it is looked at with care.
#[inline]
fn is_rotation(rotation: Quat) -> bool {
    let share = rotation.length_recip();
    share > 0.0 && share.is_finite()
}

impl Shape {
    /// Returns an axis-aligned box around the shape in the world, in constant time. It is the
    /// smallest one for cuboids and spheres, up to rounding; for all others, it is the
    /// smallest around their own box, turned and scaled with them.
    ///
    /// A broad phase should be fed the slightly larger [`NarrowPhase::world_aabb`], so that it
    /// misses no pair which is in contact by tolerance.
    ///
    /// # Errors
    /// [`BoundsError::NonFinite`] if the transform holds NaN or infinity or overflows;
    /// [`BoundsError::Unbounded`] for a shape without an end, such as a half-space.
    ///
    /// [`NarrowPhase::world_aabb`]: crate::narrow_phase::NarrowPhase::world_aabb
    #[doc(alias = "aabb")]
    pub fn world_aabb(&self, transform: &Transform) -> Result<Aabb3d, BoundsError> {
        let oriented = OrientedBox::of(self, transform, Vec3::ZERO)?;
        let (center, reach) = (oriented.center, oriented.reach());
        Ok(Aabb3d {
            min: center - reach,
            max: center + reach,
        })
    }

    /// The centre and the half sides of the box around the shape in the world, if that is quick to
    /// tell: of what is not turned, of balls, and of cuboids. They may be not finite.
    #[inline]
    pub(in crate::narrow_phase) fn quick_reach(
        &self,
        transform: &Transform,
    ) -> Option<(Vec3A, Vec3A)> {
        let (at, scale) = (Vec3A::from(transform.translation), transform.scale);
        Some(match self {
            Self::Cuboid { half_size } => {
                let half = (Vec3A::from(*half_size) * Vec3A::from(scale)).abs();
                if transform.rotation == Quat::IDENTITY {
                    (at, half)
                } else {
                    let axes = Mat3A::from_quat(transform.rotation.normalize());
                    (at, axes.abs() * half)
                }
            }
            // However it is turned, as long as that is a rotation.
            Self::Sphere { radius } if is_rotation(transform.rotation) => {
                let Vec3 { x, y, z } = scale.abs();
                let radius = radius.abs() * larger(larger(x, y), z);
                (at, Vec3A::splat(radius))
            }
            Self::Capsule {
                radius,
                half_length,
            } => {
                let Vec3 { x, y, z } = scale.abs();
                let end = Vec3A::from(transform.rotation.normalize() * Vec3::Y);
                let reach = end.abs() * (half_length.abs() * y);
                (at, reach + radius.abs() * larger(x, z))
            }
            Self::Convex(_) | Self::Mesh(_) if transform.rotation == Quat::IDENTITY => {
                let (center, half, _) = self.own_mesh()?.local_bounds();
                (
                    at + center * Vec3A::from(scale),
                    half * Vec3A::from(scale.abs()),
                )
            }
            _ => return None,
        })
    }

    /// Returns a sphere around the shape in the world, centred on its box. The smallest one for
    /// cuboids and spheres.
    ///
    /// # Errors
    /// As for [`world_aabb`](Self::world_aabb).
    pub fn bounding_sphere(&self, transform: &Transform) -> Result<BoundingSphere, BoundsError> {
        let oriented = OrientedBox::of(self, transform, Vec3::ZERO)?;
        Ok(BoundingSphere::new(oriented.center, oriented.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_4;

    #[test]
    fn turned_cube_reaches_further() {
        let shape = Shape::from_half_size(Vec3::ONE);
        let transform = Transform::from_xyz(1.0, 2.0, 3.0)
            .with_rotation(Quat::from_rotation_z(FRAC_PI_4))
            .with_scale(Vec3::new(1.0, -1.0, 5.0));
        let placed = OrientedBox::of(&shape, &transform, Vec3::ZERO).unwrap();
        let diagonal = 2f32.sqrt();
        assert!((placed.reach() - Vec3A::new(diagonal, diagonal, 5.0)).length() < 1e-5);
        assert!((placed.radius - 27f32.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn closest_point_is_clamped_along_own_axes() {
        let shape = Shape::from_half_size(Vec3::ONE);
        let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
        let placed = OrientedBox::of(&shape, &turned, Vec3::ZERO).unwrap();
        let closest = placed.closest_point(Vec3A::new(5.0, 0.0, 0.0));
        assert!((closest - Vec3A::new(2f32.sqrt(), 0.0, 0.0)).length() < 1e-5);
        let inside = Vec3A::new(0.1, 0.2, 0.3);
        assert!((placed.closest_point(inside) - inside).length() < 1e-6);
    }
}
