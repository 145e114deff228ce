//! Whether the surface of a solid keeps away from itself, so that what of it is nearest to a point
//! tells on which side of it the point is.
//!
//! Where a surface crosses itself, a point may be behind the nearest polygon and outside all the
//! same, or before it and inside; and where parts of it are nearer to each other than rounding, any
//! of them may be found as the nearest.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};
use smallvec::SmallVec;

use super::closest;
use super::surface::{border, covers};
use crate::broad_phase::Overlap;
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// How near to each other polygons may be that do not join, as a share of the size of the mesh: much
/// more than the rounding of 32-bit floats, by which one may be taken for the nearer one.
const NEAR: f32 = 2e-5;
/// The least cosine of the angle between the normals of two polygons that join: along a sharper edge,
/// they are as near to each other too far from where they join.
const FOLDED: f32 = -0.98;
/// The part of a side that is left out at its end on a polygon that has more than three corners, or
/// that does not belong to a triangle: further on, it may come back.
const AT_END: f32 = 0.25;
/// So many polygons whose boxes are near that of another are looked at for each polygon, on average, and so
/// many anyway: more there are only where boxes say little.
const EFFORT: usize = 256;
const LEAST_EFFORT: usize = 1 << 16;

/// Whether a mesh is one solid, in one piece, whose surface is near itself only where polygons join.
///
/// It is found out when a mesh is first asked, and remembered: in O(n log n). A mesh whose polygons are
/// in each other's boxes in such numbers that it would take longer does not tell.
pub fn tells_sides(mesh: &PolygonMesh) -> bool {
    mesh.is_one_solid()
        && mesh.keeps_away(|| mesh.is_manifold() && !is_folded(mesh) && Apart::of(mesh).is_all())
}

/// Whether two polygons that join nearly lie on each other.
fn is_folded(mesh: &PolygonMesh) -> bool {
    (0..mesh.polygon_count()).any(|polygon| {
        let normal = mesh.normals()[polygon];
        let mut across = mesh.across(polygon).iter();
        across.any(|other| normal.dot(mesh.normals()[*other as usize]) < FOLDED)
    })
}

/// The polygons of a mesh around its centre, which is where numbers are exact.
struct Apart<'a> {
    mesh: &'a PolygonMesh,
    center: Vec3A,
    least: f32,
}

type Corners = SmallVec<[Vec3A; 8]>;

impl<'a> Apart<'a> {
    fn of(mesh: &'a PolygonMesh) -> Self {
        let (center, _, radius) = mesh.local_bounds();
        Self {
            mesh,
            center,
            least: NEAR * radius,
        }
    }

    /// Are all polygons apart that do not join? No, if that takes too long to say.
    fn is_all(&self) -> bool {
        let count = self.mesh.polygon_count() as u32;
        let mut effort = LEAST_EFFORT + EFFORT * count as usize;
        (0..count).all(|polygon| {
            let corners = self.corners(polygon);
            let mut is_apart = |other: u32| {
                effort = effort.saturating_sub(1);
                effort > 0 && (other <= polygon || self.are_apart(polygon, &corners, other))
            };
            let Some(tree) = self.mesh.tree() else {
                return (polygon + 1..count).all(is_apart);
            };
            let mut are_all = true;
            tree.search(&Overlap::new(self.around(&corners)), 0.0, |other, _| {
                are_all = is_apart(other);
                if are_all {
                    ControlFlow::Continue(0.0)
                } else {
                    ControlFlow::Break(())
                }
            });
            are_all
        })
    }

    /// A box around a polygon, in the space of the mesh, that reaches into those of polygons near it.
    fn around(&self, corners: &[Vec3A]) -> Aabb3d {
        let first = (corners[0], corners[0]);
        let (min, max) = corners.iter().fold(first, |(min, max), corner| {
            (min.min(*corner), max.max(*corner))
        });
        // The way there and back rounds.
        let margin = self.least + 4.0 * f32::EPSILON * self.center.abs().max_element();
        Aabb3d {
            min: min + self.center - margin,
            max: max + self.center + margin,
        }
    }

    fn at(&self, vertex: u32) -> Vec3A {
        Vec3A::from(self.mesh.vertices()[vertex as usize]) - self.center
    }

    fn corners(&self, polygon: u32) -> Corners {
        let corners = self.mesh.polygon(polygon as usize).iter();
        corners.map(|vertex| self.at(*vertex)).collect()
    }

    /// Whether two polygons are near each other nowhere but where they join.
    fn are_apart(&self, one: u32, corners: &[Vec3A], other: u32) -> bool {
        let [ours, theirs] = [one, other].map(|polygon| self.mesh.polygon(polygon as usize));
        if let (&[a, b, c], &[d, e, f]) = (ours, theirs)
            && let &[at_a, at_b, at_c] = corners
        {
            let (ours, at_ours) = ([a, b, c], [at_a, at_b, at_c]);
            let (theirs, at_theirs) = ([d, e, f], [d, e, f].map(|vertex| self.at(vertex)));
            return self.triangle_leaves_alone((ours, &at_ours), (other, theirs, &at_theirs))
                && self.triangle_leaves_alone((theirs, &at_theirs), (one, ours, &at_ours));
        }
        let others = self.corners(other);
        self.leaves_alone((one, corners), (other, &others))
            && self.leaves_alone((other, &others), (one, corners))
    }

    /// Whether the sides of one triangle are near another nowhere but where the two join.
    ///
    /// Sides that begin on the other are near it nowhere else, if their third sides are not.
    fn triangle_leaves_alone(
        &self,
        (ours, corners): ([u32; 3], &[Vec3A; 3]),
        (other, theirs, others): (u32, [u32; 3], &[Vec3A; 3]),
    ) -> bool {
        let is_shared = ours.map(|vertex| {
            let [d, e, f] = theirs;
            (vertex == d) | (vertex == e) | (vertex == f)
        });
        [[0, 1], [1, 2], [2, 0]].into_iter().all(|side| {
            is_shared[side[0]]
                || is_shared[side[1]]
                || !self.is_near(side.map(|end| corners[end]), others, other)
        })
    }

    /// The same of polygons of any number of corners.
    fn leaves_alone(&self, one: (u32, &[Vec3A]), other: (u32, &[Vec3A])) -> bool {
        let [ours, theirs] = [one.0, other.0].map(|polygon| self.mesh.polygon(polygon as usize));
        let at = |corner: usize| ours[corner % ours.len()];
        let is_shared = |corner: usize| theirs.contains(&at(corner));
        let is_side = |from: u32, to: u32| {
            border(theirs).any(|side| side == [from, to] || side == [to, from])
        };
        border(one.1).enumerate().all(|(side, [from, to])| {
            let ends = match [is_shared(side), is_shared(side + 1)] {
                [false, false] => [from, to],
                [true, true] if is_side(at(side), at(side + 1)) => return true,
                // From one corner of it to another, across it, or beside it.
                [true, true] => [from.lerp(to, AT_END), to.lerp(from, AT_END)],
                [true, false] => [from.lerp(to, AT_END), to],
                [false, true] => [from, to.lerp(from, AT_END)],
            };
            !self.is_near(ends, other.1, other.0)
        })
    }

    /// Whether a segment and a polygon are apart along the way from the middle of one to that of the
    /// other. Nearly all are.
    #[inline]
    fn are_parted(&self, ends: &[Vec3A; 2], corners: &[Vec3A]) -> bool {
        let sum = corners
            .iter()
            .fold(Vec3A::ZERO, |sum, corner| sum + *corner);
        let way = (ends[0] + ends[1]) * 0.5 - sum / corners.len() as f32;
        let nearest = ends[0].dot(way).min(ends[1].dot(way));
        let furthest = corners.iter().map(|corner| corner.dot(way));
        let gap = nearest - furthest.fold(f32::NEG_INFINITY, f32::max);
        gap > self.least * way.length()
    }

    /// Whether a segment is near a polygon.
    #[inline]
    fn is_near(&self, ends: [Vec3A; 2], corners: &[Vec3A], polygon: u32) -> bool {
        !self.are_parted(&ends, corners) && self.is_near_side_by_side(ends, corners, polygon)
    }

    /// The same, of two that are not known to be apart.
    #[inline(never)]
    fn is_near_side_by_side(&self, ends: [Vec3A; 2], corners: &[Vec3A], polygon: u32) -> bool {
        let normal = Vec3A::from(self.mesh.normals()[polygon as usize]);
        let height = |point: &Vec3A| (*point - corners[0]).dot(normal);
        // Corners are in one plane, but for a little.
        let off = corners.iter().map(|corner| height(corner).abs());
        let reach = self.least + off.fold(0.0, f32::max);
        let [start, end] = [height(&ends[0]), height(&ends[1])];
        if start.min(end) > reach || start.max(end) < -reach {
            return false;
        }
        let crosses = start * end < 0.0
            && covers(
                corners,
                normal,
                ends[0].lerp(ends[1], start / (start - end)),
            );
        let ends_on = || {
            let is_on =
                |(end, height): (Vec3A, f32)| height.abs() <= reach && covers(corners, normal, end);
            is_on((ends[0], start)) || is_on((ends[1], end))
        };
        let is_beside = || {
            border(corners).any(|side| {
                let (one, other) = closest::segments(ends, side);
                one.distance_squared(other) <= self.least * self.least
            })
        };
        crosses || ends_on() || is_beside()
    }
}

#[cfg(test)]
mod tests;
