//! What is made of a mesh.

use std::hash::{Hash, Hasher};

use bevy::{mesh::Mesh, prelude::*};

use super::{enclosing, voxels::voxels};
use crate::narrow_phase::{ConvexMesh, PolygonMesh, Shape, ShapeError, mesh_triangles};

/// What a [`ShapeFromMesh`](super::ShapeFromMesh) makes of its mesh.
///
/// The first four have the polygons of the mesh, whose numbers queries tell. The others are around
/// it, in its own coordinates, which the entity's transform scales like any shape; vertices that no
/// triangle uses do not count. All of them are quicker to test than a mesh of many triangles.
///
/// | form | solid | what is wrong with a mesh |
/// |---|---|---|
/// | [`AsItIs`](Self::AsItIs), [`Solid`](Self::Solid), [`SurfaceOnly`](Self::SurfaceOnly) | where it is closed; never, if a surface only | what [`PolygonMesh::from_mesh`] says |
/// | [`Convex`](Self::Convex) | yes | that, or that it is not convex |
/// | [`ConvexHull`](Self::ConvexHull) | yes | that it is flat |
/// | [`Cuboid`](Self::Cuboid), [`Sphere`](Self::Sphere), [`Capsule`](Self::Capsule) | yes | nothing but that it has no triangles, or bad numbers |
/// | [`Voxels`](Self::Voxels) | yes | that its voxels are too many |
///
/// Two of one form are equal if their sizes are the same number, so that one shape is built for
/// them.
#[derive(Clone, Copy, Debug, Default, Reflect)]
#[reflect(Default, Debug, PartialEq)]
#[type_path = "bevy_octree"]
#[non_exhaustive]
pub enum MeshForm {
    /// What is closed is solid, and the rest is surface.
    #[default]
    AsItIs,
    /// The same; the log says so if nothing is closed.
    Solid,
    /// A surface, however closed it is: see [`PolygonMesh::surface_only`].
    SurfaceOnly,
    /// A convex solid, as [`ConvexMesh::new`] makes it.
    Convex,
    /// The convex hull of the mesh.
    ConvexHull,
    /// The box around the mesh, along its axes.
    ///
    /// Around the mesh's origin it is a [`Shape::Cuboid`], which may be flat; elsewhere it is a
    /// convex mesh, or, if it is flat, a rectangle.
    Cuboid,
    /// The ball around the middle of the mesh's box that all of the mesh is in.
    Sphere,
    /// A capsule that all of the mesh is in, along the longest axis of its box.
    Capsule,
    /// Cubes of a side of `size`, along the mesh's axes and counted from its origin: all that
    /// triangles pass through, and all that these enclose.
    ///
    /// A triangle on the border between two cubes is in the one behind it: a box whose sides are
    /// multiples of `size` away from the origin becomes just these cubes.
    Voxels {
        /// The side of a cube, in the units of the mesh.
        size: f32,
    },
}

impl MeshForm {
    /// Which form, and its size by its bits.
    fn key(self) -> (u8, u32) {
        match self {
            Self::AsItIs => (0, 0),
            Self::Solid => (1, 0),
            Self::SurfaceOnly => (2, 0),
            Self::Convex => (3, 0),
            Self::ConvexHull => (4, 0),
            Self::Cuboid => (5, 0),
            Self::Sphere => (6, 0),
            Self::Capsule => (7, 0),
            Self::Voxels { size } => (8, size.to_bits()),
        }
    }
}

impl PartialEq for MeshForm {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for MeshForm {}

impl Hash for MeshForm {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

/// What was made of a mesh.
#[derive(Clone)]
pub(super) struct Built {
    pub(super) shape: Shape,
    /// What there is to be said about it.
    pub(super) doubt: Option<String>,
}

impl From<Shape> for Built {
    fn from(shape: Shape) -> Self {
        let doubt = None;
        Self { shape, doubt }
    }
}

/// Makes a shape of a mesh.
pub(super) fn build(mesh: &Mesh, form: MeshForm) -> Result<Built, ShapeError> {
    let points = || Ok(mesh_triangles(mesh)?.into_flattened());
    let shape = match form {
        MeshForm::AsItIs | MeshForm::Solid | MeshForm::SurfaceOnly => return polygons(mesh, form),
        MeshForm::Convex => ConvexMesh::new(PolygonMesh::from_mesh(mesh)?)?.into(),
        MeshForm::ConvexHull => Shape::convex_hull(points()?)?,
        MeshForm::Cuboid => enclosing::cuboid(&points()?)?,
        MeshForm::Sphere => enclosing::sphere(&points()?)?,
        MeshForm::Capsule => enclosing::capsule(&points()?)?,
        MeshForm::Voxels { size } => voxels(&mesh_triangles(mesh)?, size)?,
    };
    Ok(shape.into())
}

/// The mesh itself, and whether it looks as if it was meant otherwise.
fn polygons(mesh: &Mesh, form: MeshForm) -> Result<Built, ShapeError> {
    let mesh = PolygonMesh::from_mesh(mesh)?;
    if form == MeshForm::SurfaceOnly {
        return Ok(Shape::from(mesh.surface_only()).into());
    }
    let is_in_doubt = !mesh.has_inside() && (form == MeshForm::Solid || mesh.is_nearly_closed());
    let doubt = is_in_doubt.then(|| {
        mesh.open_edge().map_or_else(
            || "has no inside: it encloses nothing".into(),
            |edge| {
                let [from, to] = edge.map(|vertex| mesh.vertices()[vertex as usize]);
                format!(
                    "has no inside: it is open at the edge from {from} to {to}, if not elsewhere, too"
                )
            },
        )
    });
    let shape = mesh.into();
    Ok(Built { shape, doubt })
}

#[cfg(test)]
mod tests;
