//! A convex mesh in place, as planes that part it from another are sought: corners, normals of
//! faces, and edges with what is on both sides of them.

use bevy::math::Vec3A;

use super::{oriented_box::OrientedBox, placed::Placed, placing::Placing};
use crate::narrow_phase::mesh::topology::NO_NEIGHBOR;

/// Two faces whose normals have a cross product of less than this squared length are one, and have
/// no edge between them.
const FLUSH: f32 = 1e-12;

/// An edge of a solid.
#[derive(Clone, Copy, Debug)]
pub struct SolidEdge {
    /// Its ends, among the corners.
    pub ends: [u32; 2],
    /// The normals on both sides of it: outwards along it, the solid reaches furthest between these.
    pub normals: [Vec3A; 2],
    /// The unit vector at right angles to both, from the second to the first by the right hand.
    pub across: Vec3A,
}

/// A convex mesh in place. Filled anew for each pair; the buffers stay.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    pub corners: Vec<Vec3A>,
    pub normals: Vec<Vec3A>,
    pub edges: Vec<SolidEdge>,
}

impl Solid {
    /// Puts a shape in place. Returns `false` if it is none that is bounded by polygons, each of
    /// which faces somewhere and has one other on each side.
    pub fn fill(&mut self, placed: Placed, bounds: &OrientedBox) -> bool {
        self.corners.clear();
        self.normals.clear();
        self.edges.clear();
        let Some((mesh, size)) = placed.shape.polygons() else {
            return false;
        };
        let placing = Placing::of((mesh, size), placed, bounds);
        if placing.is_flat() {
            return false;
        }
        let corners = mesh.vertices().iter();
        self.corners
            .extend(corners.map(|corner| placing.place(*corner)));
        let normals = mesh.normals().iter();
        self.normals
            .extend(normals.map(|normal| placing.normal(*normal)));
        if self.normals.contains(&Vec3A::ZERO) {
            return false;
        }
        for polygon in 0..mesh.polygon_count() {
            let corners = mesh.polygon(polygon);
            for (side, other) in mesh.across(polygon).iter().enumerate() {
                if *other == NO_NEIGHBOR {
                    return false;
                }
                if (*other as usize) < polygon {
                    continue;
                }
                let normals = [self.normals[polygon], self.normals[*other as usize]];
                let across = normals[1].cross(normals[0]);
                if across.length_squared() > FLUSH {
                    self.edges.push(SolidEdge {
                        ends: [corners[side], corners[(side + 1) % corners.len()]],
                        normals,
                        across: across.normalize(),
                    });
                }
            }
        }
        true
    }

    /// How far it reaches along a direction.
    #[inline]
    pub fn reach(&self, direction: Vec3A) -> f32 {
        let heights = self.corners.iter().map(|corner| corner.dot(direction));
        heights.fold(f32::NEG_INFINITY, f32::max)
    }

    /// How far a second one is beyond this one along a direction; negative if they overlap.
    #[inline]
    pub fn gap(&self, second: &Self, direction: Vec3A) -> f32 {
        -second.reach(-direction) - self.reach(direction)
    }

    /// The ends of an edge.
    #[inline]
    pub fn ends(&self, edge: &SolidEdge) -> [Vec3A; 2] {
        edge.ends.map(|end| self.corners[end as usize])
    }
}
