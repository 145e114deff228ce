//! Where characters should come to rest.

use bevy::{
    math::{Quat, Vec2, Vec3},
    transform::components::Transform,
};

use super::{Aim, Course, Place, Solid, Walker, block, standing};
use crate::characters::{HALF_LENGTH, RADIUS, SKIN};

const TICKS: usize = 300;
/// Between two of them.
const LANE: f32 = 20.0;
/// Of walls: their length, height and thickness.
const WALL: Vec3 = Vec3::new(8.0, 3.0, 1.0);
/// Of the slope, in degrees.
const SLOPE: f32 = 30.0;
/// The level of what has the edge, and how far beyond that the middle of the character is.
const EDGE: [f32; 2] = [1.0, 0.1];

pub fn place() -> Place {
    let mut solids = vec![block(
        Vec3::new(-LANE, -1.0, -LANE),
        Vec3::new(LANE, 0.0, 5.0 * LANE),
    )];
    let mut walkers = vec![];
    let mut stay = |name, start, heading: Vec2| {
        let course = Course::Straight(heading);
        let aim = Aim::Stay;
        walkers.push((name, Walker { start, course, aim }));
    };

    // Not along the middle of the right angle: one wall is pressed more than the other.
    corner(&mut solids, 90.0, 0.0);
    let askew = Vec2::from_angle(20f32.to_radians());
    stay("corner 90°", standing(1.5, 0.0, 0.0), -askew);
    corner(&mut solids, 20.0, LANE);
    stay("corner 20°", standing(4.0, 0.0, LANE), Vec2::NEG_X);
    let askew = Vec2::from_angle(7f32.to_radians());
    corner(&mut solids, 20.0, 2.0 * LANE);
    stay("corner 20°, askew", standing(4.0, 0.0, 2.0 * LANE), -askew);

    // A box through whose middle the floor goes, and the point above that.
    let turn = Quat::from_rotation_z(SLOPE.to_radians());
    let at = Transform::from_xyz(0.0, 0.0, 3.0 * LANE).with_rotation(turn);
    solids.push(Solid::Box(Vec3::new(5.0, 1.0, 5.0), at));
    let on_slope = at.translation + turn * Vec3::Y * (1.0 + RADIUS + SKIN);
    stay("slope 30°", on_slope + Vec3::Y * HALF_LENGTH, Vec2::ZERO);

    let [level, beyond] = EDGE;
    let z = 4.0 * LANE;
    solids.push(block(
        Vec3::new(-4.0, 0.0, z - 2.0),
        Vec3::new(0.0, level, z + 2.0),
    ));
    let lower = ((RADIUS + SKIN).powi(2) - beyond.powi(2)).sqrt();
    let start = Vec3::new(beyond, level + lower + HALF_LENGTH, z);
    stay("edge", start, Vec2::ZERO);

    Place {
        solids,
        walkers,
        lowest: 0.0,
        ticks: TICKS,
    }
}

/// Two walls that meet at x = 0, and open along x by an angle in degrees.
fn corner(solids: &mut Vec<Solid>, angle: f32, z: f32) {
    for side in [1.0, -1.0] {
        let turn = Quat::from_rotation_y(-side * (angle / 2.0).to_radians());
        // With the inner face along x, and its end at the middle, before it is turned.
        let center = Vec3::new(WALL.x, WALL.y, side * WALL.z) / 2.0;
        let at = Transform::from_translation(turn * center + Vec3::Z * z).with_rotation(turn);
        solids.push(Solid::Box(WALL / 2.0, at));
    }
}
