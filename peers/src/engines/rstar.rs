//! rstar: an R*-tree, bulk-loaded each frame and joined with itself. Moving objects by removal and insertion takes it
//! several times longer.

use bevy::math::bounding::Aabb3d;
use rstar::{AABB, RTree, RTreeObject};

use super::{Engine, Pair};

/// An object in the tree.
struct Object {
    number: u32,
    envelope: AABB<[f32; 3]>,
}

impl RTreeObject for Object {
    type Envelope = AABB<[f32; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

/// The tree.
#[derive(Default)]
pub struct Rstar(RTree<Object>);

impl Engine for Rstar {
    fn update(&mut self, boxes: &[Aabb3d]) {
        let objects = boxes.iter().enumerate().map(|(i, aabb)| Object {
            number: i as u32,
            envelope: AABB::from_corners(aabb.min.to_array(), aabb.max.to_array()),
        });
        self.0 = RTree::bulk_load(objects.collect());
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        // The join gives each pair in both orders, and each object with itself.
        pairs.extend(
            self.0
                .intersection_candidates_with_other_tree(&self.0)
                .filter(|(a, b)| a.number < b.number)
                .map(|(a, b)| (a.number, b.number)),
        );
    }
}
