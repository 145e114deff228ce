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
use crate::{
    broad_phase::proxy::Proxies,
    octree::{NodeId, Vertex},
};

/// How many objects' turns are prepared at once.
const BATCH: usize = 32;

impl ObjectOctree {
    /// Takes up the changes of a tick: brings lists and nodes up to date.
    pub(super) fn keep_up(&mut self, proxies: &Proxies) {
        self.make_room(proxies);
        self.find_restless(proxies);
        if self.fit_root(proxies) {
            for (id, aabb) in proxies.iter() {
                self.arrive(id.get(), aabb);
            }
        } else {
            let restless = std::mem::take(&mut self.restless);
            for batch in restless.chunks(BATCH) {
                self.take_turns(batch, proxies.boxes());
            }
            self.restless = restless;
        }
        self.restructure(proxies.boxes());
    }

    /// Makes room for all objects.
    pub(super) fn make_room(&mut self, proxies: &Proxies) {
        self.entries.resize(proxies.capacity(), Entry::ABSENT);
        self.stays.resize(proxies.capacity(), StayRegion::NOWHERE);
        self.levels.resize(proxies.capacity(), 0);
    }

    /// Lists the objects whose leaves may have changed; takes those that are gone off their lists.
    fn find_restless(&mut self, proxies: &Proxies) {
        self.restless.clear();
        let root = self.root.unwrap_or_default();
        for &id in proxies.moved() {
            match proxies.get(id) {
                Some(aabb) => {
                    // Counts against N stay right only if the size class is the same.
                    let stays = self.stays[id.index()].holds(aabb)
                        & (self.levels[id.index()] == root.levels(aabb, &self.settings));
                    if !stays {
                        self.restless.push(id.get());
                    }
                }
                None => self.depart(id.get()),
            }
        }
    }

    /// Some objects' turns. First it is seen where each of them begins: in a loop that does little
    /// else, so that the processor runs ahead and waits for many entries and cells at once.
    fn take_turns(&mut self, objects: &[u32], boxes: &[Aabb3d]) {
        let of = |object: u32| &self.entries[object as usize].leaves;
        let leaves: SmallVec<[Option<NodeId>; BATCH]> = objects
            .iter()
            .map(|object| of(*object).first().copied())
            .collect();
        let tops: SmallVec<[Option<NodeId>; BATCH]> = objects
            .iter()
            .zip(leaves)
            .map(|(object, leaf)| leaf.map(|leaf| self.holder(leaf, &boxes[*object as usize])))
            .collect();
        for (&object, top) in objects.iter().zip(tops) {
            let aabb = &boxes[object as usize];
            match top {
                Some(top) => self.take_turn(object, top, aabb),
                None => self.arrive(object, aabb),
            }
        }
    }

    /// One object's turn: its box is this now, and its leaves may be others, all of them below a
    /// node.
    fn take_turn(&mut self, object: u32, top: NodeId, aabb: &Aabb3d) {
        let Some(root) = self.root else { return };
        if self.levels[object as usize] != root.levels(aabb, &self.settings) {
            self.depart(object);
            return self.arrive(object, aabb);
        }
        self.leave(top, object, aabb);
        self.enter_below(top, object, aabb);
        self.settle(object, aabb);
    }

    /// The report's first check: takes the object off the lists of the leaves that it has left, and
    /// marks the others as holding it in this turn. So it does with the nodes above them, up to one
    /// that holds all of the box.
    fn leave(&mut self, top: NodeId, object: u32, aabb: &Aabb3d) {
        let turn = self.next_turn();
        let top = self.tree.data(top).generation();
        let mut number = 0;
        while let Some(&leaf) = self.entries[object as usize].leaves.get(number) {
            self.tree.data_mut(leaf).held = turn;
            self.leave_above(leaf, top, object, aabb);
            if self.tree.data(leaf).overlaps(aabb) {
                number += 1;
            } else {
                self.unlist(leaf, object);
                self.entries[object as usize].leaves.swap_remove(number);
            }
        }
    }

    /// The same for the nodes above a leaf that are not marked yet.
    fn leave_above(&mut self, leaf: NodeId, top: u32, object: u32, aabb: &Aabb3d) {
        let (turn, levels) = (self.turn, u32::from(self.levels[object as usize]));
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

    /// The lowest node above a leaf, one of an object's, that holds all of a box: the second check
    /// begins there. (The report goes from neighbour to neighbour instead; see the notes in
    /// `docs/notes` for what that costs.)
    #[inline]
    fn holder(&self, leaf: NodeId, aabb: &Aabb3d) -> NodeId {
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
        debug_assert!(self.entries[object as usize].leaves.is_empty());
        let levels = root.levels(aabb, &self.settings);
        self.levels[object as usize] = levels;
        let counts = levels > 0;
        self.next_turn();
        if counts && self.tree.is_split(NodeId::ROOT) {
            self.tree.data_mut(NodeId::ROOT).count_in();
        }
        self.enter_below(NodeId::ROOT, object, aabb);
        self.settle(object, aabb);
    }

    /// Takes an object off all lists.
    fn depart(&mut self, object: u32) {
        let leaves = std::mem::take(&mut self.entries[object as usize].leaves);
        let turn = self.next_turn();
        let levels = u32::from(self.levels[object as usize]);
        for &leaf in &leaves {
            self.unlist(leaf, object);
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
        self.stays[object as usize] = StayRegion::NOWHERE;
    }

    /// Enters an object in all leaves at or below a node that its box overlaps and that are not
    /// marked as holding it, and counts it in the nodes between. It is counted in `top` itself
    /// already, unless that is a leaf.
    fn enter_below(&mut self, top: NodeId, object: u32, aabb: &Aabb3d) {
        let levels = u32::from(self.levels[object as usize]);
        let mut stack: SmallVec<[NodeId; 32]> = SmallVec::new();
        stack.push(top);
        while let Some(node) = stack.pop() {
            let is_split = self.tree.is_split(node);
            let cell = self.tree.data_mut(node);
            if is_split {
                if node != top && cell.held != self.turn && cell.generation() < levels {
                    cell.count_in();
                }
                let octants = octants(cell.octants(aabb));
                stack.extend(octants.filter_map(|octant| self.tree.child(node, octant)));
            } else if cell.held != self.turn {
                cell.held = self.turn;
                self.list(node, object);
            }
        }
    }

    /// Puts an object on the list of a leaf.
    pub(super) fn list(&mut self, leaf: NodeId, object: u32) {
        let levels = u32::from(self.levels[object as usize]);
        self.entries[object as usize].leaves.push(leaf);
        let cell = self.tree.data_mut(leaf);
        cell.list(object, levels > cell.generation());
        if !cell.queued && must_split(cell, self.settings.max_objects, self.settings.max_depth) {
            cell.queued = true;
            self.overfull.push(leaf);
        }
    }

    /// Takes an object off the list of a leaf, but not the leaf off the list of the object.
    fn unlist(&mut self, leaf: NodeId, object: u32) {
        let levels = u32::from(self.levels[object as usize]);
        let cell = self.tree.data_mut(leaf);
        let was_listed = cell.unlist(object, levels > cell.generation());
        debug_assert!(was_listed, "object {object} is not on the list of {leaf:?}");
    }

    /// Computes the stay region of an object whose leaves changed.
    pub(super) fn settle(&mut self, object: u32, aabb: &Aabb3d) {
        let growing = self
            .root
            .filter(|root| root.doublings < self.settings.max_doublings)
            .map(|root| root.bounds());
        let leaves = &self.entries[object as usize].leaves;
        let cells = leaves.iter().map(|leaf| self.tree.data(*leaf));
        self.stays[object as usize] = StayRegion::new(aabb, cells).within(growing.as_ref());
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

/// The octants of a mask with a bit for each.
#[inline]
pub(super) fn octants(mut mask: u32) -> impl Iterator<Item = Vertex> {
    std::iter::from_fn(move || {
        let octant = (mask != 0).then(|| Vertex::from_bits(mask.trailing_zeros()));
        mask &= mask.wrapping_sub(1);
        octant
    })
}

/// Returns `true` if a leaf lists too many objects, above the depth limit.
#[inline]
pub(super) const fn must_split(cell: &Cell, max_objects: u32, max_depth: u32) -> bool {
    cell.counted() > max_objects && cell.generation() < max_depth
}
