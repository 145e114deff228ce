//! A convex mesh around the centre of its box, along its own axes.

use bevy::math::Vec3A;

use super::facet::{Best, Facet, highest};
use crate::narrow_phase::{
    frame::{placing::cofactors, surface::border},
    length::unit,
    mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR},
};

/// A face in place.
#[derive(Clone, Copy, Debug)]
struct HullFace {
    /// Outwards; zero for one that a scale of zero flattened.
    normal: Vec3A,
    plane: f32,
    /// Where its corners begin and end.
    corners: [u32; 2],
}

/// An edge in place, with the normals of the faces beside it.
#[derive(Clone, Copy, Debug)]
struct HullEdge {
    ends: [Vec3A; 2],
    normals: [Vec3A; 2],
}

/// A convex mesh around the centre of its box, along its own axes, scaled.
#[derive(Clone, Debug, Default)]
pub struct Hull {
    corners: Vec<Vec3A>,
    faces: Vec<HullFace>,
    edges: Vec<HullEdge>,
}

impl Hull {
    /// Puts a mesh in place. O(corners).
    pub fn fill(&mut self, mesh: &PolygonMesh, scale: Vec3A) {
        let (middle, ..) = mesh.local_bounds();
        let to_normal = cofactors(scale);
        let place = |vertex: u32| (Vec3A::from(mesh.vertices()[vertex as usize]) - middle) * scale;
        self.corners.clear();
        self.faces.clear();
        self.edges.clear();
        for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
            let start = self.corners.len();
            self.corners.extend(corners.iter().map(|v| place(*v)));
            let normal = unit(Vec3A::from(*normal) * to_normal);
            self.faces.push(HullFace {
                normal,
                plane: highest(&self.corners[start..], normal),
                corners: [start as u32, self.corners.len() as u32],
            });
        }
        for polygon in 0..mesh.polygon_count() {
            let corners = mesh.polygon(polygon);
            let sides = corners.iter().zip(corners.iter().cycle().skip(1));
            for (&other, (from, to)) in mesh.across(polygon).iter().zip(sides) {
                if other == NO_NEIGHBOR || other as usize > polygon {
                    let own = self.faces[polygon].normal;
                    let beside = self.faces.get(other as usize);
                    self.edges.push(HullEdge {
                        ends: [place(*from), place(*to)],
                        normals: [own, beside.map_or(-own, |face| face.normal)],
                    });
                }
            }
        }
    }

    fn corners_of(&self, face: &HullFace) -> &[Vec3A] {
        &self.corners[face.corners[0] as usize..face.corners[1] as usize]
    }

    fn solid_faces(&self) -> impl Iterator<Item = &HullFace> {
        self.faces.iter().filter(|face| face.normal != Vec3A::ZERO)
    }

    /// Where it begins along a direction.
    pub fn lowest(&self, direction: Vec3A) -> f32 {
        -highest(&self.corners, -direction)
    }

    /// A corner that is as far along a direction as any.
    pub fn furthest(&self, direction: Vec3A) -> Vec3A {
        let height = |corner: &&Vec3A| corner.dot(direction);
        let corners = self.corners.iter();
        let furthest = corners.max_by(|a, b| height(a).total_cmp(&height(b)));
        furthest.copied().unwrap_or_default()
    }

    /// See [`Body::touches`](super::body::Body::touches).
    pub fn touches(&self, corners: &[Vec3A], normal: Vec3A, tolerance: f32) -> bool {
        let is_apart_along = |axis: Vec3A| {
            highest(corners, axis) < self.lowest(axis) - tolerance
                || -highest(corners, -axis) > highest(&self.corners, axis) + tolerance
        };
        if normal != Vec3A::ZERO && is_apart_along(normal) {
            return false;
        }
        let is_beyond = |face: &HullFace| -highest(corners, -face.normal) > face.plane + tolerance;
        if self.solid_faces().any(is_beyond) {
            return false;
        }
        // The normals of a side of a polygon by itself are half a circle.
        border(corners).all(|[from, to]| {
            let side = to - from;
            let middle = from.midpoint(to);
            let inwards = corners.iter().sum::<Vec3A>() / corners.len() as f32 - middle;
            self.edges_across(side).all(|edge| {
                let cross = side.cross(edge.ends[1] - edge.ends[0]);
                let out = edge.normals[0] + edge.normals[1];
                let axis = cross * -1f32.copysign(cross.dot(out));
                let gap = (edge.ends[0] - from).dot(axis);
                axis.dot(inwards) > 0.0 || gap <= tolerance * axis.length()
            })
        })
    }

    /// The edges that have a normal at a right angle to a side.
    fn edges_across(&self, side: Vec3A) -> impl Iterator<Item = &HullEdge> {
        self.edges.iter().filter(move |edge| {
            let [one, other] = edge.normals.map(|normal| normal.dot(side));
            one * other < 0.0
        })
    }

    /// Ways off a polygon along normals of faces, and of edges.
    pub fn ways(&self, facet: &Facet, best: &mut Best) {
        for face in self.solid_faces() {
            let depth = face.plane + highest(facet.corners, -face.normal);
            if best.is_beaten_by(depth) && facet.allows(-face.normal) {
                best.take(-face.normal, depth);
            }
        }
        for side in 0..facet.corners.len() {
            let [from, to] = facet.ends(side);
            for edge in self.edges_across(to - from) {
                let Some(direction) = facet.across(side, edge.ends[1] - edge.ends[0]) else {
                    continue;
                };
                if direction.dot(edge.normals[0] + edge.normals[1]) < 0.0 {
                    let depth = (from - edge.ends[0]).dot(direction);
                    if best.is_beaten_by(depth) && facet.is_ridge(side, direction) {
                        best.take(direction, depth);
                    }
                }
            }
        }
    }

    /// See [`Body::face_towards`](super::body::Body::face_towards).
    pub fn face_towards(&self, direction: Vec3A, corners: &mut Vec<Vec3A>) -> Vec3A {
        let along = |face: &&HullFace| face.normal.dot(direction);
        let face = self
            .solid_faces()
            .max_by(|a, b| along(a).total_cmp(&along(b)));
        let Some(face) = face else {
            return Vec3A::ZERO;
        };
        corners.extend_from_slice(self.corners_of(face));
        face.normal
    }

    /// See [`Body::for_each_plane`](super::body::Body::for_each_plane).
    pub fn for_each_plane(&self, mut cut: impl FnMut(Vec3A, f32)) {
        self.solid_faces()
            .for_each(|face| cut(face.normal, face.plane));
    }
}
