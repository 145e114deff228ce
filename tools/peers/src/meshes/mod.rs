//! `peers meshes`: exact tests against a mesh, this crate's `PolygonMesh` and parry's `TriMesh` of
//! the same triangles.
//!
//! Both get the same shapes in the same poses, near the surface, some of which touch it and some of
//! which do not; they take turns, batch by batch, and the median of the batches counts. parry is
//! asked by its public functions as its users do (`query::contact`, `cast_shapes`, `distance`,
//! `intersection_test`, with what these have as defaults), this crate by `NarrowPhase`.
//!
//! - `ray`: the first hit, of any length. parry is not asked for the normal, which this crate gives.
//! - `…-contact`: where and how deep. `…-intersects`: whether. `…-sweep`: when, within 20 length
//!   units. The capsule is Rapier's, for this crate by feature `rapier`. `mesh-…`: of a mesh of 800
//!   triangles.
//! - `closest-point`: of the mesh to a point. `distance`: of the mesh and a cuboid.
//! - `contains`: whether a point is inside, of closed meshes; for parry, by pseudo-normals, which
//!   take it a longer time to build (`build-closed`). This crate builds all that it needs at once.
//! - `build`: nanoseconds per triangle. Bytes are those that are allocated for what is built.
//!
//! What is slow answers a few questions only, but both the same ones. Where the two differ by more
//! than 0.001 length units, or one has a hit and the other none, each triangle is looked at in
//! 64-bit floats to see who is right. Depths are compared apart from that, for each defines its own.

#[path = "../../../../tests/common/allocator.rs"]
#[expect(dead_code, reason = "shared with tests")]
mod allocator;
mod engines;
mod queries;
pub mod reference;
mod report;
pub mod scenes;

use std::{fs, hint::black_box, path::PathBuf, time::Instant};

use bevy::math::Vec3;
use clap::Args;
use parry3d::shape::TriMeshFlags;

use crate::{measure::median, outcome::Outcome, progress::Progress};
use engines::{Answer, Engine, Ours, Parry};
use queries::{Operation, Query, ROCK};
use report::{Cell, Differences, Memory, Report};
use scenes::{Mesh, Scene};

/// Compares exact tests against meshes.
#[derive(Args)]
pub struct Arguments {
    /// Scenes, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<Scene>,
    /// Operations, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    operations: Vec<Operation>,
    /// Numbers of triangles.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1000,10000,100000,1000000"
    )]
    sizes: Vec<usize>,
    /// Leaves out sizes beyond this.
    #[arg(long, default_value_t = 100_000)]
    max: usize,
    /// Questions in a batch.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..))]
    batch: u32,
    /// Batches to time, after one to warm up.
    #[arg(long, default_value_t = 11, value_parser = clap::value_parser!(u16).range(1..))]
    batches: u16,
    /// Seconds for one operation on one mesh, about.
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,
    /// A first impression: few questions, batches and seconds.
    #[arg(long)]
    quick: bool,
    /// Seed of meshes and questions.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// How long and how often something is measured.
#[derive(Clone, Copy)]
struct Effort {
    batch: usize,
    batches: usize,
    seconds: f64,
}

impl Effort {
    fn of(arguments: &Arguments) -> Self {
        if arguments.quick {
            return Self {
                batch: 64,
                batches: 5,
                seconds: 0.1,
            };
        }
        Self {
            batch: arguments.batch as usize,
            batches: usize::from(arguments.batches),
            seconds: arguments.seconds,
        }
    }
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    let or_all = |given: &[Scene]| match given {
        [] => Scene::ALL.to_vec(),
        _ => given.to_vec(),
    };
    let operations = match arguments.operations.as_slice() {
        [] => Operation::ALL.to_vec(),
        given => given.to_vec(),
    };
    let sizes = arguments
        .sizes
        .iter()
        .filter(|size| **size <= arguments.max);
    let sizes: Vec<_> = sizes.copied().collect();
    let scenes = or_all(&arguments.scenes);
    let mut report = Report::default();
    let mut progress = Progress::new((scenes.len() * sizes.len() * operations.len()) as u64);
    println!("{}", report::HEADER);
    for scene in scenes {
        for &size in &sizes {
            let mut stage = Stage::new(scene, size, arguments);
            report.bytes.push(stage.memory());
            for &operation in &operations {
                progress.begin(format!("{scene}, {size} triangles, {operation}"));
                if operation.is_for_closed() && !scene.is_closed() {
                    continue;
                }
                let cell = stage.cell(operation);
                print!("{cell}");
                report.cells.push(cell);
            }
        }
    }
    drop(progress);
    print!("{report}");
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&report)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// A mesh and both engines that have it.
struct Stage {
    scene: Scene,
    mesh: Mesh,
    ours: Ours,
    parry: Parry,
    /// Of ours, parry's, and parry's with pseudo-normals.
    bytes: [usize; 3],
    effort: Effort,
    seed: u64,
}

impl Stage {
    fn new(scene: Scene, size: usize, arguments: &Arguments) -> Self {
        let mesh = scene.mesh(size, arguments.seed);
        let rock = scenes::rock(ROCK, arguments.seed);
        let (ours, our_bytes) = counted(|| Ours::build(&mesh));
        let (theirs, their_bytes) = counted(|| Parry::build(&mesh, TriMeshFlags::empty()));
        let (oriented, oriented_bytes) = counted(|| {
            scene
                .is_closed()
                .then(|| Parry::build(&mesh, TriMeshFlags::ORIENTED))
        });
        Self {
            scene,
            ours: Ours::new(ours, &rock),
            parry: Parry::new(theirs, oriented, &rock),
            bytes: [our_bytes, their_bytes, oriented_bytes],
            mesh,
            effort: Effort::of(arguments),
            seed: arguments.seed,
        }
    }

    fn memory(&self) -> Memory {
        let triangles = self.mesh.triangles.len();
        let [ours, parry, oriented] = self.bytes.map(|bytes| bytes as f64 / triangles as f64);
        Memory {
            scene: self.scene.name(),
            triangles,
            ours,
            parry,
            parry_oriented: self.scene.is_closed().then_some(oriented),
        }
    }

    fn cell(&mut self, operation: Operation) -> Cell {
        if operation.is_build() {
            self.build(operation)
        } else {
            self.compare(operation)
        }
    }

    fn build(&self, operation: Operation) -> Cell {
        let flags = match operation {
            Operation::BuildClosed => TriMeshFlags::ORIENTED,
            _ => TriMeshFlags::empty(),
        };
        let time = |build: &dyn Fn()| {
            let start = Instant::now();
            build();
            start.elapsed().as_secs_f64()
        };
        let (mut times, mut spent) = ([vec![], vec![]], 0.0);
        while times[0].len() <= self.effort.batches && spent < self.effort.seconds
            || times[0].len() < 2
        {
            let [ours, parry] = [
                time(&|| drop(black_box(Ours::build(&self.mesh)))),
                time(&|| drop(black_box(Parry::build(&self.mesh, flags)))),
            ];
            spent += ours + parry;
            times[0].push(ours);
            times[1].push(parry);
        }
        let triangles = self.mesh.triangles.len();
        let [ours_ns, parry_ns] =
            times.map(|times| median(times.into_iter().skip(1)) * 1e9 / triangles as f64);
        Cell {
            scene: self.scene.name(),
            triangles,
            operation,
            queries: 1,
            ours_ns,
            parry_ns,
            hits: 0,
            differences: Differences::default(),
        }
    }

    fn compare(&mut self, operation: Operation) -> Cell {
        let queries = self.queries(operation);
        let mut engines: [&mut dyn Engine; 2] = [&mut self.ours, &mut self.parry];
        let mut answers = [vec![], vec![]];
        let mut ask = |which: usize, count: usize| {
            answers[which].clear();
            let start = Instant::now();
            engines[which].ask(operation, &queries[..count], &mut answers[which]);
            start.elapsed().as_secs_f64() / count as f64
        };
        // As many as there is time for, judged by ever more of them.
        let mut count = 1;
        let both = loop {
            let both: f64 = [0, 1].map(|which| ask(which, count)).iter().sum();
            let next = (4 * count).min(queries.len());
            let whole = both * (next * (self.effort.batches + 1)) as f64;
            if next == count || whole > self.effort.seconds {
                break both;
            }
            count = next;
        };
        let mut times = [vec![], vec![]];
        let mut batches = (self.effort.seconds / (both * count as f64)) as usize;
        batches = batches.clamp(1, self.effort.batches);
        for number in 0..batches {
            for which in [number % 2, 1 - number % 2] {
                times[which].push(ask(which, count));
            }
        }
        let [ours_ns, parry_ns] = times.map(|times| median(times) * 1e9);
        let [ours, parry] = answers;
        Cell {
            scene: self.scene.name(),
            triangles: self.mesh.triangles.len(),
            operation,
            queries: count,
            ours_ns,
            parry_ns,
            hits: ours.iter().flatten().count(),
            differences: self.differences(operation, &queries, &ours, &parry),
        }
    }

    /// Where it is free outside the solid, if there is one and the question is about what is apart.
    fn queries(&self, operation: Operation) -> Vec<Query> {
        use Operation as O;
        let effort = self.effort;
        let is_outside = matches!(
            operation,
            O::Ray
                | O::BallSweep
                | O::CuboidSweep
                | O::CapsuleSweep
                | O::MeshSweep
                | O::ClosestPoint
                | O::Distance
        );
        if !(is_outside && self.scene.is_closed()) {
            return queries::queries(operation, &self.mesh, effort.batch, self.seed);
        }
        let mut queries = queries::queries(operation, &self.mesh, 2 * effort.batch, self.seed);
        queries.retain(|query| !reference::is_inside(&self.mesh, query.position.as_dvec3()));
        queries.truncate(effort.batch);
        queries
    }

    fn differences(
        &self,
        operation: Operation,
        queries: &[Query],
        ours: &[Answer],
        parry: &[Answer],
    ) -> Differences {
        use Operation as O;
        let is_depth = matches!(
            operation,
            O::BallContact | O::CuboidContact | O::CapsuleContact | O::MeshContact
        );
        let [low, high] = self.mesh.bounds();
        let size = ((high - low) * 0.5).max_element() + Vec3::splat(1.0).max_element();
        // As this crate documents it.
        let tolerance = f64::from(1e-4f32.max(16.0 * f32::EPSILON * size));
        let mut found = Differences::default();
        for ((query, ours), parry) in queries.iter().zip(ours).zip(parry) {
            let is_same = match (ours, parry) {
                (Some(ours), Some(parry)) => {
                    let is_near = f64::from((ours - parry).abs()) <= reference::SAME;
                    found.depths += usize::from(is_depth && !is_near);
                    is_depth || is_near
                }
                (None, None) => true,
                _ => false,
            };
            if is_same {
                continue;
            }
            found.answers += 1;
            let Some(truth) = reference::truth(operation, &self.mesh, query) else {
                continue;
            };
            let allows = |answer: &Answer| truth.allows(operation, *answer, tolerance);
            match (allows(ours), allows(parry)) {
                (true, true) => found.both_right += 1,
                (true, false) => found.ours_right += 1,
                (false, true) => found.parry_right += 1,
                (false, false) => {}
            }
        }
        found
    }
}

/// What is made, and how many bytes it holds.
fn counted<T>(make: impl FnOnce() -> T) -> (T, usize) {
    let before = allocator::live();
    let made = make();
    (made, allocator::live() - before)
}
