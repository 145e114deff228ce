//! Which objects of an animation touch, and when: the report over position tracks.
//!
//! `cargo run --release --features reports,scene_files --example animation_report --
//! assets/scenes/clip.scene.ron`

use std::{
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
    process::ExitCode,
};

use arguments::Arguments;
use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
    scene::{CollisionReport, Motion, SceneDescription},
};
use outcome::{Outcome, exit};
use progress::Progress;

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/progress.rs"]
mod progress;

const HELP: &str = "
Plays a clip, in which objects follow position tracks, and reports which of them touch: first and last contact of each
pair, and tick by tick.

Writes contacts.csv and contacts.jsonl (a row for each pair), ticks.csv and ticks.jsonl (a row for each tick with
contacts).

Usage: animation_report [OPTIONS] <FILE>

Arguments:
  <FILE>             The scene file to play

Options:
  --ticks <TICKS>    How many ticks to play; to the last keyframe if not given
  --out <FOLDER>     The folder to write to [default: target/animation_report]
  --method <METHOD>  How overlapping boxes are searched for: `auto`, `linear`, `object` or `exhaustive` [default: auto]
  -h, --help         Print help
";

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

fn run(mut arguments: Arguments) -> Outcome {
    let ticks = arguments.option("--ticks")?;
    let out = arguments
        .option("--out")?
        .unwrap_or_else(|| PathBuf::from("target/animation_report"));
    let method = arguments.option("--method")?.unwrap_or_default();
    let [file] = arguments.rest(["FILE"])?;

    let scene = SceneDescription::load(file)?;
    let ticks = ticks.unwrap_or_else(|| last_keyframe(&scene) + 1);
    let report = play(&scene, ticks, method)?;

    println!(
        "{:<12} {:<12} {:>6} {:>6} {:>6}  intervals",
        "a", "b", "first", "last", "ticks"
    );
    for pair in report.pairs() {
        let intervals: Vec<_> = pair
            .intervals
            .iter()
            .map(|(from, to)| format!("{from}–{to}"))
            .collect();
        println!(
            "{:<12} {:<12} {:>6} {:>6} {:>6}  {}",
            pair.a,
            pair.b,
            pair.first_contact,
            pair.last_contact,
            pair.ticks,
            intervals.join(", ")
        );
    }
    write(&report, &out)?;
    println!(
        "scene={} objects={} ticks={ticks} pairs={} ticks_with_contact={} out={}",
        scene.name,
        scene.object_count(),
        report.pairs().len(),
        report.ticks().count(),
        out.display()
    );
    Ok(())
}

/// The tick of the last keyframe of all tracks; 0 if there is none.
fn last_keyframe(scene: &SceneDescription) -> u64 {
    let last = |object: &bevy_octree::scene::ObjectDescription| match &object.motion {
        Motion::Track(track) => track.keyframes().last().map_or(0, |(tick, _)| *tick),
        _ => 0,
    };
    scene
        .objects()
        .map(|object| last(&object))
        .max()
        .unwrap_or(0)
}

/// Plays the clip in a headless app, and notes the contacts of each tick.
fn play(
    scene: &SceneDescription,
    ticks: u64,
    method: BroadPhaseMethod,
) -> Outcome<CollisionReport> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings {
            method,
            ..default()
        })
        .insert_resource(MotionSettings {
            step: Step::Seconds(scene.tick_length()?.as_secs_f32()),
        });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let mut report = CollisionReport::default();
    let mut progress = Progress::new(ticks);
    for tick in 0..ticks {
        progress.begin(format!("tick {tick}"));
        app.update();
        let world = app.world();
        let name = |entity| {
            world
                .get::<Name>(entity)
                .map_or_else(|| entity.to_string(), ToString::to_string)
        };
        let contacts = world
            .resource::<Contacts>()
            .iter()
            .map(|contact| (name(contact.a), name(contact.b)));
        report.record(tick, contacts)?;
    }
    Ok(report)
}

fn write(report: &CollisionReport, folder: &Path) -> Outcome {
    let create = |name: &str| {
        let path = folder.join(name);
        let file = File::create(&path)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        Outcome::Ok(BufWriter::new(file))
    };
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    report.write_csv(create("contacts.csv")?)?;
    report.write_jsonl(create("contacts.jsonl")?)?;
    report.write_ticks_csv(create("ticks.csv")?)?;
    report.write_ticks_jsonl(create("ticks.jsonl")?)?;
    Ok(())
}
