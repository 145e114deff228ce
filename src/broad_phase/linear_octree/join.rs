//! Searching the tree: one box against all, and all against all.

use bevy::math::bounding::Aabb3d;
use fearless_simd::{Level, Simd, dispatch};

use super::levels::{Block, Levels, WIDTH};

/// Two blocks of the same height whose boxes are to be compared; or one with itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    height: u32,
    a: u32,
    b: u32,
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
        stack.push(Task { height: levels.len() as u32 - 1, a: 0, b: 0 });
        while let Some(Task { height, a, .. }) = stack.pop() {
            let hits = levels[height as usize][a as usize].overlaps(simd, min, max);
            each_bit(hits, |lane| {
                let child = a * WIDTH as u32 + lane;
                match height {
                    0 => found(child),
                    _ => stack.push(Task { height: height - 1, a: child, b: child }),
                }
            });
        }
    }
}

/// Joins the tree with itself from the top down. Of two different blocks, only the boxes of the one that reach into the
/// bounds of the other are compared: most pairs of blocks that overlap have none.
#[inline(always)]
fn self_join<S: Simd>(simd: S, levels: &[Vec<Block>], stack: &mut Vec<Task>, found: &mut Vec<[u32; 2]>) {
    const ALL: u32 = 0xFF;
    stack.clear();
    stack.push(Task { height: levels.len() as u32 - 1, a: 0, b: 0 });
    while let Some(Task { height, a, b }) = stack.pop() {
        let level = &levels[height as usize];
        let (block_a, block_b) = (&level[a as usize], &level[b as usize]);
        let (base_a, base_b) = (a * WIDTH as u32, b * WIDTH as u32);
        let is_same = a == b;
        let lanes = if is_same {
            ALL
        } else {
            block_a.overlaps_lane(simd, &levels[height as usize + 1][b as usize / WIDTH], b as usize % WIDTH)
        };
        each_bit(lanes, |lane| {
            let mut hits = block_b.overlaps_lane(simd, block_a, lane as usize);
            if is_same {
                // At the bottom, each box with those after it; above, each block with itself too.
                hits &= if height == 0 { !1 << lane } else { !0 << lane };
            }
            each_bit(hits & ALL, |other| {
                let (a, b) = (base_a + lane, base_b + other);
                match height {
                    0 => found.push([a, b]),
                    _ => stack.push(Task { height: height - 1, a, b }),
                }
            });
        });
    }
}

/// Calls `f` with the place of each bit that is set.
#[inline(always)]
fn each_bit(mut bits: u32, mut f: impl FnMut(u32)) {
    while bits != 0 {
        f(bits.trailing_zeros());
        bits &= bits - 1;
    }
}
