//! Comparing all boxes of a group with each other.

use bevy::math::bounding::Aabb3d;

use super::{Proxies, ProxyId, overlap};

/// A group of objects, their boxes in one place and those that moved first.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    boxes: Vec<Aabb3d>,
    ids: Vec<ProxyId>,
    moved: usize,
}

impl Group {
    /// Makes this the group of some objects, each of them in the index and given once.
    pub(super) fn gather(&mut self, objects: impl Iterator<Item = ProxyId> + Clone, proxies: &Proxies) {
        self.ids.clear();
        self.ids.extend(objects.clone().filter(|id| proxies.is_moved(*id)));
        self.moved = self.ids.len();
        if self.moved > 0 {
            self.ids.extend(objects.filter(|id| !proxies.is_moved(*id)));
        }
        self.boxes.clear();
        self.boxes.extend(self.ids.iter().map(|id| proxies.boxes()[id.index()]));
    }

    /// Calls `found` with each pair of overlapping boxes of which at least one moved. Returns the number of pairs
    /// compared.
    #[inline]
    pub(super) fn overlaps(&self, mut found: impl FnMut([ProxyId; 2], [&Aabb3d; 2])) -> u64 {
        let mut compared = 0;
        for first in 0..self.moved {
            let aabb = &self.boxes[first];
            let others = &self.boxes[first + 1..];
            compared += others.len() as u64;
            for (other, id) in others.iter().zip(&self.ids[first + 1..]) {
                if overlap(aabb, other) {
                    found([self.ids[first], *id], [aabb, other]);
                }
            }
        }
        compared
    }

    /// The memory taken, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<Aabb3d>() + self.ids.capacity() * size_of::<ProxyId>()
    }
}
