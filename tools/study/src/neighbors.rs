//! `study neighbors`: units that ask who is near, against a grid as games write it.
//!
//! Balls of diameter 1 walk about at random, on a plain or in space, where each has as many others
//! within a distance as it is given room for. In each frame, all pairs that are near each other are
//! found in several ways, one after the other, by turns: first is who was last. What they find is
//! compared.
//!
//! | way | what it does |
//! |---|---|
//! | `grid` | the forty lines that a game begins with ([`Grid`]): a hash map from cells to units, filled anew in each frame, of which each unit looks at its own cell and those around |
//! | `cells` | the forty lines that it ends with ([`Cells`]): units sorted by cell in a room whose size is known, of which each looks at what comes after it in its own cell and those around |
//! | `pairs_among` | [`SpatialQuery::for_each_pair_among`], exact, with the closest points of each pair |
//! | `pairs_within` | [`SpatialQuery::for_each_pair_within`], of all units with all units |
//! | `within` | [`SpatialQuery::for_each_within`] around each unit, which finds each pair twice |
//! | `boxes` | [`SpatialIndex::for_each_pair_among`](bevy_octree::broad_phase::SpatialIndex::for_each_pair_among): of boxes, of which more are near each other |
//!
//! The grid's time is that of filling it, too. The index is there anyway, for contacts; what it
//! takes to keep it up is told beside: boxes and maintenance of a tick.

use std::{ops::Range, time::Instant};

use bevy::{platform::collections::HashMap, prelude::*};
use bevy_octree::prelude::*;
use clap::Args;

use crate::{
    outcome::Outcome,
    stage_times::{STAGES, StageTimes},
};

/// Compares ways to find all units that are near each other.
#[derive(Args)]
pub struct Arguments {
    /// Units.
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(2..))]
    units: u32,
    /// How many others are near a unit, in the mean.
    #[arg(long, default_value_t = 3.0)]
    neighbors: f32,
    /// Within which distance of their centres units are near each other, in diameters.
    #[arg(long, default_value_t = 2.0)]
    distance: f32,
    /// Frames to time, after some to warm up.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Seed of the units.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Frames that are not timed.
const WARM_UP: u32 = 10;
/// How far a unit goes in a frame, along each axis, at most: a run of 6 diameters per second.
const STEP: f32 = 0.1;
const RADIUS: f32 = 0.5;

/// A uniform grid, as a game developer would write it.
#[derive(Default)]
struct Grid {
    cells: HashMap<IVec3, Vec<(Entity, Vec3)>>,
}

impl Grid {
    fn fill(&mut self, units: impl Iterator<Item = (Entity, Vec3)>, cell: f32) {
        self.cells.values_mut().for_each(Vec::clear);
        for (unit, position) in units {
            let key = (position / cell).floor().as_ivec3();
            self.cells.entry(key).or_default().push((unit, position));
        }
    }

    fn for_each_pair(
        &self,
        distance: f32,
        height: i32,
        mut found: impl FnMut(Entity, Entity, f32),
    ) {
        for (key, units) in &self.cells {
            for x in -1..=1 {
                for y in -height..=height {
                    for z in -1..=1 {
                        let Some(others) = self.cells.get(&(key + IVec3::new(x, y, z))) else {
                            continue;
                        };
                        for &(a, position) in units {
                            for &(b, other) in others {
                                let squared = position.distance_squared(other);
                                if a < b && squared <= distance * distance {
                                    found(a, b, squared.sqrt());
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Units in the order of the cells of a room, by a counting sort: as grids are written where they
/// have to be fast.
#[derive(Default)]
struct Cells {
    /// Cells along each axis, with an empty one on each side.
    size: IVec3,
    /// By cell: where its units begin in the order; and the end of the last.
    starts: Vec<u32>,
    units: Vec<(Entity, Vec3)>,
    order: Vec<(Entity, Vec3)>,
}

impl Cells {
    fn cell(&self, position: Vec3, side: Vec3, cell: f32) -> usize {
        let at = ((position + side / 2.0) / cell).as_ivec3() + 1;
        let at = at.clamp(IVec3::ONE, self.size - 2);
        (at.x + self.size.x * (at.z + self.size.z * at.y)) as usize
    }

    fn fill(&mut self, units: impl Iterator<Item = (Entity, Vec3)>, side: Vec3, cell: f32) {
        self.size = (side / cell).ceil().as_ivec3().max(IVec3::ONE) + 2;
        self.starts.clear();
        self.starts
            .resize(self.size.element_product() as usize + 2, 0);
        self.units.clear();
        self.units.extend(units);
        for unit in 0..self.units.len() {
            let cell = self.cell(self.units[unit].1, side, cell);
            self.starts[cell + 2] += 1;
        }
        for cell in 2..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        self.order
            .resize(self.units.len(), (Entity::PLACEHOLDER, Vec3::ZERO));
        for unit in 0..self.units.len() {
            let cell = self.cell(self.units[unit].1, side, cell) + 1;
            self.order[self.starts[cell] as usize] = self.units[unit];
            self.starts[cell] += 1;
        }
    }

    fn for_each_pair(&self, distance: f32, mut found: impl FnMut(Entity, Entity, f32)) {
        let (row, layer) = (self.size.x, self.size.x * self.size.z);
        let mut compare = |units: Range<usize>, first: i32, last: i32| {
            let others = self.starts[first as usize]..self.starts[last as usize + 1];
            for a in units {
                // Three cells of a row are one run; of its own, what comes after it.
                let others = others.start.max(a as u32 + 1)..others.end;
                for b in others {
                    let [(unit, position), (other, place)] =
                        [self.order[a], self.order[b as usize]];
                    let squared = position.distance_squared(place);
                    if squared <= distance * distance {
                        found(unit, other, squared.sqrt());
                    }
                }
            }
        };
        for cell in 0..self.size.element_product() {
            let units =
                self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize;
            if units.is_empty() {
                continue;
            }
            compare(units.clone(), cell, cell + 1);
            for others in [row, layer - row, layer, layer + row] {
                if self.size.y > 3 || others == row {
                    compare(units.clone(), cell + others - 1, cell + others + 1);
                }
            }
        }
    }
}

/// What a way found.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    pairs: u64,
    /// The sum of the distances of centres, but that those who overlap are as far apart as if they
    /// touched.
    sum: f64,
}

impl Found {
    fn add(&mut self, distance: f32) {
        self.pairs += 1;
        self.sum += f64::from(distance.max(2.0 * RADIUS));
    }
}

const WAYS: [&str; 6] = [
    "grid",
    "cells",
    "pairs_among",
    "pairs_within",
    "within",
    "boxes",
];

/// The times of each way, and what it found last.
#[derive(Resource)]
struct Results {
    distance: f32,
    /// How many layers of cells are above and below: none on a plain.
    height: i32,
    side: Vec3,
    grid: Grid,
    cells: Cells,
    frame: usize,
    ms: [Vec<f64>; WAYS.len()],
    found: [Found; WAYS.len()],
}

#[derive(Component)]
struct Unit;

fn ask(
    mut results: ResMut<Results>,
    units: Query<(Entity, &Transform), With<Unit>>,
    spatial: SpatialQuery,
) {
    let all = SpatialQueryFilter::DEFAULT;
    let results = &mut *results;
    let (distance, apart) = (results.distance, results.distance - 2.0 * RADIUS);
    results.frame += 1;
    for turn in 0..WAYS.len() {
        let way = (results.frame + turn) % WAYS.len();
        let mut found = Found::default();
        let start = Instant::now();
        match WAYS[way] {
            "grid" => {
                let units = units.iter().map(|(unit, at)| (unit, at.translation));
                results.grid.fill(units, distance);
                results
                    .grid
                    .for_each_pair(distance, results.height, |_, _, apart| found.add(apart));
            }
            "cells" => {
                let units = units.iter().map(|(unit, at)| (unit, at.translation));
                results.cells.fill(units, results.side, distance);
                results
                    .cells
                    .for_each_pair(distance, |_, _, apart| found.add(apart));
            }
            "pairs_among" => spatial.for_each_pair_among(apart, &all, |near| {
                found.add(near.distance + 2.0 * RADIUS);
            }),
            "pairs_within" => spatial.for_each_pair_within(apart, &all, &all, |near| {
                found.add(near.distance + 2.0 * RADIUS);
            }),
            "within" => {
                for (unit, at) in &units {
                    spatial.for_each_within(at.translation, distance - RADIUS, &all, |hit| {
                        if hit.entity > unit {
                            found.add(hit.distance + RADIUS);
                        }
                    });
                }
            }
            _ => spatial.index().index().for_each_pair_among(
                apart,
                |_| true,
                |_, _, apart| {
                    found.add(apart + 2.0 * RADIUS);
                },
            ),
        }
        results.ms[way].push(start.elapsed().as_secs_f64() * 1e3);
        results.found[way] = found;
    }
}

fn walk(mut units: Query<(&mut Transform, &mut Way), With<Unit>>) {
    for (mut at, mut way) in &mut units {
        let Way { step, side } = &mut *way;
        for axis in 0..3 {
            if (at.translation[axis] + step[axis]).abs() > *side / 2.0 {
                step[axis] = -step[axis];
            }
        }
        at.translation += *step;
    }
}

/// How a unit goes, and in a room of which side.
#[derive(Component)]
struct Way {
    step: Vec3,
    side: f32,
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    for (name, height) in [("on a plain", 0), ("in space", 1)] {
        compare(arguments, name, height)?;
    }
    Ok(())
}

fn compare(arguments: &Arguments, name: &str, height: i32) -> Outcome {
    let &Arguments {
        units,
        neighbors,
        distance,
        frames,
        seed,
    } = arguments;
    if !(distance > 2.0 * RADIUS && neighbors > 0.0) {
        return Err("units are near each other beyond one diameter, and have neighbours".into());
    }
    // The part of the room that is near a unit is that of the others that are.
    let near = std::f32::consts::PI * distance.powi(2);
    let side = match height {
        0 => (near * units as f32 / neighbors).sqrt(),
        _ => (near * distance * 4.0 / 3.0 * units as f32 / neighbors).cbrt(),
    };
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(Results {
            distance,
            height,
            side: Vec3::new(side, side * height as f32, side),
            grid: Grid::default(),
            cells: Cells::default(),
            frame: 0,
            ms: default(),
            found: default(),
        })
        .add_systems(Update, walk.in_set(CollisionSystems::Motion))
        .add_systems(PostUpdate, ask);
    StageTimes::install(&mut app, Update);
    app.finish();
    app.cleanup();
    let mut random = fastrand::Rng::with_seed(seed);
    let flat = Vec3::new(1.0, height as f32, 1.0);
    let mut vector = |reach: f32| {
        flat * Vec3::from_array(std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * reach))
    };
    let entities: Vec<_> = (0..units)
        .map(|_| {
            let (place, step) = (vector(side / 2.0), vector(STEP));
            (
                Unit,
                Way { step, side },
                CollisionShape::sphere(RADIUS),
                Transform::from_translation(place),
            )
        })
        .collect();
    app.world_mut().spawn_batch(entities);
    for frame in 0..WARM_UP + frames {
        if frame == WARM_UP {
            app.world_mut().resource_mut::<StageTimes>().reset();
            let mut results = app.world_mut().resource_mut::<Results>();
            results.ms.iter_mut().for_each(Vec::clear);
        }
        app.update();
    }
    let sums = &app.world().resource::<StageTimes>().sums;
    let stage = |wanted: &str| {
        let stages = STAGES.iter().zip(sums);
        let sum: f64 = stages
            .filter(|((_, name), _)| *name == wanted)
            .map(|(_, sum)| sum.as_secs_f64())
            .sum();
        sum * 1e3 / f64::from(frames)
    };
    let results = app.world().resource::<Results>();
    println!("{units} units {name}, {distance} near, {frames} frames");
    println!("way          median ms   least ms      pairs   per unit  grid / it  cells / it");
    let sorted = |way: usize| {
        let mut ms = results.ms[way].clone();
        ms.sort_unstable_by(f64::total_cmp);
        ms
    };
    let median = |way: usize| sorted(way)[results.ms[way].len() / 2];
    for (way, name) in WAYS.iter().enumerate() {
        let (ms, found) = (median(way), results.found[way]);
        let differs = |a: f64, b: f64| (a - b).abs() > 1e-3 * a.abs().max(1.0);
        let wrong = differs(found.pairs as f64, results.found[0].pairs as f64)
            || differs(found.sum, results.found[0].sum);
        println!(
            "{name:<12} {ms:>9.3} {:>10.3} {:>10} {:>10.2} {:>10.2} {:>11.2}{}",
            sorted(way)[0],
            found.pairs,
            2.0 * found.pairs as f64 / f64::from(units),
            median(0) / ms,
            median(1) / ms,
            if wrong && *name != "boxes" {
                " MISMATCH"
            } else {
                ""
            },
        );
    }
    println!(
        "upkeep of the index: bounds {:.3} ms, maintenance {:.3} ms",
        stage("bounds"),
        stage("maintenance"),
    );
    println!(
        "grid_ratio={:.2} cells_ratio={:.2} (by pairs_among)",
        median(0) / median(2),
        median(1) / median(2)
    );
    Ok(())
}
