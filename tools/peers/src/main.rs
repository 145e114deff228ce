//! Measures this crate and its peers side by side: `cargo run --release -p peers --
//! broad|app|queries|meshes|shapes|characters`.
//!
//! - `broad`: the broad phase alone. Every engine gets the same boxes, frame by frame, and gives
//!   all pairs that overlap; engines take turns, in one process and on one thread. See [`broad`]
//!   and [`engines`].
//! - `app`: end to end in headless Bevy apps. See [`app`].
//! - `queries`: rays, regions and nearest objects. See [`queries`].
//! - `meshes`: exact tests against meshes. See [`meshes`].
//! - `shapes`: exact tests of two shapes. See [`shapes`].
//! - `characters`: characters that walk. See [`characters`].
//!
//! # What is fair
//!
//! | setting | reason |
//! |---|---|
//! | release profile, one codegen unit per crate, as in the workspace's `Cargo.toml` | what this crate's own programs are built with; no crate is built otherwise than the others |
//! | thin link-time optimisation for published figures: `CARGO_PROFILE_RELEASE_LTO=thin` | calls across crates are inlined for all; not in the profile, where it would make every example slow to build |
//! | no `target-cpu` | what users get; who detects wider instructions at run time may use them |
//! | parry, rapier, obvhs and rstar at their newest versions, Avian and `bevy_rapier` at the newest for Bevy 0.19 | the best that there is |
//! | no peer's `parallel` feature, Bevy without `multi_threaded` | one thread each; with the feature `parallel`, all have theirs, and `--threads` says how many work in `app` and `broad` |
//! | Avian with `simd` | it is faster, and changes nothing else |
//! | skins and margins as rapier and Avian set them | scenes are made for boxes of about one length unit |

mod app;
mod broad;
mod characters;
mod engines;
mod measure;
mod meshes;
#[path = "../../../examples/common/outcome.rs"]
mod outcome;
#[path = "../../common/plot.rs"]
mod plot;
#[path = "../../../examples/common/progress.rs"]
mod progress;
mod queries;
mod scenes;
mod shapes;
mod threads;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measures `bevy_octree` and its peers side by side.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The broad phase alone: all overlapping pairs of moving boxes, frame by frame.
    Broad(broad::Arguments),
    /// End to end, in headless Bevy apps.
    App(app::Arguments),
    /// Rays, regions and nearest objects.
    Queries(queries::Arguments),
    /// Exact tests against meshes: rays, contacts, sweeps, distances, building.
    Meshes(meshes::Arguments),
    /// Exact tests of two shapes: contacts, distances, sweeps.
    Shapes(shapes::Arguments),
    /// Characters that walk: what they cost, what they are in, where they get to.
    Characters(characters::Arguments),
}

fn main() -> ExitCode {
    outcome::exit(match Arguments::parse().command {
        Command::Broad(arguments) => broad::run(&arguments),
        Command::App(arguments) => app::run(&arguments),
        Command::Queries(arguments) => queries::run(&arguments),
        Command::Meshes(arguments) => meshes::run(&arguments),
        Command::Shapes(arguments) => shapes::run(&arguments),
        Command::Characters(arguments) => characters::run(&arguments),
    })
}
