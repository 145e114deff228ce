//! Runs one of the report's test sets: two planes of cubes that move toward each other and bounce off.
//!
//! `cargo run --release --example planes -- --help` explains the arguments.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use bevy::prelude::*;
use bevy_octree::{
    counters::TickCounters,
    prelude::*,
    scene::{SceneDescription, TestSet},
};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

type Error = Box<dyn std::error::Error>;

/// Two parallel planes of cubes move toward each other and bounce off: the test sets of the 1994 report, or a scene
/// file, in a headless app.
///
/// Prints one line of figures for each method. Without --method, both run, and must find the same contacts.
#[derive(Parser)]
struct Arguments {
    /// Rings of cubes around the central cube of each plane; r rings make 2·(2r + 1)² cubes.
    #[arg(long, default_value_t = 10)]
    rings: u32,
    /// N: how many objects a leaf of the octree may list before it splits.
    #[arg(long, default_value_t = ObjectOctreeSettings::default().max_objects)]
    max_objects: u32,
    /// How many ticks to run.
    #[arg(long, default_value_t = 200)]
    steps: u32,
    /// How overlapping boxes are searched for: `octree` or `exhaustive`. Both, one after the other, if not given.
    #[arg(long)]
    method: Option<Method>,
    /// A scene file to run instead of a test set, such as assets/scenes/mixed_shapes.scene.ron.
    #[arg(long, conflicts_with = "rings")]
    scene: Option<PathBuf>,
}

fn main() -> Result<(), Error> {
    let arguments = Arguments::parse();
    let scene = match &arguments.scene {
        Some(path) => SceneDescription::load(path)?,
        None => SceneDescription::from(TestSet::new(arguments.rings)),
    };
    let octree = ObjectOctreeSettings::with_max_objects(arguments.max_objects);
    octree.check()?;
    let methods = match arguments.method {
        Some(Method::Octree(_)) => vec![Method::Octree(octree)],
        Some(method) => vec![method],
        None => vec![Method::Octree(octree), Method::Exhaustive],
    };
    let mut totals = Vec::new();
    for method in &methods {
        totals.push(run(&scene, method, arguments.steps, arguments.max_objects)?);
    }
    if let [first, second] = &totals[..]
        && (first.contacts, first.bounces) != (second.contacts, second.bounces)
    {
        return Err("the two methods do not find the same contacts".into());
    }
    Ok(())
}

/// Runs a scene by one method, and prints its line.
fn run(scene: &SceneDescription, method: &Method, steps: u32, max_objects: u32) -> Result<TickCounters, Error> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings { method: method.clone() })
        .insert_resource(MotionSettings { step: Step::Seconds(scene.tick_length()?.as_secs_f32()) });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let progress = ProgressBar::new(u64::from(steps)).with_message(method.to_string());
    progress.set_style(ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} ticks, {eta} left")?);
    let start = Instant::now();
    let mut shown = start;
    for step in 0..steps {
        app.update();
        if shown.elapsed() >= Duration::from_secs(1) {
            shown = Instant::now();
            progress.set_position(u64::from(step + 1));
        }
    }
    let milliseconds = start.elapsed().as_secs_f64() * 1e3 / f64::from(steps.max(1));
    progress.finish_and_clear();

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
