//! Queries: from the top block down, eight boxes at a time, near ones first.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use fearless_simd::{Level, dispatch, f32x8, i32x8, mask32x8, prelude::*};

use super::octree::LinearOctree;
use crate::broad_phase::{
    block::{Block, WIDTH},
    boxes::ProxyId,
    measure::{Bound, Measure},
    proxy::Proxies,
};

/// As many levels as can be above the boxes, of which there are fewer than 2³².
const MOST_LEVELS: usize = 11;

/// A block of which some of the eight below wait to be looked at.
#[derive(Clone, Copy, Debug, Default)]
struct Frame {
    /// How near the bounds of the eight are, if that matters.
    nearness: [f32; WIDTH],
    /// Those that wait: a bit for each.
    rest: u32,
    /// The first of them, in its level.
    first: u32,
}

/// What a query goes down: blocks of boxes, and who is in them.
pub(in crate::broad_phase) trait Blocks {
    /// Blocks by level, the boxes first.
    fn levels(&self) -> &[Vec<Block>];

    /// Are the boxes in the blocks those that are asked about, and not only around them?
    fn are_exact(&self) -> bool;

    /// Who is in a slot; `None` beyond the last.
    fn owner(&self, slot: u32) -> Option<u32>;

    /// The box of who is in a slot.
    fn box_of(&self, owner: u32, slot: u32) -> Option<Aabb3d>;

    /// What a measure says of a block of boxes.
    #[inline(always)]
    fn test_boxes<M: Measure, S: Simd>(
        &self,
        simd: S,
        measure: &M,
        index: u32,
        bound: Bound,
    ) -> (u32, f32x8<S>) {
        measure.test_block(simd, &self.levels()[0][index as usize], bound)
    }
}

/// What is done with what a search finds.
pub trait Visit {
    /// Are blocks of boxes taken as a whole?
    const BLOCKS: bool = false;

    /// Takes an object, or whatever is in a box, and the distance of the box; tells the limit from
    /// then on.
    fn visit(&mut self, found: u32, distance: f32) -> ControlFlow<(), f32>;

    /// Takes a block of eight boxes, by its number, of which none has been looked at; tells the
    /// limit from then on.
    #[inline(always)]
    fn visit_block<S: Simd>(&mut self, _: S, _: u32) -> ControlFlow<(), f32> {
        ControlFlow::Break(())
    }
}

impl<F: FnMut(u32, f32) -> ControlFlow<(), f32>> Visit for F {
    #[inline(always)]
    fn visit(&mut self, found: u32, distance: f32) -> ControlFlow<(), f32> {
        self(found, distance)
    }
}

/// Has `visit` take the owner of each box within the limit.
pub(in crate::broad_phase) fn search<M: Measure>(
    level: Level,
    blocks: &impl Blocks,
    measure: &M,
    limit: f32,
    visit: &mut impl Visit,
) {
    dispatch!(level, simd => {
        let (bound, mut frames) = (measure.bound(limit), [Frame::default(); MOST_LEVELS]);
        Descent { blocks, measure, visit, limit, bound, frames: &mut frames }.run(simd);
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
        let blocks = Skins::of(self, proxies);
        let mut visit = |id: u32, distance: f32| visit(ProxyId::new(id), distance);
        search(self.level, &blocks, measure, limit, &mut visit);
    }
}

/// The skins of the octree, and the boxes in them.
pub(super) struct Skins<'a> {
    octree: &'a LinearOctree,
    proxies: &'a Proxies,
}

impl<'a> Skins<'a> {
    pub(super) const fn of(octree: &'a LinearOctree, proxies: &'a Proxies) -> Self {
        Self { octree, proxies }
    }

    /// The box of who is in a slot.
    #[inline(always)]
    pub(super) fn box_in(&self, slot: u32) -> Option<Aabb3d> {
        self.box_of(self.owner(slot)?, slot)
    }
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
    fn box_of(&self, owner: u32, slot: u32) -> Option<Aabb3d> {
        // What is in the block is in the cache, and what is in the order of space likely to be.
        if self.octree.exact {
            Some(self.octree.tree.get(slot as usize))
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
    visit: &'a mut V,
    /// Objects farther away than this are of no interest, nor blocks beyond the bound that goes
    /// with it.
    limit: f32,
    bound: Bound,
    /// The block that was looked at last on each level above that of the boxes, by the height of
    /// the blocks below it. Lent, so that all else here can be kept in registers.
    frames: &'a mut [Frame; MOST_LEVELS],
}

impl<B: Blocks, M: Measure, V: Visit> Descent<'_, B, M, V> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let levels = self.blocks.levels();
        let top = levels.len() - 1;
        let (mut height, mut index) = (top, 0);
        loop {
            if V::BLOCKS && height == 0 {
                let ControlFlow::Continue(limit) = self.visit.visit_block(simd, index) else {
                    return;
                };
                self.limit = limit;
                self.bound = self.measure.bound(limit);
            } else if height == 0 {
                let (blocks, measure) = (self.blocks, self.measure);
                let (hits, nearness) = blocks.test_boxes(simd, measure, index, self.bound);
                if self.at_leaf(simd, index, hits, nearness).is_break() {
                    return;
                }
            } else {
                let block = &levels[height][index as usize];
                let (hits, nearness) = self.measure.test_block(simd, block, self.bound);
                if hits != 0 {
                    height -= 1;
                    index = self.enter(simd, height, index, hits, nearness);
                    continue;
                }
            }
            // On the way up, the first level where one waits.
            index = loop {
                if height == top {
                    return;
                }
                if let Some(next) = self.next_of(simd, height) {
                    break next;
                }
                height += 1;
            };
        }
    }

    /// The nearest of the blocks at a height that are below one and are hit; the others wait.
    #[inline(always)]
    fn enter<S: Simd>(
        &mut self,
        simd: S,
        height: usize,
        above: u32,
        hits: u32,
        nearness: f32x8<S>,
    ) -> u32 {
        let lane = nearest::<M, S>(simd, hits, nearness);
        let frame = &mut self.frames[height];
        frame.first = above * WIDTH as u32;
        frame.rest = hits & !(1 << lane);
        if M::ORDERED {
            nearness.store_slice(&mut frame.nearness);
        }
        frame.first + lane
    }

    /// Visits the objects of a block of boxes that are hit.
    #[inline(always)]
    fn at_leaf<S: Simd>(
        &mut self,
        simd: S,
        index: u32,
        hits: u32,
        nearness: f32x8<S>,
    ) -> ControlFlow<()> {
        let first = index * WIDTH as u32;
        let mut rest = hits;
        while rest != 0 {
            let lane = nearest::<M, S>(simd, rest, nearness);
            rest &= !(1 << lane);
            let Some(owner) = self.blocks.owner(first + lane) else {
                continue;
            };
            let distance = if self.blocks.are_exact() && M::EXACT {
                Some(nearness[lane as usize] + 0.0)
            } else {
                let aabb = self.blocks.box_of(owner, first + lane);
                aabb.and_then(|aabb| self.measure.test_box(&aabb, self.limit))
            };
            let Some(distance) = distance else { continue };
            self.limit = self.visit.visit(owner, distance)?;
            self.bound = self.measure.bound(self.limit);
            if M::ORDERED {
                rest &= within(simd, nearness, self.bound);
            }
        }
        ControlFlow::Continue(())
    }

    /// The nearest of the blocks that wait at a height and are not beyond the bound.
    #[inline(always)]
    fn next_of<S: Simd>(&mut self, simd: S, height: usize) -> Option<u32> {
        let frame = &mut self.frames[height];
        if frame.rest == 0 {
            return None;
        }
        let nearness = f32x8::from_slice(simd, &frame.nearness);
        if M::ORDERED {
            frame.rest &= within(simd, nearness, self.bound);
            if frame.rest == 0 {
                return None;
            }
        }
        let lane = nearest::<M, S>(simd, frame.rest, nearness);
        frame.rest &= !(1 << lane);
        Some(frame.first + lane)
    }
}

/// Which of eight are not beyond a bound: a bit for each.
#[inline(always)]
fn within<S: Simd>(simd: S, nearness: f32x8<S>, bound: Bound) -> u32 {
    nearness.simd_le(bound.splat(simd)).to_bitmask() as u32
}

/// The nearest of those lanes of which the bits are set, of which there is one; the first, if they
/// are as near, or if that does not matter.
#[inline(always)]
fn nearest<M: Measure, S: Simd>(simd: S, lanes: u32, nearness: f32x8<S>) -> u32 {
    debug_assert!(lanes != 0, "one is there");
    if !M::ORDERED || lanes.is_power_of_two() {
        return lanes.trailing_zeros();
    }
    // Numbers that are not negative are in the order of their bits, of which the last are the lane.
    // Minus zero comes first of all.
    let numbers = i32x8::from_slice(simd, &[0, 1, 2, 3, 4, 5, 6, 7]);
    let keys = nearness.bitcast::<i32x8<S>>() & !7 | numbers;
    let mask = mask32x8::from_bitmask(simd, u64::from(lanes));
    let least = mask.select(keys, i32x8::splat(simd, i32::MAX)).reduce_min();
    least as u32 & 7
}
