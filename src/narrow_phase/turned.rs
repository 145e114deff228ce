//! Shapes turned in themselves.

use std::sync::Arc;

use bevy::math::{DMat3, Vec3};

use super::frame::surface::polygons_of;
use super::mesh::convex_mesh::ConvexMesh;
use super::shape::Shape;

impl Shape {
    /// The shape, turned the other way: what was at `turn * point` is at `point`. Shapes without polygons stay as they are.
    pub(crate) fn turned_back(&self, turn: &DMat3) -> Self {
        let Some((mesh, size)) = polygons_of(self).filter(|_| *turn != DMat3::IDENTITY) else { return self.clone() };
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

    /// Is it the very same: of the same size, or the same mesh?
    #[inline]
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cuboid { half_size: a }, Self::Cuboid { half_size: b }) => a == b,
            (Self::Sphere { radius: a }, Self::Sphere { radius: b }) => a == b,
            (Self::Convex(a), Self::Convex(b)) => Arc::ptr_eq(a, b),
            (Self::Mesh(a), Self::Mesh(b)) => Arc::ptr_eq(a, b),
            #[cfg(feature = "rapier")]
            (Self::Rapier(a), Self::Rapier(b)) => Arc::ptr_eq(&a.0, &b.0),
            _ => false,
        }
    }
}
