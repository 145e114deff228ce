//! Runs one of the report's test sets: two planes of cubes that move toward each other and bounce off.
//!
//! `cargo run --release --example planes -- --help` explains the arguments.

use std::{path::PathBuf, process::ExitCode, time::Instant};

use bevy::prelude::*;
use bevy_octree::{
    counters::TickCounters,
    prelude::*,
    scene::{SceneDescription, TestSet},
};
use clap::Parser;
use outcome::{Outcome, exit};
use progress::Progress;

#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/progress.rs"]
mod progress;

/// Two parallel planes of cubes move toward each other and bounce off: the test sets of the 1994 report, or a scene
/// file, in a headless app.
///
/// Prints one line of figures for each method. Without --method, both run, and must find the same contacts.
#[derive(Parser)]
struct Arguments {
    /// Rings of cubes around the central cube of each plane; r rings make 2·(2r + 1)² cubes.
    #[arg(long, default_value_t = 10, allow_negative_numbers = true)]
    rings: u32,
    /// N: how many objects a leaf of the octree may list before it splits.
    #[arg(long, default_value_t = ObjectOctreeSettings::default().max_objects, allow_negative_numbers = true)]
    max_objects: u32,
    /// How many ticks to run.
    #[arg(long, default_value_t = 200, allow_negative_numbers = true)]
    steps: u32,
    /// How overlapping boxes are searched for: `auto`, `linear`, `object` or `exhaustive`. The last two, one after the
    /// other, if not given.
    #[arg(long)]
    method: Option<BroadPhaseMethod>,
    /// A scene file to run instead of a test set, such as assets/scenes/mixed_shapes.scene.ron.
    #[arg(long, conflicts_with = "rings")]
    scene: Option<PathBuf>,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Outcome {
    let scene = match &arguments.scene {
        Some(path) => SceneDescription::load(path)?,
        None => SceneDescription::from(TestSet::new(arguments.rings)),
    };
    let octree = ObjectOctreeSettings::with_max_objects(arguments.max_objects);
    octree.check()?;
    let methods = match &arguments.method {
        Some(BroadPhaseMethod::ObjectOctree(_)) => vec![BroadPhaseMethod::ObjectOctree(octree)],
        Some(method) => vec![method.clone()],
        None => vec![BroadPhaseMethod::ObjectOctree(octree), BroadPhaseMethod::Exhaustive],
    };
    let mut totals = Vec::new();
    for method in &methods {
        totals.push(measure(&scene, method, arguments.steps, arguments.max_objects)?);
    }
    if let [first, second] = &totals[..]
        && (first.contacts, first.bounces) != (second.contacts, second.bounces)
    {
        return Err("the two methods do not find the same contacts".into());
    }
    Ok(())
}

/// Runs a scene by one method, and prints its line.
fn measure(scene: &SceneDescription, method: &BroadPhaseMethod, steps: u32, max_objects: u32) -> Outcome<TickCounters> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings { method: method.clone(), ..default() })
        .insert_resource(MotionSettings { step: Step::Seconds(scene.tick_length()?.as_secs_f32()) });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let mut progress = Progress::new(u64::from(steps));
    let start = Instant::now();
    for step in 0..steps {
        progress.begin(format!("{method}: {:.2} ms per step", per_step(start, step)));
        app.update();
    }
    let milliseconds = per_step(start, steps);
    drop(progress);

    let total = app.world().resource::<CollisionCounters>().total;
    println!(
        "scene={} objects={} steps={steps} max_objects={max_objects} method={method} pairs_tested={} contacts={} bounces={} nodes={} ms_per_step={milliseconds:.4}",
        scene.name,
        scene.object_count(),
        total.pairs_tested,
        total.contacts,
        total.bounces,
        app.world().resource::<CollisionIndex>().index().stats().nodes,
    );
    Ok(total)
}

/// The milliseconds that each of so many steps took.
fn per_step(start: Instant, steps: u32) -> f64 {
    start.elapsed().as_secs_f64() * 1e3 / f64::from(steps.max(1))
}
