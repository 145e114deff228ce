//! Searching the tree: one box against all, and all against all.
//!
//! Both go from the top down, one level at a time. What there is to look at on a level is a list of
//! numbers in twos, and a step makes the list of the next level from it, without branches: a
//! comparison of a box with the eight of a block gives a mask, and [`push_lanes`](List::push_lanes)
//! appends what the lanes of the mask stand for.
//!
//! # All against all, by an example
//!
//! One block, number 0, has boxes in the slots 0 to 3, of which 0 overlaps 1 and 3, and 2 overlaps
//! 3. Lanes 4 to 7 are empty: they overlap nothing.
//!
//! | list | holds | here |
//! |---|---|---|
//! | pairs | two blocks of one level | (0, 0): a block is joined with itself, too |
//! | rows | a slot of the first, and the second block | (0, 0) (1, 0) … (7, 0): on the top level, all lanes |
//!
//! | row | `hits`: lanes of the block that overlap the slot | `after_self`: lanes after the slot's own | found |
//! |---|---|---|---|
//! | (0, 0) | `0000_1011` | `1111_1110` | (0, 1) (0, 3) |
//! | (1, 0) | `0000_0011` | `1111_1100` | |
//! | (2, 0) | `0000_1100` | `1111_1000` | (2, 3) |
//! | (3, 0) | `0000_1101` | `1111_0000` | |
//!
//! So each pair is found once, and none of a box with itself. The mask `after_self` counts in rows
//! of a slot and its own block alone, and above the bottom, where slots are blocks of the level
//! below, it has the slot's own lane too: each block is to be joined with itself there. The rows of
//! two different blocks are fewer: only those boxes of the first that reach into the bounds of the
//! second, which stand in the level above.

use fearless_simd::{Level, Simd, dispatch};

use super::{
    levels::Levels,
    list::{FIRST, List, Packed, SECOND, pack, unpack},
};
use crate::{
    broad_phase::block::{ALL, Block, WIDTH},
    parallel,
};

/// How many pairs of blocks are worked on at once: few enough that what they lead to stays in the
/// cache.
const BATCH: usize = 128;

/// Pairs of blocks, and slots, of one job.
const PAIRS_OF_JOB: usize = 256;
const SLOTS_OF_JOB: usize = 512;

/// How many rows of a search are worked on at once: seldom fewer than there are, and a bound where
/// all overlap.
const ROWS: usize = 8 * BATCH;

/// Lists that are worked with, kept for the next time.
#[derive(Clone, Debug, Default)]
pub(super) struct JoinBuffers {
    /// Pairs of blocks from which the jobs begin.
    pairs: List,
    next: List,
    jobs: Vec<Job>,
}

/// The lists of a job.
#[derive(Clone, Debug, Default)]
struct Job {
    /// Boxes, each with a block of the same level with which to compare it.
    rows: List,
    /// By height: pairs of blocks whose bounds overlap, or rows.
    pairs: Vec<List>,
    found: List,
    compared: usize,
}

impl Job {
    /// The list of rows, and one for each of so many levels.
    fn lists(&mut self, levels: usize) -> (&mut List, &mut [List]) {
        if self.pairs.len() < levels {
            self.pairs.resize_with(levels, List::default);
        }
        (&mut self.rows, &mut self.pairs[..levels])
    }
}

/// Which boxes make a pair.
pub(super) trait Reach: Sync {
    /// Which of the eight of a block are in reach of the box in a lane of another.
    fn hits<S: Simd>(&self, simd: S, block: &Block, other: &Block, lane: usize) -> u32;
}

/// Those that overlap.
pub(super) struct Touching;

impl Reach for Touching {
    #[inline(always)]
    fn hits<S: Simd>(&self, simd: S, block: &Block, other: &Block, lane: usize) -> u32 {
        block.overlaps_lane(simd, other, lane)
    }
}

/// Those that are within a distance along each axis.
pub(super) struct Within(pub f32);

impl Reach for Within {
    #[inline(always)]
    fn hits<S: Simd>(&self, simd: S, block: &Block, other: &Block, lane: usize) -> u32 {
        block.within_lane(simd, other, lane, self.0)
    }
}

impl Levels {
    /// Appends the slots of each pair of boxes in reach of each other that is to be kept, the lower slot
    /// first.
    ///
    /// From the top down: pairs of boxes in reach on one level are the pairs of blocks to look
    /// at on the next. Only the boxes of the one block that reach into the bounds of the other are
    /// compared with it; most pairs of blocks have none. Whether a pair is to be kept is asked
    /// before the list has grown by more than a batch.
    pub(super) fn self_join(
        &self,
        level: Level,
        reach: &impl Reach,
        work: &mut JoinBuffers,
        found: &mut List,
        keep: Option<&(impl Fn(u32, u32) -> bool + Sync)>,
    ) {
        let mut height = self.as_slice().len() - 1;
        let JoinBuffers { pairs, next, jobs } = work;
        jobs.resize_with(jobs.len().max(1), Job::default);
        pairs.clear();
        pairs.reserve(1);
        pairs.push(pack(0, 0));
        // The upper levels at once, until there is work for several.
        while height > 0 && pairs.as_slice().len() <= PAIRS_OF_JOB {
            next.clear();
            let rows = &mut jobs[0].rows;
            dispatch!(level, simd => self.join_blocks(simd, reach, height, pairs.as_slice(), rows, next));
            std::mem::swap(pairs, next);
            height -= 1;
        }
        let pairs = pairs.as_slice();
        // The order of what is found does not depend on how the work is divided.
        if !parallel::is_on() || pairs.len() <= PAIRS_OF_JOB {
            let (rows, below) = jobs[0].lists(height);
            return self.join(level, reach, height, pairs, rows, below, found, keep);
        }
        jobs.resize_with(
            jobs.len().max(pairs.len().div_ceil(PAIRS_OF_JOB)),
            Job::default,
        );
        parallel::for_each(
            pairs.chunks(PAIRS_OF_JOB).zip(&mut *jobs),
            |(pairs, job)| {
                let mut found = std::mem::take(&mut job.found);
                found.clear();
                let (rows, below) = job.lists(height);
                self.join(level, reach, height, pairs, rows, below, &mut found, keep);
                job.found = found;
            },
        );
        for job in &jobs[..pairs.len().div_ceil(PAIRS_OF_JOB)] {
            found.extend(job.found.as_slice());
        }
    }

    /// Joins pairs of blocks of one height, and all that is below them.
    #[expect(
        clippy::too_many_arguments,
        reason = "lists that are lent, each for its own purpose"
    )]
    fn join(
        &self,
        level: Level,
        reach: &impl Reach,
        height: usize,
        pairs: &[Packed],
        rows: &mut List,
        below: &mut [List],
        found: &mut List,
        keep: Option<&impl Fn(u32, u32) -> bool>,
    ) {
        for batch in pairs.chunks(BATCH) {
            match below.split_last_mut() {
                None => {
                    let start = found.as_slice().len();
                    dispatch!(level, simd => self.join_blocks(simd, reach, height, batch, rows, found));
                    if let Some(keep) = keep {
                        found.retain_from(start, keep);
                    }
                }
                Some((next, below)) => {
                    next.clear();
                    dispatch!(level, simd => self.join_blocks(simd, reach, height, batch, rows, next));
                    self.join(
                        level,
                        reach,
                        height - 1,
                        next.as_slice(),
                        rows,
                        below,
                        found,
                        keep,
                    );
                }
            }
        }
    }

    /// Appends all pairs of boxes in reach of each other in pairs of blocks, in two passes without branches.
    #[inline(always)]
    fn join_blocks<S: Simd>(
        &self,
        simd: S,
        reach: &impl Reach,
        height: usize,
        pairs: &[Packed],
        rows: &mut List,
        found: &mut List,
    ) {
        let blocks = &self.as_slice()[height][..];
        rows.clear();
        rows.reserve(pairs.len());
        for pair in pairs {
            let [a, b] = unpack(*pair);
            let reaching = match self.as_slice().get(height + 1) {
                Some(above) => reach.hits(
                    simd,
                    &blocks[a as usize],
                    &above[b as usize / WIDTH],
                    b as usize % WIDTH,
                ),
                None => ALL,
            };
            rows.push_lanes(reaching, pack(first_slot(a), b), FIRST);
        }
        let rows = rows.as_slice();
        found.reserve(rows.len());
        for row in rows {
            let [slot, b] = unpack(*row);
            let (a, lane) = block_and_lane(slot);
            let hits = reach.hits(simd, &blocks[b as usize], &blocks[a as usize], lane);
            let same_block = all_if(a == b);
            let after_self = (!0 << lane) << u32::from(height == 0);
            found.push_lanes(
                hits & (after_self | !same_block),
                pack(slot, first_slot(b)),
                SECOND,
            );
        }
    }

    /// Appends, for each of some slots, that slot and each other slot whose box overlaps its own,
    /// if the two are to be kept: `keep` gets the slot that is searched for first, and is asked
    /// before the list has grown by more than a batch. Returns how often a box was compared with a
    /// block.
    pub(super) fn search(
        &self,
        level: Level,
        slots: &[u32],
        work: &mut JoinBuffers,
        found: &mut List,
        keep: &(impl Fn(u32, u32) -> bool + Sync),
    ) -> usize {
        let height = self.as_slice().len();
        let search = |slots: &[u32], job: &mut Job, found: &mut List| {
            let (rows, below) = job.lists(height);
            let mut compared = 0;
            for batch in slots.chunks(BATCH) {
                rows.clear();
                rows.reserve(batch.len());
                for slot in batch {
                    debug_assert!(
                        (*slot as usize) < self.as_slice()[0].len() * WIDTH,
                        "there is such a slot"
                    );
                    rows.push(pack(*slot, 0));
                }
                compared += self.descend_rows(level, rows.as_slice(), below, found, keep);
            }
            compared
        };
        let chunks = slots.chunks(SLOTS_OF_JOB);
        if !parallel::is_on() || chunks.len() <= 1 {
            work.jobs.resize_with(work.jobs.len().max(1), Job::default);
            return search(slots, &mut work.jobs[0], found);
        }
        work.jobs
            .resize_with(work.jobs.len().max(chunks.len()), Job::default);
        let jobs = &mut work.jobs[..chunks.len()];
        parallel::for_each(chunks.zip(&mut *jobs), |(slots, job)| {
            let mut found = std::mem::take(&mut job.found);
            found.clear();
            job.compared = search(slots, job, &mut found);
            job.found = found;
        });
        jobs.iter()
            .for_each(|job| found.extend(job.found.as_slice()));
        jobs.iter().map(|job| job.compared).sum()
    }

    /// Slots go down the tree side by side, one level after the other: rows are slots, each with a
    /// block of the level that has as many lists left as there are below it.
    fn descend_rows(
        &self,
        level: Level,
        rows: &[Packed],
        lists: &mut [List],
        found: &mut List,
        keep: &impl Fn(u32, u32) -> bool,
    ) -> usize {
        let Some((next, below)) = lists.split_last_mut() else {
            return 0;
        };
        let mut compared = rows.len();
        for rows in rows.chunks(ROWS) {
            if below.is_empty() {
                let start = found.as_slice().len();
                dispatch!(level, simd => self.search_blocks(simd, 0, rows, found));
                found.retain_from(start, keep);
            } else {
                next.clear();
                dispatch!(level, simd => self.search_blocks(simd, below.len(), rows, next));
                compared += self.descend_rows(level, next.as_slice(), below, found, keep);
            }
        }
        compared
    }

    /// Appends the boxes of each row's block that overlap the row's own.
    #[inline(always)]
    fn search_blocks<S: Simd>(&self, simd: S, height: usize, rows: &[Packed], found: &mut List) {
        let (boxes, blocks) = (&self.as_slice()[0][..], &self.as_slice()[height][..]);
        found.reserve(rows.len());
        for row in rows {
            let [slot, b] = unpack(*row);
            let (own, lane) = block_and_lane(slot);
            let hits = blocks[b as usize].overlaps_lane(simd, &boxes[own as usize], lane);
            // At the bottom, each is found by itself.
            let itself = u32::from(height == 0 && own == b) << lane;
            found.push_lanes(hits & !itself, pack(slot, first_slot(b)), SECOND);
        }
    }
}

/// The first slot of a block.
#[inline(always)]
const fn first_slot(block: u32) -> u32 {
    block * WIDTH as u32
}

/// The block that a slot is in, and its lane there.
#[inline(always)]
const fn block_and_lane(slot: u32) -> (u32, usize) {
    (slot / WIDTH as u32, slot as usize % WIDTH)
}

/// A mask of all lanes, or of none.
#[inline(always)]
const fn all_if(condition: bool) -> u32 {
    (condition as u32).wrapping_neg()
}

impl JoinBuffers {
    pub(super) fn memory_bytes(&self) -> usize {
        let of_job = |job: &Job| {
            let lists = job.pairs.iter().chain([&job.rows, &job.found]);
            size_of::<Job>() + lists.map(List::memory_bytes).sum::<usize>()
        };
        self.pairs.memory_bytes()
            + self.next.memory_bytes()
            + self.jobs.iter().map(of_job).sum::<usize>()
    }
}
