//! Runs a stress scene in a headless app, and measures its frames.
//!
//! `cargo run --release -p study -- stress --help` explains the arguments.

use std::{
    num::NonZero,
    time::{Duration, Instant},
};

use bevy_octree::{broad_phase::BroadPhaseMethod, scene::stress::StressScene};
use clap::Args;

use crate::{
    extra::Extra,
    outcome::Outcome,
    progress::Progress,
    quantile::quantile,
    stress_app::{Setup, StressApp},
    threads::use_threads,
    which_scene::WhichScene,
};

/// The time of a frame at 60 frames per second, in milliseconds.
const BUDGET_MS: f64 = 16.6;
/// Where the search for the largest number of objects begins and ends.
const FEWEST: usize = 1000;
const MOST: usize = 2_048_000;
/// The search ends when the number is known to within this factor, or after so much time.
const PRECISION: f64 = 1.03;
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs a stress scene with all of the library's plugins in a headless app: entities with a box
/// each, moved by a system, with a message for each contact that starts or ends.
///
/// Prints one line: `update_ms` is the median time of a frame and `p99_ms` the time that one frame
/// in a hundred takes longer than, in milliseconds; `started` and `ended` count messages since the
/// entities came in. Then the mean milliseconds of each stage per frame (`motion_ms` is the scene's
/// own: moving the boxes and writing transforms), and the stage that takes most with its share.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    which: WhichScene,
    /// How many frames to measure. The first update, in which all entities come in, is none of
    /// them.
    #[arg(long, default_value_t = NonZero::new(120).unwrap_or(NonZero::<u32>::MIN), allow_negative_numbers = true)]
    frames: NonZero<u32>,
    /// How many threads work on systems and in the library.
    #[arg(long, default_value_t = NonZero::<usize>::MIN, allow_negative_numbers = true)]
    threads: NonZero<usize>,
    /// The broad phase: `object` for the report's N-objects octree, `exhaustive`, or any other that
    /// the library knows. The library's default if not given.
    #[arg(long)]
    method: Option<BroadPhaseMethod>,
    /// What every object has beyond a box that moves.
    #[arg(long)]
    with: Option<Extra>,
    /// Instead of measuring --objects, look for the largest number of objects whose median frame
    /// takes at most 16.6 ms (up to 2 048 000 objects, in about two minutes at most), and measure
    /// that.
    #[arg(long)]
    find_limit: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    use_threads(arguments.threads)?;
    let method = arguments.method.clone().unwrap_or_default();
    method.check()?;
    let WhichScene {
        scene,
        objects,
        seed,
    } = arguments.which;
    let mut setup = Setup {
        scene,
        objects,
        seed,
        method,
        with: arguments.with,
    };
    let frames = arguments.frames.get();
    if arguments.find_limit {
        let limit = find_limit(&setup, frames)?;
        println!("{limit}");
        setup.objects = limit.objects;
    }
    measure(&setup, frames, arguments.threads)
}

/// Runs a scene, and prints its line.
fn measure(setup: &Setup, frames: u32, threads: NonZero<usize>) -> Outcome {
    let mut app = StressApp::new(setup)?;
    let mut progress = Progress::new(u64::from(frames));
    for _ in 0..frames {
        progress.begin(format!("{} contacts", app.counters().tick.contacts));
        app.frame();
    }
    drop(progress);
    let Setup {
        scene,
        objects,
        seed,
        method,
        with: _,
    } = setup;
    let [update_ms, p99_ms] = [0.5, 0.99].map(|share| quantile(&app.update_ms, share));
    let total = app.counters().total;
    print!(
        "scene={scene} objects={objects} update_ms={update_ms:.3} p99_ms={p99_ms:.3} started={} ended={} contacts={} frames={frames} threads={threads} seed={seed} method={method}",
        total.started,
        total.ended,
        app.counters().tick.contacts,
    );
    let stages = app.stages_ms();
    let frame: f64 = stages.iter().map(|(_, ms)| ms).sum();
    for (name, ms) in &stages {
        print!(" {name}_ms={ms:.3}");
    }
    let (largest, ms) = stages
        .iter()
        .copied()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or_default();
    println!(" largest={largest} largest_share={:.3}", ms / frame);
    Ok(())
}

/// The largest number of objects that holds the budget.
struct Limit {
    scene: StressScene,
    objects: usize,
    /// The least number that does not, if there is one.
    beyond: Option<usize>,
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            scene,
            objects,
            beyond,
        } = self;
        write!(
            f,
            "scene={scene} limit_objects={objects} limit_ms={BUDGET_MS} too_many="
        )?;
        match beyond {
            Some(beyond) => write!(f, "{beyond}"),
            None => write!(f, "unknown"),
        }
    }
}

/// Doubles the number of objects until it is too large, and then halves the distance.
fn find_limit(setup: &Setup, frames: u32) -> Outcome<Limit> {
    let start = Instant::now();
    let mut limit = Limit {
        scene: setup.scene,
        objects: 0,
        beyond: None,
    };
    let mut progress = Progress::new(16);
    while start.elapsed() < PATIENCE {
        let objects = match (limit.objects, limit.beyond) {
            (0, None) => FEWEST,
            (held, None) if held >= MOST => break,
            (held, None) => 2 * held,
            (held, Some(beyond))
                if beyond as f64 <= PRECISION * held as f64 || beyond - held <= 1 =>
            {
                break;
            }
            (held, Some(beyond)) => held.midpoint(beyond),
        };
        progress.begin(format!(
            "{objects} objects; {} are not too many",
            limit.objects
        ));
        if holds_budget(
            &Setup {
                objects,
                ..setup.clone()
            },
            frames,
        )? {
            limit.objects = objects;
        } else {
            limit.beyond = Some(objects);
        }
    }
    Ok(limit)
}

/// Does the median frame hold the budget? Runs only as many frames as it takes to know.
fn holds_budget(setup: &Setup, frames: u32) -> Outcome<bool> {
    let mut app = StressApp::new(setup)?;
    let half = frames.div_ceil(2);
    let (mut within, mut beyond) = (0, 0);
    while within < half && beyond < half {
        app.frame();
        let in_time = app.update_ms.last().is_some_and(|ms| *ms <= BUDGET_MS);
        if in_time { within += 1 } else { beyond += 1 }
    }
    Ok(within >= half)
}
