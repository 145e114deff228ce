//! `peers app`: end to end, in headless Bevy apps.
//!
//! All apps are alike but for what detects collisions: one schedule run per update, the same cubes
//! of side 1 in the `brownian` scene, moved by the same system, which writes their `Transform`s;
//! transform propagation; messages about collisions that start and end, which a system reads and
//! counts. One app only moves the cubes, and shows what that costs. Apps take turns in blocks of
//! eight updates, the first of which is not counted.
//!
//! | app | its cubes | settings, and why |
//! |---|---|---|
//! | ours | a collision shape | the default settings |
//! | `avian` | kinematic bodies, sensors | one substep, as there is nothing to solve; the tree optimised in place, as no queries run meanwhile: both save it time |
//! | `rapier` | kinematic bodies, sensors | all pairs of body types active, or it would ignore kinematic pairs; fixed steps of one substep |
//! | `rapier-bodyless` | colliders without bodies, sensors | the same |
//! | `movement` | nothing | the baseline |
//!
//! With `--statics`, so many cubes more never move: static shapes of ours, Avian's static bodies,
//! rapier's fixed ones, colliders without bodies; the others go to and fro among them, or there are
//! none (`--objects 0`). With `--threads`, each app has so many, in a build with the feature
//! `parallel`.
//!
//! Numbers of events differ a little between apps: the physics engines enlarge shapes by a
//! tolerance.

mod contestants;
mod scene;

use std::{
    fs,
    num::NonZero,
    path::PathBuf,
    time::{Duration, Instant},
};

use bevy::prelude::*;
use clap::Args;
use serde::Serialize;

use crate::{
    measure::median,
    outcome::Outcome,
    progress::Progress,
    threads::{Caller, use_threads},
};
use contestants::{Contestant, Events};
use scene::Scene;

/// Updates of one app before the next one's turn.
const BLOCK: usize = 8;
/// The time of a frame at 60 Hz, in milliseconds.
const FRAME_MS: f64 = 1000.0 / 60.0;
/// No limit is looked for beyond so many objects.
const MOST_OBJECTS: usize = 4_000_000;

/// Compares apps.
#[derive(Args)]
pub struct Arguments {
    /// Moving cubes: as in the `brownian` scene, or to and fro among static ones.
    #[arg(long, default_value_t = 64_000)]
    objects: usize,
    /// Cubes that never move.
    #[arg(long, default_value_t = 0)]
    statics: usize,
    /// How many threads work, in all apps.
    #[arg(long, default_value_t = NonZero::<usize>::MIN)]
    threads: NonZero<usize>,
    /// Updates to time, after eight to warm up.
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u16).range(1..))]
    ticks: u16,
    /// Apps, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    apps: Vec<Contestant>,
    /// Also looks for the largest number of cubes that each app updates in 16.6 ms.
    #[arg(long)]
    find_limit: bool,
    /// Seed of the scene.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What was measured of an app.
#[derive(Serialize)]
struct Row {
    app: &'static str,
    objects: usize,
    statics: usize,
    threads: usize,
    tick_ms: f64,
    started: u64,
    ended: u64,
    ratio: Option<f64>,
    limit: Option<usize>,
}

/// An app and the times of its updates.
struct Runner {
    app: App,
    times: Vec<Duration>,
}

impl Runner {
    fn new(contestant: Contestant, scene: Scene) -> Self {
        Self {
            app: contestant.app(scene),
            times: vec![],
        }
    }

    fn run(&mut self, ticks: usize) {
        for _ in 0..ticks {
            let start = Instant::now();
            self.app.update();
            self.times.push(start.elapsed());
        }
    }

    /// Forgets what has been measured so far.
    fn forget(&mut self) {
        self.times.clear();
        *self.app.world_mut().resource_mut::<Events>() = Events::default();
    }

    fn median_ms(&self) -> f64 {
        median(self.times.iter().map(|time| time.as_secs_f64() * 1e3))
    }
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    let contestants = if arguments.apps.is_empty() {
        Contestant::ALL.to_vec()
    } else {
        arguments.apps.clone()
    };
    let Arguments {
        objects,
        statics,
        threads,
        seed,
        ..
    } = *arguments;
    if objects + statics == 0 {
        return Err("at least one object is needed".into());
    }
    use_threads(threads, Caller::Waits)?;
    let scene = Scene {
        objects,
        statics,
        seed,
    };
    let mut runners: Vec<_> = contestants
        .iter()
        .map(|contestant| Runner::new(*contestant, scene))
        .collect();
    let mut ticks = usize::from(arguments.ticks);
    let mut progress = Progress::new((1 + ticks.div_ceil(BLOCK)) as u64);
    progress.begin("warming up");
    for runner in &mut runners {
        runner.run(BLOCK);
        runner.forget();
    }
    while ticks > 0 {
        progress.begin(format!("{objects} cubes, {statics} static"));
        let block = ticks.min(BLOCK);
        runners.iter_mut().for_each(|runner| runner.run(block));
        ticks -= block;
    }
    drop(progress);

    let ours = contestants
        .iter()
        .zip(&runners)
        .find(|(contestant, _)| **contestant == Contestant::Ours);
    let ours = ours.map(|(_, runner)| runner.median_ms());
    let mut rows = vec![];
    for (contestant, runner) in contestants.iter().zip(&runners) {
        let events = runner.app.world().resource::<Events>();
        rows.push(Row {
            app: contestant.name(),
            objects,
            statics,
            threads: threads.get(),
            tick_ms: runner.median_ms(),
            started: events.started,
            ended: events.ended,
            ratio: ours.map(|ours| runner.median_ms() / ours),
            limit: None,
        });
    }
    drop(runners);
    if arguments.find_limit {
        for (contestant, row) in contestants.iter().zip(&mut rows) {
            row.limit = Some(limit(*contestant, scene));
        }
    }
    print(&rows);
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&rows)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

fn print(rows: &[Row]) {
    println!(
        "app               objects    statics  threads    tick_ms    started      ended    / ours  limit at 60 Hz"
    );
    for Row {
        app,
        objects,
        statics,
        threads,
        tick_ms,
        started,
        ended,
        ratio,
        limit,
    } in rows
    {
        let ratio = ratio.map_or_else(String::new, |ratio| format!("{ratio:.2}"));
        let limit = limit.map_or_else(String::new, |limit| limit.to_string());
        println!(
            "{app:<15} {objects:>9} {statics:>10} {threads:>8} {tick_ms:>10.3} {started:>10} {ended:>10} {ratio:>9} {limit:>15}"
        );
    }
}

/// The largest number of cubes whose median update takes no longer than a frame, to a few per cent.
fn limit(contestant: Contestant, scene: Scene) -> usize {
    let mut progress = Progress::new(16);
    let mut holds = |objects: usize| {
        progress.begin(format!("{}: {objects} cubes", contestant.name()));
        let mut runner = Runner::new(contestant, Scene { objects, ..scene });
        runner.run(BLOCK);
        runner.forget();
        runner.run(2 * BLOCK);
        runner.median_ms() <= FRAME_MS
    };
    let (mut low, mut high) = (0, 1000);
    while high < MOST_OBJECTS && holds(high) {
        (low, high) = (high, 2 * high);
    }
    while high - low > high / 32 {
        let middle = low.midpoint(high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
