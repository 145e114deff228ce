//! Meshes that are known to be convex.

use std::ops::Deref;

use bevy::math::Vec3;

use super::polygon_mesh::PolygonMesh;
use crate::narrow_phase::error::ShapeError;

/// How far a vertex may be outside the plane of a polygon, as a share of the mesh's radius.
const FLATNESS: f32 = 1e-4;
/// The smallest volume, as a share of the cube of the mesh's radius.
const SMALLEST_VOLUME: f32 = 1e-6;

/// A closed [`PolygonMesh`] in one piece that encloses a convex solid, its polygons facing
/// outwards.
///
/// Knowing that a solid is convex buys contacts with the normal of least penetration.
#[doc(alias = "convex hull")]
#[doc(alias = "polyhedron")]
#[derive(Clone, Debug)]
pub struct ConvexMesh(PolygonMesh);

impl ConvexMesh {
    /// Checks that the mesh is convex, and turns its polygons outwards.
    ///
    /// The time taken is the number of polygons times the number of vertices.
    ///
    /// # Errors
    /// [`ShapeError::NotClosed`], [`ShapeError::NotConnected`], [`ShapeError::Flat`] without
    /// volume, [`ShapeError::NotConvex`] if a vertex is outside the plane of a polygon by more than
    /// a ten-thousandth of the mesh's radius.
    pub fn new(mut mesh: PolygonMesh) -> Result<Self, ShapeError> {
        if let Some(edge) = mesh.open_edge() {
            return Err(ShapeError::NotClosed { edge });
        }
        if mesh.shells().len() != 1 {
            return Err(ShapeError::NotConnected(mesh.shells().len()));
        }
        let (center, _, radius) = mesh.local_bounds();
        let center = Vec3::from(center);
        let volume = relative_volume(&mesh, center, radius);
        if volume.abs() < SMALLEST_VOLUME {
            return Err(ShapeError::Flat);
        }
        if volume < 0.0 {
            mesh.flip();
        }
        for (polygon, (corners, normal)) in mesh.polygons().zip(mesh.normals()).enumerate() {
            let on_plane = mesh.vertices()[corners[0] as usize];
            for &vertex in mesh.edges().as_flattened() {
                let distance = (mesh.vertices()[vertex as usize] - on_plane).dot(*normal);
                if distance > FLATNESS * radius {
                    return Err(ShapeError::NotConvex {
                        polygon,
                        vertex,
                        distance,
                    });
                }
            }
        }
        Ok(Self(mesh))
    }

    /// A mesh that is known to be convex already.
    pub(in crate::narrow_phase) const fn trusted(mesh: PolygonMesh) -> Self {
        Self(mesh)
    }

    /// Returns the mesh without the knowledge.
    #[must_use]
    pub fn into_inner(self) -> PolygonMesh {
        self.0
    }
}

impl Deref for ConvexMesh {
    type Target = PolygonMesh;

    fn deref(&self) -> &PolygonMesh {
        &self.0
    }
}

impl TryFrom<PolygonMesh> for ConvexMesh {
    type Error = ShapeError;

    fn try_from(mesh: PolygonMesh) -> Result<Self, ShapeError> {
        Self::new(mesh)
    }
}

/// Six times the enclosed volume in units of the radius cubed, positive if the polygons face
/// outwards.
fn relative_volume(mesh: &PolygonMesh, center: Vec3, radius: f32) -> f32 {
    let at = |vertex: u32| (mesh.vertices()[vertex as usize] - center) / radius;
    let fan = |corners: &[u32]| -> f32 {
        let triangles = corners[1..].windows(2);
        triangles
            .map(|pair| at(corners[0]).dot(at(pair[0]).cross(at(pair[1]))))
            .sum()
    };
    mesh.polygons().map(fan).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::narrow_phase::mesh::polygon_mesh::tests::cube;

    #[test]
    fn cube_is_convex_whichever_way_it_faces() {
        let mut inside_out = cube();
        inside_out.flip();
        let convex = ConvexMesh::new(inside_out).unwrap();
        assert_eq!(convex.normals(), cube().normals());
    }

    #[test]
    fn dented_and_open_and_flat_meshes_are_refused() {
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let build = |polygons: &[[u32; 3]], corners: [Vec3; 4]| {
            ConvexMesh::new(PolygonMesh::new(corners, polygons)?)
        };
        assert!(build(&triangles, corners).is_ok());
        let error = build(&triangles[1..], corners).unwrap_err();
        assert!(matches!(error, ShapeError::NotClosed { .. }));
        let mut flat = corners;
        flat[3] = Vec3::new(0.3, 0.3, 0.0);
        assert_eq!(build(&triangles, flat).unwrap_err(), ShapeError::Flat);

        // A cube with a pyramid pressed into its top.
        let cube = cube();
        let mut vertices = cube.vertices().to_vec();
        vertices.push(Vec3::new(0.0, 0.0, 0.5));
        let mut polygons: Vec<Vec<u32>> = cube.polygons().map(<[u32]>::to_vec).collect();
        let top = polygons.remove(1);
        for i in 0..4 {
            polygons.push(vec![top[i], top[(i + 1) % 4], 8]);
        }
        let dented = PolygonMesh::new(vertices, polygons).unwrap();
        assert!(dented.is_closed());
        let error = ConvexMesh::new(dented).unwrap_err();
        assert!(matches!(error, ShapeError::NotConvex { .. }), "{error}");
    }
}
