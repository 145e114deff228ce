//! The tree itself: an arena of nodes, and the operations of the data type.

use std::mem;

use super::direction::Vertex;
use super::node::{Children, NodeId};

#[derive(Clone, Debug, Default)]
pub(super) struct Node<T> {
    /// The first of eight children; of a free block's first node, the first node of the next free
    /// block.
    pub(super) first_child: Option<NodeId>,
    data: T,
}

/// A tree in which every node has eight children or none, and a datum of type `T`.
///
/// The tree knows no coordinates: a node is a cube only through its place among its siblings, which
/// is a [`Vertex`]. What cube the root stands for is the client's affair.
///
/// `T`'s default value plays the part of "no client data": new nodes start with it, and it stays
/// behind where a datum is removed.
///
/// # Handles
///
/// Methods that take a [`NodeId`] require it to be live ([`contains`](Self::contains)). With
/// `debug_assertions` a dead one is detected, and panics. Without, what happens is not specified: a
/// wrong answer, a panic, or a tree out of order.
///
/// # Cost
///
/// All methods take constant time unless they say otherwise. A node takes the size of `T` plus four
/// bytes, and a block of eight siblings four bytes more. Blocks of removed nodes are used again:
/// [`split`](Self::split) allocates only when the tree grows beyond its largest size so far, and
/// [`join`](Self::join) never does.
#[derive(Clone, Debug)]
pub struct Octree<T> {
    /// Eight for each block.
    pub(super) nodes: Vec<Node<T>>,
    /// The parent of each block's nodes; none for block 0, the root's, and for free blocks.
    pub(super) parents: Vec<Option<NodeId>>,
    /// The first node of the block that was freed last; the others follow in a list.
    pub(super) free: Option<NodeId>,
    /// The number of blocks in use, without the root's.
    pub(super) splits: usize,
}

impl<T: Default> Default for Octree<T> {
    fn default() -> Self {
        Self::new(T::default())
    }
}

impl<T> Octree<T> {
    /// Returns the root.
    #[inline]
    #[must_use]
    pub const fn root(&self) -> NodeId {
        NodeId::ROOT
    }

    /// Returns `true` if the handle names a node of this tree.
    #[inline]
    #[must_use]
    pub fn contains(&self, node: NodeId) -> bool {
        node == NodeId::ROOT || self.parents.get(node.block()).is_some_and(Option::is_some)
    }

    /// Returns the parent, or [`None`] of the root.
    #[inline]
    #[must_use]
    pub fn parent(&self, node: NodeId) -> Option<NodeId> {
        debug_assert!(self.contains(node), "{node:?} was removed");
        self.parents[node.block()]
    }

    /// Returns the child in `octant`, or [`None`] of a leaf.
    #[inline]
    #[must_use]
    pub fn child(&self, node: NodeId, octant: Vertex) -> Option<NodeId> {
        self.node(node)
            .first_child
            .map(|first| first.sibling(octant.bits()))
    }

    /// Returns the children in the order of [`Vertex::ALL`]; none of a leaf.
    #[inline]
    #[must_use]
    pub fn children(&self, node: NodeId) -> Children {
        Children::new(self.node(node).first_child)
    }

    /// Returns the octant of its parent that the node is, or [`None`] of the root.
    #[inline]
    #[must_use]
    pub fn child_type(&self, node: NodeId) -> Option<Vertex> {
        debug_assert!(self.contains(node), "{node:?} was removed");
        (node != NodeId::ROOT).then(|| node.octant())
    }

    /// Returns `true` if the node has children.
    #[inline]
    #[must_use]
    pub fn is_split(&self, node: NodeId) -> bool {
        self.node(node).first_child.is_some()
    }

    /// Returns `true` if the node has no children.
    #[inline]
    #[must_use]
    pub fn is_leaf(&self, node: NodeId) -> bool {
        !self.is_split(node)
    }

    /// Returns the number of ancestors: 0 for the root, 1 for its children, and so on. Takes time
    /// linear in the result.
    #[must_use]
    pub fn generation(&self, node: NodeId) -> u32 {
        let mut generation = 0;
        let mut ancestor = self.parent(node);
        while let Some(node) = ancestor {
            generation += 1;
            ancestor = self.parents[node.block()];
        }
        generation
    }

    /// Returns the datum of the node.
    #[inline]
    #[must_use]
    pub fn data(&self, node: NodeId) -> &T {
        &self.node(node).data
    }

    /// Returns the datum of the node, to be changed.
    #[inline]
    #[must_use]
    pub fn data_mut(&mut self, node: NodeId) -> &mut T {
        &mut self.node_mut(node).data
    }

    /// Returns the data of two different nodes, to be changed; [`None`] if the nodes are the same.
    #[inline]
    #[must_use]
    pub fn data_pair_mut(&mut self, a: NodeId, b: NodeId) -> Option<(&mut T, &mut T)> {
        debug_assert!(
            self.contains(a) && self.contains(b),
            "{a:?} or {b:?} was removed"
        );
        let [a, b] = self.nodes.get_disjoint_mut([a.index(), b.index()]).ok()?;
        Some((&mut a.data, &mut b.data))
    }

    /// Gives the node the datum `data`, and returns the one it had.
    #[inline]
    pub fn swap_data(&mut self, node: NodeId, data: T) -> T {
        mem::replace(self.data_mut(node), data)
    }

    /// Returns the number of nodes.
    #[inline]
    #[must_use]
    pub const fn node_count(&self) -> usize {
        1 + 8 * self.splits
    }

    /// Returns the number of leaves.
    #[inline]
    #[must_use]
    pub const fn leaf_count(&self) -> usize {
        1 + 7 * self.splits
    }

    /// Returns the bound of [`NodeId::index`] over the nodes that the tree has and has had: the
    /// length that a table indexed by it needs.
    #[inline]
    #[must_use]
    pub const fn index_bound(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the bytes that the tree has allocated, without what its data have.
    #[inline]
    #[must_use]
    pub const fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node<T>>()
            + self.parents.capacity() * size_of::<Option<NodeId>>()
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

    #[inline]
    fn node(&self, node: NodeId) -> &Node<T> {
        debug_assert!(self.contains(node), "{node:?} was removed");
        &self.nodes[node.index()]
    }

    #[inline]
    fn node_mut(&mut self, node: NodeId) -> &mut Node<T> {
        debug_assert!(self.contains(node), "{node:?} was removed");
        &mut self.nodes[node.index()]
    }
}

impl<T: Default> Octree<T> {
    /// Creates a tree of one node, the root, with the given datum.
    #[must_use]
    pub fn new(data: T) -> Self {
        Self::with_capacity(data, 1)
    }

    /// Creates a tree of one node, with room for `nodes` of them before it allocates again.
    #[must_use]
    pub fn with_capacity(data: T, nodes: usize) -> Self {
        let blocks = 1 + nodes.saturating_sub(1).div_ceil(8);
        let mut tree = Self {
            nodes: Vec::with_capacity(blocks.saturating_mul(8)),
            parents: Vec::with_capacity(blocks),
            free: None,
            splits: 0,
        };
        tree.reset(data);
        tree
    }

    /// Removes every node but the root, drops all data, and gives the root the datum `data`. Keeps
    /// the memory.
    ///
    /// Takes time linear in the largest size of the tree since the last reset.
    pub fn reset(&mut self, data: T) {
        self.nodes.clear();
        self.nodes.resize_with(8, Node::default);
        self.parents.clear();
        self.parents.push(None);
        self.free = None;
        self.splits = 0;
        *self.data_mut(NodeId::ROOT) = data;
    }

    /// Gives a leaf eight children that hold default data, and returns them. The node keeps its own
    /// datum.
    ///
    /// Requires a leaf. Without `debug_assertions`, a node that is split already is left as it is.
    ///
    /// # Panics
    ///
    /// Like [`Vec::push`], if there is no more memory, or if the tree would have more than 2³²
    /// nodes.
    #[inline]
    pub fn split(&mut self, node: NodeId) -> Children {
        debug_assert!(self.is_leaf(node), "{node:?} is split already");
        let first = self
            .node(node)
            .first_child
            .unwrap_or_else(|| self.attach_block(node));
        Children::new(Some(first))
    }

    /// As [`split`](Self::split); the child in each octant gets the datum that `data` returns for
    /// it.
    #[inline]
    pub fn split_with(&mut self, node: NodeId, mut data: impl FnMut(Vertex) -> T) -> Children {
        let children = self.split(node);
        for child in children.clone() {
            *self.data_mut(child) = data(child.octant());
        }
        children
    }

    /// Removes all descendants of a node, which becomes a leaf and keeps its own datum.
    ///
    /// Each removed node's datum is handed to `remove`: children in the order of [`Vertex::ALL`], a
    /// node after its children. Takes time linear in their number, and neither allocates nor
    /// recurses.
    ///
    /// Requires that the node is split. Without `debug_assertions`, nothing happens to a leaf.
    #[inline]
    pub fn join(&mut self, node: NodeId, mut remove: impl FnMut(T)) {
        debug_assert!(self.is_split(node), "{node:?} is a leaf");
        let Some(mut at) = self.node(node).first_child else {
            return;
        };
        // The tree is in order whenever `remove` runs, so that it may unwind.
        loop {
            while let Some(child) = self.node(at).first_child {
                at = child;
            }
            remove(mem::take(self.data_mut(at)));
            at = loop {
                if let Some(sibling) = at.next_sibling() {
                    break sibling;
                }
                at = self.detach_block(at);
                if at == node {
                    return;
                }
                remove(mem::take(self.data_mut(at)));
            };
        }
    }

    /// Removes all data from the subtree at `node`: every node of it is left, with the default
    /// datum.
    ///
    /// Each removed datum is handed to `remove` in the order of [`subtree`](Self::subtree). Takes
    /// time linear in the number of nodes. To remove the nodes as well, [`join`](Self::join).
    pub fn clear(&mut self, node: NodeId, mut remove: impl FnMut(T)) {
        let mut next = Some(node);
        while let Some(at) = next {
            remove(mem::take(self.data_mut(at)));
            next = self.next_in_subtree(at, node);
        }
    }

    /// Makes the tree one generation taller: the root, with its datum and its subtree, becomes the
    /// child in `octant` of a new root, whose other children are leaves. Returns that child.
    ///
    /// Only the old root's handle changes: [`NodeId::ROOT`] names the new root, whose datum is the
    /// default.
    ///
    /// # Panics
    ///
    /// As [`split`](Self::split).
    pub fn grow(&mut self, octant: Vertex) -> NodeId {
        let old = mem::take(self.node_mut(NodeId::ROOT));
        let child = self.attach_block(NodeId::ROOT).sibling(octant.bits());
        if let Some(grandchild) = old.first_child {
            self.parents[grandchild.block()] = Some(child);
        }
        *self.node_mut(child) = old;
        child
    }

    /// Takes a block, of leaves with default data, and makes it the children of `node`.
    #[inline]
    fn attach_block(&mut self, node: NodeId) -> NodeId {
        let first = match self.free {
            Some(first) => {
                self.free = self.nodes[first.index()].first_child.take();
                first
            }
            None => self.push_block(),
        };
        self.parents[first.block()] = Some(node);
        self.node_mut(node).first_child = Some(first);
        self.splits += 1;
        first
    }

    /// Makes one more block.
    #[cold]
    fn push_block(&mut self) -> NodeId {
        let first = NodeId::first_of(self.parents.len()).expect("an octree has at most 2^32 nodes");
        self.nodes.resize_with(self.nodes.len() + 8, Node::default);
        self.parents.push(None);
        first
    }

    /// Frees the block of `child`, all eight of which are leaves with default data, and returns the
    /// parent.
    #[inline]
    fn detach_block(&mut self, child: NodeId) -> NodeId {
        let parent = self.parents[child.block()]
            .take()
            .expect("a child has a parent");
        let first = self.nodes[parent.index()]
            .first_child
            .take()
            .expect("a parent has children");
        self.nodes[first.index()].first_child = self.free.replace(first);
        self.splits -= 1;
        parent
    }
}

#[cfg(test)]
mod tests;
