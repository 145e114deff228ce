//! Which vector instructions searches are made with.
//!
//! What is found does not depend on them, to the last bit and in its order: nothing is added up across lanes, products are
//! rounded before they are added to, and no zero has a sign where that decides.

use fearless_simd::Level;

/// The best that this machine has.
pub(super) fn best() -> Level {
    #[cfg(test)]
    if let Some(level) = forced::level() {
        return level;
    }
    Level::new()
}

/// Other levels than the best, for tests.
#[cfg(test)]
pub(crate) mod forced {
    use std::cell::Cell;

    use fearless_simd::{Level, prelude::*};

    thread_local! {
        static FORCED: Cell<Option<Level>> = const { Cell::new(None) };
    }

    pub(super) fn level() -> Option<Level> {
        FORCED.get()
    }

    /// All that this machine has, by name; the plainest first.
    pub(crate) fn all() -> Vec<(&'static str, Level)> {
        let best = Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let others = [
            ("SSE2", best.as_sse2().map(Simd::level)),
            ("SSE4.2", best.as_sse4_2().map(Simd::level)),
            ("AVX2", best.as_avx2().map(Simd::level)),
            ("AVX-512", best.as_avx512().map(Simd::level)),
        ];
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let others = [("best", Some(best))];
        let others = others
            .into_iter()
            .filter_map(|(name, level)| Some((name, level?)));
        [("scalar", Level::fallback())]
            .into_iter()
            .chain(others)
            .collect()
    }

    /// What comes of it where whatever is made searches with these instructions.
    pub(crate) fn at<T>(level: Level, act: impl FnOnce() -> T) -> T {
        let before = FORCED.replace(Some(level));
        let done = act();
        FORCED.set(before);
        done
    }
}

#[cfg(test)]
mod tests;
