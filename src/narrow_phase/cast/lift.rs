//! How shapes are lifted off what they start in touch with, so that what is ahead can be met.

use bevy::math::Vec3;

use crate::narrow_phase::settings::NarrowPhase;

/// So often at most is a shape lifted: off a floor, off the walls of a corner, and off what is close
/// to these.
pub const MOST_LIFTS: usize = 8;

/// How far beyond what it touches it is lifted, in tolerances: no longer in touch.
const LIFT: f32 = 2.5;

/// What rounding makes of a position, as a share of it.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// How far beyond the depth of a contact a shape is lifted that is at a position.
pub fn margin(tests: &NarrowPhase, position: Vec3) -> f32 {
    LIFT * tests.tolerance() + ROUNDING * position.length()
}
