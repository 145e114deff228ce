//! The four primitives of neighbour-finding: `Adj`, `Reflect`, `CommonFace` and `CommonEdge`.
//!
//! All of them ask about a step in direction *I* from octant *O* of a block to the equally large
//! cell there, and what the step does to the block around it. Each axis along which the step goes
//! either stays in the block or leaves it, by whether the octant lies on the far or the near side.
//! The axes that are left are again a direction, as seen from the block: it may be *I* itself
//! (`Adj`), a lesser one (`CommonFace`, `CommonEdge`), or none if the step ends at a sibling.
//!
//! ```
//! use bevy_octree::octree::{Direction, Edge, Face, Vertex};
//!
//! // To the upper right from the lower right octant: out of the block through its right face,
//! let (step, octant) = (Edge::RU, Vertex::RDF);
//! assert!(!Direction::from(step).adj(octant));
//! assert_eq!(step.common_face(octant), Some(Face::R));
//! // to an upper left octant.
//! assert_eq!(Direction::from(step).reflect(octant), Vertex::LUF);
//! ```
//!
//! As in Samet, *Applications of Spatial Data Structures*, 1990, pages 87–90, each is a table
//! lookup. The tables are computed when the crate is compiled.

use super::direction::{Direction, Edge, Face, Vertex};

/// For each step and octant, the side of the octant's block by which the step leaves it.
const EXITS: [[Option<Direction>; 8]; 26] = {
    let mut table = [[None; 8]; 26];
    let mut i = 0;
    while i < 26 {
        let step = Direction::ALL[i].signs();
        let mut o = 0;
        while o < 8 {
            let octant = Vertex::ALL[o].signs();
            let mut exit = [0; 3];
            let mut axis = 0;
            while axis < 3 {
                // An axis along which there is no step has sign 0, and no octant has that.
                if step[axis] == octant[axis] {
                    exit[axis] = step[axis];
                }
                axis += 1;
            }
            table[i][o] = Direction::from_signs(exit);
            o += 1;
        }
        i += 1;
    }
    table
};

/// For each step, a bit for each axis along which it goes, as in [`Vertex::bits`].
const AXES: [u8; 26] = {
    let mut table = [0; 26];
    let mut i = 0;
    while i < 26 {
        let [x, y, z] = Direction::ALL[i].signs();
        table[i] = (x != 0) as u8 | ((y != 0) as u8) << 1 | ((z != 0) as u8) << 2;
        i += 1;
    }
    table
};

impl Direction {
    /// `Adj`: whether the octant touches this face, edge or vertex of its block, so that a step in
    /// this direction leaves the block in the same direction.
    #[inline]
    #[must_use]
    pub const fn adj(self, octant: Vertex) -> bool {
        match self.exit(octant) {
            Some(exit) => exit.index() == self.index(),
            None => false,
        }
    }

    /// `Reflect`: the octant, of its own block, that a step in this direction leads to.
    #[inline]
    #[must_use]
    pub const fn reflect(self, octant: Vertex) -> Vertex {
        Vertex::from_bits(octant.bits() ^ AXES[self.index()] as u32)
    }

    /// The direction, seen from the octant's block, of the block that a step leads to; [`None`] if
    /// it leads to a sibling.
    ///
    /// This is the direction itself where [`adj`](Self::adj) holds, and otherwise the common edge
    /// or face if there is one.
    #[inline]
    pub(super) const fn exit(self, octant: Vertex) -> Option<Self> {
        EXITS[self.index()][octant.index()]
    }
}

impl Edge {
    /// `CommonFace`: the face of the octant's block that lies between the octant and its neighbour
    /// across this edge.
    ///
    /// [`None`] if the neighbour is a sibling, or lies across an edge of the block.
    #[inline]
    #[must_use]
    pub const fn common_face(self, octant: Vertex) -> Option<Face> {
        match Direction::Edge(self).exit(octant) {
            Some(Direction::Face(face)) => Some(face),
            _ => None,
        }
    }
}

impl Vertex {
    /// `CommonFace`: the face of the octant's block that lies between the octant and its neighbour
    /// across this vertex.
    ///
    /// [`None`] if the neighbour is a sibling, or lies across an edge or a vertex of the block.
    #[inline]
    #[must_use]
    pub const fn common_face(self, octant: Vertex) -> Option<Face> {
        match Direction::Vertex(self).exit(octant) {
            Some(Direction::Face(face)) => Some(face),
            _ => None,
        }
    }

    /// `CommonEdge`: the edge of the octant's block that lies between the octant and its neighbour
    /// across this vertex.
    ///
    /// [`None`] if the neighbour is a sibling, or lies across a face or a vertex of the block.
    #[inline]
    #[must_use]
    pub const fn common_edge(self, octant: Vertex) -> Option<Edge> {
        match Direction::Vertex(self).exit(octant) {
            Some(Direction::Edge(edge)) => Some(edge),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::IVec3;

    use super::*;

    /// The lower corner of the unit cell that is the octant of the block from 0 to 2.
    fn cell(octant: Vertex) -> IVec3 {
        (octant.offset() + IVec3::ONE) / 2
    }

    /// The cell that the step leads to, and the lattice place of the block it belongs to.
    fn step(direction: Direction, octant: Vertex) -> (IVec3, IVec3) {
        let cell = cell(octant) + direction.offset();
        (cell.rem_euclid(IVec3::splat(2)), cell.div_euclid(IVec3::splat(2)))
    }

    /// Every direction with every octant.
    fn entries() -> impl Iterator<Item = (Direction, Vertex)> {
        Direction::ALL.into_iter().flat_map(|direction| Vertex::ALL.map(|octant| (direction, octant)))
    }

    #[test]
    fn adj_is_contact_with_the_feature() {
        for (direction, octant) in entries() {
            // The feature is where the block's closed cell meets the one in that direction.
            let block = direction.offset() * 2;
            let (low, high) = (block.max(IVec3::ZERO), (block + 2).min(IVec3::splat(2)));
            let cell = cell(octant);
            let overlap = high.min(cell + 1) - low.max(cell);
            let touches = overlap.min_element() >= 0;
            assert_eq!(direction.adj(octant), touches, "{direction} of {octant}");
        }
    }

    #[test]
    fn reflect_is_the_place_in_the_block_that_is_reached() {
        for (direction, octant) in entries() {
            let (place, _) = step(direction, octant);
            assert_eq!(cell(direction.reflect(octant)), place, "{direction} of {octant}");
        }
    }

    #[test]
    fn common_face_and_edge_lie_between_the_blocks() {
        for (direction, octant) in entries() {
            let (_, block) = step(direction, octant);
            let face = Face::ALL.into_iter().find(|face| face.offset() == block);
            let edge = Edge::ALL.into_iter().find(|edge| edge.offset() == block);
            match direction {
                Direction::Face(_) => {}
                Direction::Edge(step) => assert_eq!(step.common_face(octant), face),
                Direction::Vertex(step) => {
                    assert_eq!(step.common_face(octant), face);
                    assert_eq!(step.common_edge(octant), edge);
                }
            }
        }
    }

    #[test]
    fn an_exit_is_one_of_the_four_cases() {
        for (direction, octant) in entries() {
            let (_, block) = step(direction, octant);
            let exit = direction.exit(octant);
            assert_eq!(exit.map_or(IVec3::ZERO, Direction::offset), block);
            assert_eq!(exit == Some(direction), direction.adj(octant));
        }
    }
}
