//! A progress bar on the terminal, for runs over a second.

use std::{
    borrow::Cow,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Runs that take less show no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar on standard error if that is a terminal. It appears once a second has passed, and goes with its owner.
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    begun: u64,
}

impl Progress {
    /// Progress over so many pieces of work.
    pub fn new(pieces: u64) -> Self {
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {elapsed} (about {eta} left)  {wide_msg}");
        let bar = ProgressBar::with_draw_target(Some(pieces), ProgressDrawTarget::hidden());
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Self { bar, started: Instant::now(), begun: 0 }
    }

    /// The next piece of work begins, and the one before it has ended.
    pub fn begin(&mut self, what: impl Into<Cow<'static, str>>) {
        if self.bar.is_hidden() && self.started.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_message(what);
        self.bar.set_position(self.begun);
        self.begun += 1;
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
