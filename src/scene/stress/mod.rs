//! Stress scenes: many moving boxes, made to measure broad phases.
//!
//! A [`StressSimulation`] is nothing but boxes and a rule that moves them: no app, no entities. A [`StressScene`] names
//! one of ten rules; each strains another part of a broad phase.
//!
//! ```
//! use bevy_octree::scene::stress::{StressScene, StressSimulation};
//!
//! let mut simulation = StressSimulation::new("brownian".parse()?, 1000, 7);
//! let before = simulation.boxes().to_vec();
//! simulation.step();
//! assert_eq!(simulation.boxes().len(), 1000);
//! assert!(simulation.boxes() != before);
//! # Ok::<(), bevy_octree::scene::stress::UnknownScene>(())
//! ```
//!
//! # The scenes
//!
//! Lengths are in sides of a box, which is a cube of side 1 except in `sizes` and for the ground; speeds are per tick and axis. The last
//! column is the number of other boxes that a box overlaps on average, at the start unless said otherwise.
//!
//! | scene | what happens | speed | overlaps |
//! |---|---|---|---|
//! | [`brownian`](StressScene::Brownian) | random motion in a cube with walls; each velocity is drawn anew every 32nd tick | 0.05 to 0.1 | 1 |
//! | [`freefall`](StressScene::Freefall) | boxes fall onto a floor, eight to a column, and rest there: nine in ten within 100 ticks, the last within 1 100 | up to 0.5 | 0.6; about 3 at rest |
//! | [`gravity`](StressScene::Gravity) | a moving attractor pulls a cloud of boxes that fly about it | up to 1 | 1 |
//! | [`planes`](StressScene::Planes) | the two planes of the report's [`TestSet`](super::TestSet); cubes turn where they meet, and again where they came from | 1/16 | hardly any: now and then those of a ring |
//! | [`static90`](StressScene::Static90) | as `brownian`, but nine boxes in ten never move | 0.05 to 0.1 | 1 |
//! | [`sizes`](StressScene::Sizes) | as `brownian`, with sides from 1 to 1 000, log-uniform | 0.05 to 0.1 of the own side | 4 |
//! | [`clusters`](StressScene::Clusters) | as `brownian`, but nine boxes in ten are confined to nine cubes, together 1 % of the space | 0.05 to 0.1 | 2 in the clusters |
//! | [`ground`](StressScene::Ground) | as `brownian`, but one box is a ground that never moves, 20 000 wide and 1 high | 0.05 to 0.1 | 1, and the ground those at the bottom |
//! | [`outlier`](StressScene::Outlier) | as `brownian`, but in the fourth tick one box goes a million away along each axis, and rests there | 0.05 to 0.1 | 1 |
//! | [`rooms`](StressScene::Rooms) | as `brownian`, but in four rooms, each a cube with walls, 10 000 from each other | 0.05 to 0.1 | 1 |
//!
//! Space grows with the number of objects, so that all but `planes` are as dense at a million objects as at a thousand.
//! Objects come in no spatial order. A step takes O(n) time, a few nanoseconds per object.
//!
//! The arithmetic is addition, multiplication, division and square root alone, which round alike everywhere: the same
//! seed gives the same bits on any machine.

mod drift;
mod freefall;
mod gravity;
mod name;
mod planes;
mod random;

use bevy::math::bounding::Aabb3d;
use fastrand::Rng;

pub use name::{StressScene, UnknownScene};

/// Boxes that move by the rule of a [`StressScene`].
#[derive(Clone, Debug)]
pub struct StressSimulation {
    scene: StressScene,
    tick: u64,
    boxes: Vec<Aabb3d>,
    motion: Motion,
}

#[derive(Clone, Debug)]
enum Motion {
    Drift(drift::Drift),
    Freefall(freefall::Freefall),
    Gravity(gravity::Gravity),
    Planes(planes::Planes),
}

impl StressSimulation {
    /// Returns the scene at tick 0, with so many objects. The same seed gives the same simulation.
    #[must_use]
    pub fn new(scene: StressScene, objects: usize, seed: u64) -> Self {
        let rng = Rng::with_seed(seed);
        let drift = |(boxes, drift)| (boxes, Motion::Drift(drift));
        let (boxes, motion) = match scene {
            StressScene::Brownian => drift(drift::brownian(objects, rng)),
            StressScene::Static90 => drift(drift::static90(objects, rng)),
            StressScene::Sizes => drift(drift::sizes(objects, rng)),
            StressScene::Clusters => drift(drift::clusters(objects, rng)),
            StressScene::Ground => drift(drift::ground(objects, rng)),
            StressScene::Outlier => drift(drift::outlier(objects, rng)),
            StressScene::Rooms => drift(drift::rooms(objects, rng)),
            StressScene::Freefall => {
                let (boxes, freefall) = freefall::new(objects, rng);
                (boxes, Motion::Freefall(freefall))
            }
            StressScene::Gravity => {
                let (boxes, gravity) = gravity::new(objects, rng);
                (boxes, Motion::Gravity(gravity))
            }
            StressScene::Planes => {
                let (boxes, planes) = planes::new(objects, rng);
                (boxes, Motion::Planes(planes))
            }
        };
        Self { scene, tick: 0, boxes, motion }
    }

    /// Advances by one tick. The boxes of objects that do not move keep their bits. O(n).
    pub fn step(&mut self) {
        match &mut self.motion {
            Motion::Drift(drift) => drift.step(&mut self.boxes),
            Motion::Freefall(freefall) => freefall.step(&mut self.boxes),
            Motion::Gravity(gravity) => gravity.step(&mut self.boxes),
            Motion::Planes(planes) => planes.step(&mut self.boxes),
        }
        self.tick += 1;
    }

    /// Returns the boxes of this tick, in the order of the objects. All are finite.
    #[must_use]
    pub fn boxes(&self) -> &[Aabb3d] {
        &self.boxes
    }

    /// Returns the scene.
    #[must_use]
    pub const fn scene(&self) -> StressScene {
        self.scene
    }

    /// Returns how many steps were taken.
    #[must_use]
    pub const fn tick(&self) -> u64 {
        self.tick
    }
}

#[cfg(test)]
mod tests;
