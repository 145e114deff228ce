//! Motion: velocities, position tracks and the clock (Swan 1994, sections 1.2 and 1.3).

mod clock;
mod step;
mod track;
mod velocity;

use bevy::prelude::*;

pub use clock::CollisionClock;
pub use step::{MotionSettings, Step};
pub use track::{Interpolation, Outside, PositionTrack, TrackError, TrackStart};
pub(crate) use velocity::is_moved_by_velocity;
pub use velocity::{MovedElsewhere, Velocity};

use crate::schedule::{CollisionSystems, add_to_tick};

/// The plugin that moves entities by their [`Velocity`] or [`PositionTrack`], in the set
/// [`Motion`](CollisionSystems::Motion).
///
/// Where a system of your own moves them, it belongs into that set, or before it. Bounces of
/// [swept](crate::swept::Swept) entities go on for the rest of a tick by `Velocity`, and by the
/// step of the [`MotionSettings`]: let it take its step from these, or mark what it moves with
/// [`MovedElsewhere`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        register(app);
        add_to_tick(app, |app, schedule| {
            let move_all = (velocity::move_by_velocity, track::follow_tracks).chain();
            app.add_systems(schedule, move_all.in_set(CollisionSystems::Motion));
        });
    }
}

/// Everything but the systems: what others read, though nothing moves entities.
pub(crate) fn register(app: &mut App) {
    for register in [
        clock::register,
        step::register,
        track::register,
        velocity::register,
    ] {
        register(app);
    }
}
