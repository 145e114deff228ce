//! On which side of a closed surface a point is, by what of the surface is closest to it.
//!
//! Over a polygon, the polygon's normal tells; over an edge, the sum of the normals of the two
//! polygons there; over a vertex, the sum of those around it, each times its angle there (Bærentzen
//! and Aanæs, *Signed Distance Computation Using the Angle Weighted Pseudonormal*, 2005).

use std::f32::consts::TAU;

use bevy::math::Vec3A;

use super::placing::Placing;
use super::surface::ClosestPoint;
use crate::narrow_phase::mesh::{polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR};

/// The least cosine of the angle between a normal and a way that counts as straight.
const STRAIGHT: f32 = 0.9999;
/// The greatest cosine of the angle between an edge and a way that counts as straight.
const ACROSS: f32 = 1e-3;
/// The least part of an edge beyond which it does not end, and the greatest within which it does.
const WITHIN: f32 = 1e-3;
const AT_END: f32 = 1e-6;
/// The least cosine of the angle between a sum of normals and a way that tells the side.
const CLEAR: f32 = 0.02;
/// How near to a side of a polygon its normal does not tell, as a share of the size of the mesh: there,
/// rounding may have found it in place of the polygon across.
const BESIDE: f32 = 1e-5;
/// More polygons around a vertex are not looked at.
const MOST_AROUND: usize = 32;

/// Whether a point is on the inner side of a closed mesh, of which the closest point is known;
/// `None` if the surface there does not tell. Of a mesh that [tells sides](super::apart::tells_sides), it
/// tells whether the point is inside.
pub fn is_behind(
    mesh: &PolygonMesh,
    placing: &Placing,
    closest: &ClosestPoint,
    point: Vec3A,
    tolerance: f32,
) -> Option<bool> {
    let offset = point - closest.point;
    if closest.distance <= tolerance {
        return None;
    }
    let around = Around { mesh, placing };
    let height = offset.dot(closest.normal);
    if height.abs() >= STRAIGHT * closest.distance && around.is_well_within(closest) {
        return Some(height < 0.0);
    }
    let (outwards, most) = around.sum_of_normals(closest, offset.try_normalize()?)?;
    let height = offset.dot(outwards);
    (height.abs() >= CLEAR * most * closest.distance).then_some(height < 0.0)
}

struct Around<'a> {
    mesh: &'a PolygonMesh,
    placing: &'a Placing,
}

impl Around<'_> {
    /// Whether the closest point is not beside a side of its polygon.
    fn is_well_within(&self, closest: &ClosestPoint) -> bool {
        let corners = self.mesh.polygon(closest.polygon as usize);
        let least = BESIDE * self.placing.size();
        let mut from = self.at(corners[corners.len() - 1]);
        corners.iter().all(|corner| {
            let to = self.at(*corner);
            let (side, start) = (to - from, from);
            from = to;
            let beside = side.cross(closest.point - start).length_squared();
            beside > least * least * side.length_squared()
        })
    }

    /// The sum of the normals around the closest point, if it is on an edge or a vertex and the way
    /// from there is straight; and how long it can be.
    fn sum_of_normals(&self, closest: &ClosestPoint, way: Vec3A) -> Option<(Vec3A, f32)> {
        let polygon = closest.polygon as usize;
        let corners = self.mesh.polygon(polygon);
        let next = |side: usize| (side + 1) % corners.len();
        (0..corners.len()).find_map(|side| {
            let [a, b] = [side, next(side)].map(|corner| self.at(corners[corner]));
            let (along, from) = (b - a, closest.point - a);
            let squared = along.length_squared();
            if from.length_squared() <= AT_END * AT_END * squared {
                return self.around_vertex(polygon, side);
            }
            let share = from.dot(along) / squared;
            let is_within = (WITHIN..=1.0 - WITHIN).contains(&share);
            let beside = (from - along * share).length_squared();
            let is_on = beside <= AT_END * AT_END * squared;
            let is_across = way.dot(along).abs() <= ACROSS * squared.sqrt();
            let other = self.mesh.across(polygon)[side];
            (is_within && is_on && is_across && other != NO_NEIGHBOR)
                .then(|| (closest.normal + self.normal(other as usize), 2.0))
        })
    }

    /// The same at a corner of a polygon.
    fn around_vertex(&self, polygon: usize, corner: usize) -> Option<(Vec3A, f32)> {
        let vertex = self.mesh.polygon(polygon)[corner];
        let tip = self.at(vertex);
        let (mut sum, mut angles) = (Vec3A::ZERO, 0.0);
        let start = (polygon, corner);
        let mut on = start;
        for _ in 0..MOST_AROUND {
            let (polygon, corner) = on;
            let (corners, normal) = (self.mesh.polygon(polygon), self.normal(polygon));
            let count = corners.len();
            let neighbors = [corner + 1, corner + count - 1].map(|i| corners[i % count]);
            let [next, last] = neighbors.map(|vertex| self.at(vertex) - tip);
            let angle = next.angle_between(last);
            // A corner of a polygon that is not convex.
            let is_reflex = count > 3 && next.cross(last).dot(normal) < 0.0;
            let angle = if is_reflex { TAU - angle } else { angle };
            sum += normal * angle;
            angles += angle;
            on = self.mesh.next_around(on)?;
            if on == start {
                return Some((sum, angles));
            }
        }
        None
    }

    fn at(&self, vertex: u32) -> Vec3A {
        self.placing.place(self.mesh.vertices()[vertex as usize])
    }

    fn normal(&self, polygon: usize) -> Vec3A {
        self.placing.normal(self.mesh.normals()[polygon])
    }
}

#[cfg(test)]
pub(super) mod tests;
