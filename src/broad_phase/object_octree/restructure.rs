//! Splits and merges: the tree takes its canonical shape.

use super::{
    list::{List, size_class},
    maintain::must_split,
    octree::ObjectOctree,
};
use crate::octree::{NodeId, Vertex};

impl ObjectOctree {
    /// Merges and splits what maintenance has queued.
    pub(super) fn restructure(&mut self) {
        self.merge_shrunk();
        self.split_overfull();
    }

    /// Puts a node in the queue if it is to merge.
    #[inline]
    pub(super) fn queue_merge(&mut self, node: NodeId) {
        let cell = self.tree.data_mut(node);
        if cell.counted() <= self.settings.max_objects - self.settings.merge_slack && !cell.queued {
            cell.queued = true;
            self.shrunk.push(node);
        }
    }

    /// Merges leaves that list at most N distinct objects with their siblings, and goes on with the
    /// parents. No node is made here, so that the handle of a node that is gone names no other.
    fn merge_shrunk(&mut self) {
        // The list grows on the way.
        let mut index = 0;
        while let Some(&node) = self.shrunk.get(index) {
            index += 1;
            if !self.tree.contains(node) {
                continue;
            }
            self.tree.data_mut(node).queued = false;
            if self.is_mergeable(node) {
                self.merge(node);
                if let Some(parent) = self.tree.parent(node) {
                    self.queue_merge(parent);
                }
            }
        }
        self.shrunk.clear();
    }

    /// Returns `true` if a node counts few enough objects to be a leaf, and its children are leaves.
    fn is_mergeable(&self, node: NodeId) -> bool {
        let limit = self.settings.max_objects - self.settings.merge_slack;
        self.tree.is_split(node)
            && self.tree.data(node).counted() <= limit
            && self
                .tree
                .children(node)
                .all(|child| self.tree.is_leaf(child))
    }

    /// Makes a node a leaf that lists all that its children list.
    fn merge(&mut self, node: NodeId) {
        self.has_new_shape = true;
        let turn = self.next_turn();
        self.seen.resize(self.entries.len(), 0);
        let half_size = self.root.map_or(0.0, |root| root.half_size);
        let bounds = self.tree.data(node).bounds();
        let mut all = self.spare.pop().unwrap_or_default();
        for child in self.tree.children(node) {
            let list = self.tree.data_mut(child).take_list();
            for (object, aabb) in list.iter() {
                if std::mem::replace(&mut self.seen[object as usize], turn) == turn {
                    continue;
                }
                let entry = &mut self.entries[object as usize];
                entry
                    .leaves
                    .retain(|leaf| self.tree.parent(*leaf) != Some(node));
                entry.enter(node, all.objects().len());
                all.push(object, &aabb, size_class(half_size, &aabb), &bounds);
            }
            self.recycle(list);
        }
        self.tree.join(node, drop);
        self.tree.data_mut(node).put_list(all);
    }

    /// Splits leaves that list more than N objects, and their children in turn, down to the depth
    /// limit.
    fn split_overfull(&mut self) {
        while let Some(leaf) = self.overfull.pop() {
            if !self.tree.contains(leaf) {
                continue;
            }
            let cell = self.tree.data_mut(leaf);
            cell.queued = false;
            if must_split(cell, self.settings.max_objects, self.settings.max_depth)
                && !self.tree.is_split(leaf)
            {
                self.split(leaf);
            }
        }
    }

    fn split(&mut self, leaf: NodeId) {
        self.has_new_shape = true;
        let cell = self.tree.data_mut(leaf);
        let list = cell.take_list();
        let frame = cell.frame();
        let children = self.tree.split(leaf);
        for (child, octant) in children.clone().zip(Vertex::ALL) {
            let list = self.spare.pop().unwrap_or_default();
            self.tree.data_mut(child).set_child_of(&frame, octant, list);
        }
        for (object, aabb) in list.iter() {
            let entry = &mut self.entries[object as usize];
            if let Some(index) = entry.leaves.iter().position(|listed| *listed == leaf) {
                entry.forget(index);
            }
            let octants = self.tree.data(leaf).octants(&aabb);
            for (octant, child) in children.clone().enumerate() {
                if octants >> octant & 1 != 0 {
                    self.list(child, object, &aabb);
                }
            }
        }
        self.recycle(list);
    }

    /// Keeps a list for the next leaf. Those that have grown beyond what leaves need are let go: by
    /// and by, all would.
    pub(super) fn recycle(&mut self, mut list: List) {
        let most = 2 * (self.settings.max_objects as usize + 1);
        if (1..=most).contains(&list.capacity()) {
            list.clear();
            self.spare.push(list);
        }
    }
}
