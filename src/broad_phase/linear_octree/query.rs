//! Queries: from the top block down, eight boxes at a time, near ones first.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use fearless_simd::{dispatch, f32x8, prelude::*};

use super::octree::LinearOctree;
use crate::broad_phase::{
    block::{Block, WIDTH},
    boxes::ProxyId,
    measure::Measure,
    proxy::Proxies,
};

/// A block to look at.
#[derive(Clone, Copy, Debug, Default)]
struct Task {
    /// How near its bounds are.
    nearness: f32,
    height: u32,
    place: u32,
}

/// As many blocks as can wait: each level but one leaves seven of eight, and there are 11 levels above 2³² boxes.
const MOST_TASKS: usize = 11 * (WIDTH - 1) + 1;

impl LinearOctree {
    /// Calls `visit` with each object within the limit, and its distance; it tells the limit from then on.
    pub(in crate::broad_phase) fn search<M: Measure>(
        &self,
        proxies: &Proxies,
        measure: &M,
        limit: f32,
        visit: impl FnMut(ProxyId, f32) -> ControlFlow<(), f32>,
    ) {
        dispatch!(self.level, simd => self.descend(simd, proxies, measure, limit, visit));
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

    #[inline(always)]
    fn descend<S: Simd, M: Measure>(
        &self,
        simd: S,
        proxies: &Proxies,
        measure: &M,
        mut limit: f32,
        mut visit: impl FnMut(ProxyId, f32) -> ControlFlow<(), f32>,
    ) {
        let levels = self.tree.as_slice();
        let mut bound = measure.bound(limit);
        let mut tasks = [Task::default(); MOST_TASKS];
        let mut waiting = 0;
        let mut task = Task { height: levels.len() as u32 - 1, ..Task::default() };
        loop {
            let block = &levels[task.height as usize][task.place as usize];
            let (hits, nearness) = measure.eight(simd, block, bound);
            let first = task.place * WIDTH as u32;
            if task.height == 0 {
                let mut lanes = [0; WIDTH];
                let count = ranked::<M, S>(hits, nearness, |lane, rank| lanes[rank] = lane);
                for &lane in &lanes[..count] {
                    if M::ORDERED && nearness[lane as usize] > bound {
                        break;
                    }
                    let Some(id) = self.owners.get((first + lane) as usize).map(|id| ProxyId::new(*id)) else {
                        continue;
                    };
                    let distance = if self.exact && M::EXACT {
                        Some(nearness[lane as usize] + 0.0)
                    } else {
                        self.box_of(proxies, id, block, first + lane).and_then(|aabb| measure.one(&aabb, limit))
                    };
                    let Some(distance) = distance else { continue };
                    match visit(id, distance) {
                        ControlFlow::Continue(new) => limit = new,
                        ControlFlow::Break(()) => return,
                    }
                    bound = measure.bound(limit);
                }
            } else if hits != 0 {
                let height = task.height - 1;
                if hits & (hits - 1) == 0 {
                    task = Task { height, place: first + hits.trailing_zeros(), ..task };
                    continue;
                }
                let last = waiting + hits.count_ones() as usize - 1;
                waiting += ranked::<M, S>(hits, nearness, |lane, rank| {
                    tasks[last - rank] = Task { nearness: nearness[lane as usize], height, place: first + lane };
                });
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                task = tasks[waiting];
                if !(M::ORDERED && task.nearness > bound) {
                    break;
                }
            }
        }
    }
}

/// Calls `f` with each lane that is hit and its rank, from the nearest to the farthest if that matters. Returns the
/// number of hits.
#[inline(always)]
fn ranked<M: Measure, S: Simd>(hits: u32, nearness: f32x8<S>, mut f: impl FnMut(u32, usize)) -> usize {
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
