//! How the cost of the broad phase grows with the number of objects, at constant density.
//!
//! `cargo run --release -p study -- growth --help` explains the arguments.

use std::time::{Duration, Instant};

use bevy_octree::{
    broad_phase::{BroadPhaseMethod, ProxyId, SpatialIndex},
    scene::stress::{StressScene, StressSimulation},
};
use clap::Args;

use crate::{outcome::Outcome, progress::Progress, quantile::quantile};

/// What a method does may alternate from tick to tick: a sample is the mean over so many.
const SPAN: usize = 8;

/// Few objects are measured over more spans, until so many boxes have been set.
const BOXES_SET: usize = 8_000_000;

/// Measures how time and memory grow with the number of objects, on scenes that are as dense at a
/// million objects as at a thousand; then objects that come all at once, and go all at once.
///
/// A tick sets every box, brings the index up to date and finds all pairs; the motion of the scene
/// is not in it. `ns_per_object` is the median over spans of eight ticks, `growth` its ratio to
/// that of the smallest number of objects, `bytes_per_object` the memory of the index: boxes, broad
/// phase and pairs. `build_ns` and `despawn_ns` are for each object, the medians of several builds.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// The scenes: brownian, freefall, gravity, planes, static90, sizes, clusters, ground, outlier
    /// or rooms.
    #[arg(long, value_delimiter = ',', default_values_t = [StressScene::Brownian, StressScene::Gravity])]
    scenes: Vec<StressScene>,
    /// The broad phases: auto, linear, object or exhaustive.
    #[arg(long, value_delimiter = ',', default_values_t = [BroadPhaseMethod::Auto])]
    engines: Vec<BroadPhaseMethod>,
    /// How many objects, from few to many.
    #[arg(long, value_delimiter = ',', default_values_t = [1_000, 4_000, 16_000, 64_000, 250_000, 1_000_000])]
    objects: Vec<usize>,
    /// How many objects come and go at once.
    #[arg(long, value_delimiter = ',', default_values_t = [200_000, 400_000])]
    builds: Vec<usize>,
    /// How many spans of ticks, and how many builds, are measured at least.
    #[arg(long, default_value_t = 5)]
    repeats: usize,
    /// Another seed gives other scenes of the same kind.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Seconds instead of a minute: up to 16 000 objects, builds of 20 000 and 40 000, and 2
    /// repeats.
    #[arg(long, conflicts_with_all = ["objects", "builds", "repeats"])]
    quick: bool,
}

pub fn run(mut arguments: Arguments) -> Outcome {
    if arguments.quick {
        arguments.objects = vec![1_000, 4_000, 16_000];
        arguments.builds = vec![20_000, 40_000];
        arguments.repeats = 2;
    }
    let arguments = &arguments;
    let Arguments {
        scenes,
        engines,
        objects,
        builds,
        ..
    } = arguments;
    let mut progress =
        Progress::new((scenes.len() * engines.len() * (objects.len() + builds.len())) as u64);
    for scene in scenes {
        for engine in engines {
            let mut smallest = None;
            for &objects in objects {
                progress.begin(format!("{scene}, {engine}, {objects} objects"));
                let Tick { ns, bytes, pairs } = tick(arguments, *scene, engine, objects)?;
                let growth = ns / *smallest.get_or_insert(ns);
                println!(
                    "scene={scene} engine={engine} objects={objects} ns_per_object={ns:.1} growth={growth:.2} \
                     bytes_per_object={bytes:.1} pairs_per_object={pairs:.2}"
                );
            }
            for &objects in builds {
                progress.begin(format!("{scene}, {engine}, {objects} objects at once"));
                let [build, despawn] = lifetime(arguments, *scene, engine, objects)?;
                println!(
                    "scene={scene} engine={engine} objects={objects} build_ns={build:.1} despawn_ns={despawn:.1}"
                );
            }
        }
    }
    Ok(())
}

/// What a tick costs, by object.
struct Tick {
    ns: f64,
    bytes: f64,
    pairs: f64,
}

fn tick(
    arguments: &Arguments,
    scene: StressScene,
    engine: &BroadPhaseMethod,
    objects: usize,
) -> Outcome<Tick> {
    let mut simulation = StressSimulation::new(scene, objects, arguments.seed);
    let mut index = SpatialIndex::new(engine);
    let ids = spawn(&mut index, &simulation)?;
    index.find_pairs();
    let spans = arguments.repeats.max(BOXES_SET / SPAN / objects.max(1));
    let mut samples = Vec::with_capacity(spans);
    // The first span warms up.
    for span in 0..=spans {
        let mut time = Duration::ZERO;
        for _ in 0..SPAN {
            simulation.step();
            let start = Instant::now();
            for (id, aabb) in ids.iter().zip(simulation.boxes()) {
                index.set(*id, aabb)?;
            }
            index.find_pairs();
            time += start.elapsed();
        }
        if span > 0 {
            samples.push(nanoseconds(time, objects * SPAN));
        }
    }
    let per_object = |value: usize| value as f64 / objects.max(1) as f64;
    Ok(Tick {
        ns: quantile(&samples, 0.5),
        bytes: per_object(index.memory_bytes()),
        pairs: per_object(index.pairs().len()),
    })
}

/// The time for each object from nothing to all pairs, and from all objects to none.
///
/// All builds are made in one index, and the first is not counted: whether the system maps fresh
/// memory for each of them depends on the size, and would be measured instead.
fn lifetime(
    arguments: &Arguments,
    scene: StressScene,
    engine: &BroadPhaseMethod,
    objects: usize,
) -> Outcome<[f64; 2]> {
    let simulation = StressSimulation::new(scene, objects, arguments.seed);
    let mut index = SpatialIndex::new(engine);
    let (mut builds, mut despawns) = (Vec::new(), Vec::new());
    for repeat in 0..=arguments.repeats {
        let start = Instant::now();
        let ids = spawn(&mut index, &simulation)?;
        index.find_pairs();
        let built = Instant::now();
        for id in ids {
            index.remove(id);
        }
        index.find_pairs();
        let end = Instant::now();
        if repeat > 0 {
            builds.push(nanoseconds(built - start, objects));
            despawns.push(nanoseconds(end - built, objects));
        }
        // Two more updates, and the handles can be used again.
        index.update();
        index.update();
    }
    Ok([builds, despawns].map(|times| quantile(&times, 0.5)))
}

fn spawn(index: &mut SpatialIndex, simulation: &StressSimulation) -> Outcome<Vec<ProxyId>> {
    Ok(simulation
        .boxes()
        .iter()
        .map(|aabb| index.insert(*aabb))
        .collect::<Result<_, _>>()?)
}

fn nanoseconds(time: Duration, objects: usize) -> f64 {
    time.as_secs_f64() * 1e9 / objects.max(1) as f64
}
