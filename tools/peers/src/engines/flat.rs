//! No structure at all: brute force, and the floor.

use std::hint::black_box;

use bevy::math::bounding::Aabb3d;

use super::{Engine, Pair, overlap};

/// More objects than this, and every box against every other takes too long to wait for.
pub const MOST: usize = 8000;

/// Every box against every other, in the order in which they stand in memory.
#[derive(Default)]
pub struct Brute(Vec<Aabb3d>);

impl Engine for Brute {
    fn update(&mut self, boxes: &[Aabb3d]) {
        self.0.clear();
        self.0.extend_from_slice(boxes);
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in self.0.iter().enumerate().skip(i + 1) {
                if overlap(a, b) {
                    pairs.push((i as u32, j as u32));
                }
            }
        }
    }
}

/// Reads every box and writes one word: what nobody who looks at all boxes can go below.
#[derive(Default)]
pub struct Floor(u32);

impl Engine for Floor {
    fn update(&mut self, boxes: &[Aabb3d]) {
        let sum = boxes.iter().fold(bevy::math::Vec3A::ZERO, |sum, aabb| {
            sum + aabb.min + aabb.max
        });
        self.0 = black_box((sum.x + sum.y + sum.z).to_bits());
    }

    fn pairs(&mut self, _: &mut Vec<Pair>) {}
}
