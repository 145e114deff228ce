//! One run: a test set, a way to search, a number of steps, and the time that they took.

use std::{
    collections::{HashMap, hash_map::Entry},
    fmt,
    time::{Duration, Instant},
};

use bevy_octree::{
    broad_phase::{ObjectOctreeSettings, PairSearch},
    counters::TickCounters,
    motion::{MotionSettings, Step},
    prelude::*,
    scene::TestSet,
};

use super::headless::app_with;
use crate::outcome::Outcome;

/// A row of Table 1: a way to search for pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Row {
    /// The octree, with at most N objects in a leaf.
    Octree(u32),
    /// The octree with an N that no set reaches: the root stays a leaf.
    Big,
    /// All pairs, without any octree.
    Exhaustive,
}

impl Row {
    /// The rows of the report's table, and exhaustive search without an octree, which the report's
    /// last row stands for.
    pub const ALL: [Self; 6] = [
        Self::Octree(5),
        Self::Octree(10),
        Self::Octree(30),
        Self::Octree(50),
        Self::Big,
        Self::Exhaustive,
    ];

    /// Is space divided?
    pub const fn is_divided(self) -> bool {
        matches!(self, Self::Octree(_))
    }

    fn method(self) -> BroadPhaseMethod {
        // The report's search, whatever the library's default is.
        let octree = |max_objects| {
            BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings {
                max_objects,
                search: PairSearch::Leaves,
                ..ObjectOctreeSettings::default()
            })
        };
        match self {
            Self::Octree(n) => octree(n),
            Self::Big => octree(u32::MAX),
            Self::Exhaustive => BroadPhaseMethod::Exhaustive,
        }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Octree(n) => f.pad(&format!("N = {n}")),
            Self::Big => f.pad("N = big"),
            Self::Exhaustive => f.pad("exhaustive"),
        }
    }
}

/// What one run gave.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// The time of all steps. Not in it: making the app, and its first update, which takes up the
    /// objects.
    pub time: Duration,
    /// The sums over all steps.
    pub counters: TickCounters,
}

/// Runs a test set for so many steps.
fn run(set: &TestSet, row: Row, steps: u32) -> Run {
    let mut app = app_with(set, row.method());
    let motion = *app.world().resource::<MotionSettings>();
    // In the update that takes up the objects, no time passes.
    app.insert_resource(MotionSettings {
        step: Step::Seconds(0.0),
    });
    app.update();
    app.insert_resource(motion)
        .insert_resource(CollisionCounters::default());

    let start = Instant::now();
    for _ in 0..steps {
        app.update();
    }
    let time = start.elapsed();
    Run {
        time,
        counters: app.world().resource::<CollisionCounters>().total,
    }
}

/// Runs, and checks that the results of all runs agree.
#[derive(Default)]
pub struct Laboratory {
    /// By rings and steps: contacts and bounces, and whose they were.
    verdicts: HashMap<(u32, u32), ([u64; 2], Row)>,
    /// By rings, steps and row: the pairs that were compared.
    work: HashMap<(u32, u32, Row), u64>,
}

impl Laboratory {
    /// Runs a test set for so many steps.
    ///
    /// # Errors
    /// If another way to search gave other contacts or bounces, or the same one compared other
    /// pairs before.
    pub fn run(&mut self, set: &TestSet, row: Row, steps: u32) -> Outcome<Run> {
        let run = run(set, row, steps);
        let verdict = [run.counters.contacts, run.counters.bounces];
        match self.verdicts.entry((set.rings, steps)) {
            Entry::Vacant(entry) => {
                entry.insert((verdict, row));
            }
            Entry::Occupied(entry) if entry.get().0 == verdict => {}
            Entry::Occupied(entry) => {
                let ([contacts, bounces], other) = entry.get();
                let [mine, my_bounces] = verdict;
                let name = set.name();
                return Err(format!(
                    "the methods disagree on {name} after {steps} steps: {row} has {mine} contacts and {my_bounces} \
                     bounces, {other} has {contacts} and {bounces}"
                )
                .into());
            }
        }
        let compared = run.counters.pairs_tested;
        let before = *self.work.entry((set.rings, steps, row)).or_insert(compared);
        if before != compared {
            let name = set.name();
            return Err(format!(
                "{row} on {name} compared {compared} pairs in one run, {before} in another"
            )
            .into());
        }
        Ok(run)
    }
}
