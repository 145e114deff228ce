//! How a character walks.

use std::f32::consts::PI;

use bevy::{math::ops, prelude::*};

use crate::move_and_slide::MoveSettings;

/// How exactly a normal is known.
const ROUNDING: f32 = 1e-4;

/// How a character walks: what is ground to it, and what it steps on.
///
/// Lengths are in world units, for somebody about 1.8 tall. A number that is negative, or not finite, counts as zero.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[doc(alias("CharacterAutostep", "floor_max_angle"))]
pub struct WalkSettings {
    /// Where up is. It need not be a unit vector; one that is zero or not finite counts as [`Vec3::Y`].
    pub up: Vec3,
    /// The steepest slope that is ground, in radians from the horizontal. It slides down what is steeper.
    pub max_slope: f32,
    /// How high a step may be that it climbs as it walks; 0 for none.
    #[doc(alias = "autostep")]
    pub step_height: f32,
    /// How far below it ground is sought when it was on the ground before, so that it goes down slopes and stairs without
    /// losing touch; 0 for no further than it stands.
    #[doc(alias("snap to ground", "floor_snap_length"))]
    pub snap: f32,
    /// Does it stop where there is no ground ahead, rather than fall?
    pub stop_at_ledges: bool,
    /// Is it turned around `up` by ground that turns?
    pub turn_with_ground: bool,
    /// How it moves among others.
    pub moves: MoveSettings,
}

impl Default for WalkSettings {
    fn default() -> Self {
        Self {
            up: Vec3::Y,
            max_slope: 50.0 * PI / 180.0,
            step_height: 0.3,
            snap: 0.3,
            stop_at_ledges: false,
            turn_with_ground: true,
            moves: MoveSettings::default(),
        }
    }
}

impl WalkSettings {
    /// The unit vector that is up.
    pub(super) fn upwards(&self) -> Vec3 {
        self.up.try_normalize().unwrap_or(Vec3::Y)
    }

    /// The least part of a normal along `up` that is ground.
    pub(super) fn flattest(&self) -> f32 {
        ops::cos(length(self.max_slope).min(PI / 2.0)) - ROUNDING
    }

    pub(super) fn step(&self) -> f32 {
        length(self.step_height)
    }

    pub(super) fn sought(&self) -> f32 {
        length(self.snap)
    }
}

/// A number that is to be a length.
fn length(number: f32) -> f32 {
    if number.is_finite() {
        number.max(0.0)
    } else {
        0.0
    }
}
