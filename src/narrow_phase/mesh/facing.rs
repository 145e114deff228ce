//! Which side of the polygons of a solid is outside.

use bevy::math::DVec3;

use super::{cache::Facing, polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR};

/// How far off a polygon a point is that is surely on one side of it, as a share of the polygon's
/// size.
const BESIDE: f64 = 1e-5;

impl Facing {
    /// O(shells · log n), and O(n) if they differ.
    fn of(mesh: &PolygonMesh) -> Self {
        let shells = mesh.shell_polygons();
        let solid = || shells.iter().filter(|polygon| mesh.bounds_solid(**polygon));
        let mut sides = solid().map(|polygon| mesh.is_outwards(*polygon));
        let first = sides.next().unwrap_or(true);
        if solid().count() == shells.len() && sides.all(|side| side == first) {
            return Self::Outwards(first);
        }
        let mut known: Vec<Option<bool>> = vec![None; mesh.polygon_count()];
        let mut open = Vec::new();
        for polygon in 0..mesh.polygon_count() as u32 {
            if known[polygon as usize].is_some() || !mesh.bounds_solid(polygon) {
                continue;
            }
            let side = mesh.is_outwards(polygon);
            open.push(polygon);
            while let Some(polygon) = open.pop() {
                let across = mesh.across(polygon as usize).iter().copied();
                known[polygon as usize] = Some(side);
                open.extend(across.filter(|other| {
                    *other != NO_NEIGHBOR
                        && known[*other as usize].is_none()
                        && mesh.bounds_solid(*other)
                }));
            }
        }
        let mut sides = known.iter().flatten();
        let first = sides.next().copied().unwrap_or(true);
        if sides.all(|side| *side == first) {
            return Self::Outwards(first);
        }
        Self::Each(known.iter().map(|side| side.unwrap_or(true)).collect())
    }
}

impl PolygonMesh {
    /// Which way the normal of a polygon points that bounds a solid: 1 outwards, -1 inwards. `None`
    /// for one that does not.
    #[inline]
    pub(in crate::narrow_phase) fn outwards(&self, polygon: u32) -> Option<f32> {
        if !self.bounds_solid(polygon) {
            return None;
        }
        let is_outwards = match self.cache.facing.get_or_init(|| Facing::of(self)) {
            Facing::Outwards(is_outwards) => *is_outwards,
            Facing::Each(sides) => sides[polygon as usize],
        };
        Some(if is_outwards { 1.0 } else { -1.0 })
    }

    /// Is the side that the normal of a polygon points to outside? Of a wall with a solid on both
    /// sides, it is taken to be.
    fn is_outwards(&self, polygon: u32) -> bool {
        let corners = self.polygon(polygon as usize);
        let at = |corner: usize| self.vertices()[corners[corner] as usize].as_dvec3();
        // Within the polygon, if it is convex.
        let middle: DVec3 = (at(0) + at(1) + at(2)) / 3.0;
        let size = (at(1) - at(0)).length().min((at(2) - at(1)).length());
        let normal = self.normals()[polygon as usize].as_dvec3();
        !self.winds_around(middle + normal * (BESIDE * size))
            || self.winds_around(middle - normal * (BESIDE * size))
    }
}
