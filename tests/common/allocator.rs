//! An allocator that counts, for tests of what stays flat and what is linear.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn add(bytes: usize) {
    PEAK.fetch_max(LIVE.fetch_add(bytes, Relaxed) + bytes, Relaxed);
}

// SAFETY: it is the system's allocator that allocates.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(place, layout, size) }
    }
}

/// The whole process is counted: tests take turns, each for as long as it holds this.
pub fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The bytes that are allocated now.
pub fn live() -> usize {
    LIVE.load(Relaxed)
}

/// How many bytes more than before are allocated at most, while something is done.
pub fn peak_of(work: impl FnOnce()) -> usize {
    let before = live();
    PEAK.store(before, Relaxed);
    work();
    PEAK.load(Relaxed) - before
}

/// Checks that as much is allocated after `rounds` rounds as before, after some that warm up,
/// within 1 %. What the test harness does meanwhile is allowed for.
///
/// A buffer that is filled by chance has a highest point that is reached late at times, and grows
/// then: so there are three trials, one after the other. What leaks grows in each of them.
#[track_caller]
pub fn assert_flat(what: &str, warm_up: usize, rounds: usize, round: impl FnMut()) {
    assert_flat_but_for(2048, what, warm_up, rounds, round);
}

/// The same, with so many bytes allowed for.
#[track_caller]
pub fn assert_flat_but_for(
    spare: usize,
    what: &str,
    warm_up: usize,
    rounds: usize,
    mut round: impl FnMut(),
) {
    (0..warm_up).for_each(|_| round());
    let mut trials = Vec::with_capacity(3);
    while trials.len() < 3 {
        let before = live();
        (0..rounds).for_each(|_| round());
        let after = live();
        if after <= before + before / 100 + spare {
            return;
        }
        trials.push([before, after]);
    }
    panic!("{what}: bytes before and after {rounds} rounds, three times: {trials:?}");
}
