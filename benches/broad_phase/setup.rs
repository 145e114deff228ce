//! What the benchmarks have in common: sizes, methods, and an index that follows a scene.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

use bevy::math::bounding::Aabb3d;
use bevy_octree::{
    broad_phase::{BroadPhaseMethod, ObjectOctreeSettings, ProxyId, SpatialIndex},
    scene::stress::{StressScene, StressSimulation},
};
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, measurement::WallTime,
};

/// How many objects there are.
pub const SIZES: [usize; 3] = [1_000, 8_000, 64_000];

/// The scenes of what is measured tick by tick: slow and fast motion, rest, and few objects unlike
/// all others.
pub const SCENES: [StressScene; 6] = [
    StressScene::Brownian,
    StressScene::Gravity,
    StressScene::Static90,
    StressScene::Ground,
    StressScene::Outlier,
    StressScene::Rooms,
];

/// Exhaustive search is measured up to here: it takes time by the square.
const FEW: usize = 1_000;

const SEED: u64 = 1;

/// The group of benchmarks of one thing on one scene.
pub fn group<'a>(
    criterion: &'a mut Criterion,
    what: &str,
    scene: StressScene,
) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(format!("{what}/{scene}"));
    group.sampling_mode(SamplingMode::Flat);
    group
}

/// Calls `bench` with each size, and each method that is worth measuring at it.
pub fn each_method(
    group: &mut BenchmarkGroup<WallTime>,
    mut bench: impl FnMut(&mut BenchmarkGroup<WallTime>, BenchmarkId, &BroadPhaseMethod, usize),
) {
    for objects in SIZES {
        group.throughput(Throughput::Elements(objects as u64));
        let exhaustive = (objects <= FEW).then_some(BroadPhaseMethod::Exhaustive);
        for method in methods().into_iter().chain(exhaustive) {
            bench(
                group,
                BenchmarkId::new(method.to_string(), objects),
                &method,
                objects,
            );
        }
    }
}

/// The methods for many objects.
pub fn methods() -> [BroadPhaseMethod; 2] {
    [
        BroadPhaseMethod::LinearOctree,
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::default()),
    ]
}

/// The scene at its start.
pub fn simulation(scene: StressScene, objects: usize) -> StressSimulation {
    StressSimulation::new(scene, objects, SEED)
}

/// Adds an object for each box.
pub fn insert(index: &mut SpatialIndex, boxes: &[Aabb3d]) -> Vec<ProxyId> {
    boxes
        .iter()
        .map(|aabb| index.insert(*aabb).expect("boxes of scenes are finite"))
        .collect()
}

/// An index that follows a scene.
pub struct Follower {
    simulation: StressSimulation,
    index: SpatialIndex,
    ids: Vec<ProxyId>,
}

/// What a tick took.
#[derive(Clone, Copy, Default)]
pub struct Tick {
    /// Every box set, and one update.
    pub maintain: Duration,
    /// The search for pairs.
    pub pairs: Duration,
}

impl Follower {
    /// Some ticks after the start, when what is made once has been made.
    pub fn new(method: &BroadPhaseMethod, scene: StressScene, objects: usize) -> Self {
        let simulation = simulation(scene, objects);
        let mut index = SpatialIndex::new(method);
        let ids = insert(&mut index, simulation.boxes());
        index.find_pairs();
        let mut follower = Self {
            simulation,
            index,
            ids,
        };
        for _ in 0..4 {
            follower.tick();
        }
        follower
    }

    pub fn index(&self) -> &SpatialIndex {
        &self.index
    }

    /// One tick. The scene's own motion is in neither time.
    pub fn tick(&mut self) -> Tick {
        self.simulation.step();
        let start = Instant::now();
        for (id, aabb) in self.ids.iter().zip(self.simulation.boxes()) {
            self.index
                .set(*id, aabb)
                .expect("boxes of scenes are finite");
        }
        self.index.update();
        let maintained = Instant::now();
        black_box(self.index.find_pairs().len());
        Tick {
            maintain: maintained - start,
            pairs: maintained.elapsed(),
        }
    }
}
