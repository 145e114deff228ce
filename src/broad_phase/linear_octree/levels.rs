//! The tree without pointers: blocks of eight boxes, and above them blocks of the bounds of blocks.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use super::{EMPTY, JOB, Visitor};
use crate::parallel;

/// How many boxes a block holds.
pub const WIDTH: usize = 8;

/// All lanes of a block.
pub(super) const ALL: u32 = (1 << WIDTH) - 1;

/// Eight boxes, coordinate by coordinate.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Block {
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
}

impl Block {
    /// Eight boxes that overlap nothing.
    pub(in crate::broad_phase) const EMPTY: Self =
        Self { min: [[f32::INFINITY; WIDTH]; 3], max: [[f32::NEG_INFINITY; WIDTH]; 3] };

    #[inline(always)]
    pub(in crate::broad_phase) fn set(&mut self, lane: usize, aabb: &Aabb3d) {
        let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
        for axis in 0..3 {
            self.min[axis][lane] = min[axis];
            self.max[axis][lane] = max[axis];
        }
    }

    #[inline(always)]
    pub(in crate::broad_phase) fn get(&self, lane: usize) -> Aabb3d {
        let corner = |side: &[[f32; WIDTH]; 3]| Vec3A::new(side[0][lane], side[1][lane], side[2][lane]);
        Aabb3d { min: corner(&self.min), max: corner(&self.max) }
    }

    /// Is a box within the one in a lane?
    #[inline(always)]
    pub(super) fn holds(&self, lane: usize, aabb: &Aabb3d) -> bool {
        let outer = self.get(lane);
        (outer.min.cmple(aabb.min) & outer.max.cmpge(aabb.max)).all()
    }

    /// Which of the eight hold the box in the same lane of another block: a bit for each.
    #[inline(always)]
    pub(super) fn holds_all<S: Simd>(&self, simd: S, inner: &Self) -> u32 {
        let lanes = |side: &[[f32; WIDTH]; 3], axis: usize| f32x8::from_slice(simd, &side[axis]);
        let min = |axis| lanes(&self.min, axis).simd_le(lanes(&inner.min, axis));
        let max = |axis| lanes(&self.max, axis).simd_ge(lanes(&inner.max, axis));
        ((min(0) & min(1) & min(2)) & (max(0) & max(1) & max(2))).to_bitmask() as u32
    }

    /// The bounds of all eight.
    #[inline(always)]
    fn bounds(&self) -> Aabb3d {
        let fold = |lanes: &[f32; WIDTH], pick: fn(f32, f32) -> f32| {
            let four: [f32; 4] = std::array::from_fn(|lane| pick(lanes[lane], lanes[lane + 4]));
            pick(pick(four[0], four[2]), pick(four[1], four[3]))
        };
        let lower = |a: f32, b: f32| if a < b { a } else { b };
        let upper = |a: f32, b: f32| if a > b { a } else { b };
        Aabb3d {
            min: Vec3A::from_array(std::array::from_fn(|axis| fold(&self.min[axis], lower))),
            max: Vec3A::from_array(std::array::from_fn(|axis| fold(&self.max[axis], upper))),
        }
    }

    /// The lower or the upper sides of all eight along an axis.
    #[inline(always)]
    pub(in crate::broad_phase) fn side<S: Simd>(&self, simd: S, upper: bool, axis: usize) -> f32x8<S> {
        let sides = if upper { &self.max } else { &self.min };
        f32x8::from_slice(simd, &sides[axis])
    }

    /// Which of the eight overlap an interval along an axis, touching included: a bit for each.
    #[inline(always)]
    pub(in crate::broad_phase) fn overlaps_along<S: Simd>(&self, simd: S, axis: usize, low: f32, high: f32) -> u32 {
        let below = self.side(simd, false, axis).simd_le(f32x8::splat(simd, high));
        let above = self.side(simd, true, axis).simd_ge(f32x8::splat(simd, low));
        (below & above).to_bitmask() as u32
    }

    /// Which of the eight a box overlaps, touching included: a bit for each.
    #[inline(always)]
    pub(in crate::broad_phase) fn overlaps<S: Simd>(&self, simd: S, min: [f32; 3], max: [f32; 3]) -> u32 {
        let below = |axis: usize| f32x8::from_slice(simd, &self.min[axis]).simd_le(f32x8::splat(simd, max[axis]));
        let above = |axis: usize| f32x8::from_slice(simd, &self.max[axis]).simd_ge(f32x8::splat(simd, min[axis]));
        let x = below(0) & above(0);
        let y = below(1) & above(1);
        let z = below(2) & above(2);
        (x & y & z).to_bitmask() as u32
    }

    /// Which of the eight the box in a lane of another block overlaps.
    #[inline(always)]
    pub(super) fn overlaps_lane<S: Simd>(&self, simd: S, other: &Self, lane: usize) -> u32 {
        let corner = |side: &[[f32; WIDTH]; 3]| std::array::from_fn(|axis| side[axis][lane]);
        self.overlaps(simd, corner(&other.min), corner(&other.max))
    }
}

/// How many others the bounds of a block of boxes overlap, in good order: a rough figure.
const OVERLAPPED: f32 = 16.0;

/// What a block of boxes counts for at most where there are few.
const LEAST_MOST: f32 = 4.0;

/// How loose the bounds of blocks of boxes have become since all boxes were put in order.
///
/// The number of blocks that one overlaps is roughly proportional to the cube of the sum of its sides. Each block is
/// compared with itself as it was then, and counts for no more than if it overlapped all others: so a few objects of any
/// size, anywhere, weigh as much as they cost, and no more.
#[derive(Clone, Debug, Default)]
struct Looseness {
    /// How many blocks are known, and by block, in eights: one by the sum of its sides at first.
    blocks: usize,
    at_first: Vec<[f32; WIDTH]>,
    /// What a block counts for at most; 1 if it is as large as at first.
    most: f32,
    sum: f64,
}

impl Looseness {
    /// The mean of all blocks: 1 if they are as large as at first.
    fn mean(&self) -> f64 {
        self.sum / self.blocks.max(1) as f64
    }

    /// Forgets what blocks were at first.
    fn start_over(&mut self) {
        self.blocks = 0;
        self.at_first.clear();
    }

    /// Measures all blocks, given their bounds.
    fn measure(&mut self, bounds: &[Block], blocks: usize) {
        if self.blocks < blocks {
            self.note_at_first(bounds, blocks);
        }
        self.sum = 0.0;
        for (bounds, at_first) in bounds.iter().zip(&self.at_first) {
            let sides = sides(bounds);
            let counts: [f32; WIDTH] = std::array::from_fn(|lane| self.count(sides[lane], at_first[lane]));
            let four: [f32; 4] = std::array::from_fn(|lane| counts[lane] + counts[lane + 4]);
            self.sum += f64::from((four[0] + four[2]) + (four[1] + four[3]));
        }
    }

    /// Notes how large blocks are that it knows nothing of. Those that came since the others were put in order are in no
    /// order themselves: they are compared with what is typical of the others.
    #[cold]
    fn note_at_first(&mut self, bounds: &[Block], blocks: usize) {
        let known = self.at_first.as_flattened().iter().take(self.blocks);
        // The geometric mean, nearly: the bits of a float are its logarithm, nearly.
        let bits = known.map(|at_first| u64::from(at_first.to_bits())).sum::<u64>();
        let typical = bits.checked_div(self.blocks as u64).map(|bits| f32::from_bits(bits as u32));
        self.at_first.resize(blocks.div_ceil(WIDTH), [0.0; WIDTH]);
        let all = self.at_first.as_flattened_mut().iter_mut().zip(bounds.iter().flat_map(sides));
        for (at_first, sides) in all.take(blocks).skip(self.blocks) {
            *at_first = typical.unwrap_or(sides.max(f32::MIN_POSITIVE).recip());
        }
        self.blocks = blocks;
        self.most = (blocks as f32 / OVERLAPPED).max(LEAST_MOST);
    }

    /// Measures a block that has changed.
    #[inline]
    fn change(&mut self, place: usize, old: &Aabb3d, new: &Aabb3d) {
        if let Some(at_first) = self.at_first.get(place / WIDTH) {
            let count = |bounds| f64::from(self.count(sides_of(bounds), at_first[place % WIDTH]));
            self.sum += count(new) - count(old);
        }
    }

    /// What a block counts for.
    #[inline(always)]
    fn count(&self, sides: f32, at_first: f32) -> f32 {
        let growth = sides * at_first;
        (growth * growth * growth).min(self.most)
    }
}

/// The sum of a box's sides, of which each may be too large a number; nothing for one that is empty.
#[inline(always)]
fn sides_of(bounds: &Aabb3d) -> f32 {
    let sides = bounds.max - bounds.min;
    (sides.x + sides.y + sides.z).clamp(0.0, f32::MAX)
}

/// The same for eight boxes.
#[inline(always)]
fn sides(block: &Block) -> [f32; WIDTH] {
    let side = |axis: usize, lane: usize| block.max[axis][lane] - block.min[axis][lane];
    std::array::from_fn(|lane| (side(0, lane) + side(1, lane) + side(2, lane)).clamp(0.0, f32::MAX))
}

/// All levels: the boxes at the bottom, a single block on top.
#[derive(Clone, Debug)]
pub(super) struct Levels {
    levels: Vec<Vec<Block>>,
    looseness: Looseness,
}

impl Default for Levels {
    fn default() -> Self {
        Self { levels: vec![vec![Block::EMPTY]], looseness: Looseness::default() }
    }
}

impl Levels {
    /// Makes room for exactly so many boxes in a new order, which are to be set before the next refit.
    pub(super) fn resize(&mut self, boxes: usize) {
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

    /// How many times as many blocks of boxes overlap each other as at the first refit after a [`resize`](Self::resize),
    /// roughly.
    pub(super) fn looseness(&self) -> f64 {
        self.looseness.mean()
    }

    /// Adds levels until there is a single block on top, all of them empty.
    fn raise(&mut self) {
        let mut top = self.levels.len() - 1;
        while self.levels[top].len() > 1 {
            self.levels.push(vec![Block::EMPTY; self.levels[top].len().div_ceil(WIDTH)]);
            top += 1;
        }
    }

    /// Makes room for one more box at the end, where the last block is full. `end` is the new box's place.
    pub(super) fn push(&mut self, end: usize) {
        let mut place = end;
        for height in 0..self.levels.len() {
            place /= WIDTH;
            if place == self.levels[height].len() {
                self.levels[height].push(Block::EMPTY);
            }
        }
        let height = self.levels.len();
        self.raise();
        if self.levels.len() > height {
            self.refit();
        }
    }

    /// Puts a box in its place. The levels above know of it only after a refit.
    #[inline]
    pub(super) fn set(&mut self, slot: usize, aabb: &Aabb3d) {
        self.levels[0][slot / WIDTH].set(slot % WIDTH, aabb);
    }

    /// The box in a place.
    #[inline]
    pub(super) fn get(&self, slot: usize) -> Aabb3d {
        self.levels[0].get(slot / WIDTH).map_or(EMPTY, |block| block.get(slot % WIDTH))
    }

    /// Brings all levels above the boxes up to date. O(n), with a small constant.
    pub(super) fn refit(&mut self) {
        for height in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(height);
            let chunks = above[0].chunks_mut(JOB).zip(below[height - 1].chunks(JOB * WIDTH));
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

    /// Brings the blocks above one box up to date.
    pub(super) fn refit_above(&mut self, slot: usize) {
        let mut place = slot / WIDTH;
        for height in 1..self.levels.len() {
            let bounds = self.levels[height - 1][place].bounds();
            let above = &mut self.levels[height][place / WIDTH];
            if height == 1 {
                self.looseness.change(place, &above.get(place % WIDTH), &bounds);
            }
            above.set(place % WIDTH, &bounds);
            place /= WIDTH;
        }
    }

    /// Blocks by level, the boxes first.
    #[inline]
    pub(super) fn as_slice(&self) -> &[Vec<Block>] {
        &self.levels
    }

    /// Lets a visitor walk through the tree; `object` is called with the slots of the boxes that it reaches.
    pub(super) fn traverse(&self, visitor: &mut dyn Visitor, mut object: impl FnMut(usize, &mut dyn Visitor)) {
        let mut stack = vec![(self.levels.len() - 1, 0)];
        while let Some((height, place)) = stack.pop() {
            let block = &self.levels[height][place];
            for lane in (0..WIDTH).rev() {
                let bounds = block.get(lane);
                if bounds.min.x > bounds.max.x || !visitor.enter(&bounds) {
                    continue;
                }
                let child = place * WIDTH + lane;
                match height {
                    0 => object(child, visitor),
                    _ => stack.push((height - 1, child)),
                }
            }
        }
    }

    /// The blocks of boxes that are not empty: their bounds, and how many boxes they hold.
    pub(super) fn blocks_of_boxes(&self) -> impl Iterator<Item = (Aabb3d, u32)> {
        let count = |block: &Block| (0..WIDTH).map(|lane| u32::from(block.min[0][lane] <= block.max[0][lane])).sum();
        self.levels[0].iter().map(move |block| (block.bounds(), count(block))).filter(|(_, boxes)| *boxes > 0)
    }

    /// The number of levels.
    pub(super) fn height(&self) -> u32 {
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

    pub(super) fn memory_bytes(&self) -> usize {
        self.levels.iter().map(|level| level.capacity() * size_of::<Block>()).sum::<usize>()
            + self.looseness.at_first.capacity() * size_of::<[f32; WIDTH]>()
    }

    /// Checks that bounds hold what is below them, and that nothing stands beyond the last of so many boxes.
    ///
    /// # Panics
    /// If it is not so.
    pub(super) fn assert_well_formed(&self, boxes: usize) {
        assert_eq!(self.levels.last().map(Vec::len), Some(1), "a single block on top");
        for (below, above) in self.levels.iter().zip(self.levels.iter().skip(1)) {
            assert_eq!(below.len().div_ceil(WIDTH), above.len());
            for (place, block) in below.iter().enumerate() {
                let (inner, outer) = (block.bounds(), above[place / WIDTH].get(place % WIDTH));
                let held = outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all();
                assert!(held, "block {place} is within its bounds");
            }
        }
        for slot in boxes..self.levels[0].len() * WIDTH {
            assert_eq!(self.get(slot), EMPTY);
        }
    }
}
