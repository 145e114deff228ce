//! Shapes turned in themselves.

use bevy::math::{DMat3, Vec3};

use super::mesh::convex_mesh::ConvexMesh;
use super::shape::Shape;

impl Shape {
    /// The shape, turned the other way: what was at `turn * point` is at `point`. Shapes without
    /// polygons stay as they are.
    pub(crate) fn turned_back(&self, turn: &DMat3) -> Self {
        let Some((mesh, size)) = self.polygons().filter(|_| *turn != DMat3::IDENTITY) else {
            return self.clone();
        };
        let size = Vec3::from(size).abs().as_dvec3();
        let back = turn.transpose();
        let turned = mesh.turned(
            |vertex| (back * (vertex.as_dvec3() * size)).as_vec3(),
            // Those of a cuboid, the only one with a size of its own, are along its axes.
            |normal| (back * normal.as_dvec3()).normalize_or_zero().as_vec3(),
        );
        match self {
            Self::Mesh(_) => turned.into(),
            _ => ConvexMesh::trusted(turned).into(),
        }
    }
}
