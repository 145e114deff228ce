//! The scenes, as boxes frame by frame.

use std::{fmt, str::FromStr};

use bevy::math::bounding::Aabb3d;

use self::stress::{StressScene, StressSimulation};

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
const MOST: f32 = 0.8;
/// Ticks after which nobody waits any longer for rest.
const PATIENCE: usize = 5000;

impl Case {
    /// All cases: each scene from its beginning, and free fall once most boxes rest, too.
    pub fn all() -> Vec<Self> {
        let mut cases = vec![];
        for scene in StressScene::ALL {
            cases.push(Self { scene, at_rest: false });
            if scene == StressScene::Freefall {
                cases.push(Self { scene, at_rest: true });
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
                let resting = recorded[0].iter().zip(simulation.boxes()).filter(|(old, new)| old == new).count();
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
        f.pad(&format!("{}{}", self.scene, if self.at_rest { AT_REST } else { "" }))
    }
}

impl FromStr for Case {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let (scene, at_rest) = match name.strip_suffix(AT_REST) {
            Some(scene) => (scene, true),
            None => (name, false),
        };
        let scene = scene.parse().map_err(|error: <StressScene as FromStr>::Err| error.to_string())?;
        Ok(Self { scene, at_rest })
    }
}

/// Stand-in until the crate's own module of this name is there.
pub mod stress {
    use bevy::math::{Vec3, bounding::Aabb3d};
    use std::fmt;

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum StressScene {
        Brownian,
        Freefall,
        Static90,
    }

    impl StressScene {
        pub const ALL: [Self; 3] = [Self::Brownian, Self::Freefall, Self::Static90];
    }

    impl fmt::Display for StressScene {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.pad(&format!("{self:?}").to_lowercase())
        }
    }

    impl std::str::FromStr for StressScene {
        type Err = String;
        fn from_str(name: &str) -> Result<Self, String> {
            Self::ALL.into_iter().find(|s| s.to_string() == name).ok_or(format!("unknown scene `{name}`"))
        }
    }

    pub struct StressSimulation {
        scene: StressScene,
        boxes: Vec<Aabb3d>,
        velocities: Vec<Vec3>,
        world: f32,
        random: fastrand::Rng,
    }

    impl StressSimulation {
        pub fn new(scene: StressScene, objects: usize, seed: u64) -> Self {
            let mut random = fastrand::Rng::with_seed(seed);
            // One overlap each: a box of side 1 overlaps those whose centre is in a cube of side 2 about its own.
            let world = (objects as f32 * 8.0).cbrt();
            let mut unit = || Vec3::new(random.f32(), random.f32(), random.f32());
            let boxes = (0..objects).map(|_| Aabb3d::new(unit() * world, Vec3::splat(0.5))).collect();
            let velocities = (0..objects).map(|_| (unit() - 0.5) * 0.1).collect();
            Self { scene, boxes, velocities, world, random }
        }

        pub fn boxes(&self) -> &[Aabb3d] {
            &self.boxes
        }

        pub fn step(&mut self) {
            for (i, (aabb, velocity)) in self.boxes.iter_mut().zip(&mut self.velocities).enumerate() {
                let moves = match self.scene {
                    StressScene::Brownian => true,
                    StressScene::Freefall => aabb.min.y > 0.0,
                    StressScene::Static90 => i % 10 == 0,
                };
                if !moves {
                    continue;
                }
                if self.scene == StressScene::Freefall {
                    velocity.y -= 0.01;
                } else if self.random.f32() < 0.02 {
                    *velocity = (Vec3::new(self.random.f32(), self.random.f32(), self.random.f32()) - 0.5) * 0.1;
                }
                let center = (aabb.min + aabb.max) * 0.5;
                for axis in 0..3 {
                    if center[axis] < 0.0 || center[axis] > self.world {
                        velocity[axis] = velocity[axis].abs() * (self.world / 2.0 - center[axis]).signum();
                    }
                }
                aabb.min += bevy::math::Vec3A::from(*velocity);
                aabb.max += bevy::math::Vec3A::from(*velocity);
            }
        }
    }
}
