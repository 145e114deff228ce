//! Bricks of 4 × 4 × 4 cells, as masks of 64 bits: x counts 1, y 4 and z 16.

use bevy::math::IVec3;

use super::faces::Faces;
use crate::octree::Face;

/// A brick all of whose cells are full.
pub const FULL: u64 = !0;

/// The cells with coordinate 0 along each axis, and by how many bits the next ones are away.
const FIRST: [u64; 3] = [0x1111_1111_1111_1111, 0x000f_000f_000f_000f, 0xffff];
const STEP: [u32; 3] = [1, 4, 16];

/// The bit of a cell in its brick.
#[inline]
pub fn bit(cell: IVec3) -> u64 {
    let IVec3 { x, y, z } = cell & 3;
    1 << (x | y << 2 | z << 4)
}

/// The cells of a brick that have a coordinate along an axis.
#[inline]
pub fn slab(axis: usize, coordinate: i32) -> u64 {
    FIRST[axis] << (STEP[axis] * (coordinate as u32 & 3))
}

/// The cells in a mask.
pub fn cells(brick: IVec3, mask: u64) -> impl Iterator<Item = IVec3> {
    let some = |bits: u64| (bits != 0).then_some(bits);
    std::iter::successors(some(mask), move |bits| some(bits & (bits - 1))).map(move |bits| {
        let bit = bits.trailing_zeros() as i32;
        (brick << 2) + IVec3::new(bit & 3, bit >> 2 & 3, bit >> 4)
    })
}

/// Which cells of a brick have their face to a side of which nothing full is, by face; `beside` has
/// the mask of the brick that is there.
#[inline]
pub fn exposed(mask: u64, beside: impl Fn(Face) -> u64) -> [u64; 6] {
    Face::ALL.map(|face| {
        let signs = face.signs();
        let axis = signs.iter().position(|sign| *sign != 0);
        let axis = axis.expect("a face is across an axis");
        let (step, first) = (STEP[axis], FIRST[axis]);
        let last = first << (3 * step);
        let is_up = signs[axis] > 0;
        let border = if is_up { last } else { first };
        let mut covered = match is_up {
            true => mask >> step & !last,
            false => mask << step & !first,
        };
        if mask & border != 0 {
            let beside = beside(face);
            covered |= match is_up {
                true => (beside & first) << (3 * step),
                false => (beside & last) >> (3 * step),
            };
        }
        mask & !covered
    })
}

/// A box of cells in a brick: the first and the last along each axis, and the faces that are
/// exposed.
#[derive(Clone, Copy, Debug)]
pub struct BrickBox {
    pub first: [u32; 3],
    pub last: [u32; 3],
    pub faces: Faces,
}

/// Calls `found` with boxes that together are the cells of a mask, each once. Of each face of a box,
/// all is exposed or nothing.
///
/// They are grown along x, then z, then y, as long as that can be: floors become few.
#[inline]
pub fn for_each_box(mask: u64, exposed: &[u64; 6], mut found: impl FnMut(BrickBox)) {
    let mut rest = mask;
    while rest != 0 {
        let bit = rest.trailing_zeros();
        let first = [bit & 3, bit >> 2 & 3, bit >> 4];
        let (mut last, mut all) = (first, 1_u64 << bit);
        for axis in [0, 2, 1] {
            while last[axis] < 3 {
                let mut longer = last;
                longer[axis] += 1;
                let cells = range(first, longer);
                if cells & !rest != 0 || !is_uniform(cells, first, longer, exposed) {
                    break;
                }
                (last, all) = (longer, cells);
            }
        }
        rest &= !all;
        let is_exposed = |face: &Face| side(all, *face, first, last) & exposed[face.index()] != 0;
        let faces = Face::ALL.into_iter().filter(is_exposed).collect();
        found(BrickBox { first, last, faces });
    }
}

/// The cells from one to another.
#[inline]
fn range(first: [u32; 3], last: [u32; 3]) -> u64 {
    let along = |axis: usize| {
        let slabs = |coordinate: u32| FIRST[axis] << (STEP[axis] * coordinate);
        (first[axis]..=last[axis]).fold(0, |cells, coordinate| cells | slabs(coordinate))
    };
    along(0) & along(1) & along(2)
}

/// Those cells of a box that are at one of its faces.
#[inline]
fn side(cells: u64, face: Face, first: [u32; 3], last: [u32; 3]) -> u64 {
    let signs = face.signs();
    let axis = usize::from(signs[1] != 0) + 2 * usize::from(signs[2] != 0);
    let end = if signs[axis] > 0 { last } else { first };
    cells & slab(axis, end[axis] as i32)
}

/// Is of each face of a box all exposed, or nothing?
#[inline]
fn is_uniform(cells: u64, first: [u32; 3], last: [u32; 3], exposed: &[u64; 6]) -> bool {
    Face::ALL.into_iter().all(|face| {
        let side = side(cells, face, first, last);
        let part = side & exposed[face.index()];
        part == 0 || part == side
    })
}
