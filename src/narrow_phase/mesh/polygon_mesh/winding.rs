//! Whether a mesh winds around a point.

use bevy::math::{DVec3, Vec3A, Vec3Swizzles, bounding::Aabb3d};

use smallvec::SmallVec;

use super::PolygonMesh;
use crate::narrow_phase::mesh::junctions::Junction;

/// Outlines of so many corners, vertices on sides included, allocate nothing.
const SHORT: usize = 64;

/// The corners of a polygon, and the vertices on its sides, in the order around it.
#[derive(Clone)]
struct Outline<'a> {
    corners: std::slice::Iter<'a, u32>,
    /// The side that begins at the next corner.
    next_side: usize,
    /// Those on the sides from the first on.
    junctions: &'a [Junction],
}

impl Iterator for Outline<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if let [first, rest @ ..] = self.junctions
            && (first.side as usize) < self.next_side
        {
            self.junctions = rest;
            return Some(first.vertex);
        }
        let corner = self.corners.next()?;
        self.next_side += 1;
        Some(*corner)
    }
}

/// A ray along an axis, one way or the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisRay {
    origin: DVec3,
    axis: usize,
    is_backwards: bool,
}

impl AxisRay {
    /// The one along x.
    pub(super) const fn along_x(origin: DVec3) -> Self {
        Self {
            origin,
            axis: 0,
            is_backwards: false,
        }
    }

    /// The one that leaves a box first, or misses it.
    fn shortest(origin: DVec3, center: Vec3A, half: Vec3A) -> Self {
        let from_center = origin - center.as_dvec3();
        let left = half.as_dvec3() - from_center.abs();
        let axis = left.min_position();
        Self {
            origin,
            axis,
            is_backwards: from_center[axis] < 0.0,
        }
    }

    /// Has the ray go along x.
    #[inline]
    fn turn(&self, point: DVec3) -> DVec3 {
        let turned = match self.axis {
            0 => point,
            1 => point.yzx(),
            _ => point.zxy(),
        };
        if self.is_backwards {
            turned.with_x(-turned.x)
        } else {
            turned
        }
    }

    /// A box around the ray, which as 32-bit floats may be a little off.
    fn bounds(&self) -> Aabb3d {
        let near = self.origin.as_vec3a();
        let (mut min, mut max) = (near.map(f32::next_down), near.map(f32::next_up));
        if self.is_backwards {
            min[self.axis] = f32::MIN;
        } else {
            max[self.axis] = f32::MAX;
        }
        Aabb3d { min, max }
    }
}

impl PolygonMesh {
    /// Calls `found` with the corners of each polygon that bounds a solid, those vertices included
    /// that lie on its sides: so that polygons side by side have the same corners there.
    pub(in crate::narrow_phase) fn for_each_solid(&self, mut found: impl FnMut(&[u32])) {
        let mut outline = SmallVec::<[u32; SHORT]>::new();
        for polygon in 0..self.polygon_count() {
            if !self.solid.contains(polygon as u32) {
                continue;
            }
            if self.has_junctions() {
                outline.clear();
                outline.extend(self.outline(polygon));
                found(&outline);
            } else {
                found(self.polygon(polygon));
            }
        }
    }

    pub(in crate::narrow_phase) const fn has_junctions(&self) -> bool {
        !self.junctions.is_empty()
    }

    /// The corners of a polygon, and the vertices on its sides.
    fn outline(&self, polygon: usize) -> Outline<'_> {
        let start = self.polygons.sides(polygon).start;
        let first = self
            .junctions
            .partition_point(|junction| (junction.side as usize) < start);
        Outline {
            corners: self.polygon(polygon).iter(),
            next_side: start,
            junctions: &self.junctions[first..],
        }
    }

    /// Returns `true` if the mesh winds around a point that is not on its surface.
    ///
    /// Counts how often a ray along an axis comes out of it more often than in: the one that first
    /// leaves its box. A side that two polygons share is seen alike from both, so that none can slip
    /// through between them.
    pub(in crate::narrow_phase) fn winds_around(&self, point: DVec3) -> bool {
        if !self.has_inside() {
            return false;
        }
        let ray = AxisRay::shortest(point, self.center, self.half_size);
        let mut winding = 0;
        self.for_each_along(&ray, |polygon| {
            if self.solid.contains(polygon as u32) {
                winding += self.crossing(polygon, &ray);
            }
        });
        winding != 0
    }

    /// Calls `found` with each polygon whose box a ray may meet.
    pub(super) fn for_each_along(&self, ray: &AxisRay, mut found: impl FnMut(usize)) {
        let Some(tree) = &self.tree else {
            return (0..self.polygon_count()).for_each(found);
        };
        tree.for_each_overlapping(&ray.bounds(), |polygon| found(polygon as usize));
    }

    /// Which way a ray crosses a polygon: 1 or -1; 0 if it does not. Opposite rays, opposite signs.
    pub(super) fn crossing(&self, polygon: usize, ray: &AxisRay) -> i32 {
        if self.has_junctions() {
            self.crossing_of(self.outline(polygon), ray)
        } else {
            self.crossing_of(self.polygon(polygon).iter().copied(), ray)
        }
    }

    fn crossing_of(&self, corners: impl Iterator<Item = u32> + Clone, ray: &AxisRay) -> i32 {
        let point = ray.turn(ray.origin);
        let at = |vertex: u32| ray.turn(self.vertices[vertex as usize].as_dvec3());
        let mut winding = 0;
        for (a, b) in corners.clone().zip(corners.clone().cycle().skip(1)) {
            let (a, b) = (at(a), at(b));
            if (a.y > point.y) != (b.y > point.y) {
                // From the lower end up, whichever polygon asks.
                let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
                let share = (point.y - low.y) / (high.y - low.y);
                if low.z + (high.z - low.z) * share > point.z {
                    winding += if b.y > a.y { 1 } else { -1 };
                }
            }
        }
        if winding == 0 {
            return 0;
        }
        let mut ways = corners.clone().map(at);
        let Some(origin) = ways.next() else {
            return 0;
        };
        let normal: DVec3 = ways
            .clone()
            .zip(ways.skip(1))
            .map(|(a, b)| (a - origin).cross(b - origin))
            .sum();
        let (first, last) = corners.map(at).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(first, last), corner| (first.min(corner.x), last.max(corner.x)),
        );
        let aside = (point - origin).with_x(0.0);
        // Where it is along x cannot be told of one that is seen from its side.
        let x = (origin.x - normal.dot(aside) / normal.x).clamp(first, last);
        if x > point.x { winding } else { 0 }
    }
}
