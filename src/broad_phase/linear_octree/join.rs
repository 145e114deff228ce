//! Searching the tree: one box against all, and all against all.

use bevy::math::bounding::Aabb3d;
use fearless_simd::{Level, Simd, dispatch};

use super::levels::{Block, Levels, WIDTH};

/// Two blocks of the same height whose boxes are to be compared; or one with itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Task {
    height: u32,
    a: u32,
    b: u32,
    /// The boxes of `a` that reach into the bounds of `b`: a bit for each.
    lanes: u32,
}

impl Levels {
    /// Appends the slots of each pair of overlapping boxes, the lower slot first.
    pub(super) fn self_join(&self, level: Level, stack: &mut Vec<Task>, found: &mut Vec<[u32; 2]>) {
        dispatch!(level, simd => self_join(simd, self.as_slice(), stack, found));
    }

    /// Calls `found` with the slots of all boxes that overlap `aabb`.
    #[inline(always)]
    pub(super) fn query<S: Simd>(&self, simd: S, aabb: &Aabb3d, stack: &mut Vec<Task>, mut found: impl FnMut(u32)) {
        let levels = self.as_slice();
        let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
        stack.clear();
        stack.push(Task { height: levels.len() as u32 - 1, ..Task::default() });
        while let Some(Task { height, a, .. }) = stack.pop() {
            let hits = levels[height as usize][a as usize].overlaps(simd, min, max);
            each_bit(u64::from(hits), |lane| {
                let child = a * WIDTH as u32 + lane;
                match height {
                    0 => found(child),
                    _ => stack.push(Task { height: height - 1, a: child, ..Task::default() }),
                }
            });
        }
    }
}

/// Joins the tree with itself from the top down. Of two different blocks, only the boxes of the one that reach into the
/// bounds of the other are compared; most pairs of blocks whose bounds overlap have none, and are dropped.
///
/// Branches that cannot be predicted cost more than comparisons here. So the verdicts on all pairs of two blocks are
/// gathered in one mask, and tasks are put on the stack first and taken off again if there is nothing to do.
#[inline(always)]
fn self_join<S: Simd>(simd: S, levels: &[Vec<Block>], stack: &mut Vec<Task>, found: &mut Vec<[u32; 2]>) {
    const ALL: u32 = (1 << WIDTH) - 1;
    const MOST_CHILDREN: usize = WIDTH * WIDTH;
    stack.clear();
    stack.resize(MOST_CHILDREN, Task::default());
    stack[0] = Task { height: levels.len() as u32 - 1, a: 0, b: 0, lanes: ALL };
    let mut tasks = 1;
    while tasks > 0 {
        tasks -= 1;
        let Task { height, a, b, lanes } = stack[tasks];
        let level = &levels[height as usize];
        let (block_a, block_b) = (&level[a as usize], &level[b as usize]);
        let (base_a, base_b) = (a * WIDTH as u32, b * WIDTH as u32);
        let mut verdicts = 0_u64;
        if a == b {
            for lane in 0..WIDTH {
                // At the bottom, each box with those after it; above, each block with itself too.
                let after = if height == 0 { !1 << lane } else { !0 << lane };
                let hits = block_a.overlaps_lane(simd, block_a, lane) & after & ALL;
                verdicts |= u64::from(hits) << (lane * WIDTH);
            }
        } else {
            each_bit(u64::from(lanes), |lane| {
                let hits = block_b.overlaps_lane(simd, block_a, lane as usize);
                verdicts |= u64::from(hits) << (lane as usize * WIDTH);
            });
        }
        if height == 0 {
            each_bit(verdicts, |bit| found.push([base_a + bit / WIDTH as u32, base_b + bit % WIDTH as u32]));
            continue;
        }
        if stack.len() < tasks + MOST_CHILDREN {
            stack.resize(tasks + 2 * MOST_CHILDREN, Task::default());
        }
        let below = &levels[height as usize - 1];
        each_bit(verdicts, |bit| {
            let lane_b = bit % WIDTH as u32;
            let (a, b) = (base_a + bit / WIDTH as u32, base_b + lane_b);
            let is_same = u32::from(a == b).wrapping_neg();
            let lanes = below[a as usize].overlaps_lane(simd, block_b, lane_b as usize) | (is_same & ALL);
            stack[tasks] = Task { height: height - 1, a, b, lanes };
            tasks += usize::from(lanes != 0);
        });
    }
}

/// Calls `f` with the place of each bit that is set.
#[inline(always)]
fn each_bit(mut bits: u64, mut f: impl FnMut(u32)) {
    while bits != 0 {
        f(bits.trailing_zeros());
        bits &= bits - 1;
    }
}
