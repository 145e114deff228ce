//! Handles of nodes, and the children of one: what a tree and its walks have in common.

use std::iter::FusedIterator;
use std::num::NonZeroU32;
use std::ops::Range;

use super::direction::Vertex;

/// A handle of a node of an [`Octree`](super::Octree).
///
/// It stays valid until the node is removed ([`join`](super::Octree::join) of an ancestor,
/// [`reset`](super::Octree::reset)). Handles are small and cheap, and know nothing of the tree: a
/// removed node's handle names whichever node is given its slot later.
/// [`contains`](super::Octree::contains) tells whether some node has it now.
///
/// `Option<NodeId>` is no larger than `NodeId`.
// Siblings stand in blocks of eight: the lower three bits are the child type, the others the block.
// Block 0 is the root's, which takes slot 1 of it, so that no handle is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(NonZeroU32);

impl NodeId {
    /// The root of every octree.
    pub const ROOT: Self = Self(NonZeroU32::MIN);

    /// Returns a small number that no other live node has, to find the node's entry in a table of
    /// one's own: always less than [`index_bound`](super::Octree::index_bound).
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        self.0.get() as usize
    }

    #[inline]
    pub(super) const fn block(self) -> usize {
        self.index() >> 3
    }

    #[inline]
    pub(super) const fn octant(self) -> Vertex {
        Vertex::from_bits(self.0.get())
    }

    /// The sibling in `slot`, seen from the first one.
    #[inline]
    pub(super) fn sibling(self, slot: u32) -> Self {
        debug_assert!(self.0.get() & 7 == 0 && slot < 8);
        Self(self.0 | slot)
    }

    #[inline]
    pub(super) fn next_sibling(self) -> Option<Self> {
        let is_last = self.0.get() & 7 == 7;
        if is_last {
            None
        } else {
            self.0.checked_add(1).map(Self)
        }
    }

    /// The first node of `block`, unless it is block 0 or past the last handle.
    #[inline]
    pub(super) fn first_of(block: usize) -> Option<Self> {
        u32::try_from(block)
            .ok()?
            .checked_mul(8)
            .and_then(NonZeroU32::new)
            .map(Self)
    }
}

/// The children of a node in the order of [`Vertex::ALL`]; empty for a leaf.
///
/// It does not borrow the tree, so that the tree can change during the walk. Made by
/// [`children`](super::Octree::children) and [`split`](super::Octree::split).
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
            None => Self {
                first: NodeId::ROOT,
                slots: 0..0,
            },
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
