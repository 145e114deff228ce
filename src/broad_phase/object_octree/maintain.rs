//! Maintenance after a tick (Swan 1994, section 2.4): objects leave leaves, and enter others.
//!
//! All objects that moved take their turn first; nodes split and merge afterwards, when every list
//! is up to date. The outcome is that of restructuring after each object, since the shape is
//! canonical, with no node split only to be merged again in the same tick.

use bevy::math::bounding::Aabb3d;
use smallvec::SmallVec;

use super::{
    cell::Cell,
    octree::{Entry, ObjectOctree},
    stay::StayRegion,
};
use crate::{broad_phase::proxy::Proxies, octree::NodeId};

impl ObjectOctree {
    /// Takes up the changes of a tick: brings lists and nodes up to date.
    pub(super) fn keep_up(&mut self, proxies: &Proxies) {
        self.entries.resize(proxies.capacity(), Entry::ABSENT);
        if self.fit_root(proxies) {
            for (id, aabb) in proxies.iter() {
                self.arrive(id.get(), aabb);
            }
        } else if self.root.is_some() {
            for &id in proxies.moved() {
                match proxies.get(id) {
                    Some(aabb) => self.take_turn(id.get(), aabb),
                    None => self.depart(id.get()),
                }
            }
        }
        self.restructure();
    }

    /// One object's turn: its box is this now.
    fn take_turn(&mut self, object: u32, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        let levels = root.levels(aabb, &self.settings);
        let entry = &mut self.entries[object as usize];
        if entry.leaves.is_empty() {
            return self.arrive(object, aabb);
        }
        if entry.levels == levels && entry.stay.holds(aabb) {
            entry.aabb = *aabb;
            return;
        }
        // Counts against N stay right only if the size class is the same.
        if entry.levels != levels {
            self.depart(object);
            return self.arrive(object, aabb);
        }
        entry.aabb = *aabb;
        let top = self.holder(object, aabb);
        self.leave(object, aabb);
        self.enter_below(top, object, aabb);
        self.unsettle(object);
    }

    /// The report's first check: takes the object off the lists of the leaves that it has left, and
    /// marks the others as holding it in this turn.
    fn leave(&mut self, object: u32, aabb: &Aabb3d) {
        let turn = self.next_turn();
        let mut index = 0;
        while let Some(&leaf) = self.entries[object as usize].leaves.get(index) {
            let cell = self.tree.data_mut(leaf);
            if cell.overlaps(aabb) {
                cell.held = turn;
                index += 1;
            } else {
                self.unlist(leaf, object);
                self.entries[object as usize].leaves.swap_remove(index);
            }
        }
    }

    /// The lowest node above one of an object's leaves that holds all of a box: the second check
    /// begins there. (The report goes from neighbour to neighbour instead; see the notes in
    /// `docs/notes` for what that costs.)
    fn holder(&self, object: u32, aabb: &Aabb3d) -> NodeId {
        let Some(&leaf) = self.entries[object as usize].leaves.first() else {
            return NodeId::ROOT;
        };
        let mut node = leaf;
        while !self.tree.data(node).holds(aabb) {
            let Some(parent) = self.tree.parent(node) else {
                break;
            };
            node = parent;
        }
        node
    }

    /// Enters an object that is in no leaf.
    pub(super) fn arrive(&mut self, object: u32, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        let entry = &mut self.entries[object as usize];
        debug_assert!(entry.leaves.is_empty());
        entry.aabb = *aabb;
        entry.levels = root.levels(aabb, &self.settings);
        self.next_turn();
        self.enter_below(NodeId::ROOT, object, aabb);
        self.unsettle(object);
    }

    /// Takes an object off all lists.
    fn depart(&mut self, object: u32) {
        let leaves = std::mem::take(&mut self.entries[object as usize].leaves);
        for &leaf in &leaves {
            self.unlist(leaf, object);
        }
        self.entries[object as usize].stay = StayRegion::NOWHERE;
    }

    /// Enters an object in all leaves at or below a node that its box overlaps and that are not
    /// marked as holding it.
    fn enter_below(&mut self, top: NodeId, object: u32, aabb: &Aabb3d) {
        let mut stack: SmallVec<[NodeId; 32]> = SmallVec::new();
        stack.push(top);
        while let Some(node) = stack.pop() {
            let children = self.tree.children(node);
            let cell = self.tree.data_mut(node);
            if children.len() > 0 {
                let octants = cell.octants(aabb);
                stack.extend(
                    children
                        .enumerate()
                        .filter(|(o, _)| octants >> o & 1 != 0)
                        .map(|(_, child)| child),
                );
            } else if cell.held != self.turn {
                cell.held = self.turn;
                self.list(node, object);
            }
        }
    }

    /// Puts an object on the list of a leaf.
    pub(super) fn list(&mut self, leaf: NodeId, object: u32) {
        let entry = &mut self.entries[object as usize];
        entry.leaves.push(leaf);
        let cell = self.tree.data_mut(leaf);
        cell.list(object, entry.counts_in(cell.generation()));
        if !cell.queued && must_split(cell, self.settings.max_objects, self.settings.max_depth) {
            cell.queued = true;
            self.overfull.push(leaf);
        }
    }

    /// Takes an object off the list of a leaf, but not the leaf off the list of the object.
    fn unlist(&mut self, leaf: NodeId, object: u32) {
        let entry = &self.entries[object as usize];
        let cell = self.tree.data_mut(leaf);
        let was_listed = cell.unlist(object, entry.counts_in(cell.generation()));
        debug_assert!(was_listed, "object {object} is not on the list of {leaf:?}");
        if let Some(parent) = self.tree.parent(leaf) {
            self.queue_merge(parent);
        }
    }

    /// Has the object's stay region computed anew when the tree has its new shape.
    pub(super) fn unsettle(&mut self, object: u32) {
        let entry = &mut self.entries[object as usize];
        if !entry.unsettled {
            entry.unsettled = true;
            self.unsettled.push(object);
        }
    }
}

/// Returns `true` if a leaf lists too many objects, above the depth limit.
#[inline]
pub(super) const fn must_split(cell: &Cell, max_objects: u32, max_depth: u32) -> bool {
    cell.counted() > max_objects && cell.generation() < max_depth
}
