//! Queries: from the top block down, eight boxes at a time, near ones first.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use fearless_simd::{dispatch, f32x8, prelude::*};

use super::octree::LinearOctree;
use crate::broad_phase::{
    block::{Block, WIDTH},
    boxes::ProxyId,
    measure::{Bound, Measure},
    proxy::Proxies,
};

/// A block to look at.
#[derive(Clone, Copy, Debug, Default)]
struct Task {
    /// How near its bounds are.
    nearness: f32,
    height: u32,
    block: u32,
}

/// As many blocks as can wait: each level but one leaves seven of eight, and there are 11 levels
/// above 2³² boxes.
const MOST_TASKS: usize = 11 * (WIDTH - 1) + 1;

impl LinearOctree {
    /// Calls `visit` with each object within the limit, and its distance; it tells the limit from
    /// then on.
    pub(in crate::broad_phase) fn search<M: Measure>(
        &self,
        proxies: &Proxies,
        measure: &M,
        limit: f32,
        visit: impl FnMut(ProxyId, f32) -> ControlFlow<(), f32>,
    ) {
        dispatch!(self.level, simd => {
            let (bound, mut tasks) = (measure.bound(limit), [Task::default(); MOST_TASKS]);
            Descent { octree: self, proxies, measure, visit, limit, bound, tasks: &mut tasks, waiting: 0 }.run(simd);
        });
    }

    /// The box of the object in a slot, of which the skin is in the tree.
    #[inline(always)]
    fn box_of(&self, proxies: &Proxies, id: ProxyId, block: &Block, slot: u32) -> Option<Aabb3d> {
        // What is in the block is in the cache, and what is in the order of space likely to be.
        if self.exact {
            Some(block.get(slot as usize % WIDTH))
        } else if self.boxes_are_gathered {
            self.boxes.get(slot as usize).copied()
        } else {
            proxies.boxes().get(id.index()).copied()
        }
    }
}

/// A query on its way down: one block after the other, from the top one on. All in one function
/// once it is compiled.
struct Descent<'a, M, V> {
    octree: &'a LinearOctree,
    proxies: &'a Proxies,
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

impl<M: Measure, V: FnMut(ProxyId, f32) -> ControlFlow<(), f32>> Descent<'_, M, V> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let levels = self.octree.tree.as_slice();
        let mut task = Task {
            height: levels.len() as u32 - 1,
            ..Task::default()
        };
        loop {
            let block = &levels[task.height as usize][task.block as usize];
            let (hits, nearness) = self.measure.test_block(simd, block, self.bound);
            let only_child = if task.height > 0 {
                self.at_inner(task, hits, nearness)
            } else if self.at_leaf(task, block, hits, nearness).is_break() {
                return;
            } else {
                None
            };
            let Some(next) = only_child.or_else(|| self.next_task()) else {
                return;
            };
            task = next;
        }
    }

    /// Visits the objects of a block of boxes that are hit.
    #[inline(always)]
    fn at_leaf<S: Simd>(
        &mut self,
        task: Task,
        block: &Block,
        hits: u32,
        nearness: f32x8<S>,
    ) -> ControlFlow<()> {
        let first = task.block * WIDTH as u32;
        let mut lanes = [0; WIDTH];
        let count = ranked::<M, S>(hits, nearness, |lane, rank| lanes[rank] = lane);
        for &lane in &lanes[..count] {
            if M::ORDERED && self.bound.excludes(nearness[lane as usize]) {
                break;
            }
            let Some(id) = self
                .octree
                .owners
                .get((first + lane) as usize)
                .map(|id| ProxyId::new(*id))
            else {
                continue;
            };
            let distance = if self.octree.exact && M::EXACT {
                Some(nearness[lane as usize] + 0.0)
            } else {
                let aabb = self.octree.box_of(self.proxies, id, block, first + lane);
                aabb.and_then(|aabb| self.measure.test_box(&aabb, self.limit))
            };
            let Some(distance) = distance else { continue };
            self.limit = (self.visit)(id, distance)?;
            self.bound = self.measure.bound(self.limit);
        }
        ControlFlow::Continue(())
    }

    /// Has the blocks that are hit wait, the nearest one on top; or returns it, if it is the only
    /// one.
    #[inline(always)]
    fn at_inner<S: Simd>(&mut self, task: Task, hits: u32, nearness: f32x8<S>) -> Option<Task> {
        let (height, first) = (task.height - 1, task.block * WIDTH as u32);
        if hits == 0 {
            return None;
        }
        if hits & (hits - 1) == 0 {
            return Some(Task {
                height,
                block: first + hits.trailing_zeros(),
                ..task
            });
        }
        let last = self.waiting + hits.count_ones() as usize - 1;
        debug_assert!(last < MOST_TASKS);
        self.waiting += ranked::<M, S>(hits, nearness, |lane, rank| {
            self.tasks[last - rank] = Task {
                nearness: nearness[lane as usize],
                height,
                block: first + lane,
            };
        });
        None
    }

    /// The next of the blocks that wait and are not beyond the bound.
    #[inline(always)]
    fn next_task(&mut self) -> Option<Task> {
        while self.waiting > 0 {
            self.waiting -= 1;
            let task = self.tasks[self.waiting];
            if !(M::ORDERED && self.bound.excludes(task.nearness)) {
                return Some(task);
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
