//! The pointerless octree: a sorted array instead of a tree of nodes.
//!
//! The boxes are put in order along a space-filling curve, which visits an octant of space before it goes on to the
//! next, at every scale. Eight boxes that follow each other make a *block*; the bounds of eight blocks make a block one
//! level up, and so on. Where a block's parent and children are follows from its place: there are no pointers, and one
//! box is compared with the eight of a block by a few vector instructions. (The report mentions pointerless octrees,
//! Swan 1994, section 2, after Samet 1990.)
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{Method, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&Method::Linear);
//! for x in 0..1000 {
//!     index.insert(Aabb3d::new(Vec3::X * x as f32, Vec3::splat(0.5)))?;
//! }
//! index.update();
//! assert_eq!(index.find_pairs().len(), 999); // each touches the next
//! # Ok::<(), bevy_octree::broad_phase::BoxError>(())
//! ```
//!
//! # What makes it fast
//!
//! - **Skins.** What is indexed is not the box but its *skin*: the box swept along its recent motion for some ticks
//!   ahead. While an object stays in its skin, the index stays as it is, and so does the list of *near pairs*, those
//!   whose skins overlap; a tick then compares the boxes of near pairs, and nothing else. How far ahead is chosen from
//!   the speeds: fast objects get no skin, and near pairs are then the pairs themselves.
//! - **All at once.** When more than a share of the objects have left their skins, all are sorted anew, and the tree is
//!   joined with itself, from the top down: two blocks are compared only if their bounds overlap. A few that leave
//!   their skins are moved in their place, and searched for one by one.
//! - **Few movers among many.** If only a small part of all objects moved, each of these is searched for, and near pairs
//!   are not kept: what rests costs nothing.
//! - **The order in memory is the order in space.** Neighbours are compared from cache.
//! - **Sizes apart.** Objects four times smaller than others are sorted apart from them, so that a large box does not
//!   blow up the bounds of a block of small ones.

mod join;
mod levels;
mod order;
mod skin;
mod validate;

#[cfg(test)]
mod tests;

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{Level, Simd, dispatch};

use super::{BroadPhase, BroadPhaseStats, EVERYWHERE, Pair, Proxies, ProxyId, Visitor, overlap};
use join::Task;
use levels::Levels;
pub(super) use levels::{Block, WIDTH};
use skin::Skins;

/// No slot.
const NONE: u32 = u32::MAX;

/// A box that overlaps nothing.
const EMPTY: Aabb3d = Aabb3d { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

/// All objects are sorted anew when more than one in so many has left its skin since the last time.
const REFRESH_SHARE: usize = 6;

/// Near pairs are left aside when fewer than one object in so many moved.
const SPARSE_SHARE: usize = 16;

/// The pointerless octree. See the [module's documentation](self).
#[derive(Debug)]
pub struct LinearOctree {
    /// The vector instructions that this machine has.
    level: Level,
    skins: Skins,
    /// By proxy: its slot.
    slot_of: Vec<u32>,
    /// By slot, which is a place in the order of the curve: its proxy. An object that went leaves its slot empty until
    /// all are sorted anew; one that came has a slot at the end until then.
    owners: Vec<u32>,
    /// The tree of skins, by slot.
    tree: Levels,
    /// Slots of objects whose skins overlap; as of before the skins in `fresh` changed.
    near: Vec<[u32; 2]>,
    /// Is `near` kept up to date?
    near_is_kept: bool,
    /// Is every skin the box itself, as of this tick?
    tight: bool,
    /// Slots whose skin changed since `near` was made, each once, and by slot whether it is one of these.
    fresh: Vec<u32>,
    is_fresh: Vec<bool>,
    /// By slot: boxes of this tick, gathered for the comparison of near pairs.
    boxes: Vec<Aabb3d>,
    boxes_are_gathered: bool,
    /// Proxies that left their skin in this tick, or have none.
    escaped: Vec<u32>,
    /// How many objects came, went or left their skin since all were sorted.
    changes: usize,
    stack: Vec<Task>,
    items: Vec<u64>,
    scratch: Vec<u64>,
}

impl Default for LinearOctree {
    fn default() -> Self {
        Self {
            level: Level::new(),
            skins: Skins::default(),
            slot_of: Vec::new(),
            owners: Vec::new(),
            tree: Levels::default(),
            near: Vec::new(),
            near_is_kept: false,
            tight: false,
            fresh: Vec::new(),
            is_fresh: Vec::new(),
            boxes: Vec::new(),
            boxes_are_gathered: false,
            escaped: Vec::new(),
            changes: 0,
            stack: Vec::new(),
            items: Vec::new(),
            scratch: Vec::new(),
        }
    }
}

impl LinearOctree {
    /// Lets go of objects that are gone, and lists those that left their skins.
    fn follow(&mut self, proxies: &Proxies) {
        self.slot_of.resize(proxies.capacity(), NONE);
        self.skins.begin_tick(proxies.capacity());
        self.tight = false;
        self.escaped.resize(proxies.moved().len(), 0);
        let mut escaped = 0;
        for &id in proxies.moved() {
            if !proxies.contains(id) {
                self.let_go(id);
                continue;
            }
            // Without a branch: it would be mispredicted often.
            self.escaped[escaped] = id.get();
            escaped += usize::from(!self.skins.holds(id, &proxies.boxes()[id.index()]));
        }
        self.escaped.truncate(escaped);
        self.changes += escaped;
    }

    fn let_go(&mut self, id: ProxyId) {
        self.skins.remove(id);
        let slot = std::mem::replace(&mut self.slot_of[id.index()], NONE);
        if slot != NONE {
            self.owners[slot as usize] = NONE;
            self.tree.set(slot as usize, &EMPTY);
            self.renew_slot(slot);
            self.changes += 1;
        }
    }

    /// Sorts all objects anew, and gives all of them new skins.
    pub(super) fn refresh(&mut self, proxies: &Proxies) {
        self.changes = 0;
        self.slot_of.resize(proxies.capacity(), NONE);
        self.tight = self.skins.renew_all(proxies, &self.escaped);
        let objects = proxies.iter().map(|(id, _)| id.get());
        order::order(self.level, proxies.boxes(), objects, &mut self.items, &mut self.scratch);
        self.owners.clear();
        self.owners.extend(self.items.iter().map(|item| *item as u32));
        for (slot, id) in (0..).zip(&self.owners) {
            self.slot_of[*id as usize] = slot;
        }
        self.tree.rebuild(self.owners.iter().map(|id| self.skins.get(ProxyId::new(*id))));
        self.forget_near();
        self.is_fresh.clear();
        self.is_fresh.resize(self.owners.len(), false);
        self.boxes_are_gathered = false;
    }

    fn forget_near(&mut self) {
        self.near_is_kept = false;
        self.near.clear();
        for slot in self.fresh.drain(..) {
            self.is_fresh[slot as usize] = false;
        }
    }

    /// Gives the objects that left their skins new ones, in their old places, and places to those that have none.
    fn renew_escaped(&mut self, proxies: &Proxies) {
        self.skins.renew(proxies, &self.escaped);
        let mut escaped = std::mem::take(&mut self.escaped);
        let one_by_one = escaped.len() * 32 < self.owners.len();
        for &id in &escaped {
            let skin = *self.skins.get(ProxyId::new(id));
            let slot = &mut self.slot_of[id as usize];
            if *slot == NONE {
                *slot = self.owners.len() as u32;
                self.owners.push(id);
                self.is_fresh.push(false);
                self.boxes_are_gathered = false;
                self.tree.push(self.owners.len() - 1);
            }
            let slot = *slot;
            self.tree.set(slot as usize, &skin);
            if one_by_one {
                self.tree.refit_above(slot as usize);
            }
            self.renew_slot(slot);
        }
        if !one_by_one {
            self.tree.refit();
        }
        escaped.clear();
        self.escaped = escaped;
    }

    /// Notes that the near pairs of a slot are not known any more.
    fn renew_slot(&mut self, slot: u32) {
        if self.near_is_kept && !std::mem::replace(&mut self.is_fresh[slot as usize], true) {
            self.fresh.push(slot);
        }
    }

    /// Brings the near pairs up to date.
    fn find_near(&mut self) {
        if self.fresh.len() * REFRESH_SHARE > self.owners.len() {
            self.forget_near();
        }
        if !self.near_is_kept {
            self.near_is_kept = true;
            self.tree.self_join(self.level, &mut self.stack, &mut self.near);
        } else if !self.fresh.is_empty() {
            let is_fresh = &self.is_fresh;
            self.near.retain(|[a, b]| !(is_fresh[*a as usize] | is_fresh[*b as usize]));
            // In the order of space, one search finds in the cache what the last one has read.
            self.fresh.sort_unstable();
            dispatch!(self.level, simd => self.search_fresh(simd));
            for slot in self.fresh.drain(..) {
                self.is_fresh[slot as usize] = false;
            }
        }
    }

    #[inline(always)]
    fn search_fresh<S: Simd>(&mut self, simd: S) {
        for &slot in &self.fresh {
            let skin = self.tree.get(slot as usize);
            self.tree.query(simd, &skin, &mut self.stack, |other| {
                // Of two fresh ones, the lower finds the pair.
                if other > slot || (other < slot && !self.is_fresh[other as usize]) {
                    self.near.push([slot.min(other), slot.max(other)]);
                }
            });
        }
    }

    /// Brings the boxes by slot up to date.
    fn gather(&mut self, proxies: &Proxies) {
        let boxes = proxies.boxes();
        if self.boxes_are_gathered && proxies.moved().len() * 2 < self.owners.len() {
            for id in proxies.moved() {
                let slot = self.slot_of[id.index()];
                if slot != NONE {
                    self.boxes[slot as usize] = boxes[id.index()];
                }
            }
        } else {
            self.boxes_are_gathered = true;
            self.boxes.clear();
            self.boxes.extend(self.owners.iter().map(|id| boxes.get(*id as usize).unwrap_or(&EMPTY)));
        }
    }

    /// The pairs among the near ones.
    fn compare_near(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        self.find_near();
        if !self.tight {
            self.gather(proxies);
        }
        let start = pairs.len();
        pairs.resize(start + self.near.len(), Pair { a: ProxyId::new(0), b: ProxyId::new(0) });
        let mut end = start;
        // Without a branch on the verdict: it would be mispredicted often.
        for [a, b] in &self.near {
            pairs[end] = Pair { a: ProxyId::new(*a), b: ProxyId::new(*b) };
            let hit = self.tight || overlap(&self.boxes[*a as usize], &self.boxes[*b as usize]);
            end += usize::from(hit);
        }
        // So far, these are slots.
        let hits = start..end;
        end = start;
        let all_moved = proxies.all_moved();
        for place in hits {
            let [a, b] = [pairs[place].a, pairs[place].b].map(|slot| ProxyId::new(self.owners[slot.index()]));
            pairs[end] = Pair { a: a.min(b), b: a.max(b) };
            end += usize::from(all_moved || proxies.is_moved(a) || proxies.is_moved(b));
        }
        pairs.truncate(end);
        self.near.len() as u64
    }

    /// The pairs of each object that moved, searched for one by one.
    #[inline(always)]
    fn search_moved<S: Simd>(&mut self, simd: S, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let mut compared = 0;
        for &id in proxies.moved() {
            let Some(aabb) = proxies.get(id) else { continue };
            self.tree.query(simd, aabb, &mut self.stack, |slot| {
                let other = ProxyId::new(self.owners[slot as usize]);
                compared += 1;
                // Of two that moved, the lower finds the pair.
                if (other > id || (other < id && !proxies.is_moved(other)))
                    && overlap(aabb, &proxies.boxes()[other.index()])
                {
                    pairs.push(Pair { a: id.min(other), b: id.max(other) });
                }
            });
        }
        compared
    }
}

impl BroadPhase for LinearOctree {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.follow(proxies);
        if self.changes * REFRESH_SHARE > proxies.len() {
            self.refresh(proxies);
        } else if !self.escaped.is_empty() {
            self.renew_escaped(proxies);
        }
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let moved = proxies.moved().len();
        if moved == 0 {
            0
        } else if moved * SPARSE_SHARE < proxies.len() {
            self.boxes_are_gathered = false;
            dispatch!(self.level, simd => self.search_moved(simd, proxies, pairs))
        } else {
            self.compare_near(proxies, pairs)
        }
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.tree.traverse(visitor, |slot, visitor| {
            let id = ProxyId::new(self.owners[slot]);
            visitor.object(id, &proxies.boxes()[id.index()], &EVERYWHERE);
        });
    }

    fn stats(&self) -> BroadPhaseStats {
        let by_proxy = self.slot_of.capacity() * size_of::<u32>() + self.skins.memory_bytes();
        let by_slot = self.owners.capacity() * size_of::<u32>()
            + self.is_fresh.capacity()
            + self.boxes.capacity() * size_of::<Aabb3d>()
            + self.tree.memory_bytes();
        let lists = (self.fresh.capacity() + self.escaped.capacity()) * size_of::<u32>()
            + (self.near.capacity() + self.items.capacity() + self.scratch.capacity()) * size_of::<u64>()
            + self.stack.capacity() * size_of::<Task>();
        BroadPhaseStats {
            nodes: self.tree.blocks(),
            leaves: self.tree.leaves(),
            depth: self.tree.height() - 1,
            entries: self.owners.iter().filter(|owner| **owner != NONE).count(),
            bytes: by_proxy + by_slot + lists,
        }
    }
}
