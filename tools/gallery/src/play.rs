//! When ticks run: pause, single steps, speed.

use bevy::{ecs::schedule::ScheduleLabel, prelude::*};

/// A tick of the scene: collision detection, and whatever else moves things. It runs as often in a
/// frame as [`Play`] says.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tick;

/// How many ticks there are in a second, at speed 1.
pub const TICKS_PER_SECOND: f32 = 64.0;

/// More than that are left out, where the machine does not keep up.
const MOST_PER_FRAME: u32 = 8;

/// Whether ticks run, and how fast.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Play {
    /// Whether ticks wait until they are asked for.
    pub is_paused: bool,
    /// How many ticks are asked for, paused or not.
    pub pending: u32,
    /// How fast, 1 for 64 ticks in a second.
    pub speed: f32,
    /// How many ticks the scene has had.
    pub tick: u64,
    /// The part of a tick that is left of the last frame.
    rest: f32,
}

impl Default for Play {
    fn default() -> Self {
        Self {
            is_paused: false,
            pending: 0,
            speed: 1.0,
            tick: 0,
            rest: 0.0,
        }
    }
}

impl Play {
    /// The slowest and the fastest.
    pub const SPEEDS: [f32; 2] = [0.125, 4.0];

    /// Returns what runs so fast.
    pub fn at_speed(speed: f32) -> Self {
        Self {
            speed,
            ..Self::default()
        }
    }

    /// Back to tick 0.
    pub const fn begin(&mut self) {
        self.tick = 0;
        self.rest = 0.0;
        self.pending = 0;
    }

    /// Makes it faster, or slower, within its limits.
    pub const fn multiply_speed(&mut self, by: f32) {
        let [slowest, fastest] = Self::SPEEDS;
        self.speed = (self.speed * by).clamp(slowest, fastest);
    }

    /// The number of ticks of a frame that took so long.
    fn due(&mut self, seconds: f32) -> u32 {
        let mut due = std::mem::take(&mut self.pending);
        if !self.is_paused {
            self.rest += seconds * self.speed * TICKS_PER_SECOND;
            let whole = self.rest.floor();
            self.rest -= whole;
            due += whole as u32;
        }
        due.min(MOST_PER_FRAME)
    }
}

/// Runs the ticks that are due in this frame.
pub fn run_ticks(world: &mut World) {
    let seconds = world.resource::<Time<Real>>().delta_secs();
    let due = world.resource_mut::<Play>().due(seconds);
    for _ in 0..due {
        world.run_schedule(Tick);
        world.resource_mut::<Play>().tick += 1;
    }
}

/// The condition that ticks ran since it was last asked.
pub fn ticked(play: Res<Play>, mut last: Local<u64>) -> bool {
    std::mem::replace(&mut *last, play.tick) != play.tick
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_has_the_ticks_of_its_time() {
        let mut play = Play::default();
        // Two and a half ticks, twice.
        assert_eq!([play.due(2.5 / 64.0), play.due(2.5 / 64.0)], [2, 3]);
        play.speed = 0.5;
        assert_eq!([play.due(1.0 / 64.0), play.due(1.0 / 64.0)], [0, 1]);
        assert_eq!(play.due(100.0), MOST_PER_FRAME);
        play.is_paused = true;
        play.pending = 1;
        assert_eq!([play.due(1.0), play.due(1.0)], [1, 0]);
    }

    #[test]
    fn speed_has_limits() {
        let mut play = Play::default();
        play.multiply_speed(100.0);
        assert_eq!(play.speed, 4.0);
        play.multiply_speed(1e-6);
        assert_eq!(play.speed, 0.125);
    }
}
