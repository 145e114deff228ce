//! The scenes, as boxes frame by frame.

use std::{fmt, str::FromStr};

use bevy::math::bounding::Aabb3d;
use bevy_octree::scene::stress::{StressScene, StressSimulation};

/// A scene, and from when on it is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    scene: StressScene,
    /// Only once most objects rest.
    at_rest: bool,
}

/// What the name of a case ends with if it begins once most objects rest.
const AT_REST: &str = "-rest";
/// Most: this share of the objects.
const MOST: f32 = 0.9;
/// Ticks after which nobody waits any longer for rest.
const PATIENCE: usize = 5000;

impl Case {
    /// All cases: each scene from its beginning, and free fall once most boxes rest, too.
    pub fn all() -> Vec<Self> {
        let mut cases = vec![];
        for scene in StressScene::ALL {
            cases.push(Self {
                scene,
                at_rest: false,
            });
            if scene == StressScene::Freefall {
                cases.push(Self {
                    scene,
                    at_rest: true,
                });
            }
        }
        cases
    }

    /// The boxes of so many consecutive frames.
    pub fn frames(self, objects: usize, frames: usize, seed: u64) -> Vec<Vec<Aabb3d>> {
        let mut simulation = StressSimulation::new(self.scene, objects, seed);
        let mut recorded = vec![simulation.boxes().to_vec()];
        if self.at_rest {
            for _ in 0..PATIENCE {
                simulation.step();
                let resting = recorded[0]
                    .iter()
                    .zip(simulation.boxes())
                    .filter(|(old, new)| old == new)
                    .count();
                recorded[0].copy_from_slice(simulation.boxes());
                if resting as f32 >= MOST * objects as f32 {
                    break;
                }
            }
        }
        while recorded.len() < frames {
            simulation.step();
            recorded.push(simulation.boxes().to_vec());
        }
        recorded
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!(
            "{}{}",
            self.scene,
            if self.at_rest { AT_REST } else { "" }
        ))
    }
}

impl FromStr for Case {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let (scene, at_rest) = match name.strip_suffix(AT_REST) {
            Some(scene) => (scene, true),
            None => (name, false),
        };
        let scene = scene
            .parse()
            .map_err(|error: <StressScene as FromStr>::Err| error.to_string())?;
        Ok(Self { scene, at_rest })
    }
}
