//! Change ticks of whole tables: which rows changed since a system last ran.

use bevy::ecs::change_detection::{ContiguousMut, ContiguousRef, Tick};

/// So many rows of a table make a job of their own.
pub(crate) const ROWS: usize = 4096;
/// So many rows are passed over at once where none of them changed.
pub(crate) const GROUP: usize = 64;

/// The time since a system last ran.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SinceLastRun {
    last_run: Tick,
    this_run: Tick,
}

impl SinceLastRun {
    /// That of the system which reads this column.
    pub(crate) fn of<T>(column: &ContiguousRef<'_, T>) -> Self {
        Self {
            last_run: column.last_run_tick(),
            this_run: column.this_run_tick(),
        }
    }

    /// That of the system which writes to this column.
    pub(crate) fn of_mut<T>(column: &ContiguousMut<'_, T>) -> Self {
        Self {
            last_run: column.last_run_tick(),
            this_run: column.this_run_tick(),
        }
    }

    /// What changes in this run is given this tick.
    pub(crate) const fn this_run(self) -> Tick {
        self.this_run
    }

    /// Did what was last changed at this tick change since?
    #[inline]
    pub(crate) fn changed(self, tick: Tick) -> bool {
        tick.is_newer_than(self.last_run, self.this_run)
    }

    /// Did any of these? Without a branch, for the vector instructions of the machine.
    #[inline]
    pub(crate) fn any_changed(self, ticks: &[Tick]) -> bool {
        ticks
            .iter()
            .fold(false, |any, tick| any | self.changed(*tick))
    }
}
