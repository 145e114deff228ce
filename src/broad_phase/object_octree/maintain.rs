//! Maintenance after a tick (Swan 1994, section 2.4): objects leave leaves, and enter others.
//!
//! All objects that moved take their turn first; nodes split and merge afterwards, when every list
//! is up to date. The outcome is that of restructuring after each object, since the shape is
//! canonical, with no node split only to be merged again in the same tick.

use bevy::math::bounding::Aabb3d;
use fearless_simd::dispatch;
use smallvec::SmallVec;

use super::{
    cell::Cell,
    list::size_class,
    octree::{Entry, ObjectOctree},
};
use crate::{broad_phase::proxy::Proxies, octree::NodeId};

/// Where more than one object in so many moved, all leaves are gone through in the order of space,
/// and otherwise the objects that moved.
pub(super) const FEW: usize = 3;

impl ObjectOctree {
    /// Takes up the changes of a tick: brings lists and nodes up to date.
    pub(super) fn keep_up(&mut self, proxies: &Proxies) {
        self.entries.resize(proxies.capacity(), Entry::ABSENT);
        self.ticks = self.ticks.wrapping_add(1);
        let came_or_went = proxies.population_changed();
        let follows_all = self.root.is_some() && proxies.moved().len() * FEW > proxies.len();
        let mut some_may_have_left = !follows_all || came_or_went;
        if follows_all {
            if came_or_went {
                self.depart_gone(proxies);
            }
            some_may_have_left |= self.follow_all(proxies);
        }
        if self.fit_root(proxies, some_may_have_left) {
            for (id, aabb) in proxies.iter() {
                self.arrive(id.get(), aabb);
            }
        } else if follows_all {
            let restless = std::mem::take(&mut self.restless);
            for &object in &restless {
                self.take_turn(object, &proxies.boxes()[object as usize]);
            }
            self.restless = restless;
            self.restless.clear();
            if came_or_went {
                self.receive_new(proxies);
            }
        } else if self.root.is_some() {
            for &id in proxies.moved() {
                match proxies.get(id) {
                    Some(aabb) => self.follow(id.get(), aabb),
                    None => self.depart(id.get()),
                }
            }
        }
        self.restructure();
    }

    /// Takes objects that are gone off all lists.
    fn depart_gone(&mut self, proxies: &Proxies) {
        for &id in proxies.moved() {
            if !proxies.contains(id) {
                self.depart(id.get());
            }
        }
    }

    /// Enters objects that are in no leaf yet.
    fn receive_new(&mut self, proxies: &Proxies) {
        for &id in proxies.moved() {
            if let Some(aabb) = proxies.get(id)
                && self.entries[id.index()].leaves.is_empty()
            {
                self.arrive(id.get(), aabb);
            }
        }
    }

    /// All leaves take the boxes of this tick. Lists the objects whose leaves may have changed.
    /// Returns `true` if one has left the root.
    fn follow_all(&mut self, proxies: &Proxies) -> bool {
        let Some(root) = self.root else { return false };
        if std::mem::take(&mut self.has_new_shape) {
            self.leaves.clear();
            self.leaves.extend(self.tree.leaves(NodeId::ROOT));
        }
        let bounds = root.bounds();
        let may_grow = root.doublings < self.settings.max_doublings;
        dispatch!(self.level, simd => {
            let mut some_left = false;
            for &leaf in &self.leaves {
                let cell = self.tree.data_mut(leaf);
                let within = (may_grow && cell.is_outermost()).then_some(&bounds);
                let cell_bounds = cell.bounds();
                some_left |= cell.list_mut().follow(
                    simd,
                    proxies.boxes(),
                    &cell_bounds,
                    root.half_size,
                    within,
                    &mut self.restless,
                );
            }
            some_left
        })
    }

    /// The leaves of one object take its box of this tick.
    fn follow(&mut self, object: u32, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        let class = size_class(root.half_size, aabb);
        let entry = &mut self.entries[object as usize];
        if entry.leaves.is_empty() {
            return self.arrive(object, aabb);
        }
        let mut is_restless = false;
        for number in 0..entry.leaves.len() {
            let cell = self.tree.data_mut(entry.leaves[number]);
            let bounds = cell.bounds();
            let index = cell.list().find(object, entry.hint(number));
            debug_assert!(index.is_some(), "its leaves list the object");
            if let Some(index) = index {
                entry.note(number, index);
                is_restless |= cell.list_mut().set(index, aabb, class, &bounds);
            }
        }
        if is_restless {
            self.take_turn(object, aabb);
        }
    }

    /// One object's turn, if it has not had it: its box is this now, and its leaves may be others.
    fn take_turn(&mut self, object: u32, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        let entry = &mut self.entries[object as usize];
        if std::mem::replace(&mut entry.turned, self.ticks) == self.ticks {
            return;
        }
        // Counts against N stay right only if the size class is the same.
        if entry.levels != root.levels(aabb, &self.settings) {
            self.depart(object);
            return self.arrive(object, aabb);
        }
        let top = self.holder(object, aabb);
        self.leave(top, object, aabb);
        self.enter_below(top, object, aabb);
    }

    /// The report's first check: takes the object off the lists of the leaves that it has left, and
    /// marks the others as holding it in this turn. So it does with the nodes above them, up to one
    /// that all of the box is below.
    fn leave(&mut self, top: NodeId, object: u32, aabb: &Aabb3d) {
        let turn = self.next_turn();
        let top = self.tree.data(top).generation();
        let mut number = 0;
        while let Some(&leaf) = self.entries[object as usize].leaves.get(number) {
            let cell = self.tree.data_mut(leaf);
            cell.held = turn;
            self.leave_above(leaf, top, object, aabb);
            if self.tree.data(leaf).overlaps(aabb) {
                number += 1;
            } else {
                self.unlist(leaf, object, number);
                self.entries[object as usize].forget(number);
            }
        }
    }

    /// The same for the nodes above a leaf that are not marked yet.
    fn leave_above(&mut self, leaf: NodeId, top: u32, object: u32, aabb: &Aabb3d) {
        let (turn, levels) = (self.turn, self.entries[object as usize].levels);
        let mut node = leaf;
        while let Some(parent) = self.tree.parent(node) {
            node = parent;
            let cell = self.tree.data_mut(node);
            let is_above_all = cell.generation() <= top && cell.holds(aabb);
            if is_above_all || std::mem::replace(&mut cell.held, turn) == turn {
                break;
            }
            if cell.generation() < levels && !cell.overlaps(aabb) {
                cell.count_out();
                self.queue_merge(node);
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
        entry.levels = root.levels(aabb, &self.settings);
        let entry_levels = entry.levels;
        self.next_turn();
        if entry_levels > 0 && self.tree.is_split(NodeId::ROOT) {
            self.tree.data_mut(NodeId::ROOT).count_in();
        }
        self.enter_below(NodeId::ROOT, object, aabb);
    }

    /// Takes an object off all lists.
    fn depart(&mut self, object: u32) {
        let leaves = std::mem::take(&mut self.entries[object as usize].leaves);
        let turn = self.next_turn();
        let levels = self.entries[object as usize].levels;
        for (number, &leaf) in leaves.iter().enumerate() {
            self.unlist(leaf, object, number);
            let mut above = self.tree.parent(leaf);
            while let Some(node) = above {
                let cell = self.tree.data_mut(node);
                if std::mem::replace(&mut cell.held, turn) == turn {
                    break;
                }
                if cell.generation() < levels {
                    cell.count_out();
                    self.queue_merge(node);
                }
                above = self.tree.parent(node);
            }
        }
    }

    /// Enters an object in all leaves at or below a node that its box overlaps and that are not
    /// marked as holding it, and counts it in the nodes between. It is counted in `top` itself,
    /// unless that is a leaf.
    fn enter_below(&mut self, top: NodeId, object: u32, aabb: &Aabb3d) {
        let levels = self.entries[object as usize].levels;
        let mut stack: SmallVec<[NodeId; 32]> = SmallVec::new();
        stack.push(top);
        while let Some(node) = stack.pop() {
            let children = self.tree.children(node);
            let cell = self.tree.data_mut(node);
            if children.len() > 0 {
                if node != top && cell.held != self.turn && cell.generation() < levels {
                    cell.count_in();
                }
                let octants = cell.octants(aabb);
                stack.extend(
                    children
                        .enumerate()
                        .filter(|(o, _)| octants >> o & 1 != 0)
                        .map(|(_, child)| child),
                );
            } else if cell.held != self.turn {
                cell.held = self.turn;
                self.list(node, object, aabb);
            }
        }
    }

    /// Puts an object on the list of a leaf.
    pub(super) fn list(&mut self, leaf: NodeId, object: u32, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        let entry = &mut self.entries[object as usize];
        let cell = self.tree.data_mut(leaf);
        let class = size_class(root.half_size, aabb);
        let index = cell.enlist(object, aabb, class, entry.counts_in(cell.generation()));
        entry.enter(leaf, index);
        if !cell.queued && must_split(cell, self.settings.max_objects, self.settings.max_depth) {
            cell.queued = true;
            self.overfull.push(leaf);
        }
    }

    /// Takes an object off the list of its leaf of this number, but not the leaf off the list of the
    /// object.
    fn unlist(&mut self, leaf: NodeId, object: u32, number: usize) {
        let entry = &self.entries[object as usize];
        let cell = self.tree.data_mut(leaf);
        let counts = entry.counts_in(cell.generation());
        let was_listed = cell.unlist(object, entry.hint(number), counts);
        debug_assert!(was_listed, "object {object} is not on the list of {leaf:?}");
    }
}

/// Returns `true` if a leaf lists too many objects, above the depth limit.
#[inline]
pub(super) const fn must_split(cell: &Cell, max_objects: u32, max_depth: u32) -> bool {
    cell.counted() > max_objects && cell.generation() < max_depth
}
