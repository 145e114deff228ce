//! Warnings in the log, counted.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use tracing::{Event, Level, Metadata, Subscriber, span, subscriber};

struct Counter(Arc<AtomicUsize>);

impl Subscriber for Counter {
    fn enabled(&self, metadata: &Metadata) -> bool {
        *metadata.level() == Level::WARN && metadata.target().starts_with("bevy_octree")
    }

    fn new_span(&self, _: &span::Attributes) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, _: &Event) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// How many warnings of the crate's this thread logs meanwhile.
pub fn warnings(act: impl FnOnce()) -> usize {
    let count = Arc::new(AtomicUsize::new(0));
    subscriber::with_default(Counter(count.clone()), act);
    count.load(Ordering::Relaxed)
}
