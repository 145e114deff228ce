//! Runs one of the report's test sets: two planes of cubes that move toward each other and bounce
//! off.
//!
//! `cargo run --release --example planes -- --help` explains the arguments.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use arguments::Arguments;
use bevy::prelude::*;
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    collision_index::CollisionIndex,
    counters::TickCounters,
    motion::{MotionSettings, Step},
    prelude::*,
    scene::{SceneDescription, TestSet},
};
use outcome::{Outcome, exit};
use progress::Progress;

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/progress.rs"]
mod progress;

/// Of the numbers that the report tried, the best on its sets.
const MAX_OBJECTS: u32 = 50;

const HELP: &str = "
Two parallel planes of cubes move toward each other and bounce off: the test sets of the 1994 report, or a scene file, in
a headless app.

Prints one line of figures for each method. Without --method, both run, and must find the same contacts.

Usage: planes [OPTIONS]

Options:
  --rings <RINGS>    Rings of cubes around the central cube of each plane; r rings make 2·(2r + 1)² cubes [default: 10]
  --max-objects <N>  How many objects a leaf of the octree may list before it splits [default: 50]
  --steps <STEPS>    How many ticks to run [default: 200]
  --method <METHOD>  How overlapping boxes are searched for: `auto`, `linear`, `object` or `exhaustive`. The last two, one
                     after the other, if not given
  --scene <FILE>     A scene file to run instead of a test set, such as assets/scenes/mixed_shapes.scene.ron; needs a
                     build with --features scene_files
  -h, --help         Print help
";

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

fn run(mut arguments: Arguments) -> Outcome {
    let rings: Option<u32> = arguments.option("--rings")?;
    let max_objects = arguments.option("--max-objects")?.unwrap_or(MAX_OBJECTS);
    let steps = arguments.option("--steps")?.unwrap_or(200);
    let method: Option<BroadPhaseMethod> = arguments.option("--method")?;
    let file: Option<PathBuf> = arguments.option("--scene")?;
    let [] = arguments.rest([])?;

    let scene = match (file, rings) {
        (Some(_), Some(_)) => return Err("--scene cannot be used with --rings".into()),
        (Some(file), None) => load(&file)?,
        (None, rings) => SceneDescription::from(TestSet::new(rings.unwrap_or(10))),
    };
    let octree = ObjectOctreeSettings::with_max_objects(max_objects);
    octree.check()?;
    let methods = match method {
        Some(BroadPhaseMethod::ObjectOctree(_)) => vec![BroadPhaseMethod::ObjectOctree(octree)],
        Some(method) => vec![method],
        None => vec![
            BroadPhaseMethod::ObjectOctree(octree),
            BroadPhaseMethod::Exhaustive,
        ],
    };
    let mut totals = Vec::new();
    for method in &methods {
        totals.push(measure(&scene, method, steps, max_objects)?);
    }
    if let [first, second] = &totals[..]
        && (first.contacts, first.bounces) != (second.contacts, second.bounces)
    {
        return Err("the two methods do not find the same contacts".into());
    }
    Ok(())
}

#[cfg(feature = "scene_files")]
fn load(file: &Path) -> Outcome<SceneDescription> {
    Ok(SceneDescription::load(file)?)
}

#[cfg(not(feature = "scene_files"))]
fn load(_: &Path) -> Outcome<SceneDescription> {
    Err("--scene needs a build with --features scene_files".into())
}

/// Runs a scene by one method, and prints its line.
fn measure(
    scene: &SceneDescription,
    method: &BroadPhaseMethod,
    steps: u32,
    max_objects: u32,
) -> Outcome<TickCounters> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings {
            method: method.clone(),
            ..default()
        })
        .insert_resource(MotionSettings {
            step: Step::Seconds(scene.tick_length()?.as_secs_f32()),
        });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let mut progress = Progress::new(u64::from(steps));
    let start = Instant::now();
    for step in 0..steps {
        progress.begin(format!(
            "{method}: {:.2} ms per step",
            per_step(start, step)
        ));
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
        app.world()
            .resource::<CollisionIndex>()
            .index()
            .stats()
            .nodes,
    );
    Ok(total)
}

/// The milliseconds that each of so many steps took.
fn per_step(start: Instant, steps: u32) -> f64 {
    start.elapsed().as_secs_f64() * 1e3 / f64::from(steps.max(1))
}
