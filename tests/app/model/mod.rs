//! Whole apps to which anything happens, at random, beside what follows from their components alone:
//! contacts, messages, observers, lists and queries after every step.
//!
//! `BEVY_OCTREE_TEST_CASES` is the number of histories to try, each of up to 60 steps at random, after those that bring in who is there.

mod apply;
mod machine;
mod ops;
mod oracle;
mod random;

use std::cell::Cell;

use machine::{Machine, Seen};
use ops::Step;
use proptest::{prelude::*, test_runner::TestRunner};

fn replay(steps: &[Step]) -> Seen {
    let mut machine = Machine::new();
    for step in steps {
        machine.step(step);
    }
    machine.end()
}

fn cases() -> u32 {
    let asked = std::env::var("BEVY_OCTREE_TEST_CASES");
    asked.map_or(200, |number| number.parse().expect("a number of cases"))
}

#[test]
fn whatever_happens_follows_from_what_is_there() {
    let mut runner = TestRunner::new(ProptestConfig {
        cases: cases(),
        failure_persistence: None,
        max_shrink_iters: 4000,
        ..ProptestConfig::default()
    });
    let seen = Cell::new(Seen::default());
    let found = runner.run(&random::history(60), |steps| {
        seen.set(seen.get() + replay(&steps));
        Ok(())
    });
    if let Err(failure) = found {
        panic!("{failure}");
    }
    let Seen {
        ticks,
        contacts,
        events,
        answers,
    } = seen.get();
    let least = cases() as usize;
    println!("{ticks} ticks, {contacts} contacts, {events} events, {answers} answers to queries");
    assert!(
        ticks > 5 * least && contacts > 20 * least,
        "{ticks} {contacts}"
    );
    assert!(
        events > least / 2 && answers > 5 * least,
        "{events} {answers}"
    );
}

/// A list of an entity that something else than `Disabled` disabled went on naming what it had
/// touched.
#[test]
fn the_list_of_what_a_component_of_ones_own_disables_is_empty() {
    use ops::{Op::*, Part};
    replay(&[
        Step::Do(Spawn(0, [0; 3])),
        Step::Do(Spawn(0, [0; 3])),
        Step::Do(Give(0, Part::Colliding)),
        Step::Tick,
        Step::Do(Disable(0, true)),
    ]);
}

/// Who was disabled before the first tick, which computed boxes and did no more, and was enabled
/// before the second, came into no index.
#[test]
fn who_is_disabled_during_half_of_the_first_tick() {
    use ops::Op::*;
    // All sets but the first two.
    for skipped in 0..1 << 5 {
        replay(&[
            Step::Do(Spawn(0, [0; 3])),
            Step::Do(Spawn(0, [0; 3])),
            Step::Do(Disable(1, false)),
            Step::TickWithout(skipped << 2),
            Step::Do(Enable(1)),
        ]);
    }
}
