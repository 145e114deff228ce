//! The shapes that the exact tests know.

use std::sync::Arc;

use bevy::math::bounding::{Aabb3d, BoundingSphere};
use bevy::math::{Vec3, Vec3A, primitives};
use bevy::transform::components::Transform;

use super::large::length;
use super::oriented_box::OrientedBox;
use super::{BoundsError, ConvexMesh, PolygonMesh, ShapeError};

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
    Rapier(bevy_rapier3d::parry::shape::SharedShape),
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

    /// An axis-aligned box around the shape in the world, in constant time. It is the smallest one
    /// for cuboids and spheres, up to rounding; for meshes and Rapier shapes, it is the smallest
    /// around their own box, turned and scaled with them.
    ///
    /// A broad phase should be fed the slightly larger [`NarrowPhase::world_aabb`], so that it
    /// misses no pair which is in contact by tolerance.
    ///
    /// # Errors
    /// [`BoundsError::NonFinite`] if the transform holds NaN or infinity or overflows;
    /// [`BoundsError::Unbounded`] for an endless Rapier shape, such as a half-space.
    ///
    /// [`NarrowPhase::world_aabb`]: super::NarrowPhase::world_aabb
    pub fn world_aabb(&self, transform: &Transform) -> Result<Aabb3d, BoundsError> {
        let oriented = OrientedBox::of(self, transform, Vec3::ZERO)?;
        let reach = oriented.reach();
        Ok(Aabb3d { min: oriented.center - reach, max: oriented.center + reach })
    }

    /// A sphere around the shape in the world, centred on its box. The smallest one for cuboids and
    /// spheres.
    ///
    /// # Errors
    /// As for [`world_aabb`](Self::world_aabb).
    pub fn bounding_sphere(&self, transform: &Transform) -> Result<BoundingSphere, BoundsError> {
        let oriented = OrientedBox::of(self, transform, Vec3::ZERO)?;
        Ok(BoundingSphere::new(oriented.center, oriented.radius))
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
            Self::Rapier(shape) => super::parry::local_bounds(shape),
        }
    }
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
