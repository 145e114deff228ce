//! `peers broad`: the broad phase alone.
//!
//! The frames of a scene are made before anything is timed, so that every engine sees the same.
//! Engines take turns in blocks of [`BLOCK`] frames, each time in another order: what disturbs the
//! machine for a while disturbs all of them, and only the first frame of a block finds the caches
//! as another engine left them, which a median ignores. The first block is for warming up, and is
//! not counted. A frame's time is that of handing over all boxes, maintenance, and all pairs,
//! written to a list that keeps its memory.
//!
//! The pairs of all engines are compared frame by frame by their number and an order-independent
//! hash, with those of brute force if it takes part, otherwise with what most of the engines found.

mod chart;
mod report;
mod run;

use std::{fs, num::NonZero, path::PathBuf};

use clap::Args;

use crate::{
    engines::{self, Entry, Role},
    outcome::Outcome,
    progress::Progress,
    scenes::Case,
    threads::{Caller, use_threads},
};
use report::Report;

/// Frames for which an engine runs before the next one does.
const BLOCK: usize = 8;

/// Compares broad phases.
#[derive(Args)]
pub struct Arguments {
    /// Scenes, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<Case>,
    /// Numbers of objects.
    #[arg(long, value_delimiter = ',', default_value = "1000,8000,64000,256000")]
    objects: Vec<usize>,
    /// Frames to time, after eight to warm up.
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u16).range(1..=1000))]
    frames: u16,
    /// Engines, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_parser = engine)]
    engines: Vec<Entry>,
    /// How many threads work, in all engines that divide their work: this crate's but `exhaustive`,
    /// and parry, rapier and obvhs where they can.
    #[arg(long, default_value_t = NonZero::<usize>::MIN)]
    threads: NonZero<usize>,
    /// An engine that takes longer than so many seconds for a frame leaves the comparison.
    #[arg(long, default_value_t = 2.0)]
    limit: f64,
    /// Seed of the scenes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Draws the ratios to STEM.svg and STEM.png.
    #[arg(long, value_name = "STEM")]
    chart: Option<PathBuf>,
}

fn engine(name: &str) -> Result<Entry, String> {
    let all = engines::all();
    let names: Vec<_> = all.iter().map(|entry| entry.name).collect();
    all.iter()
        .find(|entry| entry.name == name)
        .copied()
        .ok_or_else(|| format!("unknown engine: expected one of {}", names.join(", ")))
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    use_threads(arguments.threads, Caller::Works)?;
    let or_all = |given: &[Case]| {
        if given.is_empty() {
            Case::all()
        } else {
            given.to_vec()
        }
    };
    let engines = if arguments.engines.is_empty() {
        engines::all()
    } else {
        arguments.engines.clone()
    };
    let cases = or_all(&arguments.scenes);
    let mut report = Report::default();
    let mut progress = Progress::new((cases.len() * arguments.objects.len()) as u64);
    println!("{}", report::HEADER);
    for case in cases {
        for &objects in &arguments.objects {
            progress.begin(format!("{case}, {objects} objects"));
            let engines: Vec<_> = engines
                .iter()
                .filter(|entry| objects <= entry.most_objects)
                .copied()
                .collect();
            let frames = case.frames(
                objects,
                BLOCK + usize::from(arguments.frames),
                arguments.seed,
            );
            let cell = run::compare(&case.to_string(), &frames, &engines, arguments.limit);
            print!("{cell}");
            report.cells.push(cell);
        }
    }
    drop(progress);
    print!("{report}");
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&report)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    if let Some(stem) = &arguments.chart {
        for path in chart::draw(stem, &report)? {
            println!("{}", path.display());
        }
    }
    if report
        .cells
        .iter()
        .flat_map(|cell| &cell.rows)
        .any(|row| row.role == Role::Ours && row.mismatch)
    {
        return Err("this crate's pairs differ from those of its peers".into());
    }
    Ok(())
}
