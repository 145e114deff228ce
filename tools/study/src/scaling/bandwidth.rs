//! How fast memory is here.

use std::{
    fmt, hint,
    sync::Barrier,
    thread,
    time::{Duration, Instant},
};

/// How many 64-bit numbers each thread copies, and from how many: far more than caches hold.
const NUMBERS: usize = 16 << 20;

/// How often they are copied; the fastest time counts.
const REPEATS: usize = 5;

/// What memory gives one thread, and two at once.
#[derive(Clone, Copy, Debug)]
pub struct Bandwidth {
    /// Bytes read and written per millisecond.
    one: f64,
    two: f64,
}

impl Bandwidth {
    /// Copies large arrays, on one thread and on two.
    pub fn measure() -> Self {
        Self {
            one: copied_per_ms(1),
            two: copied_per_ms(2),
        }
    }

    /// How many threads it serves at once as it serves one: from 1 to 2.
    pub fn threads(&self) -> f64 {
        (self.two / self.one).clamp(1.0, 2.0)
    }

    /// How many bytes one thread moves in so many milliseconds.
    pub fn bytes_in(&self, ms: f64) -> f64 {
        ms * self.one
    }
}

impl fmt::Display for Bandwidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, two] = [self.one, self.two].map(|bytes_per_ms| bytes_per_ms * 1e-6);
        write!(
            f,
            "Memory moves {one:.1} GB/s for one thread and {two:.1} GB/s for two: it serves {:.2} threads at once.",
            self.threads()
        )
    }
}

/// How many times as much two threads compute as one, without memory: 2 if there are two cores that
/// nobody else uses.
pub fn free_cores() -> f64 {
    computed(2) / computed(1).max(1.0)
}

/// How many numbers so many threads draw in a while.
fn computed(threads: usize) -> f64 {
    const WHILE: Duration = Duration::from_millis(300);
    let barrier = Barrier::new(threads);
    let draw = || {
        let mut random = fastrand::Rng::with_seed(1);
        let mut drawn = 0_u64;
        barrier.wait();
        let start = Instant::now();
        while start.elapsed() < WHILE {
            for _ in 0..10_000 {
                hint::black_box(random.u64(..));
            }
            drawn += 10_000;
        }
        drawn
    };
    thread::scope(|scope| {
        let all: Vec<_> = (0..threads).map(|_| scope.spawn(draw)).collect();
        all.into_iter()
            .filter_map(|thread| thread.join().ok())
            .map(|drawn| drawn as f64)
            .sum()
    })
}

/// Bytes read and written per millisecond by so many threads at once.
fn copied_per_ms(threads: usize) -> f64 {
    let barrier = Barrier::new(threads);
    let fastest = |barrier: &Barrier| {
        let from = vec![1_u64; NUMBERS];
        let mut to = vec![0_u64; NUMBERS];
        let mut fastest = Duration::MAX;
        for _ in 0..REPEATS {
            barrier.wait();
            let start = Instant::now();
            to.copy_from_slice(hint::black_box(&from));
            hint::black_box(&mut to);
            fastest = fastest.min(start.elapsed());
        }
        fastest
    };
    let slowest = thread::scope(|scope| {
        let all: Vec<_> = (0..threads)
            .map(|_| scope.spawn(|| fastest(&barrier)))
            .collect();
        all.into_iter()
            .filter_map(|thread| thread.join().ok())
            .max()
            .unwrap_or(Duration::MAX)
    });
    (threads * 2 * NUMBERS * size_of::<u64>()) as f64 / (slowest.as_secs_f64() * 1e3)
}
