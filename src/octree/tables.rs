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
    pub const fn common_face(self, octant: Self) -> Option<Face> {
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
    pub const fn common_edge(self, octant: Self) -> Option<Edge> {
        match Direction::Vertex(self).exit(octant) {
            Some(Direction::Edge(edge)) => Some(edge),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
