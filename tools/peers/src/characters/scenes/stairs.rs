//! Flights of steps.

use bevy::math::{Vec2, Vec3};

use super::{Aim, Course, Extent, Place, Walker, block, standing};
use crate::characters::{SPEED, TICK};

/// How high the steps of each flight are, with its names: up and down.
const FLIGHTS: [(f32, [&str; 2]); 3] = [
    (0.1, ["0.1 up", "0.1 down"]),
    (0.2, ["0.2 up", "0.2 down"]),
    (0.3, ["0.3 up", "0.3 down"]),
];
const STEPS: u32 = 10;
const DEPTH: f32 = 0.3;
const WIDTH: f32 = 3.0;
/// Between two flights.
const LANE: f32 = 6.0;
/// Before the first step, and behind the last way.
const SPARE: f32 = 2.0;

pub fn place(extent: Extent) -> Place {
    let way = SPEED * TICK * extent.ticks as f32 + SPARE;
    let flight = STEPS as f32 * DEPTH;
    let lanes = 2.0 * FLIGHTS.len() as f32;
    let mut solids = vec![block(
        Vec3::new(-way - SPARE, -1.0, -LANE),
        Vec3::new(flight + way, 0.0, lanes * LANE),
    )];
    let mut walkers = vec![];
    let mut lane = 0.0;
    for (height, names) in FLIGHTS {
        for (is_down, name) in [false, true].into_iter().zip(names) {
            // Each step goes on under those above it; the last is as long as the way.
            for step in 0..STEPS {
                let [front, level] = [step as f32 * DEPTH, (step + 1) as f32 * height];
                let side = WIDTH / 2.0;
                solids.push(block(
                    Vec3::new(front, level - height, lane - side),
                    Vec3::new(flight + way, level, lane + side),
                ));
            }
            walkers.push(if is_down {
                let start = standing(flight + SPARE / 2.0, STEPS as f32 * height, lane);
                let course = Course::Straight(Vec2::NEG_X);
                let aim = Aim::Descend;
                (name, Walker { start, course, aim })
            } else {
                let start = standing(-SPARE / 2.0, 0.0, lane);
                let course = Course::Straight(Vec2::X);
                let aim = Aim::Climb(STEPS, height);
                (name, Walker { start, course, aim })
            });
            lane += LANE;
        }
    }
    Place {
        solids,
        walkers,
        lowest: 0.0,
        ticks: extent.ticks,
    }
}
