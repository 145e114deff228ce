//! Motion: velocities, position tracks and the clock (Swan 1994, sections 1.2 and 1.3).

mod clip;
mod track;

use bevy::prelude::*;

use crate::schedule::{CollisionSystems, add_to_tick};
pub use clip::{CollisionReport, Interval, PairContacts, TickOutOfOrder};
pub use track::{Interpolation, Outside, PositionTrack, TrackError};

/// How fast and where to an entity moves, in units per second, in the space of its parent.
///
/// Contacts count with its velocity in the world, to which that of each ancestor adds: one that is moved by other means than
/// its velocity may have one beside [`MovedElsewhere`], which says how fast it is.
///
/// The report gives each object a direction and a speed; this is their product. A velocity that is not finite moves
/// nothing, with a warning in the log.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect, Deref, DerefMut)]
#[reflect(Component, Debug, Default, PartialEq)]
#[require(Transform)]
pub struct Velocity(pub Vec3);

/// The entity's [`Velocity`] says how it moves, but something else moves it: a system of your own, a physics engine.
/// Contacts change the velocity all the same.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct MovedElsewhere;

/// Counts ticks from zero: the runs of the schedule that the plugins are in. After tick [`u64::MAX`], it is zero again.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct CollisionClock {
    tick: u64,
}

impl CollisionClock {
    /// The number of the current tick: 0 during the first, and one more after each.
    #[must_use]
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Sets the clock, as to play position tracks from another tick on.
    pub const fn set_tick(&mut self, tick: u64) {
        self.tick = tick;
    }

    pub(crate) fn advance(mut clock: ResMut<Self>) {
        clock.tick = clock.tick.wrapping_add(1);
    }
}

/// Settings of the motion.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct MotionSettings {
    /// How much time passes in a tick.
    pub step: Step,
}

/// How much time passes in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum Step {
    /// What [`Time`] says in the schedule that the plugins are in: the fixed timestep in fixed schedules. Nothing if
    /// the app has no `Time`.
    #[default]
    Time,
    /// So many seconds, whatever the time. A number that is negative or not finite lets no time pass, with a warning
    /// in the log.
    Seconds(f32),
}

impl Step {
    /// The seconds of a tick; `None` for a step that is negative or not finite.
    pub(crate) fn seconds(self, time: Option<&Time>) -> Option<f32> {
        match self {
            Self::Time => Some(time.map_or(0.0, Time::delta_secs)),
            Self::Seconds(seconds) => (seconds.is_finite() && seconds >= 0.0).then_some(seconds),
        }
    }
}

/// Moves entities, each tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<PositionTrack>().register_type::<MovedElsewhere>();
        add_to_tick(app, |app, schedule| {
            let move_all = (move_by_velocity, follow_tracks).chain();
            app.add_systems(schedule, move_all.in_set(CollisionSystems::Motion));
        });
    }
}

/// Entities on a track go where the track says, whatever their velocity.
fn follow_tracks(mut followers: Query<(&PositionTrack, &mut Transform)>, clock: Res<CollisionClock>) {
    for (track, mut transform) in &mut followers {
        let position = track.position(clock.tick());
        // What does not move must not count as changed.
        if transform.translation != position {
            transform.translation = position;
        }
    }
}

/// Beside a [`Velocity`].
type MovedByVelocity = (Without<PositionTrack>, Without<MovedElsewhere>);

/// Does [`move_by_velocity`] move this entity?
pub(crate) fn is_moved_by_velocity(entity: EntityRef) -> bool {
    entity.contains::<Velocity>() && !entity.contains::<PositionTrack>() && !entity.contains::<MovedElsewhere>()
}

fn move_by_velocity(
    mut moving: Query<(Entity, &Velocity, &mut Transform), MovedByVelocity>,
    settings: Res<MotionSettings>,
    time: Option<Res<Time>>,
    mut warned: Local<bool>,
) {
    let Some(seconds) = settings.step.seconds(time.as_deref()) else {
        if !std::mem::replace(&mut *warned, true) {
            tracing::warn!("nothing moves: the step is {:?}, expected seconds, finite and not negative", settings.step);
        }
        return;
    };
    *warned = false;
    for (entity, velocity, mut transform) in &mut moving {
        // What does not move must not count as changed.
        if velocity.0 == Vec3::ZERO || seconds == 0.0 {
            continue;
        }
        if velocity.0.is_finite() {
            transform.translation += velocity.0 * seconds;
        } else {
            tracing::warn!("{entity} does not move: its velocity is {}", velocity.0);
        }
    }
}
