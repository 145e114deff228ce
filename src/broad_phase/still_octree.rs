//! The same tree over boxes that never change: what meshes are searched by.

mod join;
mod triangle_block;

use std::ops::ControlFlow;

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};
use fearless_simd::{Level, f32x8, prelude::*};

use super::{
    block::{Block, WIDTH},
    halving, level,
    linear_octree::{
        levels::Levels,
        query::{self, Blocks, Visit},
    },
    measure::{Bound, Measure},
    query::Region,
};

pub(crate) use join::JoinStack;
pub(crate) use triangle_block::TriangleBlock;

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
    /// Of a tree of triangles, these, in the order of slots; its lowest level has no boxes.
    triangles: Box<[TriangleBlock]>,
}

impl StillOctree {
    /// Puts boxes in the order of space, and blocks around them. None may be inverted or infinite.
    pub(crate) fn new(boxes: &[Aabb3d]) -> Self {
        let level = level::best();
        let owners = halving::order(boxes);
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
            triangles: Box::default(),
        }
    }

    /// A tree of triangles, of which none has an infinite corner.
    pub(crate) fn of_triangles(
        triangles: impl ExactSizeIterator<Item = [Vec3; 3]> + Clone,
    ) -> Self {
        let around = |[a, b, c]: [Vec3; 3]| Aabb3d {
            min: Vec3A::from(a.min(b).min(c)),
            max: Vec3A::from(a.max(b).max(c)),
        };
        let triangles: Vec<_> = triangles.collect();
        let boxes: Vec<_> = triangles.iter().copied().map(around).collect();
        let mut tree = Self::new(&boxes);
        drop(boxes);
        let in_order = tree.owners.iter().map(|index| triangles[*index as usize]);
        tree.triangles = TriangleBlock::of(in_order);
        tree.levels.forget_boxes();
        tree
    }

    /// The triangles in the order of slots, if it is a tree of triangles.
    pub(crate) fn triangles(&self) -> Option<&[TriangleBlock]> {
        (!self.triangles.is_empty()).then_some(&self.triangles)
    }

    /// The boxes in a block of triangles; `None` if it is a tree of boxes.
    #[inline(always)]
    fn boxes_of_triangles(&self, index: u32) -> Option<Block> {
        let triangles = self.triangles.get(index as usize)?;
        let left = self.owners.len() - index as usize * WIDTH;
        Some(triangles.boxes(left.min(WIDTH)))
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

    /// The number of levels of blocks, of which the lowest is that of the boxes and the highest is
    /// one block.
    pub(crate) fn height(&self) -> u32 {
        self.levels.height()
    }

    /// The number of blocks on a level.
    pub(crate) fn blocks_on(&self, level: u32) -> u32 {
        self.owners.len().div_ceil(WIDTH.pow(level + 1)) as u32
    }

    /// Calls `found` with the boxes in a block: each with its slot on the lowest level, which is 0,
    /// and above with the index of the block one level below that it is around.
    #[inline]
    pub(crate) fn for_each_in_block(
        &self,
        level: u32,
        index: u32,
        mut found: impl FnMut(&Aabb3d, u32),
    ) {
        let width = WIDTH as u32;
        let below = match level {
            0 => self.owners.len(),
            _ => self.owners.len().div_ceil(WIDTH.pow(level)),
        };
        for child in index * width..(below as u32).min((index + 1) * width) {
            let (block, lane) = (child / width, child as usize % WIDTH);
            let aabb = match (level, self.triangles.get(block as usize)) {
                (0, Some(triangles)) => triangles.get(lane),
                _ => self.levels()[level as usize][block as usize].get(lane),
            };
            found(&aabb, child);
        }
    }

    /// The indices of all boxes, near ones one after the other.
    pub(crate) fn in_order(&self) -> &[u32] {
        &self.owners
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.levels.memory_bytes()
            + self.owners.capacity() * size_of::<u32>()
            + size_of_val::<[_]>(&self.triangles)
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
    fn box_of(&self, _: u32, slot: u32) -> Option<Aabb3d> {
        let (index, lane) = (slot / WIDTH as u32, slot as usize % WIDTH);
        Some(match self.triangles.get(index as usize) {
            Some(triangles) => triangles.get(lane),
            None => self.levels.get(slot as usize),
        })
    }

    #[inline(always)]
    fn test_boxes<M: Measure, S: Simd>(
        &self,
        simd: S,
        measure: &M,
        index: u32,
        bound: Bound,
    ) -> (u32, f32x8<S>) {
        match self.boxes_of_triangles(index) {
            Some(boxes) => measure.test_block(simd, &boxes, bound),
            None => measure.test_block(simd, &self.levels()[0][index as usize], bound),
        }
    }
}
