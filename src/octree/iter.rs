//! Walks over an octree, none of which allocates or recurses.

use std::iter::FusedIterator;
use std::ops::Range;

use super::direction::Vertex;
use super::tree::{NodeId, Octree};

/// The children of a node in the order of [`Vertex::ALL`]; empty for a leaf.
///
/// It does not borrow the tree, so that the tree can change during the walk. Made by
/// [`Octree::children`] and [`Octree::split`].
#[derive(Clone, Debug)]
pub struct Children {
    first: NodeId,
    slots: Range<u32>,
}

impl Children {
    /// The eight siblings that start at `first`, or nothing.
    #[inline]
    pub(super) fn new(first: Option<NodeId>) -> Self {
        match first {
            Some(first) => Self { first, slots: 0..8 },
            None => Self { first: NodeId::ROOT, slots: 0..0 },
        }
    }
}

impl Iterator for Children {
    type Item = NodeId;

    #[inline]
    fn next(&mut self) -> Option<NodeId> {
        self.slots.next().map(|slot| self.first.sibling(slot))
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.slots.size_hint()
    }
}

impl DoubleEndedIterator for Children {
    #[inline]
    fn next_back(&mut self) -> Option<NodeId> {
        self.slots.next_back().map(|slot| self.first.sibling(slot))
    }
}

impl ExactSizeIterator for Children {}
impl FusedIterator for Children {}

/// The nodes of a subtree in depth-first order, a node before its children. Made by
/// [`Octree::subtree`].
#[derive(Clone, Debug)]
pub struct Subtree<'a, T> {
    tree: &'a Octree<T>,
    top: NodeId,
    next: Option<NodeId>,
}

impl<'a, T> Subtree<'a, T> {
    #[inline]
    pub(super) fn new(tree: &'a Octree<T>, top: NodeId) -> Self {
        Self { tree, top, next: Some(top) }
    }
}

impl<T> Iterator for Subtree<'_, T> {
    type Item = NodeId;

    #[inline]
    fn next(&mut self) -> Option<NodeId> {
        let node = self.next?;
        self.next = self.tree.next_in_subtree(node, self.top);
        Some(node)
    }
}

impl<T> FusedIterator for Subtree<'_, T> {}

/// The leaves of a subtree in depth-first order. Made by [`Octree::leaves`].
#[derive(Clone, Debug)]
pub struct Leaves<'a, T>(Subtree<'a, T>);

impl<'a, T> Leaves<'a, T> {
    #[inline]
    pub(super) fn new(tree: &'a Octree<T>, top: NodeId) -> Self {
        Self(Subtree::new(tree, top))
    }
}

impl<T> Iterator for Leaves<'_, T> {
    type Item = NodeId;

    #[inline]
    fn next(&mut self) -> Option<NodeId> {
        let tree = self.0.tree;
        self.0.find(|&node| tree.is_leaf(node))
    }
}

impl<T> FusedIterator for Leaves<'_, T> {}

impl<T> Octree<T> {
    /// The nodes of the subtree at `node`, itself first, in depth-first order.
    #[inline]
    #[must_use]
    pub fn subtree(&self, node: NodeId) -> Subtree<'_, T> {
        Subtree::new(self, node)
    }

    /// The leaves of the subtree at `node` in depth-first order; `node` itself if it is a leaf.
    #[inline]
    #[must_use]
    pub fn leaves(&self, node: NodeId) -> Leaves<'_, T> {
        Leaves::new(self, node)
    }

    /// The node after `node` in a depth-first walk of the subtree at `top`.
    #[inline]
    pub(super) fn next_in_subtree(&self, mut node: NodeId, top: NodeId) -> Option<NodeId> {
        if let Some(child) = self.child(node, Vertex::LDF) {
            return Some(child);
        }
        while node != top {
            if let Some(sibling) = node.next_sibling() {
                return Some(sibling);
            }
            node = self.parent(node)?;
        }
        None
    }
}
