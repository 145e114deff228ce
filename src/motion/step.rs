//! How much time passes in a tick.

use bevy::prelude::*;

/// The settings of motion, as a resource: how long a tick is.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct MotionSettings {
    /// The time that passes in a tick.
    pub step: Step,
}

/// The time that passes in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub enum Step {
    /// What [`Time`] says in the schedule that the plugins are in: the fixed timestep in fixed
    /// schedules. Nothing if the app has no `Time`.
    #[default]
    Time,
    /// So many seconds, whatever the time. A number that is negative or not finite lets no time
    /// pass, with a warning in the log.
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

pub(super) fn register(app: &mut App) {
    app.init_resource::<MotionSettings>()
        .register_type::<MotionSettings>();
}
