//! Queries: from the top block down, eight boxes at a time, near ones first.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use fearless_simd::{Level, dispatch, f32x8, prelude::*};

use super::octree::LinearOctree;
use crate::broad_phase::{
    block::{Block, WIDTH},
    boxes::ProxyId,
    measure::{Bound, Measure},
    proxy::Proxies,
};

/// A block to look at, in eight bytes: those that wait are many.
#[derive(Clone, Copy, Debug, Default)]
struct Task {
    /// How near its bounds are.
    nearness: f32,
    node: Node,
}

/// A block by its number and its height above those of boxes.
#[derive(Clone, Copy, Debug, Default)]
struct Node(u32);

impl Node {
    const HEIGHT_BITS: u32 = 4;

    #[inline(always)]
    fn new(height: u32, block: u32) -> Self {
        // So many boxes take 50 gigabytes.
        debug_assert!(
            block < 1 << (u32::BITS - Self::HEIGHT_BITS),
            "2³¹ boxes at most"
        );
        Self(block << Self::HEIGHT_BITS | height)
    }

    #[inline(always)]
    fn height(self) -> u32 {
        self.0 & ((1 << Self::HEIGHT_BITS) - 1)
    }

    #[inline(always)]
    fn block(self) -> u32 {
        self.0 >> Self::HEIGHT_BITS
    }

    /// One of the eight blocks below.
    #[inline(always)]
    fn child(self, lane: u32) -> Self {
        Self::new(self.height() - 1, self.block() * WIDTH as u32 + lane)
    }
}

/// As many blocks as can wait: each level but one leaves seven of eight, and there are 10 levels
/// above 2³¹ boxes.
const MOST_TASKS: usize = 10 * (WIDTH - 1) + 1;

/// What a query goes down: blocks of boxes, and who is in them.
pub(in crate::broad_phase) trait Blocks {
    /// Blocks by level, the boxes first.
    fn levels(&self) -> &[Vec<Block>];

    /// Are the boxes in the blocks those that are asked about, and not only around them?
    fn are_exact(&self) -> bool;

    /// Who is in a slot; `None` beyond the last.
    fn owner(&self, slot: u32) -> Option<u32>;

    /// The box of who is in a slot of a block.
    fn box_of(&self, owner: u32, block: &Block, slot: u32) -> Option<Aabb3d>;
}

/// Calls `visit` with the owner of each box within the limit, and its distance; it tells the limit
/// from then on.
pub(in crate::broad_phase) fn search<M: Measure>(
    level: Level,
    blocks: &impl Blocks,
    measure: &M,
    limit: f32,
    visit: impl FnMut(u32, f32) -> ControlFlow<(), f32>,
) {
    dispatch!(level, simd => {
        let (bound, mut tasks) = (measure.bound(limit), [Task::default(); MOST_TASKS]);
        Descent { blocks, measure, visit, limit, bound, tasks: &mut tasks, waiting: 0 }.run(simd);
    });
}

impl LinearOctree {
    /// Calls `visit` with each object within the limit, and its distance; it tells the limit from
    /// then on.
    pub(in crate::broad_phase) fn search<M: Measure>(
        &self,
        proxies: &Proxies,
        measure: &M,
        limit: f32,
        mut visit: impl FnMut(ProxyId, f32) -> ControlFlow<(), f32>,
    ) {
        let blocks = Skins {
            octree: self,
            proxies,
        };
        search(self.level, &blocks, measure, limit, |id, distance| {
            visit(ProxyId::new(id), distance)
        });
    }
}

/// The skins of the octree, and the boxes in them.
struct Skins<'a> {
    octree: &'a LinearOctree,
    proxies: &'a Proxies,
}

impl Blocks for Skins<'_> {
    #[inline(always)]
    fn levels(&self) -> &[Vec<Block>] {
        self.octree.tree.as_slice()
    }

    #[inline(always)]
    fn are_exact(&self) -> bool {
        self.octree.exact
    }

    #[inline(always)]
    fn owner(&self, slot: u32) -> Option<u32> {
        self.octree.owners.get(slot as usize).copied()
    }

    #[inline(always)]
    fn box_of(&self, owner: u32, block: &Block, slot: u32) -> Option<Aabb3d> {
        // What is in the block is in the cache, and what is in the order of space likely to be.
        if self.octree.exact {
            Some(block.get(slot as usize % WIDTH))
        } else if self.octree.boxes_are_gathered {
            self.octree.boxes.get(slot as usize).copied()
        } else {
            self.proxies.boxes().get(owner as usize).copied()
        }
    }
}

/// A query on its way down: one block after the other, from the top one on. All in one function
/// once it is compiled.
struct Descent<'a, B, M, V> {
    blocks: &'a B,
    measure: &'a M,
    visit: V,
    /// Objects farther away than this are of no interest, nor blocks beyond the bound that goes
    /// with it.
    limit: f32,
    bound: Bound,
    /// The blocks that wait, the next one last. Lent, so that all else here can be kept in
    /// registers.
    tasks: &'a mut [Task; MOST_TASKS],
    waiting: usize,
}

impl<B: Blocks, M: Measure, V: FnMut(u32, f32) -> ControlFlow<(), f32>> Descent<'_, B, M, V> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let levels = self.blocks.levels();
        let mut node = Node::new(levels.len() as u32 - 1, 0);
        loop {
            let block = &levels[node.height() as usize][node.block() as usize];
            let (hits, nearness) = self.measure.test_block(simd, block, self.bound);
            let nearest_child = if node.height() > 0 {
                self.at_inner(node, hits, nearness)
            } else if self.at_leaf(node, block, hits, nearness).is_break() {
                return;
            } else {
                None
            };
            let Some(next) = nearest_child.or_else(|| self.next_node()) else {
                return;
            };
            node = next;
        }
    }

    /// Visits the objects of a block of boxes that are hit.
    #[inline(always)]
    fn at_leaf<S: Simd>(
        &mut self,
        node: Node,
        block: &Block,
        hits: u32,
        nearness: f32x8<S>,
    ) -> ControlFlow<()> {
        let first = node.block() * WIDTH as u32;
        let mut lanes = [0; WIDTH];
        let count = ranked::<M, S>(hits, nearness, |lane, rank| lanes[rank] = lane);
        for &lane in &lanes[..count] {
            if M::ORDERED && self.bound.excludes(nearness[lane as usize]) {
                break;
            }
            let Some(owner) = self.blocks.owner(first + lane) else {
                continue;
            };
            let distance = if self.blocks.are_exact() && M::EXACT {
                Some(nearness[lane as usize] + 0.0)
            } else {
                let aabb = self.blocks.box_of(owner, block, first + lane);
                aabb.and_then(|aabb| self.measure.test_box(&aabb, self.limit))
            };
            let Some(distance) = distance else { continue };
            self.limit = (self.visit)(owner, distance)?;
            self.bound = self.measure.bound(self.limit);
        }
        ControlFlow::Continue(())
    }

    /// Returns the nearest of the blocks that are hit, and has the others wait, nearer ones on top.
    #[inline(always)]
    fn at_inner<S: Simd>(&mut self, node: Node, hits: u32, nearness: f32x8<S>) -> Option<Node> {
        if hits == 0 {
            return None;
        }
        if hits & (hits - 1) == 0 {
            return Some(node.child(hits.trailing_zeros()));
        }
        let last = self.waiting + hits.count_ones() as usize - 1;
        debug_assert!(last < MOST_TASKS);
        ranked::<M, S>(hits, nearness, |lane, rank| {
            self.tasks[last - rank] = Task {
                nearness: nearness[lane as usize],
                node: node.child(lane),
            };
        });
        self.waiting = last;
        Some(self.tasks[last].node)
    }

    /// The next of the blocks that wait and are not beyond the bound.
    #[inline(always)]
    fn next_node(&mut self) -> Option<Node> {
        while self.waiting > 0 {
            self.waiting -= 1;
            let task = self.tasks[self.waiting];
            if !(M::ORDERED && self.bound.excludes(task.nearness)) {
                return Some(task.node);
            }
        }
        None
    }
}

/// Calls `f` with each lane that is hit and its rank, from the nearest to the farthest if that
/// matters. Returns the number of hits.
#[inline(always)]
fn ranked<M: Measure, S: Simd>(
    hits: u32,
    nearness: f32x8<S>,
    mut f: impl FnMut(u32, usize),
) -> usize {
    if hits.is_power_of_two() {
        f(hits.trailing_zeros(), 0);
        return 1;
    }
    let mut rest = hits;
    let mut count = 0;
    while rest != 0 {
        let lane = rest.trailing_zeros();
        rest &= rest - 1;
        // Without a branch: it would be mispredicted often.
        let rank = if M::ORDERED {
            let own = nearness[lane as usize];
            let nearer = nearness.simd_lt(own).to_bitmask() as u32;
            let as_near = nearness.simd_eq(own).to_bitmask() as u32 & ((1 << lane) - 1);
            ((nearer | as_near) & hits).count_ones() as usize
        } else {
            count
        };
        f(lane, rank);
        count += 1;
    }
    count
}
