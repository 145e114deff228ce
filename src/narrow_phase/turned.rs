//! Shapes turned in themselves.

use std::sync::Arc;

use bevy::math::{DMat3, Vec3};

use super::mesh::{convex_mesh::ConvexMesh, polygon_mesh::PolygonMesh};
use super::rounded::{Rounded, RoundedCore};
use super::shape::Shape;

/// A mesh, turned the other way.
fn mesh_turned_back(mesh: &PolygonMesh, turn: &DMat3) -> PolygonMesh {
    let back = turn.transpose();
    mesh.turned(
        |vertex| (back * vertex.as_dvec3()).as_vec3(),
        |normal| (back * normal.as_dvec3()).normalize_or_zero().as_vec3(),
    )
}

impl Shape {
    /// Can it be [turned](Self::turned_back)? Others are along axes of their own.
    pub(crate) fn can_turn(&self) -> bool {
        match self {
            Self::Sphere { .. } | Self::HalfSpace { .. } => true,
            Self::Rounded(rounded) => !matches!(
                rounded.core(),
                RoundedCore::Cuboid { .. } | RoundedCore::ConicalFrustum { .. }
            ),
            _ => self.polygons().is_some(),
        }
    }

    /// The shape, turned the other way: what was at `turn * point` is at `point`. Shapes that
    /// [cannot turn](Self::can_turn) stay as they are.
    pub(crate) fn turned_back(&self, turn: &DMat3) -> Self {
        let back = turn.transpose();
        let at = |point: Vec3| (back * point.as_dvec3()).as_vec3();
        match self {
            Self::HalfSpace { normal } if *turn != DMat3::IDENTITY => {
                return Self::HalfSpace {
                    normal: at(*normal).normalize_or(*normal),
                };
            }
            Self::Rounded(rounded) if *turn != DMat3::IDENTITY => {
                let core = match rounded.core() {
                    RoundedCore::Segment(ends) => RoundedCore::Segment(ends.map(at)),
                    RoundedCore::Triangle(corners) => RoundedCore::Triangle(corners.map(at)),
                    RoundedCore::Convex(mesh) => {
                        let turned = mesh_turned_back(mesh, turn);
                        RoundedCore::Convex(Arc::new(ConvexMesh::trusted(turned)))
                    }
                    RoundedCore::Cuboid { .. } | RoundedCore::ConicalFrustum { .. } => {
                        return self.clone();
                    }
                };
                // Points of the largest sizes may be beyond all numbers then.
                let turned = Rounded::new(core, rounded.radius());
                return turned.map_or_else(|_| self.clone(), Self::from);
            }
            _ => {}
        }
        let Some((mesh, size)) = self.polygons().filter(|_| *turn != DMat3::IDENTITY) else {
            return self.clone();
        };
        let size = Vec3::from(size).abs().as_dvec3();
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
