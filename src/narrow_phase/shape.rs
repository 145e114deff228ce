//! The shapes that the exact tests know.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A, primitives};
#[cfg(feature = "rapier")]
use bevy_rapier3d::parry::shape::SharedShape;

use super::error::{BoundsError, ShapeError};
use super::length::length;
use super::mesh::{convex_mesh::ConvexMesh, polygon_mesh::PolygonMesh};

#[cfg(feature = "rapier")]
/// Half extents beyond this stand for infinity: parry gives endless shapes boxes of this order.
const ENDLESS: f32 = f32::MAX / 8.0;

/// What an object is made of, in its own coordinates. Cheap to clone: meshes are shared.
///
/// A [`Transform`] places it: scale first, then rotation, then translation.
///
/// * The scale of a cuboid or mesh works along its own axes; a negative one mirrors.
/// * A sphere stays a sphere: of a scale that differs by axis, the largest absolute component
///   counts.
/// * A half extent, radius or scale of zero is allowed: the shape is then a rectangle, segment or
///   point.
/// * `Shape::Rapier` ignores the scale, since `bevy_rapier3d` bakes it into the collider itself.
///
/// The constructors check their input. Variants built by hand are not checked: a negative extent or
/// radius counts as its absolute value, and a shape that is not finite has no bounds and no
/// contacts.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::narrow_phase::{Shape, ShapeError};
///
/// let brick = Shape::cuboid(Vec3::new(2.0, 1.0, 1.0))?;
/// assert!(Shape::sphere(-1.0).is_err());
/// # let _ = brick;
/// # Ok::<(), ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub enum Shape {
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A solid ball around the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A convex solid bounded by polygons.
    Convex(Arc<ConvexMesh>),
    /// Any mesh of planar polygons: a solid if it is closed, a surface otherwise.
    Mesh(Arc<PolygonMesh>),
    /// A shape of `bevy_rapier3d`.
    #[cfg(feature = "rapier")]
    Rapier(SharedShape),
}

impl Shape {
    /// A box around the origin, by its half extents along its own axes.
    ///
    /// # Errors
    /// [`ShapeError::HalfSize`] if one is negative, NaN or infinite. Zero is allowed.
    pub fn cuboid(half_size: Vec3) -> Result<Self, ShapeError> {
        if half_size.is_finite() && half_size.min_element() >= 0.0 {
            Ok(Self::Cuboid { half_size })
        } else {
            Err(ShapeError::HalfSize(half_size))
        }
    }

    /// A solid ball around the origin.
    ///
    /// # Errors
    /// [`ShapeError::Radius`] if the radius is negative, NaN or infinite. Zero is allowed.
    pub fn sphere(radius: f32) -> Result<Self, ShapeError> {
        if radius.is_finite() && radius >= 0.0 { Ok(Self::Sphere { radius }) } else { Err(ShapeError::Radius(radius)) }
    }

    /// A solid bounded by polygons, checked to be convex. See [`ConvexMesh::new`].
    ///
    /// # Errors
    /// Those of [`PolygonMesh::new`] and [`ConvexMesh::new`].
    pub fn convex<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        let mesh = PolygonMesh::new(vertices, polygons)?;
        Ok(ConvexMesh::new(mesh)?.into())
    }

    /// A mesh of planar polygons, each a list of vertex indices. See [`PolygonMesh::new`].
    ///
    /// # Errors
    /// Those of [`PolygonMesh::new`].
    pub fn mesh<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        Ok(PolygonMesh::new(vertices, polygons)?.into())
    }

    /// Centre, half extents and bounding radius around that centre of the unplaced shape.
    #[inline]
    pub(super) fn local_bounds(&self) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
        match self {
            Self::Cuboid { half_size } => {
                let half = Vec3A::from(*half_size).abs();
                Ok((Vec3A::ZERO, half, length(half)))
            }
            Self::Sphere { radius } => {
                let radius = radius.abs();
                Ok((Vec3A::ZERO, Vec3A::splat(radius), radius))
            }
            Self::Convex(mesh) => Ok(mesh.local_bounds()),
            Self::Mesh(mesh) => Ok(mesh.local_bounds()),
            #[cfg(feature = "rapier")]
            Self::Rapier(shape) => foreign_bounds(shape),
        }
    }
}

#[cfg(feature = "rapier")]
/// Centre, half extents and bounding radius of the unplaced shape.
fn foreign_bounds(shape: &SharedShape) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
    let aabb = shape.compute_local_aabb();
    let (min, max) = (Vec3A::from(aabb.mins), Vec3A::from(aabb.maxs));
    if min.is_nan() || max.is_nan() {
        return Err(BoundsError::NonFinite);
    }
    let half = (max * 0.5 - min * 0.5).max(Vec3A::ZERO);
    if half.max_element() > ENDLESS {
        return Err(BoundsError::Unbounded);
    }
    Ok((min * 0.5 + max * 0.5, half, length(half)))
}

impl From<primitives::Cuboid> for Shape {
    /// Unchecked, as the primitive itself.
    fn from(cuboid: primitives::Cuboid) -> Self {
        Self::Cuboid { half_size: cuboid.half_size }
    }
}

impl From<primitives::Sphere> for Shape {
    /// Unchecked, as the primitive itself.
    fn from(sphere: primitives::Sphere) -> Self {
        Self::Sphere { radius: sphere.radius }
    }
}

impl From<PolygonMesh> for Shape {
    fn from(mesh: PolygonMesh) -> Self {
        Self::Mesh(Arc::new(mesh))
    }
}

impl From<ConvexMesh> for Shape {
    fn from(mesh: ConvexMesh) -> Self {
        Self::Convex(Arc::new(mesh))
    }
}
