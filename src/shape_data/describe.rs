//! From shapes to data.

use bevy::prelude::*;

use super::description::{CoreDescription, PartDescription, ShapeDescription};
use super::error::NoDescriptionError;
#[cfg(feature = "rapier")]
use super::foreign;
use crate::{
    components::CollisionShape,
    narrow_phase::{PolygonMesh, RoundedCore, Shape},
};

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
            Shape::Capsule {
                radius,
                half_length,
            } => Self::Capsule {
                radius: radius.abs(),
                length: 2.0 * half_length.abs(),
            },
            Shape::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => frustum(*radius_top, *radius_bottom, *half_height).into(),
            Shape::HalfSpace { normal } => Self::HalfSpace { normal: *normal },
            Shape::Rounded(rounded) => match (core(rounded.core()), rounded.radius()) {
                (CoreDescription::Segment { a, b }, 0.0) => Self::Segment { a, b },
                (CoreDescription::Segment { a, b }, radius) => {
                    Self::CapsuleBetween { a, b, radius }
                }
                (CoreDescription::Triangle { a, b, c }, 0.0) => Self::Triangle { a, b, c },
                (core, radius) => Self::Rounded { core, radius },
            },
            Shape::Compound(compound) => {
                let parts = compound.parts().map(|(pose, shape)| {
                    Ok(PartDescription {
                        position: pose.translation.into(),
                        rotation: pose.rotation,
                        shape: Self::of(shape)?,
                    })
                });
                let parts = parts.collect::<Result<_, _>>()?;
                Self::Compound { parts }
            }
            Shape::HeightField(field) => {
                let holes = field.holes();
                Self::HeightField {
                    rows: field.rows() as u32,
                    columns: field.columns() as u32,
                    heights: field.heights().to_vec(),
                    cell_size: field.cell_size(),
                    holes: holes
                        .map(|(row, column)| [row as u32, column as u32])
                        .collect(),
                }
            }
            Shape::Voxels(voxels) => {
                // In an order that does not tell how it came to be.
                let mut cells: Vec<IVec3> = voxels.iter().collect();
                cells.sort_unstable_by_key(|cell| [cell.z, cell.y, cell.x]);
                Self::Voxels {
                    cell_size: voxels.cell_size(),
                    cells,
                }
            }
            #[cfg(feature = "rapier")]
            Shape::Rapier(shape) => foreign::describe(shape)?,
        })
    }
}

/// A frustum by its sizes, or the simplest that it is.
fn frustum(radius_top: f32, radius_bottom: f32, half_height: f32) -> CoreDescription {
    let (radius_top, radius) = (radius_top.abs(), radius_bottom.abs());
    let height = 2.0 * half_height.abs();
    if radius_top == radius {
        CoreDescription::Cylinder { radius, height }
    } else if radius_top == 0.0 {
        CoreDescription::Cone { radius, height }
    } else {
        CoreDescription::ConicalFrustum {
            radius_top,
            radius_bottom: radius,
            height,
        }
    }
}

fn core(core: &RoundedCore) -> CoreDescription {
    match core {
        RoundedCore::Segment([a, b]) => CoreDescription::Segment { a: *a, b: *b },
        RoundedCore::Triangle([a, b, c]) => CoreDescription::Triangle {
            a: *a,
            b: *b,
            c: *c,
        },
        RoundedCore::Cuboid { half_size } => CoreDescription::Cuboid {
            half_size: *half_size,
        },
        RoundedCore::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height,
        } => frustum(*radius_top, *radius_bottom, *half_height),
        RoundedCore::Convex(mesh) => {
            let (vertices, polygons) = faces(mesh);
            CoreDescription::Convex { vertices, polygons }
        }
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

#[cfg(test)]
mod tests;
