//! Polygon meshes from Bevy's `Mesh`.

use std::collections::HashMap;

use bevy::math::Vec3;
use bevy::mesh::{Mesh, PrimitiveTopology, VertexAttributeValues};

use super::polygon_mesh::PolygonMesh;
use crate::narrow_phase::error::ShapeError;

/// How close two vertices have to be to be one, as a share of the largest coordinate.
const WELD: f32 = 1e-5;

impl PolygonMesh {
    /// Makes a mesh of the triangles of a Bevy mesh (feature `mesh`), listed or in a strip, indexed
    /// or not.
    ///
    /// A mesh to render has several vertices at one position where normals or texture coordinates
    /// differ. Those closer together than 10⁻⁵ of the largest coordinate are welded to one, so that
    /// the surface closes, even where it was closed by sines of a full turn. Triangles which then
    /// have no area, as at the poles of a sphere or between strips, are dropped: nothing of them is
    /// seen, either.
    ///
    /// # Errors
    /// [`ShapeError::Topology`], [`ShapeError::NoPositions`] and [`ShapeError::NoAccess`] for a
    /// mesh without triangles, positions, or data in main memory; [`ShapeError::IndexOutOfRange`]
    /// and [`ShapeError::TooFewCorners`], for the last triangle, name triangles by their number in
    /// the mesh; [`ShapeError::NonFiniteVertex`] names the vertex after welding;
    /// [`ShapeError::Empty`] if no triangle has an area.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ShapeError> {
        let no_access =
            |error: bevy::mesh::MeshAccessError| ShapeError::NoAccess(error.to_string());
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
        let (vertices, welded) = weld(positions)?;
        let mut sources = Vec::with_capacity(triangles.len());
        let triangles = (0..).zip(triangles).filter_map(|(source, triangle)| {
            let triangle = triangle.map(|v| welded[v]);
            Self::has_area(&vertices, triangle).then(|| {
                sources.push(source);
                triangle
            })
        });
        let mesh = Self::new(vertices.as_slice(), triangles)?;
        Ok(mesh.with_sources(sources))
    }
}

impl TryFrom<&Mesh> for PolygonMesh {
    type Error = ShapeError;

    fn try_from(mesh: &Mesh) -> Result<Self, ShapeError> {
        Self::from_mesh(mesh)
    }
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

/// Distinct positions, and for each vertex the index of the one it is at: that of the first vertex
/// close enough.
fn weld(positions: &[[f32; 3]]) -> Result<(Vec<Vec3>, Vec<u32>), ShapeError> {
    if u32::try_from(positions.len()).is_err() {
        return Err(ShapeError::TooLarge);
    }
    let size = positions
        .as_flattened()
        .iter()
        .fold(0f32, |size, x| size.max(x.abs()));
    let reach = (WELD * size).max(f32::MIN_POSITIVE);
    // Cells twice as wide as the reach: what is in reach of a vertex is in the cells of eight
    // corners.
    let cell = |position: Vec3| {
        (position.as_dvec3() / f64::from(2.0 * reach))
            .floor()
            .as_i64vec3()
    };
    let mut cells: HashMap<_, Vec<u32>> = HashMap::with_capacity(positions.len());
    let mut distinct: Vec<Vec3> = Vec::new();
    let welded = positions.iter().map(|&position| {
        let position = Vec3::from(position);
        let corners = (0..8u8).map(|i| {
            let side = |bit: u8| if i & bit == 0 { -reach } else { reach };
            cell(position + Vec3::new(side(1), side(2), side(4)))
        });
        let near = corners.filter_map(|corner| cells.get(&corner)).flatten();
        let close =
            |known: &&u32| (distinct[**known as usize] - position).abs().max_element() <= reach;
        let known = near.copied().find(|known| close(&known));
        known.unwrap_or_else(|| {
            let new = distinct.len() as u32;
            cells.entry(cell(position)).or_default().push(new);
            distinct.push(position);
            new
        })
    });
    let welded = welded.collect();
    Ok((distinct, welded))
}

#[cfg(test)]
mod tests;
