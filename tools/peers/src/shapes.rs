//! `peers shapes`: exact tests of two shapes, beside parry.
//!
//! The ten pairs that games have most, each in many poses near each other, about half of which are in
//! contact: whether they are, where and how deep, how far they are apart, and when one on its way
//! meets the other. The same poses to both, in turns; hits are compared, and so are distances. A
//! pair of this crate begins with two transforms, as entities have them, one of parry's with two of
//! its poses.
//!
//! parry's own calls for a pair of shapes decide which of its algorithms runs, as in rapier.

use std::{fs, path::PathBuf, time::Instant};

use bevy::{
    math::{Dir3, Quat, Vec3},
    transform::components::Transform,
};
use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
use clap::Args;
use parry3d::{
    math::{Pose, Rotation, Vector},
    query::{self, ShapeCastOptions},
    shape::SharedShape,
};
use serde::Serialize;

use crate::{
    measure::{geometric_mean, median},
    outcome::Outcome,
    progress::Progress,
};

/// How far a moving shape goes.
const SWEEP: f32 = 4.0;
/// Two answers that are no further apart are one, as a share of the sizes, which are about one.
const SAME: f32 = 1e-2;

/// Compares exact tests of pairs of shapes.
#[derive(Args)]
pub struct Arguments {
    /// Poses of each pair.
    #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..))]
    poses: u32,
    /// How often all poses are asked, after one round to warm up.
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Seed of the poses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What is asked.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
enum Operation {
    Intersects,
    Contact,
    Distance,
    Sweep,
}

impl Operation {
    const ALL: [Self; 4] = [Self::Intersects, Self::Contact, Self::Distance, Self::Sweep];

    const fn name(self) -> &'static str {
        match self {
            Self::Intersects => "intersects",
            Self::Contact => "contact",
            Self::Distance => "distance",
            Self::Sweep => "sweep",
        }
    }
}

/// A shape, as both have it.
struct Both {
    name: &'static str,
    ours: Shape,
    theirs: SharedShape,
}

fn shapes() -> Vec<Both> {
    let both = |name, ours, theirs| Both { name, ours, theirs };
    // A rock, as games have it: the hull of sixteen points.
    let mut random = fastrand::Rng::with_seed(3);
    let rock: Vec<Vec3> = (0..16)
        .map(|_| {
            let number = |random: &mut fastrand::Rng| random.f32() * 2.0 - 1.0;
            let point = Vec3::new(
                number(&mut random),
                number(&mut random),
                number(&mut random),
            );
            point.normalize_or(Vec3::X) * 0.6
        })
        .collect();
    let of_parry: Vec<Vector> = rock.iter().map(|point| point.to_array().into()).collect();
    let hull = SharedShape::convex_hull(&of_parry).expect("the points span a volume");
    vec![
        both("ball", Shape::sphere(0.5), SharedShape::ball(0.5)),
        both(
            "cuboid",
            Shape::cuboid(1.0, 0.8, 1.2),
            SharedShape::cuboid(0.5, 0.4, 0.6),
        ),
        both(
            "capsule",
            Shape::capsule(0.3, 1.0),
            SharedShape::capsule_y(0.5, 0.3),
        ),
        both(
            "cylinder",
            Shape::cylinder(0.4, 1.0),
            SharedShape::cylinder(0.5, 0.4),
        ),
        both(
            "hull",
            Shape::convex_hull(rock).expect("it has a volume"),
            hull,
        ),
    ]
}

/// The ten pairs.
const PAIRS: [[&str; 2]; 10] = [
    ["ball", "ball"],
    ["ball", "cuboid"],
    ["cuboid", "cuboid"],
    ["ball", "capsule"],
    ["capsule", "capsule"],
    ["capsule", "cuboid"],
    ["ball", "hull"],
    ["cuboid", "hull"],
    ["capsule", "hull"],
    ["cylinder", "cuboid"],
];

/// Two poses, as both have them, and a way.
struct Query {
    ours: [Transform; 2],
    theirs: [Pose; 2],
    way: Dir3,
}

fn queries(arguments: &Arguments) -> Vec<Query> {
    let mut random = fastrand::Rng::with_seed(arguments.seed);
    let mut vector = || Vec3::from_array([0; 3].map(|_| random.f32() * 2.0 - 1.0));
    let pose = |at: &Transform| {
        let [x, y, z, w] = at.rotation.to_array();
        let rotation = Rotation::from_xyzw(x, y, z, w);
        Pose::from_parts(at.translation.to_array().into(), rotation)
    };
    (0..arguments.poses)
        .map(|_| {
            let center = vector() * 10.0;
            let mut place = || Transform {
                translation: center + vector() * 0.7,
                rotation: Quat::from_scaled_axis(vector() * 3.0),
                ..Transform::IDENTITY
            };
            let ours = [place(), place()];
            let theirs = [pose(&ours[0]), pose(&ours[1])];
            let way = Dir3::new(vector()).unwrap_or(Dir3::X);
            Query { ours, theirs, way }
        })
        .collect()
}

/// What came out: nothing without a hit, otherwise how far or how deep.
type Answer = Option<f32>;

fn ask_ours(
    operation: Operation,
    [a, b]: [&Shape; 2],
    queries: &[Query],
    workspace: &mut Workspace,
    answers: &mut Vec<Answer>,
) {
    let tests = NarrowPhase::default();
    answers.extend(queries.iter().map(|query| {
        let (a, b) = (
            Placed::new(a, &query.ours[0]),
            Placed::new(b, &query.ours[1]),
        );
        match operation {
            Operation::Intersects => tests.intersects(a, b, workspace).then_some(0.0),
            Operation::Contact => tests.contact(a, b, workspace).map(|found| found.depth),
            Operation::Distance => tests
                .closest_points(a, b, workspace)
                .map(|found| found.distance),
            Operation::Sweep => tests
                .sweep(a, query.way, SWEEP, b, workspace)
                .map(|found| found.distance),
        }
    }));
}

fn ask_theirs(
    operation: Operation,
    [a, b]: [&SharedShape; 2],
    queries: &[Query],
    answers: &mut Vec<Answer>,
) {
    let options = ShapeCastOptions::with_max_time_of_impact(SWEEP);
    answers.extend(queries.iter().map(|query| {
        let ([at_a, at_b], a, b) = (&query.theirs, &*a.0, &*b.0);
        match operation {
            Operation::Intersects => {
                let found = query::intersection_test(at_a, a, at_b, b);
                found.ok()?.intersecting.then_some(0.0)
            }
            // As deep as it is within no margin.
            Operation::Contact => {
                let found = query::contact(at_a, a, at_b, b, 0.0).ok()??;
                Some(-found.dist)
            }
            Operation::Distance => Some(query::distance(at_a, a, at_b, b).ok()?.distance),
            Operation::Sweep => {
                let way: Vector = query.way.to_array().into();
                let found = query::cast_shapes(at_a, way, a, at_b, Vector::ZERO, b, options);
                found.ok()?.map(|hit| hit.time_of_impact)
            }
        }
    }));
}

/// One operation on one pair.
#[derive(Serialize)]
struct Cell {
    pair: String,
    operation: Operation,
    ours_ns: f64,
    parry_ns: f64,
    hits: usize,
    differ: usize,
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    let shapes = shapes();
    let of = |name: &str| {
        shapes
            .iter()
            .find(|shape| shape.name == name)
            .expect("pairs are of the shapes that there are")
    };
    let queries = queries(arguments);
    let mut workspace = Workspace::default();
    let mut cells = vec![];
    let mut progress = Progress::new(PAIRS.len() as u64);
    for names in PAIRS {
        let pair = names.map(of);
        progress.begin(format!("{}, {}", names[0], names[1]));
        for operation in Operation::ALL {
            let (mut ours, mut theirs) = (vec![], vec![]);
            let mut times = [vec![], vec![]];
            for round in 0..=arguments.rounds {
                ours.clear();
                theirs.clear();
                let start = Instant::now();
                let of_ours = pair.map(|shape| &shape.ours);
                ask_ours(operation, of_ours, &queries, &mut workspace, &mut ours);
                let middle = Instant::now();
                ask_theirs(
                    operation,
                    pair.map(|shape| &shape.theirs),
                    &queries,
                    &mut theirs,
                );
                let end = Instant::now();
                if round > 0 {
                    let each =
                        |time: std::time::Duration| time.as_secs_f64() * 1e9 / queries.len() as f64;
                    times[0].push(each(middle - start));
                    times[1].push(each(end - middle));
                }
            }
            let differ = |(one, other): &(&Answer, &Answer)| match (one, other) {
                (Some(one), Some(other)) => (one - other).abs() > SAME,
                // Within the margins of either, a contact is one or is not.
                (Some(deep), None) | (None, Some(deep)) => {
                    matches!(operation, Operation::Contact) && deep.abs() > SAME
                }
                (None, None) => false,
            };
            let [ours_ns, parry_ns] = times.map(median);
            cells.push(Cell {
                pair: names.join("-"),
                operation,
                ours_ns,
                parry_ns,
                hits: ours.iter().flatten().count(),
                differ: ours.iter().zip(&theirs).filter(differ).count(),
            });
        }
    }
    drop(progress);
    print(&cells);
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&cells)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

fn print(cells: &[Cell]) {
    println!("pair              operation     ours_ns   parry_ns    ratio   hits  differ");
    let mut ratios = vec![];
    for Cell {
        pair,
        operation,
        ours_ns,
        parry_ns,
        hits,
        differ,
    } in cells
    {
        let ratio = parry_ns / ours_ns;
        ratios.push(ratio);
        let name = operation.name();
        println!(
            "{pair:<17} {name:<10} {ours_ns:>10.1} {parry_ns:>10.1} {ratio:>8.2} {hits:>6} {differ:>7}"
        );
    }
    let worst = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = geometric_mean(&ratios);
    println!("\nworst_ratio={worst:.2} geomean_ratio={mean:.2} (parry / ours)");
}
