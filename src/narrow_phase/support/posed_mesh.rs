//! Meshes as the convex parts of other shapes meet them: triangle by triangle, by the
//! tree of the mesh.
//!
//! Scale and mirrors are put on what is asked, in 64-bit floats, and on the triangles that are found.

use std::ops::ControlFlow;

use bevy::math::{BVec3, DVec3, Vec3A, bounding::Aabb3d, primitives::HalfSpace};

use super::convex::Isometry;
use super::probe::{Probe, Search, passage};
use super::triangulate::triangulate;
use crate::broad_phase::{Measure, Overlap, ScaledDistance, StillOctree, Sweep};
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// The least scale along an axis by which is divided, as a share of the greatest.
const FLAT: f64 = 1e-7;
/// How much larger things are made for what 32-bit floats leave uncertain, as a share of the
/// lengths at hand.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;

/// A mesh of ours in its place, at a scale.
#[derive(Clone, Copy)]
pub struct PosedMesh<'a> {
    pub mesh: &'a PolygonMesh,
    pub scale: DVec3,
    pub at: Isometry,
}

impl PosedMesh<'_> {
    /// Centre and half extents of the box around it, in its own axes.
    pub fn local_box(&self) -> [DVec3; 2] {
        let (center, half, _) = self.mesh.local_bounds();
        [
            center.as_dvec3() * self.scale,
            half.as_dvec3() * self.scale.abs(),
        ]
    }

    /// Calls `visit` with the corners of all triangles that a probe admits, in place, and which
    /// polygon each is of: near ones first if what is nearest is looked for, and first ones first on
    /// a way. They face out of a solid, and otherwise as the polygons of the mesh do.
    pub fn each(&self, probe: &Probe, search: &Search, visit: &mut dyn FnMut(u32, [DVec3; 3])) {
        let Some(tree) = self.mesh.tree() else {
            return self.each_admitted(probe, search, visit);
        };
        match *probe {
            Probe::Everywhere => self.each_admitted(probe, search, visit),
            Probe::HalfSpace {
                normal,
                offset,
                approach,
            } => {
                let reach = offset + search.margin.get() + approach * search.limit.get();
                let Some(plane) = self.plane(normal, reach) else {
                    return self.each_admitted(probe, search, visit);
                };
                tree.for_each_overlapping(&[plane][..], |polygon| {
                    if search.goes_on() {
                        self.triangles(polygon as usize, visit);
                    }
                });
            }
            Probe::Box {
                center,
                half,
                direction,
            } if search.limit.get() > 0.0 => {
                self.each_on_the_way(tree, [center, half, direction], search, visit);
            }
            Probe::Box { center, half, .. } if search.is_for_nearest => {
                let Some(from) = self.back(center, half) else {
                    return;
                };
                let scale = self.scale.abs() * (1.0 - ROUNDING);
                let measure = ScaledDistance::new(from, scale.as_vec3a());
                let limit = || {
                    let margin = search.margin.get();
                    if margin < 0.0 {
                        return f32::NEG_INFINITY;
                    }
                    up(margin * margin)
                };
                self.search(tree, &measure, limit, search, visit);
            }
            Probe::Box { center, half, .. } => {
                let Some(region) = self.back(center, half + search.margin.get()) else {
                    return;
                };
                let measure = Overlap::new(region);
                self.search(tree, &measure, || 0.0, search, visit);
            }
        }
    }

    /// Of a box that moves.
    fn each_on_the_way(
        &self,
        tree: &StillOctree,
        [center, half, direction]: [DVec3; 3],
        search: &Search,
        visit: &mut dyn FnMut(u32, [DVec3; 3]),
    ) {
        let [middle, reach] = self.local_box();
        let rounding = ROUNDING * (middle.abs() + reach + half).max_element();
        let half = half + search.margin.get() + rounding;
        // From near the mesh, 32-bit floats are exact enough.
        let (low, high) = (middle - reach - half, middle + reach + half);
        let limit = search.limit.get();
        let Some([start, _]) = passage(low - center, high - center, direction, limit) else {
            return;
        };
        let flat = self.is_flat();
        let local = DVec3::select(flat, DVec3::ZERO, direction / self.divisor(flat));
        let Some((from, speed)) = self
            .around(center + direction * start, half, flat)
            .zip(Some(local.length()))
        else {
            return;
        };
        let local = (local / speed.max(f64::MIN_POSITIVE)).as_vec3a();
        let (measure, _) = Sweep::along(Vec3A::ZERO, local, from.min, from.max, f32::INFINITY);
        let left = || up((search.limit.get() - start) * speed) * (1.0 + 4.0 * f32::EPSILON);
        self.search(tree, &measure, left, search, visit);
    }

    /// Calls `visit` with the triangles that a measure finds, within a limit that changes.
    fn search(
        &self,
        tree: &StillOctree,
        measure: &impl Measure,
        limit: impl Fn() -> f32,
        search: &Search,
        visit: &mut dyn FnMut(u32, [DVec3; 3]),
    ) {
        tree.search(measure, limit(), |polygon, _| {
            self.triangles(polygon as usize, visit);
            if search.goes_on() {
                ControlFlow::Continue(limit())
            } else {
                ControlFlow::Break(())
            }
        });
    }

    /// One polygon after the other.
    fn each_admitted(
        &self,
        probe: &Probe,
        search: &Search,
        visit: &mut dyn FnMut(u32, [DVec3; 3]),
    ) {
        for polygon in 0..self.mesh.polygon_count() {
            if !search.goes_on() {
                return;
            }
            let corners = self.mesh.polygon(polygon).iter();
            let [low, high] = corners.map(|corner| self.scaled(*corner)).fold(
                [DVec3::INFINITY, DVec3::NEG_INFINITY],
                |[low, high], corner| [low.min(corner), high.max(corner)],
            );
            if probe.admits(low, high, search) {
                self.triangles(polygon, visit);
            }
        }
    }

    /// Calls `visit` with the triangles that a polygon consists of, in place.
    fn triangles(&self, polygon: usize, visit: &mut dyn FnMut(u32, [DVec3; 3])) {
        let index = polygon as u32;
        let is_turned = self.is_turned();
        let mut visit = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|corner| self.place(corner));
            visit(index, if is_turned { [a, c, b] } else { [a, b, c] });
        };
        match *self.mesh.polygon(polygon) {
            [a, b, c] => visit([a, b, c]),
            ref corners => {
                let normal = self.mesh.normals()[polygon];
                triangulate(self.mesh.vertices(), corners, normal, visit);
            }
        }
    }

    /// Do polygons as the mesh has them face the other way in place?
    fn is_turned(&self) -> bool {
        self.scale.x * self.scale.y * self.scale.z < 0.0
    }

    /// A vertex in place.
    pub fn place(&self, vertex: u32) -> DVec3 {
        self.at.to_world(self.scaled(vertex))
    }

    fn scaled(&self, vertex: u32) -> DVec3 {
        self.mesh.vertices()[vertex as usize].as_dvec3() * self.scale
    }

    /// Along which axes is there next to no scale, and no way back?
    fn is_flat(&self) -> BVec3 {
        let scale = self.scale.abs();
        let least = (FLAT * scale.max_element()).max(f64::from(f32::MIN_POSITIVE));
        scale.cmplt(DVec3::splat(least))
    }

    fn divisor(&self, flat: BVec3) -> DVec3 {
        DVec3::select(flat, DVec3::ONE, self.scale)
    }

    /// The box in the space of the mesh around a box in its axes; `None` if the mesh, being flat,
    /// is nowhere near.
    fn back(&self, center: DVec3, half: DVec3) -> Option<Aabb3d> {
        self.around(center, half, self.is_flat())
    }

    /// The same, given along which axes the mesh is flat.
    fn around(&self, center: DVec3, half: DVec3, flat: BVec3) -> Option<Aabb3d> {
        let divisor = self.divisor(flat);
        let (middle, reach, _) = self.mesh.local_bounds();
        let (middle, reach) = (middle.as_dvec3(), reach.as_dvec3());
        // All of a flat mesh counts as near.
        let center = DVec3::select(flat, middle, center / divisor);
        let half = DVec3::select(flat, reach, half / divisor.abs());
        let limit = |corner: DVec3| {
            let largest = DVec3::splat(f32::MAX.into());
            corner.clamp(-largest, largest).as_vec3a()
        };
        let (min, max) = (limit(center - half), limit(center + half));
        let is_box = min.cmple(max).all();
        is_box.then(|| Aabb3d {
            min: min.map(f32::next_down).max(Vec3A::MIN),
            max: max.map(f32::next_up).min(Vec3A::MAX),
        })
    }

    /// The half-space, in the space of the mesh, beyond whose border along a normal nothing is
    /// asked for; `None` where that is along an axis without scale.
    fn plane(&self, normal: DVec3, reach: f64) -> Option<HalfSpace> {
        let (middle, half, _) = self.mesh.local_bounds();
        let outwards = normal * self.scale;
        let size = outwards
            .abs()
            .dot(middle.abs().as_dvec3() + half.as_dvec3());
        let length = outwards.length();
        let reach = (reach + ROUNDING * (size + reach.abs())) / length;
        let inwards = -(outwards / length).as_vec3();
        let plane = inwards.extend(reach as f32);
        plane.is_finite().then(|| HalfSpace::new(plane))
    }
}

/// No less, in 32 bits.
fn up(value: f64) -> f32 {
    (value as f32).next_up()
}

#[cfg(all(test, feature = "rapier"))]
mod tests;
