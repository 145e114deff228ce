//! Convex shapes with a radius around them.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A};

use super::{error::ShapeError, length::length, mesh::convex_mesh::ConvexMesh};

/// A convex core and all that is no further from it than a radius: a cuboid with round edges, a
/// capsule in any direction; with a radius of zero, the core itself, which may be a segment or a
/// triangle.
///
/// Made by [`Shape::rounded`](super::Shape::rounded) and others of the constructors there. The core follows a scale along each of its own axes, the radius the largest
/// of the three.
#[derive(Clone, Debug)]
pub struct Rounded {
    core: RoundedCore,
    radius: f32,
}

/// The core of a [`Rounded`] shape.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum RoundedCore {
    /// From one point to another.
    Segment([Vec3; 2]),
    /// Between three points.
    Triangle([Vec3; 3]),
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A frustum of a cone around the y axis, its middle at the origin.
    ConicalFrustum {
        /// The radius at its top.
        radius_top: f32,
        /// The radius at its bottom.
        radius_bottom: f32,
        /// Half its height.
        half_height: f32,
    },
    /// A convex solid.
    Convex(Arc<ConvexMesh>),
}

impl Rounded {
    /// Makes the shape of a core and a radius around it.
    ///
    /// # Errors
    /// [`ShapeError::Length`] or [`ShapeError::HalfSize`] if a size is negative, NaN or infinite;
    /// [`ShapeError::NonFiniteVertex`] if a point is not finite.
    pub fn new(core: RoundedCore, radius: f32) -> Result<Self, ShapeError> {
        let points: &[Vec3] = match &core {
            RoundedCore::Segment(ends) => ends,
            RoundedCore::Triangle(corners) => corners,
            RoundedCore::Cuboid { half_size } => {
                if !half_size.is_finite() || half_size.min_element() < 0.0 {
                    return Err(ShapeError::HalfSize(*half_size));
                }
                &[]
            }
            RoundedCore::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => {
                ShapeError::check("radius at the top", *radius_top)?;
                ShapeError::check("radius at the bottom", *radius_bottom)?;
                ShapeError::check("height", *half_height)?;
                &[]
            }
            RoundedCore::Convex(_) => &[],
        };
        if let Some(vertex) = points.iter().position(|point| !point.is_finite()) {
            let position = points[vertex];
            return Err(ShapeError::NonFiniteVertex { vertex, position });
        }
        ShapeError::check("radius", radius)?;
        Ok(Self { core, radius })
    }

    /// Returns the core.
    #[must_use]
    pub const fn core(&self) -> &RoundedCore {
        &self.core
    }

    /// Returns the radius around the core.
    #[must_use]
    pub const fn radius(&self) -> f32 {
        self.radius
    }

    /// Centre, half extents and bounding radius of the core.
    pub(super) fn core_bounds(&self) -> (Vec3A, Vec3A, f32) {
        let of = |points: &[Vec3]| {
            let points = points.iter().copied().map(Vec3A::from);
            let (low, high) = points.clone().fold(
                (Vec3A::INFINITY, Vec3A::NEG_INFINITY),
                |(low, high), point| (low.min(point), high.max(point)),
            );
            let center = low.midpoint(high);
            let radius = points.fold(0.0, |radius: f32, point| radius.max(length(point - center)));
            (center, high - center, radius)
        };
        match &self.core {
            RoundedCore::Segment(ends) => of(ends),
            RoundedCore::Triangle(corners) => of(corners),
            RoundedCore::Cuboid { half_size } => {
                let half = Vec3A::from(*half_size).abs();
                (Vec3A::ZERO, half, length(half))
            }
            RoundedCore::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => frustum_bounds(*radius_top, *radius_bottom, *half_height),
            RoundedCore::Convex(mesh) => mesh.local_bounds(),
        }
    }
}

/// Centre, half extents and bounding radius of a frustum of a cone around the y axis.
pub(super) fn frustum_bounds(top: f32, bottom: f32, half_height: f32) -> (Vec3A, Vec3A, f32) {
    let half_height = half_height.abs();
    let radius = top.abs().max(bottom.abs());
    let half = Vec3A::new(radius, half_height, radius);
    (Vec3A::ZERO, half, length(half.with_z(0.0)))
}
