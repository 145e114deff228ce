//! Shapes from numbers, lists of polygons, and the primitives of `bevy_math`.

use std::sync::Arc;

use bevy::math::{Vec3, primitives};

use super::error::ShapeError;
use super::mesh::{convex_mesh::ConvexMesh, polygon_mesh::PolygonMesh};
use super::shape::Shape;

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
