//! Splits and merges: the tree takes its canonical shape.

use super::{
    maintain::{must_split, octants},
    octree::ObjectOctree,
};
use crate::octree::{NodeId, Vertex};
use bevy::math::bounding::Aabb3d;

impl ObjectOctree {
    /// Merges and splits what maintenance has queued, and settles the objects in question.
    pub(super) fn restructure(&mut self, boxes: &[Aabb3d]) {
        self.merge_shrunk();
        self.split_overfull(boxes);
        self.settle_all(boxes);
    }

    /// Puts a node in the queue if it counts few enough objects to be a leaf.
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
        let mut children = self.tree.children(node);
        children.len() > 0
            && self.tree.data(node).counted() <= limit
            && children.all(|child| self.tree.is_leaf(child))
    }

    /// Makes a node a leaf, which lists all that its children list.
    fn merge(&mut self, node: NodeId) {
        let turn = self.next_turn();
        self.seen.resize(self.entries.len(), 0);
        let mut objects = self.spare.pop().unwrap_or_default();
        for child in self.tree.children(node) {
            let list = self.tree.data_mut(child).take_list();
            for &object in &list {
                if std::mem::replace(&mut self.seen[object as usize], turn) != turn {
                    let entry = &mut self.entries[object as usize];
                    entry
                        .leaves
                        .retain(|leaf| self.tree.parent(*leaf) != Some(node));
                    entry.leaves.push(node);
                    objects.push(object);
                    self.unsettle(object);
                }
            }
            self.recycle(list);
        }
        self.tree.join(node, drop);
        self.tree.data_mut(node).put_list(objects);
    }

    /// Splits leaves that list more than N objects, and their children in turn, down to the depth
    /// limit.
    fn split_overfull(&mut self, boxes: &[Aabb3d]) {
        while let Some(leaf) = self.overfull.pop() {
            if !self.tree.contains(leaf) {
                continue;
            }
            let cell = self.tree.data_mut(leaf);
            cell.queued = false;
            if must_split(cell, self.settings.max_objects, self.settings.max_depth)
                && !self.tree.is_split(leaf)
            {
                self.split(leaf, boxes);
            }
        }
    }

    fn split(&mut self, leaf: NodeId, boxes: &[Aabb3d]) {
        let cell = self.tree.data_mut(leaf);
        let objects = cell.take_list();
        let frame = cell.frame();
        let children = self.tree.split(leaf);
        for (child, octant) in children.zip(Vertex::ALL) {
            let list = self.spare.pop().unwrap_or_default();
            self.tree.data_mut(child).set_child_of(&frame, octant, list);
        }
        for &object in &objects {
            let entry = &mut self.entries[object as usize];
            if let Some(index) = entry.leaves.iter().position(|listed| *listed == leaf) {
                entry.leaves.swap_remove(index);
            }
            let overlapped = self.tree.data(leaf).octants(&boxes[object as usize]);
            for octant in octants(overlapped) {
                if let Some(child) = self.tree.child(leaf, octant) {
                    self.list(child, object);
                }
            }
            self.unsettle(object);
        }
        self.recycle(objects);
    }

    /// Computes the stay regions of the objects whose leaves split or merged.
    fn settle_all(&mut self, boxes: &[Aabb3d]) {
        while let Some(object) = self.unsettled.pop() {
            self.entries[object as usize].unsettled = false;
            if !self.entries[object as usize].leaves.is_empty() {
                self.settle(object, &boxes[object as usize]);
            }
        }
    }

    /// Keeps a list for the next leaf. Those that have grown beyond what leaves need are let go: by
    /// and by, all would.
    pub(super) fn recycle(&mut self, mut list: Vec<u32>) {
        let most = 2 * (self.settings.max_objects as usize + 1);
        if (1..=most).contains(&list.capacity()) {
            list.clear();
            self.spare.push(list);
        }
    }
}
