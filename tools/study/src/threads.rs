//! How many threads work.

use std::num::NonZero;

use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};

use crate::outcome::Outcome;

/// Lets so many threads compute: the one that calls, which does its share while it waits, and those
/// of Bevy's pool. To be called before anything uses the pool.
pub fn use_threads(threads: NonZero<usize>) -> Outcome {
    if threads.get() > 1 && !cfg!(feature = "multi_threaded") {
        return Err(
            format!("{threads} threads need a build with --features multi_threaded").into(),
        );
    }
    ComputeTaskPool::get_or_init(|| {
        TaskPoolBuilder::new()
            .num_threads(threads.get() - 1)
            .build()
    });
    Ok(())
}
