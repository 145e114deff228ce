//! Warnings in the log.

use std::{
    fmt::Debug,
    mem::take,
    sync::{Arc, LazyLock, Mutex},
};

use bevy::{
    ecs::schedule::{ScheduleLabel, SingleThreadedExecutor},
    prelude::*,
};
use tracing::{
    Dispatch, Event, Level, Metadata, Subscriber,
    field::{Field, Visit},
    span, subscriber,
};

/// While there is one subscriber, `tracing` lets the thread that comes to a warning first say
/// whether anybody wants it, for good and for all threads: another test that runs at the time, and
/// does not listen. With two, it asks both.
static SECOND: LazyLock<Dispatch> = LazyLock::new(|| Dispatch::new(Listener::default()));

#[derive(Clone, Default)]
struct Listener(Arc<Mutex<Vec<String>>>);

impl Subscriber for Listener {
    fn enabled(&self, metadata: &Metadata) -> bool {
        *metadata.level() == Level::WARN && metadata.target().starts_with("bevy_octree")
    }

    fn new_span(&self, _: &span::Attributes) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event) {
        let mut message = Message(String::new());
        event.record(&mut message);
        self.0.lock().expect("nobody panics").push(message.0);
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, _: &Field, value: &dyn Debug) {
        self.0 += &format!("{value:?}");
    }
}

/// Has a schedule run on this thread: who listens to the log hears that alone.
pub fn on_this_thread(app: &mut App, schedule: impl ScheduleLabel) {
    app.edit_schedule(schedule, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
}

/// The warnings of the crate's that this thread logs meanwhile.
pub fn told(act: impl FnOnce()) -> Vec<String> {
    LazyLock::force(&SECOND);
    let listener = Listener::default();
    subscriber::with_default(listener.clone(), act);
    take(&mut *listener.0.lock().expect("nobody panics"))
}

/// How many warnings of the crate's this thread logs meanwhile.
pub fn warnings(act: impl FnOnce()) -> usize {
    told(act).len()
}
