//! How many threads work.

use std::num::NonZero;

use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};

use crate::outcome::Outcome;

/// Lets so many threads compute. One is the thread that calls. Several are those of Bevy's pool: its
/// executor has systems run there, and the thread that calls does nothing but wait. To be called
/// before anything uses the pool.
pub fn use_threads(threads: NonZero<usize>) -> Outcome {
    if threads.get() > 1 && !cfg!(feature = "multi_threaded") {
        return Err(
            format!("{threads} threads need a build with --features multi_threaded").into(),
        );
    }
    ComputeTaskPool::get_or_init(|| {
        let helpers = if threads.get() == 1 { 0 } else { threads.get() };
        TaskPoolBuilder::new().num_threads(helpers).build()
    });
    Ok(())
}
