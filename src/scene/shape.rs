//! Shapes as a scene file writes them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::narrow_phase::{PolygonMesh, Shape, ShapeError};

/// The shape of an object, as a scene file writes it.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, PartialEq)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields)]
pub enum ShapeDescription {
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A ball around the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A convex solid, from the corners and faces of its surface.
    Convex {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face as the indices of its corners, counter-clockwise seen from outside.
        polygons: Vec<Vec<u32>>,
    },
    /// A solid or surface of any form, from the corners and faces of its surface.
    Mesh {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face, a convex polygon, as the indices of its corners, counter-clockwise seen from
        /// outside.
        polygons: Vec<Vec<u32>>,
        /// Has it no inside, however closed it is? It is a room that is walked in, then; see
        /// [`PolygonMesh::surface_only`].
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        surface_only: bool,
    },
}

impl ShapeDescription {
    /// Returns the shape that is described.
    ///
    /// # Errors
    ///
    /// Those of [`Shape::try_from_half_size`], [`Shape::try_sphere`], [`Shape::convex`] and
    /// [`Shape::mesh`].
    pub fn build(&self) -> Result<Shape, ShapeError> {
        match self {
            Self::Cuboid { half_size } => Shape::try_from_half_size(*half_size),
            Self::Sphere { radius } => Shape::try_sphere(*radius),
            Self::Convex { vertices, polygons } => Shape::convex(vertices.as_slice(), polygons),
            Self::Mesh {
                vertices,
                polygons,
                surface_only,
            } => {
                let mesh = PolygonMesh::new(vertices.as_slice(), polygons)?;
                Ok(if *surface_only {
                    mesh.surface_only().into()
                } else {
                    mesh.into()
                })
            }
        }
    }
}
