//! Work in parallel, in jobs whose number and borders do not depend on how many threads there are:
//! results are the same at any number.

/// Returns `true` if there is somebody to help. That is, a `ComputeTaskPool` with at least one
/// thread, and the feature `multi_threaded`.
pub(crate) fn is_on() -> bool {
    #[cfg(feature = "multi_threaded")]
    let is_on = bevy::tasks::ComputeTaskPool::try_get().is_some_and(|pool| pool.thread_num() > 0);
    #[cfg(not(feature = "multi_threaded"))]
    let is_on = false;
    is_on
}

/// Does all jobs: side by side if that [is on](is_on), or else one after the other.
pub(crate) fn for_each<I>(jobs: I, f: impl Fn(I::Item) + Sync)
where
    I: ExactSizeIterator,
    I::Item: Send,
{
    #[cfg(feature = "multi_threaded")]
    if jobs.len() > 1
        && let Some(pool) = bevy::tasks::ComputeTaskPool::try_get()
        && pool.thread_num() > 0
    {
        let f = &f;
        pool.scope(|scope| jobs.for_each(|job| scope.spawn(async move { f(job) })));
        return;
    }
    jobs.for_each(f);
}
