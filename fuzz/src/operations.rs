//! Histories: of an index of boxes, and of a whole app, checked after each step against all pairs.

mod app;
mod index;

use crate::source::Source;

/// Reads the bytes as a history of the one, or of the other.
pub fn run(bytes: &[u8]) {
    let mut source = Source::new(bytes);
    if source.bit() {
        app::run(&mut source);
    } else {
        index::run(&mut source);
    }
}
