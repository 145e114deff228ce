//! The tree without pointers: blocks of eight boxes, and above them blocks of the bounds of blocks.

use bevy::math::bounding::Aabb3d;

use super::looseness::Looseness;
use crate::{
    broad_phase::{
        block::{Block, WIDTH},
        boxes::NOWHERE,
        engine::Visitor,
    },
    parallel,
};

/// How many slots, or near pairs, make a job of their own. A multiple of 64, so that the borders of
/// jobs are borders of blocks two levels up.
pub(super) const JOB: usize = 4096;

/// All levels: the boxes at the bottom, a single block on top.
#[derive(Clone, Debug)]
pub(in crate::broad_phase) struct Levels {
    levels: Vec<Vec<Block>>,
    looseness: Looseness,
}

impl Default for Levels {
    fn default() -> Self {
        Self {
            levels: vec![vec![Block::EMPTY]],
            looseness: Looseness::default(),
        }
    }
}

impl Levels {
    /// Makes room for exactly so many boxes in a new order, which are to be set before the next
    /// refit.
    pub(in crate::broad_phase) fn resize(&mut self, boxes: usize) {
        let blocks = boxes.div_ceil(WIDTH).max(1);
        self.levels.truncate(1);
        self.levels[0].resize(blocks, Block::EMPTY);
        self.levels[0][blocks - 1] = Block::EMPTY;
        self.looseness.start_over();
        self.raise();
    }

    /// The blocks of boxes, to set them. The levels above know of it only after a refit.
    #[inline]
    pub(super) fn boxes_mut(&mut self) -> &mut [Block] {
        &mut self.levels[0]
    }

    /// How many times as many blocks of boxes overlap each other as at the first refit after a
    /// [`resize`](Self::resize), roughly.
    pub(super) fn looseness(&self) -> f64 {
        self.looseness.mean()
    }

    /// Adds levels until there is a single block on top, all of them empty.
    fn raise(&mut self) {
        let mut top = self.levels.len() - 1;
        while self.levels[top].len() > 1 {
            self.levels
                .push(vec![Block::EMPTY; self.levels[top].len().div_ceil(WIDTH)]);
            top += 1;
        }
    }

    /// Makes room for one more box at the end, where the last block is full. `end` is the new box's
    /// slot.
    pub(super) fn push(&mut self, end: usize) {
        debug_assert!(
            end / WIDTH <= self.levels[0].len(),
            "the slots before it are there"
        );
        let mut block = end;
        for height in 0..self.levels.len() {
            block /= WIDTH;
            if block == self.levels[height].len() {
                self.levels[height].push(Block::EMPTY);
            }
        }
        let height = self.levels.len();
        self.raise();
        if self.levels.len() > height {
            self.refit();
        }
    }

    /// Puts a box in its slot. The levels above know of it only after a refit.
    #[inline]
    pub(in crate::broad_phase) fn set(&mut self, slot: usize, aabb: &Aabb3d) {
        self.levels[0][slot / WIDTH].set(slot % WIDTH, aabb);
    }

    /// The box in a slot.
    #[inline]
    pub(in crate::broad_phase) fn get(&self, slot: usize) -> Aabb3d {
        self.levels[0]
            .get(slot / WIDTH)
            .map_or(NOWHERE, |block| block.get(slot % WIDTH))
    }

    /// Brings all levels above the boxes up to date. O(n), with a small constant.
    pub(in crate::broad_phase) fn refit(&mut self) {
        for height in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(height);
            let chunks = above[0]
                .chunks_mut(JOB)
                .zip(below[height - 1].chunks(JOB * WIDTH));
            parallel::for_each(chunks, |(above, below)| {
                for (block, eight) in above.iter_mut().zip(below.chunks(WIDTH)) {
                    for (lane, child) in eight.iter().enumerate() {
                        block.set(lane, &child.bounds());
                    }
                }
            });
        }
        if let [boxes, bounds, ..] = &self.levels[..] {
            self.looseness.measure(bounds, boxes.len());
        }
    }

    /// Has no boxes any more, but the bounds of their blocks: for those who have them elsewhere.
    pub(in crate::broad_phase) fn forget_boxes(&mut self) {
        self.levels[0] = Vec::new();
    }

    /// Brings the blocks above one box up to date.
    pub(super) fn refit_above(&mut self, slot: usize) {
        let mut block = slot / WIDTH;
        for height in 1..self.levels.len() {
            let bounds = self.levels[height - 1][block].bounds();
            let above = &mut self.levels[height][block / WIDTH];
            if height == 1 {
                self.looseness
                    .change(block, &above.get(block % WIDTH), &bounds);
            }
            above.set(block % WIDTH, &bounds);
            block /= WIDTH;
        }
    }

    /// Blocks by level, the boxes first.
    #[inline]
    pub(in crate::broad_phase) fn as_slice(&self) -> &[Vec<Block>] {
        &self.levels
    }

    /// Lets a visitor walk through the tree; `object` is called with the slots of the boxes that it
    /// reaches.
    pub(super) fn traverse(
        &self,
        visitor: &mut dyn Visitor,
        mut object: impl FnMut(usize, &mut dyn Visitor),
    ) {
        let mut stack = vec![(self.levels.len() - 1, 0)];
        while let Some((height, index)) = stack.pop() {
            let block = &self.levels[height][index];
            for lane in (0..WIDTH).rev() {
                let bounds = block.get(lane);
                if bounds.min.x > bounds.max.x || !visitor.enter(&bounds) {
                    continue;
                }
                let child = index * WIDTH + lane;
                match height {
                    0 => object(child, visitor),
                    _ => stack.push((height - 1, child)),
                }
            }
        }
    }

    /// The blocks of boxes that are not empty: their bounds, and how many boxes they hold.
    pub(super) fn blocks_of_boxes(&self) -> impl Iterator<Item = (Aabb3d, u32)> {
        self.levels[0]
            .iter()
            .map(|block| (block.bounds(), block.count()))
            .filter(|(_, boxes)| *boxes > 0)
    }

    /// The number of levels.
    pub(in crate::broad_phase) fn height(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The number of blocks on all levels.
    pub(super) fn blocks(&self) -> usize {
        self.levels.iter().map(Vec::len).sum()
    }

    /// The number of blocks of boxes.
    pub(super) fn leaves(&self) -> usize {
        self.levels[0].len()
    }

    pub(in crate::broad_phase) fn memory_bytes(&self) -> usize {
        self.levels
            .iter()
            .map(|level| level.capacity() * size_of::<Block>())
            .sum::<usize>()
            + self.looseness.memory_bytes()
    }

    /// Checks that bounds hold what is below them, and that nothing stands beyond the last of so
    /// many boxes.
    ///
    /// # Panics
    /// If it is not so.
    pub(super) fn assert_well_formed(&self, boxes: usize) {
        assert_eq!(
            self.levels.last().map(Vec::len),
            Some(1),
            "a single block on top"
        );
        for (below, above) in self.levels.iter().zip(self.levels.iter().skip(1)) {
            assert_eq!(below.len().div_ceil(WIDTH), above.len());
            for (index, block) in below.iter().enumerate() {
                let (inner, outer) = (block.bounds(), above[index / WIDTH].get(index % WIDTH));
                let held = outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all();
                assert!(held, "block {index} is within its bounds");
            }
        }
        for slot in boxes..self.levels[0].len() * WIDTH {
            assert_eq!(self.get(slot), NOWHERE);
        }
    }
}
