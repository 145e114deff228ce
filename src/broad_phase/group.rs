//! Comparing all boxes of a group with each other.

use bevy::math::Vec3A;
use fearless_simd::Simd;

use super::{
    Pair, Proxies, ProxyId,
    linear_octree::{Block, WIDTH},
};

/// All three axes.
const ALL_AXES: u8 = 0b111;

/// A group of objects, those that moved first, their boxes in blocks of eight.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    ids: Vec<ProxyId>,
    blocks: Vec<Block>,
    /// By object: the axes along which its box begins in the group's cell, a bit for each.
    begins: Vec<u8>,
    moved: usize,
}

impl Group {
    /// Makes this the group of some objects, each of them in the index and given once. They are those whose boxes
    /// overlap a cell of space; `low` is its lower corner.
    #[inline]
    pub(super) fn gather(&mut self, objects: impl Iterator<Item = ProxyId>, low: Vec3A, proxies: &Proxies) {
        self.ids.clear();
        self.blocks.clear();
        self.begins.clear();
        self.ids.extend(objects);
        self.moved = self.ids.len();
        if !proxies.all_moved() {
            self.moved = 0;
            for place in 0..self.ids.len() {
                // Without a branch, which would be mispredicted often: to swap two that rest does no harm.
                let moved = proxies.is_moved(self.ids[place]);
                self.ids.swap(self.moved, place);
                self.moved += usize::from(moved);
            }
        }
        if self.moved == 0 {
            return;
        }
        for eight in self.ids.chunks(WIDTH) {
            let mut block = Block::EMPTY;
            for (lane, id) in eight.iter().enumerate() {
                let aabb = &proxies.boxes()[id.index()];
                block.set(lane, aabb);
                self.begins.push(aabb.min.cmpge(low).bitmask() as u8);
            }
            self.blocks.push(block);
        }
    }

    /// Appends each pair of overlapping boxes of which at least one moved, and whose overlap has its lower corner in
    /// the group's cell: of the cells that two boxes share, that is one. Returns the number of pairs compared.
    ///
    /// The corner is the larger of the two lower corners, axis by axis. It is below the upper borders of every cell
    /// that both boxes overlap, and above the lower borders if one of the boxes begins there.
    #[inline(always)]
    pub(super) fn overlaps<S: Simd>(&self, simd: S, pairs: &mut Vec<Pair>) -> u64 {
        let mut compared = 0;
        for first in 0..self.moved {
            compared += (self.ids.len() - first - 1) as u64;
            let (own, lane) = (first / WIDTH, first % WIDTH);
            let aabb = self.blocks[own].get(lane);
            let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
            // In its own block, those that follow.
            let mut lanes = !1 << lane;
            for (place, block) in self.blocks.iter().enumerate().skip(own) {
                let mut hits = block.overlaps(simd, min, max) & lanes;
                lanes = !0;
                while hits != 0 {
                    let other = place * WIDTH + hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    if self.begins[first] | self.begins[other] == ALL_AXES {
                        pairs.push(Pair::new(self.ids[first], self.ids[other]));
                    }
                }
            }
        }
        compared
    }

    /// The memory taken, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>()
            + self.ids.capacity() * size_of::<ProxyId>()
            + self.begins.capacity()
    }
}
