//! The pointerless octree as a whole, and its upkeep from tick to tick.

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;

use super::{
    levels::{JOB, Levels},
    list::{List, Packed, unpack},
    near::NearPairs,
    order::Order,
    skin::{Anchor, REFRESH_SHARE},
};
use crate::{
    broad_phase::{
        boxes::{EVERYWHERE, ProxyId, overlap},
        engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
        pairs::Pair,
        proxy::Proxies,
    },
    parallel,
};

/// No slot.
pub(super) const NONE: u32 = u32::MAX;

/// The pointerless octree. See the [module's documentation](super).
#[derive(Debug)]
pub struct LinearOctree {
    /// The vector instructions that this machine has.
    pub(super) level: Level,
    /// Counts the updates; 0 is none.
    pub(super) tick: u32,
    /// By proxy: its slot.
    pub(super) slot_of: Vec<u32>,
    /// By slot, which is a place in the order of the curve: its proxy. An object that went leaves its slot empty until
    /// all are sorted anew; one that came has a slot at the end until then.
    pub(super) owners: Vec<u32>,
    /// How many slots have an owner.
    pub(super) owned: usize,
    /// How many slots there were when all were sorted: those that follow are in no order.
    pub(super) sorted: usize,
    /// By slot: where the object was when its skin was made.
    pub(super) anchors: Vec<Anchor>,
    /// By slot: the box of this tick.
    pub(super) boxes: Vec<Aabb3d>,
    /// Are `boxes` of this tick?
    pub(super) boxes_are_gathered: bool,
    /// The tree of skins, by slot.
    pub(super) tree: Levels,
    /// Did the last new skins hold for that tick alone, each the box itself?
    pub(super) tight: bool,
    /// Is every skin the box itself, as of this tick?
    pub(super) exact: bool,
    pub(super) near: NearPairs,
    pub(super) order: Order,
    /// Slots of objects that left their skin in this tick, or have none.
    pub(super) escaped: Vec<u32>,
    pub(super) escaped_by_job: Vec<List>,
    pub(super) pairs_by_job: Vec<Vec<Pair>>,
    /// How many objects came, went or left their skin since all skins were made.
    pub(super) changes: usize,
}

impl Default for LinearOctree {
    fn default() -> Self {
        Self {
            level: Level::new(),
            tick: 0,
            slot_of: Vec::new(),
            owners: Vec::new(),
            owned: 0,
            sorted: 0,
            anchors: Vec::new(),
            boxes: Vec::new(),
            boxes_are_gathered: false,
            tree: Levels::default(),
            tight: false,
            exact: false,
            near: NearPairs::default(),
            order: Order::default(),
            escaped: Vec::new(),
            escaped_by_job: Vec::new(),
            pairs_by_job: Vec::new(),
            changes: 0,
        }
    }
}

impl LinearOctree {
    /// Gives all objects new skins, in a new order if the old one has become a bad one.
    pub(super) fn refresh(&mut self, proxies: &Proxies) {
        let horizon = self.horizon(proxies);
        let has_skins = horizon > 0.0;
        if self.order.is_stale(self.owners.len(), has_skins) {
            self.sort(proxies, has_skins);
        }
        self.exact = self.make_all_skins(proxies, horizon);
        self.tree.refit();
        if self.tree.looseness() > TOO_LOOSE {
            self.sort(proxies, has_skins);
            self.exact = self.make_all_skins(proxies, horizon);
            self.tree.refit();
        }
        self.order.note_looseness(self.tree.looseness());
        self.changes = 0;
        self.tight = !has_skins;
        self.near.start_over(self.owners.len());
        if !proxies.most_moved() {
            self.near.watch_moved(proxies, &self.slot_of);
        }
    }

    /// Puts all objects in order.
    fn sort(&mut self, proxies: &Proxies, for_skins: bool) {
        self.slot_of.resize(proxies.capacity(), NONE);
        let mut old_anchors = std::mem::take(&mut self.order.spare_anchors);
        std::mem::swap(&mut self.anchors, &mut old_anchors);
        self.anchors.clear();
        self.owners.clear();
        for (slot, item) in (0..).zip(self.order.sort(self.level, proxies, for_skins)) {
            let [_, id] = unpack(*item);
            let old = std::mem::replace(&mut self.slot_of[id as usize], slot);
            self.anchors.push(old_anchors.get(old as usize).copied().unwrap_or_default());
            self.owners.push(id);
        }
        self.order.spare_anchors = old_anchors;
        self.owned = self.owners.len();
        self.sorted = self.owners.len();
        self.tree.resize(self.owners.len());
        self.boxes_are_gathered = false;
    }

    /// Gives the objects that left their skins new ones, in their old places.
    fn renew_escaped(&mut self, proxies: &Proxies) {
        let horizon = self.horizon_of_escaped(proxies);
        self.set_fast_apart(proxies);
        let one_by_one = self.escaped.len() * 32 < self.owners.len();
        for &slot in &self.escaped {
            let place = slot as usize;
            let aabb = &proxies.boxes()[self.owners[place] as usize];
            let skin = self.anchors[place].renew(self.tick, aabb, horizon);
            self.tree.set(place, &skin.unwrap_or(*aabb));
            if one_by_one {
                self.tree.refit_above(place);
            }
            self.near.renew(slot);
        }
        if !one_by_one {
            self.tree.refit();
        }
    }

    /// Appends those of some near pairs whose boxes overlap and of which at least one moved.
    ///
    /// Without a branch on either verdict: these would be mispredicted often.
    fn compare(&self, near: &[Packed], proxies: &Proxies, pairs: &mut Vec<Pair>) {
        let mut hits = [0; BATCH];
        let hits = if self.exact {
            near
        } else {
            let mut count = 0;
            for pair in near {
                let [a, b] = unpack(*pair).map(|slot| &self.boxes[slot as usize]);
                hits[count] = *pair;
                count += usize::from(overlap(a, b));
            }
            &hits[..count]
        };
        let pair = |hit: &Packed| {
            let [a, b] = unpack(*hit).map(|slot| ProxyId::new(self.owners[slot as usize]));
            Pair { a: a.min(b), b: a.max(b) }
        };
        if proxies.all_moved() {
            pairs.extend(hits.iter().map(pair));
        } else {
            let mut moving = [Pair { a: ProxyId::new(0), b: ProxyId::new(0) }; BATCH];
            let mut count = 0;
            for pair in hits.iter().map(pair) {
                moving[count] = pair;
                count += usize::from(proxies.is_moved(pair.a) | proxies.is_moved(pair.b));
            }
            pairs.extend_from_slice(&moving[..count]);
        }
    }
}

/// A tree that has become looser than this is not searched as a whole.
pub(super) const TOO_LOOSE: f64 = 3.0;

/// How many near pairs are compared at once.
const BATCH: usize = 256;

impl BroadPhase for LinearOctree {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        // 0 is kept for anchors that are none.
        self.tick = self.tick.checked_add(1).unwrap_or(1);
        self.exact &= proxies.moved().is_empty();
        self.escaped.clear();
        if proxies.population_changed() {
            self.let_go_and_take_in(proxies);
        }
        for id in proxies.changed_filters() {
            if let Some(slot) = self.slot_of.get(id.index()).filter(|slot| **slot != NONE) {
                self.near.renew(*slot);
            }
        }
        if self.owned != proxies.len() {
            self.order.forget();
            return self.refresh(proxies);
        }
        if self.tight && proxies.moved().len() * REFRESH_SHARE > proxies.len() {
            // Without skins, whatever moves leaves its own.
            self.boxes_are_gathered = false;
            return self.refresh(proxies);
        }
        self.follow(proxies);
        self.changes += self.escaped.len();
        let searches_are_slow = self.near.searches_are_slow();
        if searches_are_slow {
            self.order.forget();
        }
        if searches_are_slow || self.changes * REFRESH_SHARE > proxies.len() {
            self.refresh(proxies);
        } else if !self.escaped.is_empty() {
            self.renew_escaped(proxies);
            // Those that jumped have made blocks large, in which all searches end.
            let looseness = self.tree.looseness();
            let is_dear = looseness * self.escaped.len() as f64 > proxies.len() as f64;
            if is_dear || (looseness > TOO_LOOSE && self.near.are_all_wanted()) {
                self.order.forget();
                self.refresh(proxies);
            }
        }
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        if proxies.moved().is_empty() {
            return 0;
        }
        let owners = &self.owners;
        let admits = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|slot| ProxyId::new(owners[slot as usize]));
            proxies.admits(a, b)
        };
        self.near.find(self.level, &self.tree, proxies.are_filtered().then_some(admits));
        let near = self.near.as_slice();
        let chunks = near.chunks(JOB);
        if !parallel::is_on() || chunks.len() <= 1 {
            near.chunks(BATCH).for_each(|near| self.compare(near, proxies, pairs));
        } else {
            let mut jobs = std::mem::take(&mut self.pairs_by_job);
            jobs.resize_with(chunks.len(), Vec::new);
            parallel::for_each(chunks.zip(&mut jobs), |(near, found)| {
                found.clear();
                near.chunks(BATCH).for_each(|near| self.compare(near, proxies, found));
            });
            jobs.iter().for_each(|found| pairs.extend_from_slice(found));
            self.pairs_by_job = jobs;
        }
        self.near.as_slice().len() as u64
    }

    fn asks_filters(&self) -> bool {
        true
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.tree.traverse(visitor, |slot, visitor| {
            let id = ProxyId::new(self.owners[slot]);
            visitor.object(id, &proxies.boxes()[id.index()], &EVERYWHERE);
        });
    }

    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        let generation = self.tree.height() - 1;
        for (bounds, objects) in self.tree.blocks_of_boxes() {
            found(Leaf { bounds, generation, objects });
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        let by_proxy = self.slot_of.capacity() * size_of::<u32>();
        let by_slot = self.owners.capacity() * size_of::<u32>()
            + self.boxes.capacity() * size_of::<Aabb3d>()
            + self.anchors.capacity() * size_of::<Anchor>()
            + self.tree.memory_bytes();
        let by_job = self.escaped_by_job.iter().map(List::memory_bytes).sum::<usize>()
            + self.pairs_by_job.iter().map(|pairs| pairs.capacity() * size_of::<Pair>()).sum::<usize>();
        let lists =
            by_job + self.escaped.capacity() * size_of::<u32>() + self.near.memory_bytes() + self.order.memory_bytes();
        BroadPhaseStats {
            nodes: self.tree.blocks(),
            leaves: self.tree.leaves(),
            depth: self.tree.height() - 1,
            entries: self.owned,
            bytes: by_proxy + by_slot + lists,
        }
    }
}
