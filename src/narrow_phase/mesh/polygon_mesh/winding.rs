//! Whether a mesh winds around a point.

use bevy::math::{DVec3, bounding::Aabb3d};

use super::PolygonMesh;

impl PolygonMesh {
    /// Calls `found` with the corners of each polygon that bounds a solid, those vertices included
    /// that lie on its sides: so that polygons side by side have the same corners there.
    pub(in crate::narrow_phase) fn for_each_solid(&self, mut found: impl FnMut(&[u32])) {
        let mut corners = Vec::new();
        for polygon in 0..self.polygon_count() {
            if self.solid.contains(polygon as u32) {
                self.with_outline(polygon, &mut corners, &mut found);
            }
        }
    }

    pub(super) fn with_outline<R>(
        &self,
        polygon: usize,
        outline: &mut Vec<u32>,
        found: impl FnOnce(&[u32]) -> R,
    ) -> R {
        let corners = self.polygon(polygon);
        if self.junctions.is_empty() {
            return found(corners);
        }
        let sides = self.polygons.sides(polygon);
        let first = self
            .junctions
            .partition_point(|junction| (junction.side as usize) < sides.start);
        let mut junctions = self.junctions[first..].iter().peekable();
        outline.clear();
        for (side, corner) in sides.zip(corners) {
            outline.push(*corner);
            while let Some(junction) = junctions.next_if(|next| next.side as usize == side) {
                outline.push(junction.vertex);
            }
        }
        found(outline)
    }

    /// Returns `true` if the mesh winds around a point that is not on its surface.
    ///
    /// Counts how often a ray along x comes out of it more often than in. A side that two polygons
    /// share is seen alike from both, so that none can slip through between them.
    pub(in crate::narrow_phase) fn winds_around(&self, point: DVec3) -> bool {
        if !self.has_inside() {
            return false;
        }
        let (mut winding, mut outline) = (0, Vec::new());
        self.for_each_along_x(point, |polygon| {
            if self.solid.contains(polygon as u32) {
                winding += self.with_outline(polygon, &mut outline, |corners| {
                    self.crossing(corners, point)
                });
            }
        });
        winding != 0
    }

    /// Calls `found` with each polygon whose box a ray along x may meet.
    pub(super) fn for_each_along_x(&self, point: DVec3, mut found: impl FnMut(usize)) {
        let Some(tree) = &self.tree else {
            return (0..self.polygon_count()).for_each(found);
        };
        // As 32-bit floats, it may be a little off.
        let near = point.as_vec3a();
        let ray = Aabb3d {
            min: near.map(f32::next_down),
            max: near.map(f32::next_up).with_x(f32::MAX),
        };
        tree.for_each_overlapping(&ray, |polygon| found(polygon as usize));
    }

    /// Which way a ray along x, from a point on, crosses a polygon: 1 or -1; 0 if it does not.
    pub(super) fn crossing(&self, corners: &[u32], point: DVec3) -> i32 {
        let at = |vertex: &u32| self.vertices[*vertex as usize].as_dvec3();
        let mut winding = 0;
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
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
        let origin = at(&corners[0]);
        let normal: DVec3 = corners[1..]
            .windows(2)
            .map(|pair| (at(&pair[0]) - origin).cross(at(&pair[1]) - origin))
            .sum();
        let (first, last) = corners.iter().map(at).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(first, last), corner| (first.min(corner.x), last.max(corner.x)),
        );
        let aside = (point - origin).with_x(0.0);
        // Where it is along x cannot be told of one that is seen from its side.
        let x = (origin.x - normal.dot(aside) / normal.x).clamp(first, last);
        if x > point.x { winding } else { 0 }
    }
}
