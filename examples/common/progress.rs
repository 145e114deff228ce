//! Progress on the terminal, for runs over a second.

use std::{
    fmt::Display,
    io::{IsTerminal, Write as _, stderr},
    time::{Duration, Instant},
};

/// Runs that take less show nothing.
const PATIENCE: Duration = Duration::from_secs(1);
/// The time between two changes of what is shown.
const PAUSE: Duration = Duration::from_millis(100);

/// A bar on standard error if that is a terminal. It appears once a second has passed, and goes
/// with its owner.
pub struct Progress {
    pieces: u64,
    begun: u64,
    started: Instant,
    /// When to show what has changed; never, if there is no terminal.
    due: Option<Instant>,
    is_shown: bool,
}

impl Progress {
    /// Progress over so many pieces of work.
    pub fn new(pieces: u64) -> Self {
        let started = Instant::now();
        let due = stderr().is_terminal().then(|| started + PATIENCE);
        Self {
            pieces,
            begun: 0,
            started,
            due,
            is_shown: false,
        }
    }

    /// The next piece of work begins, and the one before it has ended.
    pub fn begin(&mut self, what: impl Display) {
        let done = self.begun;
        self.begun += 1;
        let now = Instant::now();
        if self.due.is_none_or(|due| now < due) {
            return;
        }
        let elapsed = (now - self.started).as_secs_f64();
        let share = done as f64 / self.pieces.max(1) as f64;
        let left = if done == 0 {
            String::new()
        } else {
            format!(" (about {:.0} s left)", elapsed / share - elapsed)
        };
        let bar = "█".repeat((share * 30.0) as usize);
        // The terminal does not wrap the line: what has no room at its end is left out.
        show(format_args!(
            "\x1b[?7l{bar:░<30} {done}/{}  {elapsed:.0} s{left}  {what}\x1b[?7h",
            self.pieces
        ));
        self.due = Some(now + PAUSE);
        self.is_shown = true;
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.is_shown {
            show("");
        }
    }
}

/// Puts a line where the last one was. That it cannot be shown is no reason to fail.
fn show(line: impl Display) {
    let mut terminal = stderr().lock();
    _ = write!(terminal, "\r\x1b[2K{line}").and_then(|()| terminal.flush());
}
