//! Polygon meshes from Bevy's `Mesh`.

use bevy::{
    math::Vec3,
    mesh::{Mesh, PrimitiveTopology, VertexAttributeValues},
};

use super::polygon_mesh::PolygonMesh;
use crate::narrow_phase::error::ShapeError;

impl PolygonMesh {
    /// Makes a mesh of the triangles of a Bevy mesh (feature `mesh`), listed or in a strip, indexed
    /// or not.
    ///
    /// A mesh to render has several vertices at one position where normals or texture coordinates
    /// differ. Those at one position are welded to one, and so are those that are as close as a few
    /// millionths of the mesh's extent, so that the surface closes even where it was closed by
    /// sines of a full turn, and as close as 32-bit floats are there. Triangles which then have no
    /// area, as at the poles of a sphere or between strips, are left out: nothing of them is seen,
    /// either. What is left keeps its order; which triangle of the mesh it was is told by
    /// [`polygon_number`](Self::polygon_number).
    ///
    /// The time taken is linear in the number of vertices and triangles, as that of
    /// [`new`](Self::new).
    ///
    /// # Errors
    /// [`ShapeError::Topology`], [`ShapeError::NoPositions`] and [`ShapeError::NoAccess`] for a
    /// mesh without triangles, positions, or data in main memory; [`ShapeError::IndexOutOfRange`]
    /// and [`ShapeError::TooFewCorners`], for the last triangle, name triangles by their number in
    /// the mesh, and [`ShapeError::NonFiniteVertex`] the vertex, be it one that no triangle uses;
    /// [`ShapeError::Empty`] if no triangle has an area.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ShapeError> {
        let (positions, triangles) = read(mesh)?;
        Self::from_triangles(positions, triangles)
    }
}

impl TryFrom<&Mesh> for PolygonMesh {
    type Error = ShapeError;

    fn try_from(mesh: &Mesh) -> Result<Self, ShapeError> {
        Self::from_mesh(mesh)
    }
}

/// The triangles of a Bevy mesh as they are given, those without an area among them: for who needs
/// no more of it than where it is.
///
/// # Errors
/// Those of [`PolygonMesh::from_mesh`], but that triangles need no area.
pub(crate) fn mesh_triangles(mesh: &Mesh) -> Result<Vec<[Vec3; 3]>, ShapeError> {
    let (positions, triangles) = read(mesh)?;
    if let Some(vertex) = (positions.iter()).position(|at| !Vec3::from(*at).is_finite()) {
        let position = positions[vertex].into();
        return Err(ShapeError::NonFiniteVertex { vertex, position });
    }
    if triangles.is_empty() {
        return Err(ShapeError::Empty);
    }
    let corners = |triangle: [usize; 3]| triangle.map(|vertex| positions[vertex].into());
    Ok(triangles.into_iter().map(corners).collect())
}

/// Positions, and triangles whose indices are in range.
#[expect(clippy::type_complexity, reason = "two lists, for two who read them")]
fn read(mesh: &Mesh) -> Result<(&[[f32; 3]], Vec<[usize; 3]>), ShapeError> {
    let no_access = |error: bevy::mesh::MeshAccessError| ShapeError::NoAccess(error.to_string());
    let positions = mesh
        .try_attribute_option(Mesh::ATTRIBUTE_POSITION)
        .map_err(no_access)?
        .and_then(VertexAttributeValues::as_float3)
        .ok_or(ShapeError::NoPositions)?;
    let indices: Vec<usize> = match mesh.try_indices_option().map_err(no_access)? {
        Some(indices) => indices.iter().collect(),
        None => (0..positions.len()).collect(),
    };
    let triangles = triangles(mesh.primitive_topology(), &indices)?;
    for (polygon, triangle) in triangles.iter().enumerate() {
        if let Some(&vertex) = triangle.iter().find(|&&vertex| vertex >= positions.len()) {
            return Err(ShapeError::IndexOutOfRange {
                polygon,
                vertex: u32::try_from(vertex).unwrap_or(u32::MAX),
                vertices: positions.len(),
            });
        }
    }
    Ok((positions, triangles))
}

fn triangles(
    topology: PrimitiveTopology,
    indices: &[usize],
) -> Result<Vec<[usize; 3]>, ShapeError> {
    match topology {
        PrimitiveTopology::TriangleList => {
            let (triangles, rest) = indices.as_chunks();
            if rest.is_empty() {
                Ok(triangles.to_vec())
            } else {
                Err(ShapeError::TooFewCorners {
                    polygon: triangles.len(),
                    corners: rest.len(),
                })
            }
        }
        // Every other triangle of a strip is turned around.
        PrimitiveTopology::TriangleStrip => Ok(indices
            .array_windows()
            .enumerate()
            .map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
            .collect()),
        other => Err(ShapeError::Topology(other)),
    }
}

#[cfg(test)]
mod tests;
