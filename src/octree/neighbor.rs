//! Neighbours of a node: the nodes across its faces, edges and vertices.
//!
//! Next to a node may lie an equally large one, the leaf of a coarser part of the tree, or many
//! smaller ones. The neighbour *of greater or equal size* is the first or the second of these, or
//! the common ancestor of the third: the smallest node, not smaller than the node itself, that
//! contains the equally large cell in the given direction. There is none beyond the root.
//!
//! To find it, ascend to the first ancestor that contains both cells, and descend the mirrored way.
//! [`Direction::adj`], [`Vertex::common_edge`], [`Vertex::common_face`] and [`Edge::common_face`]
//! tell at each step up in which direction, from the parent, the search goes on, or that it is
//! over; [`Direction::reflect`] tells the way down (Samet, *Applications of Spatial Data
//! Structures*, 1990, chapter 3). No coordinates are needed, nor the depth of the tree.

use smallvec::SmallVec;

use super::direction::{Direction, Edge, Face, Vertex};
use super::node::NodeId;
use super::tree::Octree;

impl<T> Octree<T> {
    /// Returns the neighbour of greater or equal size in any direction, or [`None`] beyond the
    /// root.
    ///
    /// Takes time linear in the number of generations to the closest ancestor that contains both.
    /// On average over a full tree that is a constant; at worst, across the middle of the root or
    /// out of it, it is the node's generation. Allocates only if it ascends more than 32
    /// generations.
    ///
    /// ```
    /// use bevy_octree::octree::{Direction, Edge, Octree, Vertex};
    ///
    /// let mut tree = Octree::new(());
    /// let root = tree.root();
    /// tree.split(root);
    /// let left = tree.child(root, Vertex::LDF).unwrap();
    /// let right = tree.child(root, Vertex::RUF);
    ///
    /// assert_eq!(tree.neighbor(left, Direction::Edge(Edge::RU)), right);
    /// assert_eq!(tree.neighbor(left, Direction::Edge(Edge::LU)), None);
    /// ```
    #[must_use]
    pub fn neighbor(&self, node: NodeId, direction: Direction) -> Option<NodeId> {
        // The octants to take on the way down, the lowest first.
        let mut way: SmallVec<[Vertex; 32]> = SmallVec::new();
        let mut at = node;
        let mut direction = direction;
        let mut neighbor = loop {
            let parent = self.parent(at)?;
            let octant = self.child_type(at)?;
            way.push(direction.reflect(octant));
            match direction.exit(octant) {
                Some(exit) => direction = exit,
                None => break parent,
            }
            at = parent;
        };
        while let Some(octant) = way.pop() {
            match self.child(neighbor, octant) {
                Some(child) => neighbor = child,
                None => break,
            }
        }
        Some(neighbor)
    }

    /// Returns the neighbour of greater or equal size across a face; as
    /// [`neighbor`](Self::neighbor).
    #[inline]
    #[must_use]
    pub fn face_neighbor(&self, node: NodeId, face: Face) -> Option<NodeId> {
        self.neighbor(node, face.into())
    }

    /// Returns the neighbour of greater or equal size across an edge; as
    /// [`neighbor`](Self::neighbor).
    #[inline]
    #[must_use]
    pub fn edge_neighbor(&self, node: NodeId, edge: Edge) -> Option<NodeId> {
        self.neighbor(node, edge.into())
    }

    /// Returns the neighbour of greater or equal size across a vertex; as
    /// [`neighbor`](Self::neighbor).
    #[inline]
    #[must_use]
    pub fn vertex_neighbor(&self, node: NodeId, vertex: Vertex) -> Option<NodeId> {
        self.neighbor(node, vertex.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_has_no_neighbors() {
        let mut tree = Octree::new(0);
        for _ in 0..2 {
            assert!(
                Direction::ALL
                    .into_iter()
                    .all(|d| tree.neighbor(tree.root(), d).is_none())
            );
            if tree.is_leaf(NodeId::ROOT) {
                tree.split(NodeId::ROOT);
            }
        }
    }

    #[test]
    fn a_coarser_neighbor_is_larger_and_a_finer_one_is_not_entered() {
        let mut tree = Octree::new(0);
        tree.split(NodeId::ROOT);
        let left = tree.child(NodeId::ROOT, Vertex::LDF).unwrap();
        let right = tree.child(NodeId::ROOT, Vertex::RDF).unwrap();
        tree.split(left);
        let small = tree.child(left, Vertex::RUF).unwrap();
        assert_eq!(tree.face_neighbor(small, Face::R), Some(right));
        assert_eq!(tree.edge_neighbor(small, Edge::RD), Some(right));
        assert_eq!(tree.vertex_neighbor(small, Vertex::RDB), Some(right));
        assert_eq!(tree.face_neighbor(right, Face::L), Some(left));
    }

    #[test]
    fn neighbors_are_found_across_very_deep_trees() {
        // Two chains of nodes that meet at the plane between the root's left and right half.
        let mut tree = Octree::new(0);
        tree.split(NodeId::ROOT);
        let [mut left, mut right] =
            [Vertex::LDF, Vertex::RDF].map(|octant| tree.child(NodeId::ROOT, octant).unwrap());
        for _ in 0..10_000 {
            tree.split(left);
            tree.split(right);
            left = tree.child(left, Vertex::RDF).unwrap();
            right = tree.child(right, Vertex::LDF).unwrap();
        }
        assert_eq!(tree.face_neighbor(left, Face::R), Some(right));
        assert_eq!(tree.face_neighbor(right, Face::L), Some(left));
        assert_eq!(tree.face_neighbor(right, Face::F), None);
    }
}
