//! Many boxes in one spot: put in order and joined, as those of the whole tree.

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;

use super::{
    join::{JoinBuffers, Touching},
    levels::Levels,
    list::{List, Packed, unpack},
    order,
};

/// A tree over the boxes of a group, made anew for each search.
#[derive(Clone, Debug, Default)]
pub struct Crowd {
    boxes: Vec<Aabb3d>,
    /// The indices of the boxes in the order of the tree, in the lower halves.
    order: Vec<Packed>,
    scratch: Vec<Packed>,
    tree: Levels,
    work: JoinBuffers,
    found: List,
}

impl Crowd {
    /// The indices of each pair of overlapping boxes that is to be kept, each once. O(n log n), and
    /// the pairs.
    pub(in crate::broad_phase) fn overlaps(
        &mut self,
        level: Level,
        boxes: impl Iterator<Item = Aabb3d>,
        keep: impl Fn(usize, usize) -> bool + Sync,
    ) -> impl Iterator<Item = [usize; 2]> {
        let Self {
            boxes: all,
            order,
            scratch,
            tree,
            work,
            found,
        } = self;
        all.clear();
        all.extend(boxes);
        order::order(level, all, 0..all.len() as u32, order, scratch);
        tree.resize(all.len());
        let index = |slot: u32| order[slot as usize] as u32 as usize;
        for slot in 0..all.len() {
            tree.set(slot, &all[index(slot as u32)]);
        }
        tree.refit();
        found.clear();
        tree.self_join(
            level,
            &Touching,
            work,
            found,
            Some(&|a, b| keep(index(a), index(b))),
        );
        found
            .as_slice()
            .iter()
            .map(move |pair| unpack(*pair).map(index))
    }

    /// The memory taken, in bytes.
    pub(in crate::broad_phase) fn memory_bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<Aabb3d>()
            + (self.order.capacity() + self.scratch.capacity()) * size_of::<Packed>()
            + self.tree.memory_bytes()
            + self.work.memory_bytes()
            + self.found.memory_bytes()
    }
}
