//! How loose the bounds of blocks have become since all boxes were put in order.

use bevy::math::bounding::Aabb3d;

use crate::broad_phase::block::{Block, WIDTH};

/// How many others the bounds of a block of boxes overlap, in good order: a rough figure.
const OVERLAPPED: f32 = 16.0;

/// What a block of boxes counts for at most where there are few.
const LEAST_MOST: f32 = 4.0;

/// How loose the bounds of blocks of boxes have become since all boxes were put in order.
///
/// The number of blocks that one overlaps is roughly proportional to the cube of the sum of its
/// sides. Each block is compared with itself as it was then, and counts for no more than if it
/// overlapped all others: so a few objects of any size, anywhere, weigh as much as they cost, and
/// no more.
#[derive(Clone, Debug, Default)]
pub(super) struct Looseness {
    /// How many blocks are known, and by block, in eights: one by the sum of its sides at first.
    blocks: usize,
    at_first: Vec<[f32; WIDTH]>,
    /// What a block counts for at most; 1 if it is as large as at first.
    most: f32,
    sum: f64,
}

impl Looseness {
    /// The mean of all blocks: 1 if they are as large as at first.
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.blocks.max(1) as f64
    }

    /// Forgets what blocks were at first.
    pub(super) fn start_over(&mut self) {
        self.blocks = 0;
        self.at_first.clear();
    }

    /// Measures all blocks, given their bounds.
    pub(super) fn measure(&mut self, bounds: &[Block], blocks: usize) {
        if self.blocks < blocks {
            self.note_at_first(bounds, blocks);
        }
        self.sum = 0.0;
        for (bounds, at_first) in bounds.iter().zip(&self.at_first) {
            let sides = bounds.side_sums();
            let counts: [f32; WIDTH] =
                std::array::from_fn(|lane| self.count(sides[lane], at_first[lane]));
            let four: [f32; 4] = std::array::from_fn(|lane| counts[lane] + counts[lane + 4]);
            self.sum += f64::from((four[0] + four[2]) + (four[1] + four[3]));
        }
    }

    /// Notes how large blocks are that it knows nothing of. Those that came since the others were
    /// put in order are in no order themselves: they are compared with what is typical of the
    /// others.
    #[cold]
    fn note_at_first(&mut self, bounds: &[Block], blocks: usize) {
        let known = self.at_first.as_flattened().iter().take(self.blocks);
        // The geometric mean, nearly: the bits of a float are its logarithm, nearly.
        let bits = known
            .map(|at_first| u64::from(at_first.to_bits()))
            .sum::<u64>();
        let typical = bits
            .checked_div(self.blocks as u64)
            .map(|bits| f32::from_bits(bits as u32));
        self.at_first.resize(blocks.div_ceil(WIDTH), [0.0; WIDTH]);
        let all = self
            .at_first
            .as_flattened_mut()
            .iter_mut()
            .zip(bounds.iter().flat_map(Block::side_sums));
        for (at_first, sides) in all.take(blocks).skip(self.blocks) {
            *at_first = typical.unwrap_or(sides.max(f32::MIN_POSITIVE).recip());
        }
        self.blocks = blocks;
        self.most = (blocks as f32 / OVERLAPPED).max(LEAST_MOST);
    }

    /// Measures a block that has changed.
    #[inline]
    pub(super) fn change(&mut self, block: usize, old: &Aabb3d, new: &Aabb3d) {
        if let Some(at_first) = self.at_first.get(block / WIDTH) {
            let count = |bounds| f64::from(self.count(sides_of(bounds), at_first[block % WIDTH]));
            self.sum += count(new) - count(old);
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.at_first.capacity() * size_of::<[f32; WIDTH]>()
    }

    /// What a block counts for.
    #[inline(always)]
    fn count(&self, sides: f32, at_first: f32) -> f32 {
        let growth = sides * at_first;
        (growth * growth * growth).min(self.most)
    }
}

/// The sum of a box's sides, of which each may be too large a number; nothing for one that is
/// empty.
#[inline(always)]
fn sides_of(bounds: &Aabb3d) -> f32 {
    let sides = bounds.max - bounds.min;
    (sides.x + sides.y + sides.z).clamp(0.0, f32::MAX)
}
