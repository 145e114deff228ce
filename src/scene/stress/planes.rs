//! The report's planes of cubes.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fastrand::Rng;

use super::random::shuffle;
use crate::scene::test_set::{Plane, TestSet};

/// Two planes of cubes. A cube turns round where it meets the one opposite, and again where it came
/// from, for ever.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    cubes: Vec<Cube>,
}

#[derive(Clone, Copy, Debug)]
struct Cube {
    velocity: f32,
    /// The x of the lower corner at the start.
    start: f32,
}

pub(super) fn new(objects: usize, mut rng: Rng) -> (Vec<Aabb3d>, Planes) {
    let left = objects.div_ceil(2);
    let set = TestSet::new(rings_for(left));
    // The innermost cubes of each plane, so that all but an odd one have a counterpart.
    let in_use = |plane| {
        if plane == Plane::Left {
            left
        } else {
            objects - left
        }
    };
    let mut cubes: Vec<_> = set
        .cubes()
        .filter(|cube| cube.index < in_use(cube.plane))
        .collect();
    shuffle(&mut rng, &mut cubes);
    let boxes: Vec<_> = cubes
        .iter()
        .map(|cube| {
            let min = Vec3A::from(cube.position) - 0.5 * set.side;
            Aabb3d {
                min,
                max: min + set.side,
            }
        })
        .collect();
    let cubes = cubes.iter().zip(&boxes).map(|(cube, aabb)| Cube {
        velocity: cube.velocity.x,
        start: aabb.min.x,
    });
    let cubes = cubes.collect();
    (boxes, Planes { cubes })
}

impl Planes {
    pub(super) fn step(&mut self, boxes: &mut [Aabb3d]) {
        for (cube, aabb) in self.cubes.iter_mut().zip(boxes) {
            // The cube opposite is its mirror image: they meet at x = 0. All numbers are multiples
            // of 1/32, and exact.
            let meets = aabb.min.x <= 0.0 && aabb.max.x >= 0.0;
            if meets || aabb.min.x == cube.start {
                let toward_middle = cube.velocity.abs().copysign(-cube.start);
                cube.velocity = if meets { -toward_middle } else { toward_middle };
            }
            aabb.min.x += cube.velocity;
            aabb.max.x += cube.velocity;
        }
    }
}

/// The least number of rings whose planes have so many cubes each.
fn rings_for(cubes: usize) -> u32 {
    (0..)
        .find(|rings| (2 * *rings as usize + 1).pow(2) >= cubes)
        .unwrap_or(u32::MAX)
}
