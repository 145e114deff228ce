//! Memory that outlives a query, one per thread.

use std::cell::Cell;

use bevy::math::Vec3;

use crate::{broad_phase::Hit, narrow_phase::Workspace};

/// Buffers of the exact tests and of queries for several.
#[derive(Default)]
pub(super) struct Scratch {
    pub workspace: Workspace,
    /// The nearest objects so far.
    pub nearest: Vec<Hit>,
    /// The same, with the closest point of each.
    pub closest_points: Vec<(Hit, Vec3)>,
}

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

/// Lends this thread's buffers. A query within a query, from a caller's callback, gets new ones.
pub(super) fn with<T>(f: impl FnOnce(&mut Scratch) -> T) -> T {
    let mut scratch = SCRATCH.take().unwrap_or_default();
    let result = f(&mut scratch);
    SCRATCH.set(Some(scratch));
    result
}

/// Lends this thread's buffers of the exact tests.
pub(crate) fn with_workspace<T>(f: impl FnOnce(&mut Workspace) -> T) -> T {
    with(|scratch| f(&mut scratch.workspace))
}
