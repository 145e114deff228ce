//! The check that an octree's links are consistent.

use super::node::NodeId;
use super::tree::Octree;

impl<T> Octree<T> {
    /// Checks every link of the tree, in time linear in its largest size so far. For tests.
    ///
    /// # Panics
    ///
    /// Panics if a child does not lead back to its parent, a block is reached twice or not at all,
    /// a free block has links other than that of the free list, or a counter is wrong.
    pub fn assert_well_formed(&self) {
        assert_eq!(
            self.nodes.len(),
            8 * self.parents.len(),
            "eight nodes for each block"
        );
        assert_eq!(self.parents[0], None, "the root has no parent");
        for (i, node) in self.nodes[..8].iter().enumerate() {
            let is_root = i == NodeId::ROOT.index();
            assert!(
                is_root || node.first_child.is_none(),
                "unused slot {i} has children"
            );
        }

        let mut reached = vec![false; self.parents.len()];
        reached[0] = true;
        let mut reach = |first: NodeId| {
            assert_eq!(
                first.index() % 8,
                0,
                "{first:?} is not the first node of a block"
            );
            let block = first.index() / 8;
            assert!(!reached[block], "block {block} is reached twice");
            reached[block] = true;
            block
        };

        let mut splits = 0;
        // Every parent link is compared with the child link that led to it, so that the walk cannot
        // run in circles.
        for node in self.subtree(NodeId::ROOT) {
            if let Some(first) = self.nodes[node.index()].first_child {
                let block = reach(first);
                assert_eq!(self.parents[block], Some(node), "the parent of {first:?}");
                splits += 1;
            }
        }
        assert_eq!(self.splits, splits, "the number of split nodes");

        let mut free = self.free;
        while let Some(first) = free {
            let block = reach(first);
            assert_eq!(self.parents[block], None, "free block {block} has a parent");
            let [link, rest @ ..] = &self.nodes[8 * block..8 * block + 8] else {
                unreachable!("a block has eight nodes");
            };
            assert!(
                rest.iter().all(|node| node.first_child.is_none()),
                "free block {block} has children"
            );
            free = link.first_child;
        }
        assert!(reached.iter().all(|&reached| reached), "a block is lost");
    }
}
