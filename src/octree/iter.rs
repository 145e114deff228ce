//! Walks over an octree, none of which allocates or recurses.

use std::iter::FusedIterator;

use super::node::NodeId;
use super::tree::Octree;

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
        Self {
            tree,
            top,
            next: Some(top),
        }
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
    /// Returns the nodes of the subtree at `node`, itself first, in depth-first order.
    #[inline]
    #[must_use]
    pub fn subtree(&self, node: NodeId) -> Subtree<'_, T> {
        Subtree::new(self, node)
    }

    /// Returns the leaves of the subtree at `node` in depth-first order; `node` itself if it is a
    /// leaf.
    #[inline]
    #[must_use]
    pub fn leaves(&self, node: NodeId) -> Leaves<'_, T> {
        Leaves::new(self, node)
    }
}
