//! How many threads work.

use std::num::NonZero;

use crate::outcome::Outcome;

/// Lets so many threads compute, of all engines: Bevy's pool, which Avian and this crate use, and
/// rayon's, which rapier, parry and obvhs use. Several need a build with `--features parallel`; one
/// is one whatever the build. To be called before anything uses a pool.
pub fn use_threads(threads: NonZero<usize>) -> Outcome {
    if threads.get() > 1 && !cfg!(feature = "parallel") {
        return Err(format!("{threads} threads need a build with --features parallel").into());
    }
    #[cfg(feature = "parallel")]
    {
        use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
        // The thread that waits for the pool does its share.
        ComputeTaskPool::get_or_init(|| {
            TaskPoolBuilder::new()
                .num_threads(threads.get() - 1)
                .build()
        });
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()?;
    }
    Ok(())
}
