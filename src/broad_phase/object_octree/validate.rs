//! Checks of everything that is said to hold.

use bevy::math::bounding::Aabb3d;

use super::octree::ObjectOctree;
use crate::{
    broad_phase::{boxes::ProxyId, proxy::Proxies},
    octree::NodeId,
};

impl ObjectOctree {
    /// Checks the tree against the objects: that each object is listed in exactly the leaves that
    /// it overlaps, that no leaf lists more than N objects above the depth limit, that no eight
    /// leaves should have merged, that the tree equals the one built from scratch (without [merge
    /// slack](super::ObjectOctreeSettings::merge_slack)), and that everything that is stored twice
    /// agrees. For tests: takes O(nodes × objects).
    ///
    /// # Panics
    /// If anything is not as it should be, or if `proxies` changed since the last update.
    pub fn assert_well_formed(&self, proxies: &Proxies) {
        self.tree.assert_well_formed();
        assert_eq!(
            self.root.is_some(),
            !proxies.is_empty(),
            "there is a root cell if, and only if, there are objects"
        );
        assert!(self.shrunk.is_empty() && self.overfull.is_empty() && self.unsettled.is_empty());
        for (id, aabb) in proxies.iter() {
            let entry = &self.entries[id.index()];
            assert_eq!(
                Some(self.levels[id.index()]),
                self.root.map(|root| root.levels(aabb, &self.settings))
            );
            assert!(!entry.unsettled && !entry.leaves.is_empty());
            // What is not within the root is looked at again and again while that may grow.
            let sticks_out = self.root.map(|root| root.bounds()).is_some_and(|root| {
                aabb.min.cmplt(root.min).any() || aabb.max.cmpge(root.max).any()
            });
            assert!(
                self.stays[id.index()].holds(aabb) || sticks_out,
                "{id:?}: the stay region holds the box that it was made for"
            );
        }
        for node in self.tree.subtree(NodeId::ROOT) {
            let cell = self.tree.data(node);
            assert!(!cell.queued, "{node:?} waits for a split or merge");
            assert_eq!(cell.generation(), self.tree.generation(node));
            let counts = |id: ProxyId, aabb: &Aabb3d| {
                u32::from(self.levels[id.index()]) > cell.generation() && cell.overlaps(aabb)
            };
            let counted = proxies
                .iter()
                .filter(|(id, aabb)| counts(*id, aabb))
                .count();
            assert_eq!(
                cell.counted() as usize,
                counted,
                "{node:?} knows how many objects overlap it"
            );
            if self.tree.is_split(node) {
                assert!(
                    cell.listed().is_empty(),
                    "{node:?} is split and lists objects"
                );
                continue;
            }
            let overlapping: Vec<u32> = proxies
                .iter()
                .filter(|(_, aabb)| cell.overlaps(aabb))
                .map(|(id, _)| id.get())
                .collect();
            assert_eq!(
                self.sorted_list(node),
                overlapping,
                "{node:?} lists the objects that overlap it"
            );
            assert!(
                counted <= self.settings.max_objects as usize
                    || cell.generation() == self.settings.max_depth,
                "{node:?} lists {counted} objects that fit in it"
            );
            for object in overlapping {
                assert!(
                    self.entries[object as usize].leaves.contains(&node),
                    "{object} does not know of {node:?}"
                );
            }
        }
        let listed: usize = self
            .tree
            .leaves(NodeId::ROOT)
            .map(|leaf| self.tree.data(leaf).listed().len())
            .sum();
        let known: usize = self.entries.iter().map(|entry| entry.leaves.len()).sum();
        assert_eq!(
            listed, known,
            "objects know the leaves that list them, and no others"
        );
        if let Some(blocks) = &self.blocks {
            blocks.assert_well_formed(proxies);
        }
        if self.settings.merge_slack == 0 {
            self.assert_same_shape(&self.rebuilt(proxies));
        }
    }

    /// Checks that two trees over the same objects are equal, node for node.
    ///
    /// # Panics
    /// If they are not.
    pub fn assert_same_shape(&self, other: &Self) {
        assert_eq!(
            self.tree.node_count(),
            other.tree.node_count(),
            "the trees have as many nodes"
        );
        let nodes = self
            .tree
            .subtree(NodeId::ROOT)
            .zip(other.tree.subtree(NodeId::ROOT));
        for (a, b) in nodes {
            assert_eq!(
                self.tree.is_split(a),
                other.tree.is_split(b),
                "{a:?} and {b:?} are split alike"
            );
            assert_eq!(
                self.tree.data(a).bounds(),
                other.tree.data(b).bounds(),
                "{a:?} and {b:?} have the same cell"
            );
            assert_eq!(
                self.sorted_list(a),
                other.sorted_list(b),
                "{a:?} and {b:?} list the same objects"
            );
        }
    }

    fn sorted_list(&self, node: NodeId) -> Vec<u32> {
        let mut list = self.tree.data(node).listed().to_vec();
        list.sort_unstable();
        list
    }
}
