//! The pointerless octree as a whole.

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;

use super::{levels::Levels, list::List, near::NearPairs, order::Order, skin::Anchor};
use crate::broad_phase::{
    boxes::{EVERYWHERE, ProxyId},
    engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
    level,
    pairs::Pair,
    proxy::Proxies,
};

/// No slot.
pub(super) const NONE: u32 = u32::MAX;

/// The pointerless octree. See the [module's documentation](super).
#[derive(Debug)]
#[doc(alias = "bvh")]
#[doc(alias = "fat aabb")]
pub struct LinearOctree {
    /// The vector instructions that this machine has.
    pub(super) level: Level,
    /// Counts the updates; 0 is none.
    pub(super) tick: u32,
    /// By proxy: its slot.
    pub(super) slot_of: Vec<u32>,
    /// By slot, which is a position in the order of the curve: its proxy. An object that went
    /// leaves its slot empty until all are sorted anew; one that came has a slot at the end until
    /// then.
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
            level: level::best(),
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

impl BroadPhase for LinearOctree {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.keep_up(proxies);
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
        self.near.find(
            self.level,
            &self.tree,
            proxies.are_filtered().then_some(admits),
        );
        self.compare_near(proxies, pairs);
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
            found(Leaf {
                bounds,
                generation,
                objects,
            });
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        let by_proxy = self.slot_of.capacity() * size_of::<u32>();
        let by_slot = self.owners.capacity() * size_of::<u32>()
            + self.boxes.capacity() * size_of::<Aabb3d>()
            + self.anchors.capacity() * size_of::<Anchor>()
            + self.tree.memory_bytes();
        let by_job = self
            .escaped_by_job
            .iter()
            .map(List::memory_bytes)
            .sum::<usize>()
            + self
                .pairs_by_job
                .iter()
                .map(|pairs| pairs.capacity() * size_of::<Pair>())
                .sum::<usize>();
        let lists = by_job
            + self.escaped.capacity() * size_of::<u32>()
            + self.near.memory_bytes()
            + self.order.memory_bytes();
        BroadPhaseStats {
            nodes: self.tree.blocks(),
            leaves: self.tree.leaves(),
            depth: self.tree.height() - 1,
            entries: self.owned,
            bytes: by_proxy + by_slot + lists,
        }
    }
}
