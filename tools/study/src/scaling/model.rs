//! From two measurements to a prediction.

/// What is known of a stage, in milliseconds on one thread.
#[derive(Clone, Debug)]
pub struct Stage {
    pub name: String,
    /// As measured, on one thread and on two.
    pub one: f64,
    pub two: f64,
    /// What is done by one thread, however many there are.
    pub serial: f64,
    /// What is divided among threads, without waiting for memory.
    pub parallel: f64,
    /// What is divided among threads, and waits for memory.
    pub memory: f64,
    /// What waits for memory at all, whoever does it.
    pub traffic: f64,
}

/// Milliseconds, at the worst and at the best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// If memory gives all threads what they ask for.
    pub low: f64,
    /// If it gives no more than measured.
    pub high: f64,
}

impl Stage {
    /// By the times on one thread and on two, and the time that it would take if all were in the
    /// cache.
    ///
    /// By Amdahl, t(n) = s + p / n: two measurements tell both. A stage that two threads make
    /// slower is serial.
    pub fn new(name: String, one: f64, two: f64, cached: f64) -> Self {
        let divided = (2.0 * (one - two)).clamp(0.0, one);
        let traffic = (one - cached).clamp(0.0, one);
        let memory = traffic * divided / one.max(f64::MIN_POSITIVE);
        Self {
            name,
            one,
            two,
            serial: one - divided,
            parallel: divided - memory,
            memory,
            traffic,
        }
    }

    /// Its time on so many threads; `memory_threads` are as many as memory serves at once.
    fn on(&self, threads: u32, memory_threads: f64) -> f64 {
        let threads = f64::from(threads.max(1));
        self.serial + self.parallel / threads + self.memory / threads.min(memory_threads.max(1.0))
    }

    /// Its time on so many threads, given how many threads memory serves at once here.
    pub fn predict(&self, threads: u32, memory_threads: f64) -> Range {
        Range {
            low: self.on(threads, f64::INFINITY),
            high: self.on(threads, memory_threads),
        }
    }
}

/// The time of all stages on so many threads.
pub fn predict(stages: &[Stage], threads: u32, memory_threads: f64) -> Range {
    let all = stages
        .iter()
        .map(|stage| stage.predict(threads, memory_threads));
    all.fold(
        Range {
            low: 0.0,
            high: 0.0,
        },
        |sum, stage| Range {
            low: sum.low + stage.low,
            high: sum.high + stage.high,
        },
    )
}

/// The fewest threads on which all stages take no more than so many milliseconds, if memory gives
/// them what they ask for; `None` if what is serial takes longer.
pub fn threads_for(stages: &[Stage], budget_ms: f64) -> Option<u32> {
    let serial: f64 = stages.iter().map(|stage| stage.serial).sum();
    let divided: f64 = stages
        .iter()
        .map(|stage| stage.parallel + stage.memory)
        .sum();
    let left = budget_ms - serial;
    if divided <= left {
        return Some(1);
    }
    (left > 0.0).then(|| (divided / left).ceil() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(one: f64, two: f64, cached: f64) -> Stage {
        Stage::new(String::new(), one, two, cached)
    }

    #[test]
    fn two_measurements_tell_the_shares() {
        let all_parallel = stage(8.0, 4.0, 8.0);
        assert_eq!((all_parallel.serial, all_parallel.parallel), (0.0, 8.0));
        let half = stage(8.0, 6.0, 8.0);
        assert_eq!((half.serial, half.parallel), (4.0, 4.0));
        for slower in [stage(8.0, 9.0, 8.0), stage(8.0, 8.0, 4.0)] {
            assert_eq!((slower.serial, slower.parallel), (8.0, 0.0));
        }
        // Faster than twice as fast is noise.
        assert_eq!(stage(8.0, 3.0, 8.0).serial, 0.0);
        assert_eq!(stage(0.0, 0.0, 0.0).predict(4, 1.0).high, 0.0);
    }

    #[test]
    fn memory_serves_only_so_many() {
        // Half of it waits for memory.
        let bound = stage(8.0, 4.0, 4.0);
        assert_eq!((bound.parallel, bound.memory), (4.0, 4.0));
        let on_four = bound.predict(4, 1.5);
        assert_eq!(on_four.low, 2.0);
        assert!((on_four.high - (1.0 + 4.0 / 1.5)).abs() < 1e-12);
        assert_eq!(bound.predict(1, 1.5).high, 8.0);
    }

    #[test]
    fn enough_threads_are_found_if_there_are_any() {
        let stages = [stage(8.0, 6.0, 8.0), stage(10.0, 5.0, 10.0)];
        assert_eq!(threads_for(&stages, 20.0), Some(1));
        // 4 are serial, and 14 are divided.
        assert_eq!(threads_for(&stages, 6.0), Some(7));
        assert_eq!(predict(&stages, 7, 7.0).high, 6.0);
        assert_eq!(threads_for(&stages, 4.0), None);
    }
}
