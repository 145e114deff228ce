//! Eight triangles, as the leaves of a tree of triangles have them.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};
use fearless_simd::{f32x8, prelude::*};

use crate::broad_phase::block::{Block, WIDTH};

/// The corners of eight triangles that follow each other in a tree, coordinate by coordinate. Their
/// boxes are made of them when they are asked for.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct TriangleBlock {
    /// By corner and axis.
    corners: [[[f32; WIDTH]; 3]; 3],
}

impl TriangleBlock {
    /// The blocks of triangles; lanes that are left over have the last one again.
    pub(crate) fn of(triangles: impl ExactSizeIterator<Item = [Vec3; 3]>) -> Box<[Self]> {
        let empty = Self {
            corners: [[[0.0; WIDTH]; 3]; 3],
        };
        let mut blocks = vec![empty; triangles.len().div_ceil(WIDTH)].into_boxed_slice();
        for (index, triangle) in triangles.enumerate() {
            let block = &mut blocks[index / WIDTH];
            for (corner, lanes) in triangle.iter().zip(&mut block.corners) {
                for (coordinate, lanes) in corner.to_array().into_iter().zip(lanes) {
                    lanes[index % WIDTH..].fill(coordinate);
                }
            }
        }
        blocks
    }

    /// All corners of a number, by axis.
    #[inline(always)]
    pub(crate) fn corners<S: Simd>(&self, simd: S, corner: usize) -> [f32x8<S>; 3] {
        [0, 1, 2].map(|axis| f32x8::from_slice(simd, &self.corners[corner][axis]))
    }

    /// The box around one of the triangles.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Aabb3d {
        let [a, b, c] = self
            .corners
            .map(|axes| Vec3A::from_array(axes.map(|axis| axis[lane])));
        Aabb3d {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }

    /// The boxes around the first `count` of the triangles.
    #[inline(always)]
    pub(super) fn boxes(&self, count: usize) -> Block {
        Block::around(&self.corners, count)
    }
}
