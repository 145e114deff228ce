//! Boxes that move.

use bevy::math::bounding::Aabb3d;
use fastrand::Rng;

use super::{
    drift::{self, Drift},
    freefall::{self, Freefall},
    gravity::{self, Gravity},
    name::StressScene,
    planes::{self, Planes},
};

/// Boxes that move by the rule of a [`StressScene`].
#[derive(Clone, Debug)]
pub struct StressSimulation {
    scene: StressScene,
    tick: u64,
    boxes: Vec<Aabb3d>,
    rule: Rule,
}

#[derive(Clone, Debug)]
enum Rule {
    Drift(Drift),
    Freefall(Freefall),
    Gravity(Gravity),
    Planes(Planes),
}

impl StressSimulation {
    /// Returns the scene at tick 0, with so many objects. The same seed gives the same simulation.
    #[must_use]
    pub fn new(scene: StressScene, objects: usize, seed: u64) -> Self {
        let rng = Rng::with_seed(seed);
        let drift = |(boxes, drift)| (boxes, Rule::Drift(drift));
        let (boxes, rule) = match scene {
            StressScene::Brownian => drift(drift::brownian(objects, rng)),
            StressScene::Static90 => drift(drift::static90(objects, rng)),
            StressScene::Sizes => drift(drift::sizes(objects, rng)),
            StressScene::Clusters => drift(drift::clusters(objects, rng)),
            StressScene::Ground => drift(drift::ground(objects, rng)),
            StressScene::Outlier => drift(drift::outlier(objects, rng)),
            StressScene::Rooms => drift(drift::rooms(objects, rng)),
            StressScene::Freefall => {
                let (boxes, freefall) = freefall::new(objects, rng);
                (boxes, Rule::Freefall(freefall))
            }
            StressScene::Gravity => {
                let (boxes, gravity) = gravity::new(objects, rng);
                (boxes, Rule::Gravity(gravity))
            }
            StressScene::Planes => {
                let (boxes, planes) = planes::new(objects, rng);
                (boxes, Rule::Planes(planes))
            }
        };
        Self {
            scene,
            tick: 0,
            boxes,
            rule,
        }
    }

    /// Advances by one tick. The boxes of objects that do not move keep their bits. O(n).
    pub fn step(&mut self) {
        match &mut self.rule {
            Rule::Drift(drift) => drift.step(&mut self.boxes),
            Rule::Freefall(freefall) => freefall.step(&mut self.boxes),
            Rule::Gravity(gravity) => gravity.step(&mut self.boxes),
            Rule::Planes(planes) => planes.step(&mut self.boxes),
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
