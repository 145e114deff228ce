//! Which tick it is.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Counts ticks from zero: the runs of the schedule that the plugins are in. After tick
/// [`u64::MAX`], it is zero again.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Resource, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
pub struct CollisionClock {
    tick: u64,
}

impl CollisionClock {
    /// Returns the number of the current tick: 0 during the first, and one more after each.
    #[must_use]
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Sets the clock to another tick, as to play position tracks from another tick on.
    pub const fn set_tick(&mut self, tick: u64) {
        self.tick = tick;
    }

    pub(crate) fn advance(mut clock: ResMut<Self>) {
        clock.tick = clock.tick.wrapping_add(1);
    }
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<CollisionClock>()
        .register_type::<CollisionClock>();
}
