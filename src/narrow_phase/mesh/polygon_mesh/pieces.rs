//! Of how many pieces a mesh is, and how its polygons join.

use super::{PolygonMesh, Solid};
use crate::narrow_phase::mesh::{edges::Bits, topology::NO_NEIGHBOR};

impl PolygonMesh {
    /// A vertex of each connected part of the surface.
    pub(in crate::narrow_phase) fn shells(&self) -> impl ExactSizeIterator<Item = u32> {
        let first = |polygon: &u32| self.polygon(*polygon as usize)[0];
        self.shells.iter().map(first)
    }

    /// Whether the surface has parts that do not hang together.
    pub(in crate::narrow_phase) fn is_in_parts(&self) -> bool {
        self.shells.len() > 1
    }

    /// Whether the mesh is one solid, in one piece.
    pub(in crate::narrow_phase) fn is_one_solid(&self) -> bool {
        self.shells.len() == 1 && self.is_closed() && self.has_inside()
    }

    /// Whether a polygon stands for its connected part of the surface: each has one that does.
    pub(in crate::narrow_phase) fn is_representative(&self, polygon: u32) -> bool {
        self.shells.binary_search(&polygon).is_ok()
    }

    /// What was found when it was first asked whether the surface keeps away from itself: a matter of
    /// the mesh alone.
    pub(in crate::narrow_phase) fn keeps_away(&self, find: impl FnOnce() -> bool) -> bool {
        *self.keeps_away.get_or_init(find)
    }

    /// The polygon that comes after another around a vertex, and the number of its corner there:
    /// across the side that begins at a corner. `None` if none joins there that is turned alike.
    pub(in crate::narrow_phase) fn next_around(
        &self,
        (polygon, corner): (usize, usize),
    ) -> Option<(usize, usize)> {
        let corners = self.polygon(polygon);
        let [vertex, end] = [corner, corner + 1].map(|at| corners[at % corners.len()]);
        let next = self.across(polygon)[corner];
        if next == NO_NEIGHBOR {
            return None;
        }
        let corners = self.polygon(next as usize);
        let there = corners.iter().position(|corner| *corner == vertex)?;
        let last = corners[(there + corners.len() - 1) % corners.len()];
        (last == end).then_some((next as usize, there))
    }

    /// Whether all polygons bound a solid, each side joins two of them, and those at a vertex go around
    /// it once.
    pub(in crate::narrow_phase) fn is_manifold(&self) -> bool {
        if self.solid != Solid::All || self.has_junctions() {
            return false;
        }
        let mut seen = Bits::none(self.polygons.corners().len());
        let mut surrounded = Bits::none(self.vertices.len());
        for polygon in 0..self.polygon_count() {
            for (corner, vertex) in self.polygon(polygon).iter().enumerate() {
                let side = |(polygon, corner): (usize, usize)| {
                    (self.polygons.sides(polygon).start + corner) as u32
                };
                let first = (polygon, corner);
                if seen.contains(side(first)) {
                    continue;
                }
                if surrounded.contains(*vertex) {
                    return false;
                }
                surrounded.insert(*vertex);
                let mut at = first;
                while !seen.contains(side(at)) {
                    seen.insert(side(at));
                    match self.next_around(at) {
                        Some(next) => at = next,
                        None => return false,
                    }
                }
                if at != first {
                    return false;
                }
            }
        }
        true
    }
}
