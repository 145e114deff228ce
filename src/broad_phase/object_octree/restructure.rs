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

    /// Puts a node in the queue that may have to merge, since an object left one of its leaves.
    pub(super) fn queue_merge(&mut self, node: NodeId) {
        let cell = self.tree.data_mut(node);
        cell.surplus = cell.surplus.saturating_sub(1);
        if cell.surplus == 0 && !cell.queued {
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
            if let Some((list, counted)) = self.mergeable(node) {
                self.merge(node, list, counted);
                if let Some(parent) = self.tree.parent(node) {
                    self.queue_merge(parent);
                }
            }
        }
        self.shrunk.clear();
    }

    /// The distinct objects of a node's eight leaves, and how many of them count against N; `None`
    /// if they are too many, or the children are not all leaves.
    fn mergeable(&mut self, node: NodeId) -> Option<(List, u32)> {
        let children = self.tree.children(node);
        if children.len() == 0 || children.clone().any(|child| self.tree.is_split(child)) {
            return None;
        }
        let limit = self.settings.max_objects - self.settings.merge_slack;
        // What one of them lists may be too much already.
        let most = children
            .clone()
            .map(|child| self.tree.data(child).counted())
            .max()
            .unwrap_or(0);
        if most > limit {
            self.tree.data_mut(node).surplus = most - limit;
            return None;
        }
        let (generation, bounds) = (
            self.tree.data(node).generation(),
            self.tree.data(node).bounds(),
        );
        let half_size = self.root?.half_size;
        let turn = self.next_turn();
        self.seen.resize(self.entries.len(), 0);
        let mut list = self.spare.pop().unwrap_or_default();
        let mut counted = 0;
        for child in children {
            for (object, aabb) in self.tree.data(child).list().iter() {
                if std::mem::replace(&mut self.seen[object as usize], turn) != turn {
                    list.push(object, &aabb, size_class(half_size, &aabb), &bounds);
                    counted += u32::from(self.entries[object as usize].counts_in(generation));
                }
            }
        }
        if counted > limit {
            self.tree.data_mut(node).surplus = counted - limit;
            self.recycle(list);
            return None;
        }
        Some((list, counted))
    }

    fn merge(&mut self, node: NodeId, list: List, counted: u32) {
        self.has_new_shape = true;
        for (&object, index) in list.objects().iter().zip(0..) {
            let entry = &mut self.entries[object as usize];
            entry
                .leaves
                .retain(|leaf| self.tree.parent(*leaf) != Some(node));
            entry.enter(node, index);
        }
        for child in self.tree.children(node) {
            let list = self.tree.data_mut(child).take_list();
            self.recycle(list);
        }
        self.tree.join(node, drop);
        self.tree.data_mut(node).put_list(list, counted);
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
        // Objects will leave the new leaves without their grandparent being told.
        if let Some(parent) = self.tree.parent(leaf) {
            self.tree.data_mut(parent).surplus = 0;
        }
        let cell = self.tree.data_mut(leaf);
        cell.surplus = 0;
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
