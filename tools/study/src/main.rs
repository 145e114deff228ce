//! Measures the crate by itself: `cargo run --release -p study --
//! timing|growth|scaling|stress|swept|neighbors|record|replay`; beside others, that is what `peers`
//! is for.
//!
//! - `timing`: the timing study of the 1994 report, with statistics. See [`timing`].
//! - `growth`: time and memory of the broad phase, from a thousand objects to a million.
//! - `scaling`: each stage on one thread and on two, and what follows for more.
//! - `stress`: a stress scene in a headless app, by stage.
//! - `swept`: what continuous detection costs, in a crowd and in free flight.
//! - `neighbors`: units that ask who is near, against a grid. See [`neighbors`].
//! - `record`, `replay`: traces of boxes, written and put through the broad phase.
//!
//! `--help` after any of them explains its arguments. `cargo bench -p study` measures one thing at
//! a time.

#[path = "../../../tests/common/brute_force.rs"]
mod brute_force;
mod extra;
mod growth;
mod neighbors;
#[path = "../../../examples/common/outcome.rs"]
mod outcome;
#[path = "../../common/plot.rs"]
mod plot;
#[path = "../../../examples/common/progress.rs"]
mod progress;
mod quantile;
mod record;
mod replay;
mod scaling;
mod stage_times;
mod stress;
mod stress_app;
mod swept;
mod threads;
mod timing;
mod which_scene;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measures `bevy_octree` by itself.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

// What each does is said by its arguments.
#[derive(Subcommand)]
enum Verb {
    Timing(timing::Arguments),
    Growth(growth::Arguments),
    Scaling(scaling::Arguments),
    Stress(stress::Arguments),
    Swept(swept::Arguments),
    Neighbors(neighbors::Arguments),
    Record(record::Arguments),
    Replay(replay::Arguments),
}

fn main() -> ExitCode {
    outcome::exit(match Arguments::parse().verb {
        Verb::Timing(arguments) => timing::run(&arguments),
        Verb::Growth(arguments) => growth::run(arguments),
        Verb::Scaling(arguments) => scaling::run(arguments),
        Verb::Stress(arguments) => stress::run(&arguments),
        Verb::Swept(arguments) => swept::run(&arguments),
        Verb::Neighbors(arguments) => neighbors::run(&arguments),
        Verb::Record(arguments) => record::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
    })
}
