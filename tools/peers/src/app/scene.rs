//! What is in the apps.

use bevy::prelude::*;
use bevy_octree::scene::stress::{StressScene, StressSimulation};

/// How far a cube among static ones moves to and fro along each axis, in sides.
const REACH: f32 = 2.0;

/// Cubes that move, and cubes that never do.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// How many move: as in the `brownian` scene if there are no others, and otherwise to and fro
    /// where they are, far from each other.
    pub objects: usize,
    /// How many never do.
    pub statics: usize,
    /// Another seed gives another scene of the same kind.
    pub seed: u64,
}

/// What moves the cubes.
#[derive(Resource)]
pub enum Motion {
    /// The simulation knows all of them.
    Brownian(StressSimulation),
    /// Each goes to and fro, the same way in each tick.
    ToAndFro {
        /// By number: where a cube is in the middle of its way.
        homes: Vec<Vec3>,
        tick: u32,
    },
}

/// The number of a cube that moves.
#[derive(Component)]
pub struct Number(usize);

/// Where cubes are at first: those that move, and those that do not.
pub struct Places {
    pub moving: Vec<(Number, Transform)>,
    pub statics: Vec<Transform>,
}

impl Scene {
    /// Where all cubes are, and what moves them.
    pub fn begin(self) -> (Places, Motion) {
        let simulation = StressSimulation::new(
            StressScene::Brownian,
            self.objects + self.statics,
            self.seed,
        );
        let places = simulation
            .boxes()
            .iter()
            .map(|aabb| Vec3::from((aabb.min + aabb.max) * 0.5));
        if self.statics == 0 {
            let moving = places
                .enumerate()
                .map(|(i, place)| (Number(i), Transform::from_translation(place)));
            let places = Places {
                moving: moving.collect(),
                statics: vec![],
            };
            return (places, Motion::Brownian(simulation));
        }
        // Objects come in no spatial order: the first of them are anywhere.
        let places: Vec<Vec3> = places.collect();
        let (homes, statics) = places.split_at(self.objects);
        let moving = homes
            .iter()
            .enumerate()
            .map(|(i, home)| (Number(i), Transform::from_translation(*home)));
        let at_rest = statics.iter().copied().map(Transform::from_translation);
        let motion = Motion::ToAndFro {
            homes: homes.to_vec(),
            tick: 0,
        };
        let places = Places {
            moving: moving.collect(),
            statics: at_rest.collect(),
        };
        (places, motion)
    }
}

/// Moves every cube that does, in all apps alike.
pub fn move_cubes(mut motion: ResMut<Motion>, mut cubes: Query<(&Number, &mut Transform)>) {
    match &mut *motion {
        Motion::Brownian(simulation) => {
            simulation.step();
            let boxes = simulation.boxes();
            for (number, mut transform) in &mut cubes {
                let aabb = &boxes[number.0];
                transform.translation = ((aabb.min + aabb.max) * 0.5).into();
            }
        }
        Motion::ToAndFro { homes, tick } => {
            *tick += 1;
            for (number, mut transform) in &mut cubes {
                // Not all turn at the same time.
                let phase = *tick as f32 / 32.0 + number.0 as f32;
                transform.translation = homes[number.0] + Vec3::splat(REACH * phase.sin());
            }
        }
    }
}
