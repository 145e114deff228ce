//! The timing study of Swan, *Fast Collision Detection with an N-Objects Octree*, 1994, section 3,
//! as a script; and further, to a hundred thousand objects.
//!
//! `cargo run --release -p study -- timing --help` explains the arguments.

mod answers;
mod chart;
mod figures;
mod growth;
mod headless;
mod measure;
mod output;
mod runs;
mod stats;
mod table;

use std::{path::PathBuf, time::Duration};

use bevy_octree::scene::TestSet;
use clap::{Parser, value_parser};

use answers::{Answers, answer, probability};
use growth::Growth;
use measure::{Laboratory, Row};
use output::{Output, significant};
use runs::Runs;
use table::Table;

use crate::outcome::Outcome;

/// Measures collision detection on test sets of cubes, and asks what the measurements mean.
///
/// First, the sets t0 to t10 (2 to 882 cubes), searched by octrees of at most N = 5, 10, 30, 50 and
/// "big" objects in a leaf, and exhaustively: a table, two figures, and answers with statistics to
/// the questions which N is best, from what size on the octree is faster, and how surely; the same
/// several times over, for the means of what is said of the largest set and of that size. Then,
/// sets of up to 97 682 cubes: the exponent with which the time of a step grows.
///
/// Written to the folder of --out: table1.md, table1.csv, samples.csv, answers.md, growth.csv, and
/// figure9, figure10 and growth as SVG and PNG.
#[derive(Parser)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// The folder for what is written; made if there is none.
    #[arg(long, value_name = "DIR", default_value = "target/timing_study")]
    out: PathBuf,
    /// Seconds instead of minutes: every other set, 50 steps, 11 repeats, 3 runs, 40 rings, a
    /// budget of 2, where these are not given.
    #[arg(long)]
    quick: bool,
    /// How many steps each run has [default: 200].
    #[arg(long, value_parser = value_parser!(u32).range(1..=1_000_000))]
    steps: Option<u32>,
    /// How often each run is repeated, after a pass that warms up; at most 5 times in the study of
    /// growth, whose runs are long [default: 15].
    #[arg(long, value_parser = value_parser!(u32).range(1..=200))]
    repeats: Option<u32>,
    /// How often the table is measured as a whole: the ratio on its largest set and the crossover
    /// are given as means over these runs, with intervals of 95 % confidence [default: 5].
    #[arg(long, value_parser = value_parser!(u32).range(1..=100))]
    runs: Option<u32>,
    /// The rings of the largest set in the study of growth: r rings are 2·(2r + 1)² cubes [default:
    /// 110].
    #[arg(long, value_name = "RINGS", value_parser = value_parser!(u32).range(1..=i64::from(TestSet::MAX_RINGS)))]
    max_rings: Option<u32>,
    /// How many seconds exhaustive search may take in the study of growth, about; its steps, then
    /// its repeats, then its sizes are cut to fit [default: 120].
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    budget: Option<Duration>,
    /// Fixes the order of the runs, which is shuffled, and the bootstrap's resamples.
    #[arg(long, default_value_t = 1994)]
    seed: u64,
}

impl Arguments {
    /// The plan of one of the runs.
    fn table_plan(&self, run: u32) -> table::Plan {
        let every = if self.quick { 2 } else { 1 };
        table::Plan {
            sets: (0..=10).step_by(every).map(TestSet::new).collect(),
            steps: self.steps(),
            repeats: self.repeats(),
            seed: self.seed.wrapping_add(u64::from(run)),
        }
    }

    fn growth_plan(&self) -> growth::Plan {
        let largest = self.max_rings.unwrap_or(if self.quick { 40 } else { 110 });
        let rings = [10, 20, 30, 40, 60, 80, 110]
            .into_iter()
            .filter(|rings| *rings < largest)
            .chain([largest]);
        growth::Plan {
            sets: rings.map(TestSet::new).collect(),
            octrees: Row::ALL
                .into_iter()
                .filter(|row| row.is_divided())
                .collect(),
            steps: self.steps(),
            repeats: self.repeats().min(5),
            budget: self
                .budget
                .unwrap_or(Duration::from_secs(if self.quick { 2 } else { 120 })),
            seed: self.seed,
        }
    }

    fn steps(&self) -> u32 {
        self.steps.unwrap_or(if self.quick { 50 } else { 200 })
    }

    fn runs(&self) -> u32 {
        self.runs.unwrap_or(if self.quick { 3 } else { 5 })
    }

    fn repeats(&self) -> u32 {
        self.repeats.unwrap_or(if self.quick { 11 } else { 15 })
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().map_err(|_| "expected a number of seconds")?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

pub fn run(args: &Arguments) -> Outcome {
    if cfg!(debug_assertions) {
        eprintln!(
            "warning: a build without optimisation, whose times mean little: use `cargo run --release`"
        );
    }
    let output = Output::new(&args.out)?;
    let mut laboratory = Laboratory::default();

    let table = Table::measure(args.table_plan(0), &mut laboratory)?;
    println!("{}", table.write(&output)?);
    figures::figures_9_and_10(&table, &output)?;
    let Answers {
        best,
        mut text,
        largest,
    } = answer(&table, args.seed);
    let mut runs = Runs::new(best);
    runs.push(&table);
    for run in 1..args.runs() {
        runs.push(&Table::measure(args.table_plan(run), &mut laboratory)?);
    }
    text += &runs.text();
    println!("{text}");

    let growth = Growth::measure(&args.growth_plan(), &mut laboratory)?;
    growth.write(&output)?;
    figures::growth_figure(&growth, &output)?;
    let set = table.sets[table.sets.len() - 1];
    let verdict = if largest.is_faster() {
        "holds"
    } else {
        "is not shown"
    };
    let conclusion = format!(
        "{}\n## What should hold\n\n\
         - The octree at {best} beats exhaustive search on {}: **{verdict}** ({} of its time, p after Holm's correction \
         {}).\n- {}\n",
        growth.text(),
        set.name(),
        significant(largest.ratio.mid),
        probability(largest.corrected),
        growth.acceptance()
    );
    println!("{conclusion}");
    output.text("answers.md", &(text + &conclusion))?;
    println!("All files are in {}.", args.out.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_arguments_are_named() {
        for (argument, value) in [
            ("--steps", "0"),
            ("--steps", "-1"),
            ("--repeats", "0"),
            ("--runs", "0"),
            ("--repeats", "many"),
            ("--max-rings", "1001"),
            ("--budget", "-1"),
        ] {
            let error = Arguments::try_parse_from(["timing", argument, value])
                .err()
                .unwrap()
                .to_string();
            assert!(error.contains(argument) && error.contains(value), "{error}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_written_to_is_named() {
        let args = Arguments::parse_from(["timing", "--out", "Cargo.toml/study"]);
        assert!(
            run(&args)
                .unwrap_err()
                .to_string()
                .contains("Cargo.toml/study")
        );
    }

    #[test]
    fn a_small_study_writes_all_its_files() {
        let out = std::env::temp_dir().join(format!("timing_study_{}", std::process::id()));
        let small = [
            "--quick",
            "--steps",
            "2",
            "--repeats",
            "1",
            "--runs",
            "2",
            "--max-rings",
            "2",
            "--out",
        ];
        let args = Arguments::parse_from(["timing"].into_iter().chain(small).chain(out.to_str()));
        run(&args).unwrap();
        for name in
            "table1.md table1.csv samples.csv answers.md growth.csv figure9.svg figure10.png growth.png".split(' ')
        {
            assert!(std::fs::metadata(out.join(name)).unwrap().len() > 100, "{name}");
        }
        std::fs::remove_dir_all(out).unwrap();
    }
}
