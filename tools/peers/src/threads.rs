//! How many threads work.

use std::num::NonZero;

use crate::outcome::Outcome;

/// What the calling thread does while a pool works.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Caller {
    /// Its share.
    Works,
    /// Nothing: so it is with Bevy's multi-threaded executor, which runs all of an app in the pool.
    Waits,
}

/// Lets so many threads compute, of all engines: Bevy's pool, which Avian and this crate use, and
/// rayon's, which rapier, parry and obvhs use. Several need a build with `--features parallel`; one
/// is one whatever the build. To be called before anything uses a pool.
pub fn use_threads(threads: NonZero<usize>, caller: Caller) -> Outcome {
    if threads.get() > 1 && !cfg!(feature = "parallel") {
        return Err(format!("{threads} threads need a build with --features parallel").into());
    }
    #[cfg(not(feature = "parallel"))]
    let _ = caller;
    #[cfg(feature = "parallel")]
    {
        use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
        let callers = usize::from(caller == Caller::Works);
        ComputeTaskPool::get_or_init(|| {
            TaskPoolBuilder::new()
                .num_threads(threads.get() - callers)
                .build()
        });
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()?;
    }
    Ok(())
}
