//! `peers queries`: rays, regions and nearest objects, against boxes that rest.
//!
//! - A *ray* from a random point in a random direction finds the first box that it meets, and how
//!   far away.
//! - A *region* is a cube at a random place, and finds all boxes that overlap it.
//! - *Nearest* finds the box next to a random point, and how far away.
//!
//! All engines hold the boxes of the `brownian` scene and get the same queries, a batch at a time,
//! by turns; the first batch is not counted. What they find is compared: hits, and sums of
//! distances. obvhs builds with its medium settings, which take longer than a game has each frame
//! and pay in queries; its boxes stand in the tree's order. Avian's queries go through its
//! `SpatialQuery`, which tests colliders, not boxes: here they are the same, but that Avian makes
//! the boxes 0.005 larger, so that its regions find a little more. An engine that turns out to be
//! slower than [`LIMIT_NS`] per query answers a few only; what Avian does for the nearest collider
//! looks at all of them, and so does Bevy's `MeshRayCast`, which asks meshes of cubes, for each ray.

mod engines;
mod mesh_ray_cast;

use std::{fs, path::PathBuf, time::Instant};

use bevy::math::{Dir3, Vec3, bounding::Aabb3d};
use bevy_octree::scene::stress::{StressScene, StressSimulation};
use clap::Args;
use serde::Serialize;

use crate::{engines::Role, measure::median, outcome::Outcome, progress::Progress};
use engines::{Answer, Entry, QueryEngine};

/// Nanoseconds per query beyond which a few of them are enough.
const LIMIT_NS: f64 = 250_000.0;
/// A few.
const FEW: usize = 8;

/// Compares queries.
#[derive(Args)]
pub struct Arguments {
    /// Boxes.
    #[arg(long, default_value_t = 64_000, value_parser = clap::value_parser!(u32).range(1..))]
    objects: u32,
    /// Queries of each kind in a batch.
    #[arg(long, default_value_t = 4000, value_parser = clap::value_parser!(u32).range(1..))]
    batch: u32,
    /// Batches to time, after one to warm up.
    #[arg(long, default_value_t = 11, value_parser = clap::value_parser!(u16).range(1..))]
    batches: u16,
    /// Side of the regions, in sides of a box.
    #[arg(long, default_value_t = 4.0)]
    region: f32,
    /// Seed of boxes and queries.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// A ray of unbounded length.
#[derive(Clone, Copy)]
pub struct Ray {
    origin: Vec3,
    direction: Dir3,
}

/// The queries of a batch.
pub struct Batch {
    rays: Vec<Ray>,
    regions: Vec<Aabb3d>,
    points: Vec<Vec3>,
}

impl Batch {
    fn new(boxes: &[Aabb3d], arguments: &Arguments) -> Self {
        let low = boxes
            .iter()
            .fold(Vec3::INFINITY, |low, aabb| low.min(aabb.min.into()));
        let high = boxes
            .iter()
            .fold(Vec3::NEG_INFINITY, |high, aabb| high.max(aabb.max.into()));
        // Not the numbers that the boxes were drawn from.
        let mut random = fastrand::Rng::with_seed(!arguments.seed);
        let unit = |random: &mut fastrand::Rng| Vec3::new(random.f32(), random.f32(), random.f32());
        let half = Vec3::splat(arguments.region / 2.0);
        let mut batch = Self {
            rays: vec![],
            regions: vec![],
            points: vec![],
        };
        for _ in 0..arguments.batch {
            let origin = low + (high - low) * unit(&mut random);
            let direction = Dir3::new(unit(&mut random) - 0.5).unwrap_or(Dir3::X);
            batch.rays.push(Ray { origin, direction });
            batch
                .regions
                .push(Aabb3d::new(low + (high - low) * unit(&mut random), half));
            batch.points.push(low + (high - low) * unit(&mut random));
        }
        batch
    }
}

/// What is asked for.
#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Rays,
    Regions,
    Nearest,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Rays, Self::Regions, Self::Nearest];

    const fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::Regions => "regions",
            Self::Nearest => "nearest",
        }
    }

    /// Asks the first so many queries of the batch; also tells how many nanoseconds each took.
    fn ask(
        self,
        engine: &mut dyn QueryEngine,
        batch: &Batch,
        queries: usize,
    ) -> Option<(Answer, f64)> {
        let start = Instant::now();
        let answer = match self {
            Self::Rays => engine.rays(&batch.rays[..queries]),
            Self::Regions => engine.regions(&batch.regions[..queries]),
            Self::Nearest => engine.nearest(&batch.points[..queries]),
        }?;
        Some((answer, start.elapsed().as_secs_f64() * 1e9 / queries as f64))
    }
}

/// Medians of an engine for one kind of query.
#[derive(Serialize)]
struct Row {
    kind: Kind,
    engine: &'static str,
    queries: usize,
    nanoseconds: f64,
    found: u64,
    sum: f64,
    mismatch: bool,
    #[serde(skip)]
    role: Role,
}

/// An engine and what was measured of it for one kind.
struct Runner<'a> {
    entry: &'a mut Entry,
    queries: usize,
    times: Vec<f64>,
    answer: Option<Answer>,
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    let simulation = StressSimulation::new(
        StressScene::Brownian,
        arguments.objects as usize,
        arguments.seed,
    );
    let boxes = simulation.boxes();
    let batch = Batch::new(boxes, arguments);
    let mut progress = Progress::new(1 + Kind::ALL.len() as u64);
    progress.begin("building");
    let mut engines = engines::all(boxes);
    let mut rows = vec![];
    for kind in Kind::ALL {
        progress.begin(kind.name());
        let all = batch.rays.len();
        let few = FEW.min(all);
        let mut runners: Vec<_> = engines
            .iter_mut()
            .filter_map(|entry| {
                let (_, time) = kind.ask(&mut *entry.engine, &batch, few)?;
                Some(Runner {
                    entry,
                    queries: if time > LIMIT_NS { few } else { all },
                    times: vec![],
                    answer: None,
                })
            })
            .collect();
        for number in 0..=arguments.batches {
            for Runner {
                entry,
                queries,
                times,
                answer,
            } in &mut runners
            {
                let asked = kind.ask(&mut *entry.engine, &batch, *queries);
                *answer = asked.map(|(answer, _)| answer);
                times.extend(asked.map(|(_, time)| time).filter(|_| number > 0));
            }
        }
        // The first engine that answered all is the measure for the others.
        let expected = runners
            .iter()
            .find(|runner| runner.queries == all)
            .and_then(|runner| runner.answer);
        for Runner {
            entry,
            queries,
            times,
            answer,
        } in runners
        {
            let (Some(answer), Some(expected)) = (answer, expected) else {
                continue;
            };
            rows.push(Row {
                kind,
                engine: entry.name,
                queries,
                nanoseconds: median(times),
                found: answer.found,
                sum: answer.sum,
                mismatch: queries == all && !answer.agrees(expected),
                role: entry.role,
            });
        }
    }
    drop(progress);
    print(&rows, arguments);
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&rows)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

fn print(rows: &[Row], arguments: &Arguments) {
    println!(
        "{} boxes, {} queries of each kind",
        arguments.objects, arguments.batch
    );
    println!("kind     engine           ns/query    queries      found            sum    / ours");
    for kind in Kind::ALL {
        let of_kind = || rows.iter().filter(|row| row.kind == kind);
        let best = |role| {
            of_kind()
                .filter(|row| row.role == role)
                .map(|row| row.nanoseconds)
                .reduce(f64::min)
        };
        let ours = best(Role::Ours);
        for Row {
            engine,
            queries,
            nanoseconds,
            found,
            sum,
            mismatch,
            ..
        } in of_kind()
        {
            print!(
                "{:<8} {engine:<14} {nanoseconds:>10.1} {queries:>10} {found:>10} {sum:>14.1}",
                kind.name()
            );
            print!(
                "{}",
                ours.map_or_else(String::new, |ours| format!("{:>10.2}", nanoseconds / ours))
            );
            println!("{}", if *mismatch { " MISMATCH" } else { "" });
        }
    }
    for kind in Kind::ALL {
        let best = |role| {
            let rows = rows
                .iter()
                .filter(|row| row.kind == kind && row.role == role);
            rows.min_by(|a, b| a.nanoseconds.total_cmp(&b.nanoseconds))
        };
        if let (Some(ours), Some(peer)) = (best(Role::Ours), best(Role::Peer)) {
            let ratio = peer.nanoseconds / ours.nanoseconds;
            println!(
                "{}_ratio={ratio:.2} ({} / {})",
                kind.name(),
                peer.engine,
                ours.engine
            );
        }
    }
}
