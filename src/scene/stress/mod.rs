//! Stress scenes: many moving boxes, made to measure broad phases.
//!
//! A [`StressSimulation`] is nothing but boxes and a rule that moves them: no app, no entities. A
//! [`StressScene`] names one of ten rules; each strains another part of a broad phase.
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
//! Lengths are in sides of a box, which is a cube of side 1 except in `sizes` and for the ground;
//! speeds are per tick and axis. The last column is the number of other boxes that a box overlaps
//! on average, at the start unless said otherwise.
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
//! Space grows with the number of objects, so that all but `planes` are as dense at a million
//! objects as at a thousand. Objects come in no spatial order. A step takes O(n) time, a few
//! nanoseconds per object.
//!
//! The arithmetic is addition, multiplication, division and square root alone, which round alike
//! everywhere: the same seed gives the same bits on any machine.

mod drift;
mod freefall;
mod gravity;
mod name;
mod planes;
mod random;
mod simulation;

pub use name::{StressScene, UnknownScene};
pub use simulation::StressSimulation;

#[cfg(test)]
mod tests;
