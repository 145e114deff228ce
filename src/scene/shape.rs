//! Shapes as a scene file writes them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::narrow_phase::Shape;

/// The shape of an object, as a scene file writes it.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, PartialEq)]
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
    /// A solid of any form, from the corners and faces of its surface.
    Mesh {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face, a convex polygon, as the indices of its corners, counter-clockwise seen from outside.
        polygons: Vec<Vec<u32>>,
    },
}

/// What is wrong with a [`ShapeDescription`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShapeProblem {
    /// A half size that is not finite and positive along every axis.
    #[error("half_size is {0}, expected three positive numbers")]
    HalfSize(Vec3),
    /// A radius that is not finite and positive.
    #[error("radius is {0}, expected a positive number")]
    Radius(f32),
    /// A mesh without vertices or without polygons.
    #[error(
        "the mesh has {vertices} vertices and {polygons} polygons, expected at least one of each"
    )]
    EmptyMesh {
        /// The number of vertices.
        vertices: usize,
        /// The number of polygons.
        polygons: usize,
    },
    /// A vertex that is not finite.
    #[error("vertex {index} is {value}, expected finite numbers")]
    Vertex {
        /// The index of the vertex.
        index: usize,
        /// Its value.
        value: Vec3,
    },
    /// A polygon with fewer than three corners.
    #[error("polygon {index} has {corners} corners, expected at least 3")]
    TooFewCorners {
        /// The index of the polygon.
        index: usize,
        /// Its number of corners.
        corners: usize,
    },
    /// A polygon that names a vertex that does not exist.
    #[error("polygon {index} names vertex {vertex}, expected an index below {vertices}")]
    NoSuchVertex {
        /// The index of the polygon.
        index: usize,
        /// The vertex that it names.
        vertex: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A kind of shape that the exact tests do not know.
    #[error("a {0} is not available yet, expected a Cuboid or a Sphere")]
    NotAvailable(&'static str),
}

impl ShapeDescription {
    /// The shape that is described.
    ///
    /// # Errors
    ///
    /// Sizes that are not finite and positive; meshes without faces, or with faces that are not polygons of existing,
    /// finite vertices.
    pub fn build(&self) -> Result<Shape, ShapeProblem> {
        self.check()?;
        match *self {
            Self::Cuboid { half_size } => Ok(Shape::Cuboid { half_size }),
            Self::Sphere { radius } => Ok(Shape::Sphere { radius }),
            Self::Convex { .. } => Err(ShapeProblem::NotAvailable("Convex")),
            Self::Mesh { .. } => Err(ShapeProblem::NotAvailable("Mesh")),
        }
    }

    /// Checks the description without building the shape.
    ///
    /// # Errors
    ///
    /// As [`ShapeDescription::build`].
    pub fn check(&self) -> Result<(), ShapeProblem> {
        match self {
            Self::Cuboid { half_size } => (half_size.is_finite() && half_size.min_element() > 0.0)
                .then_some(())
                .ok_or(ShapeProblem::HalfSize(*half_size)),
            Self::Sphere { radius } => (radius.is_finite() && *radius > 0.0)
                .then_some(())
                .ok_or(ShapeProblem::Radius(*radius)),
            Self::Convex { vertices, polygons } | Self::Mesh { vertices, polygons } => {
                check_mesh(vertices, polygons)
            }
        }
    }
}

fn check_mesh(vertices: &[Vec3], polygons: &[Vec<u32>]) -> Result<(), ShapeProblem> {
    if vertices.is_empty() || polygons.is_empty() {
        return Err(ShapeProblem::EmptyMesh {
            vertices: vertices.len(),
            polygons: polygons.len(),
        });
    }
    if let Some(index) = vertices.iter().position(|vertex| !vertex.is_finite()) {
        return Err(ShapeProblem::Vertex {
            index,
            value: vertices[index],
        });
    }
    for (index, polygon) in polygons.iter().enumerate() {
        if polygon.len() < 3 {
            return Err(ShapeProblem::TooFewCorners {
                index,
                corners: polygon.len(),
            });
        }
        if let Some(&vertex) = polygon
            .iter()
            .find(|&&vertex| vertex as usize >= vertices.len())
        {
            return Err(ShapeProblem::NoSuchVertex {
                index,
                vertex,
                vertices: vertices.len(),
            });
        }
    }
    Ok(())
}
