//! The same tree over boxes that never change: what meshes are searched by.

mod join;
mod split;

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;

use super::{
    block::{Block, WIDTH},
    linear_octree::{
        levels::Levels,
        query::{self, Blocks, Visit},
    },
    measure::Measure,
    query::Region,
};

pub(crate) use join::JoinStack;

/// A pointerless octree of boxes that stay as they are, each known by its index.
///
/// Built in O(n log n); a search visits O(log n) blocks for each box that it finds.
/// Nothing is allocated per search.
#[derive(Clone, Debug)]
pub(crate) struct StillOctree {
    level: Level,
    levels: Levels,
    /// The index of the box in each slot.
    owners: Vec<u32>,
}

impl StillOctree {
    /// Puts boxes in the order of space, and blocks around them. None may be inverted or infinite.
    pub(crate) fn new(boxes: &[Aabb3d]) -> Self {
        let level = Level::new();
        let owners = split::order(boxes);
        let mut levels = Levels::default();
        levels.resize(owners.len());
        for (slot, owner) in owners.iter().enumerate() {
            levels.set(slot, &boxes[*owner as usize]);
        }
        levels.refit();
        Self {
            level,
            levels,
            owners,
        }
    }

    /// Calls `found` with the index of each box that overlaps a region, in no particular order.
    #[inline]
    pub(crate) fn for_each_overlapping(
        &self,
        region: &(impl Region + ?Sized),
        mut found: impl FnMut(u32),
    ) {
        let (measure, limit) = region.measure();
        self.search(&measure, limit, |index, _| {
            found(index);
            ControlFlow::Continue(limit)
        });
    }

    /// Calls `visit` with the index of each box within the limit, and its distance, near ones first
    /// if the measure has an order; it tells the limit from then on.
    #[inline]
    pub(crate) fn search<M: Measure>(
        &self,
        measure: &M,
        limit: f32,
        mut visit: impl FnMut(u32, f32) -> ControlFlow<(), f32>,
    ) {
        self.search_with(measure, limit, &mut visit);
    }

    /// The same, with something whose part is compiled into the search, whatever its size.
    #[inline]
    pub(crate) fn search_with<M: Measure>(&self, measure: &M, limit: f32, visit: &mut impl Visit) {
        query::search(self.level, self, measure, limit, visit);
    }

    /// The indices of all boxes, near ones one after the other.
    pub(crate) fn in_order(&self) -> &[u32] {
        &self.owners
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.levels.memory_bytes() + self.owners.capacity() * size_of::<u32>()
    }
}

impl Blocks for StillOctree {
    #[inline(always)]
    fn levels(&self) -> &[Vec<Block>] {
        self.levels.as_slice()
    }

    #[inline(always)]
    fn are_exact(&self) -> bool {
        true
    }

    #[inline(always)]
    fn owner(&self, slot: u32) -> Option<u32> {
        self.owners.get(slot as usize).copied()
    }

    #[inline(always)]
    fn box_of(&self, _: u32, block: &Block, slot: u32) -> Option<Aabb3d> {
        Some(block.get(slot as usize % WIDTH))
    }
}
