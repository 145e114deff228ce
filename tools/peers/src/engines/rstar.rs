//! rstar: an R*-tree, bulk-loaded each frame and joined with itself. Moving objects by removal and
//! insertion takes it several times longer.

use bevy::math::bounding::Aabb3d;
use rstar::{AABB, RTree, RTreeObject};

use super::{Engine, Pair};

/// An object in the tree.
pub struct Object {
    /// Its number.
    pub number: u32,
    /// Its box.
    pub envelope: AABB<[f32; 3]>,
}

impl RTreeObject for Object {
    type Envelope = AABB<[f32; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

/// A box in rstar's terms.
pub fn envelope_of(aabb: &Aabb3d) -> AABB<[f32; 3]> {
    AABB::from_corners(aabb.min.to_array(), aabb.max.to_array())
}

/// The tree of these boxes, built at once.
pub fn load(boxes: &[Aabb3d]) -> RTree<Object> {
    let object = |(number, aabb)| Object {
        number,
        envelope: envelope_of(aabb),
    };
    RTree::bulk_load((0..).zip(boxes).map(object).collect())
}

/// The tree.
#[derive(Default)]
pub struct Rstar(RTree<Object>);

impl Engine for Rstar {
    fn update(&mut self, boxes: &[Aabb3d]) {
        self.0 = load(boxes);
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
