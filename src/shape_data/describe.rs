//! From shapes to data.

use bevy::prelude::*;
use thiserror::Error;

use super::description::ShapeDescription;
#[cfg(feature = "rapier")]
use super::foreign;
use crate::{
    components::CollisionShape,
    narrow_phase::{PolygonMesh, Shape},
};

/// Why a shape has no data: it is one of Rapier's, of a kind that the crate has none for.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no data for a shape of Rapier's of the kind {kind}")]
#[non_exhaustive]
pub struct NoDescriptionError {
    /// What Rapier calls the kind.
    pub kind: String,
}

impl ShapeDescription {
    /// Returns the data of a shape, of which [`build`](Self::build) makes the same one.
    ///
    /// It is the simplest that there is for the shape, which need not be the one that the shape was
    /// made of: a tetrahedron is a convex solid, sizes that are negative are their absolute values.
    /// A mesh has the vertices and polygons that it has itself, in their order: where triangles of
    /// a Bevy mesh were left out, hits [number](PolygonMesh::polygon_number) those of the mesh that
    /// is built of the data by their index. In time linear in the data.
    ///
    /// Of Rapier's shapes, what comes of the data is one of the crate's own, to which the scale of a
    /// [`Transform`] applies; Rapier has baked it in already. Where there is one that is not 1, the
    /// two differ.
    ///
    /// ```
    /// use bevy_octree::{narrow_phase::Shape, shape_data::ShapeDescription};
    ///
    /// let data = ShapeDescription::of(&Shape::sphere(0.5))?;
    /// assert_eq!(data, ShapeDescription::Sphere { radius: 0.5 });
    /// # Ok::<(), bevy_octree::shape_data::NoDescriptionError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`NoDescriptionError`] for shapes of Rapier's of which the crate has no kind: those of
    /// somebody else's making, and voxels that are no cubes. Never for the crate's own.
    pub fn of(shape: &Shape) -> Result<Self, NoDescriptionError> {
        Ok(match shape {
            Shape::Cuboid { half_size } => Self::Cuboid {
                half_size: half_size.abs(),
            },
            Shape::Sphere { radius } => Self::Sphere {
                radius: radius.abs(),
            },
            Shape::Convex(mesh) => {
                let (vertices, polygons) = faces(mesh);
                Self::Convex { vertices, polygons }
            }
            Shape::Mesh(mesh) => {
                let (vertices, polygons) = faces(mesh);
                let surface_only = mesh.is_surface_only();
                Self::Mesh {
                    vertices,
                    polygons,
                    surface_only,
                }
            }
            #[cfg(feature = "rapier")]
            Shape::Rapier(shape) => foreign::describe(&**shape)?,
        })
    }
}

/// The corners and faces of a mesh.
fn faces(mesh: &PolygonMesh) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let polygons = mesh.polygons().map(<[u32]>::to_vec).collect();
    (mesh.vertices().to_vec(), polygons)
}

/// As [`ShapeDescription::of`].
impl TryFrom<&Shape> for ShapeDescription {
    type Error = NoDescriptionError;

    fn try_from(shape: &Shape) -> Result<Self, NoDescriptionError> {
        Self::of(shape)
    }
}

/// As [`ShapeDescription::of`].
impl TryFrom<&CollisionShape> for ShapeDescription {
    type Error = NoDescriptionError;

    fn try_from(shape: &CollisionShape) -> Result<Self, NoDescriptionError> {
        Self::of(shape)
    }
}

/// Data for shapes by their sizes, as [`Shape`] has them.
#[cfg(feature = "rapier")]
impl ShapeDescription {
    /// All within a radius of a segment.
    pub(super) fn capsule(a: Vec3, b: Vec3, radius: f32) -> Self {
        let is_upright = a == -b && b.x == 0.0 && b.z == 0.0 && b.y >= 0.0;
        if is_upright {
            let length = 2.0 * b.y;
            Self::Capsule { radius, length }
        } else {
            Self::CapsuleBetween { a, b, radius }
        }
    }

    /// A cone without its tip, or one of its special cases.
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "`Shape` has no conical frustum so far")
    )]
    pub(super) fn frustum(radius_top: f32, radius_bottom: f32, half_height: f32) -> Self {
        let height = 2.0 * half_height;
        if radius_top == radius_bottom {
            let radius = radius_top;
            Self::Cylinder { radius, height }
        } else if radius_top == 0.0 {
            let radius = radius_bottom;
            Self::Cone { radius, height }
        } else {
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            }
        }
    }
}

#[cfg(test)]
mod tests;
