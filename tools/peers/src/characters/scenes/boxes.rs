//! A floor with boxes on it.

use std::f32::consts::TAU;

use bevy::{
    math::{EulerRot, Quat, Vec3},
    transform::components::Transform,
};

use super::{Aim, Course, Extent, Place, Solid, Walker, block, standing};
use crate::characters::{RADIUS, judge::Judge};

const BOXES: usize = 1000;
/// Half the length of the floor.
const HALF: f32 = 75.0;
/// How far from its rim nobody walks.
const RIM: f32 = 5.0;
/// This share of the boxes is to step on, and this share of the others leans.
const SHARES: [f32; 2] = [0.3, 0.2];
/// So much room has a character at first.
const ROOM: f64 = 0.1;

pub fn place(extent: Extent) -> Place {
    let mut random = fastrand::Rng::with_seed(extent.seed);
    let mut between = |low: f32, high: f32| low + (high - low) * random.f32();
    let mut solids = vec![block(
        Vec3::new(-HALF, -1.0, -HALF),
        Vec3::new(HALF, 0.0, HALF),
    )];
    for _ in 0..BOXES {
        let [x, z] = [0; 2].map(|_| between(-HALF, HALF));
        let [is_step, is_leaning] = SHARES.map(|share| between(0.0, 1.0) < share);
        let [length, width] = [0; 2].map(|_| between(0.5, 3.5));
        let height = if is_step {
            between(0.1, 0.25)
        } else {
            between(1.0, 3.0)
        };
        let mut turn = Quat::from_rotation_y(between(0.0, TAU));
        if is_leaning && !is_step {
            let [tilt, roll] = [0; 2].map(|_| between(-0.6, 0.6));
            turn *= Quat::from_euler(EulerRot::XZY, tilt, roll, 0.0);
        }
        let at = Transform::from_xyz(x, height / 2.0, z).with_rotation(turn);
        solids.push(Solid::Box(Vec3::new(length, height, width) / 2.0, at));
    }
    let judge = Judge::new(&solids);
    let reach = HALF - RIM;
    let mut random = fastrand::Rng::with_seed(!extent.seed);
    let mut walker = || {
        let start = loop {
            let [x, z] = [0; 2].map(|_| (random.f32() * 2.0 - 1.0) * reach);
            // High enough above the floor for the room that is asked for.
            let start = standing(x, RADIUS / 2.0, z);
            if judge.gap(start) > ROOM {
                break start;
            }
        };
        let course = Course::wander(random.u64(..), reach);
        let aim = Aim::Way;
        ("", Walker { start, course, aim })
    };
    Place {
        walkers: (0..extent.characters).map(|_| walker()).collect(),
        solids,
        lowest: 0.0,
        ticks: extent.ticks,
    }
}
