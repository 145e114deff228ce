//! What each stage of a tick would take on more threads than there are here: a prediction.
//!
//! `cargo run --release -p study --features multi_threaded -- scaling --help` explains the
//! arguments.

mod bandwidth;
mod model;
mod run;
mod table;

use bevy_octree::scene::stress::StressScene;
use clap::Args;

use bandwidth::Bandwidth;
use model::Stage;
use run::{Place, StageMs, measure};

use crate::{outcome::Outcome, progress::Progress};

/// Two threads that compute less than so many times as much as one are disturbed by others.
const BUSY: f64 = 1.8;

/// Measures each stage of a tick on one thread and on two, and predicts what it takes on more.
///
/// Each run is a `study stress` of its own, for a process has one pool of threads; runs with one
/// thread and with two take turns, and the least of each stage's times counts, for what else the
/// machine does only adds to them. Where that is much, nothing follows, and it says so. What two threads
/// save tells the serial and the parallel share (Amdahl 1967). How much more an object takes among
/// many than among few, who fit in the cache, tells how much of the parallel share waits for
/// memory, which more threads speed up only until there is no more bandwidth.
///
/// Prints a table for each scene and number of objects, and what a tick at 60 Hz would need. A range
/// is from a machine on which memory gives no more threads than it gives two here, to one on which
/// it gives all of them what they ask for.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// The scenes: brownian, freefall, gravity, planes, static90, sizes, clusters, ground, outlier
    /// or rooms.
    #[arg(long, value_delimiter = ',', default_values_t = [StressScene::Brownian, StressScene::Gravity])]
    scenes: Vec<StressScene>,
    /// How many objects.
    #[arg(long, value_delimiter = ',', default_values_t = [64_000, 1_000_000])]
    objects: Vec<usize>,
    /// How many objects fit in the cache, to compare with.
    #[arg(long, default_value_t = 4_000)]
    few: usize,
    /// For how many threads to predict.
    #[arg(long, value_delimiter = ',', default_values_t = [4, 8, 16])]
    threads: Vec<u32>,
    /// How many runs there are of each kind.
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// How many frames each run has at least; with few objects it has more.
    #[arg(long, default_value_t = 20)]
    frames: u32,
    /// Another seed gives other scenes of the same kind.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Seconds instead of minutes: up to 16 000 objects, and one run of each kind.
    #[arg(long, conflicts_with_all = ["objects", "runs"])]
    quick: bool,
}

pub fn run(mut arguments: Arguments) -> Outcome {
    if !cfg!(feature = "multi_threaded") {
        return Err("two threads need a build with --features multi_threaded".into());
    }
    if arguments.quick {
        arguments.objects = vec![16_000];
        arguments.runs = 1;
    }
    let Arguments {
        scenes,
        objects,
        few,
        runs,
        ..
    } = &arguments;
    let bandwidth = Bandwidth::measure();
    let cores = bandwidth::free_cores();
    println!("{bandwidth} Two threads compute {cores:.2} times as much as one.\n");
    if cores < BUSY {
        println!(
            "**The machine does something else, too: two threads have no two cores, and what follows means little.**\n"
        );
    }
    let runs_of_all = scenes.len() * (objects.len() + 1) * (*runs).max(1) * 2;
    let mut progress = Progress::new(runs_of_all as u64);
    for &scene in scenes {
        let [few_ms, _] = fastest(&arguments, scene, *few, &mut progress)?;
        for &objects in objects {
            let [one, two] = fastest(&arguments, scene, objects, &mut progress)?;
            let stages = stages(&one, &two, &few_ms, objects as f64 / (*few).max(1) as f64);
            let tables = table::Tables {
                scene,
                objects,
                stages: &stages,
                bandwidth: &bandwidth,
                threads: &arguments.threads,
            };
            println!("{tables}");
        }
    }
    Ok(())
}

/// The least milliseconds of each stage, on one thread and on two.
fn fastest(
    arguments: &Arguments,
    scene: StressScene,
    objects: usize,
    progress: &mut Progress,
) -> Outcome<[StageMs; 2]> {
    let mut all = [Vec::new(), Vec::new()];
    let frames = arguments
        .frames
        .max(u32::try_from(2_000_000 / objects.max(1)).unwrap_or(u32::MAX));
    for _ in 0..arguments.runs.max(1) {
        for (threads, runs) in (1..).zip(&mut all) {
            progress.begin(format!("{scene}, {objects} objects, threads: {threads}"));
            runs.push(measure(Place {
                scene,
                objects,
                threads,
                frames,
                seed: arguments.seed,
            })?);
        }
    }
    Ok(all.map(|runs| least_of(&runs)))
}

/// The least time of each stage over runs, all of which have the same stages.
fn least_of(runs: &[StageMs]) -> StageMs {
    let names = runs.first().into_iter().flatten();
    names
        .enumerate()
        .map(|(index, (name, _))| {
            let times = runs.iter().map(|run| run[index].1);
            (name.clone(), times.fold(f64::INFINITY, f64::min))
        })
        .collect()
}

/// What is known of each stage; `times` as many objects were measured as fit in the cache.
fn stages(one: &StageMs, two: &StageMs, few: &StageMs, times: f64) -> Vec<Stage> {
    one.iter()
        .zip(two)
        .zip(few)
        .map(|(((name, one), (_, two)), (_, few))| {
            Stage::new(name.clone(), *one, *two, few * times)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{model::predict, *};

    #[test]
    fn the_least_is_by_stage() {
        let run = |a: f64, b: f64| vec![("a".to_owned(), a), ("b".to_owned(), b)];
        let least = least_of(&[run(1.0, 9.0), run(2.0, 7.0), run(3.0, 8.0)]);
        assert_eq!(least, run(1.0, 7.0));
    }

    #[test]
    fn more_threads_never_make_it_slower() {
        let stages = stages(
            &vec![("a".to_owned(), 10.0), ("b".to_owned(), 4.0)],
            &vec![("a".to_owned(), 6.0), ("b".to_owned(), 5.0)],
            &vec![("a".to_owned(), 4.0), ("b".to_owned(), 4.0)],
            2.0,
        );
        let mut before = f64::INFINITY;
        for threads in [1, 2, 4, 1000] {
            let now = predict(&stages, threads, 1.5).low;
            assert!(now <= before, "{now}, {before}");
            before = now;
        }
        assert!((before - 6.0).abs() < 0.01, "two serial shares: {before}");
    }
}
