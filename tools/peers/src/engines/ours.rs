//! This crate, used as a game would: every box is set, one maintenance step, all pairs.

use bevy::math::bounding::Aabb3d;
use bevy_octree::broad_phase::{BroadPhaseMethod, ProxyId, SpatialIndex};

use super::{Engine, Pair};

/// A [`SpatialIndex`].
pub struct Ours {
    index: SpatialIndex,
    ids: Vec<ProxyId>,
}

impl Ours {
    /// One that searches by the method of this name.
    ///
    /// # Panics
    /// If there is no such method.
    pub fn new(method: &str) -> Self {
        let method: BroadPhaseMethod = method.parse().expect("the engines of the list are methods");
        Self {
            index: SpatialIndex::new(&method),
            ids: vec![],
        }
    }
}

impl Engine for Ours {
    fn update(&mut self, boxes: &[Aabb3d]) {
        if self.ids.is_empty() {
            self.ids = boxes
                .iter()
                .map(|aabb| self.index.insert(*aabb).expect("the boxes are finite"))
                .collect();
        } else {
            for (id, aabb) in self.ids.iter().zip(boxes) {
                self.index.set(*id, aabb).expect("the boxes are finite");
            }
        }
        self.index.update();
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        // Handles are dense and were given out in object order: they are the numbers of the
        // objects.
        pairs.extend(
            self.index
                .find_pairs()
                .iter()
                .map(|pair| (pair.a.get(), pair.b.get())),
        );
    }
}
