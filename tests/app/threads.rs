//! Pairs, answers of queries, and their order are the same at any number of threads.
//!
//! A process has one pool of threads. So the test runs itself, in a process of its own for each
//! number.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    process::Command,
};

use bevy::{
    math::{Dir3, Vec3, bounding::RayCast3d},
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_octree::{
    broad_phase::{BroadPhaseMethod, HitLists, SpatialIndex},
    scene::stress::{StressScene, StressSimulation},
};

/// Tells the process of its own how many threads besides the main one it is to use.
const HELPERS: &str = "BEVY_OCTREE_TEST_HELPERS";

/// Runs a scene with enough objects for several jobs, and returns a hash of all pairs in their
/// order.
fn run(scene: StressScene) -> u64 {
    let mut simulation = StressSimulation::new(scene, 20_000, 4);
    let mut index = SpatialIndex::new(&BroadPhaseMethod::LinearOctree);
    let ids: Vec<_> = simulation
        .boxes()
        .iter()
        .map(|aabb| index.insert(*aabb).unwrap())
        .collect();
    let mut hasher = DefaultHasher::new();
    for _ in 0..12 {
        index.update();
        index
            .find_pairs()
            .iter()
            .for_each(|pair| pair.hash(&mut hasher));
        simulation.step();
        for (id, aabb) in ids.iter().zip(simulation.boxes()) {
            index.set(*id, aabb).unwrap();
        }
    }
    index.update();
    ask(&index, &mut hasher);
    hasher.finish()
}

/// Queries for many, whose answers come in an order too.
fn ask(index: &SpatialIndex, hasher: &mut DefaultHasher) {
    let mut pairs = 0;
    index.for_each_pair_among(
        0.4,
        |id| id.get() % 9 != 0,
        |a, b, distance| {
            pairs += 1;
            (a, b, distance.to_bits()).hash(hasher);
        },
    );
    assert!(pairs > 5000, "{pairs}");
    let points: Vec<Vec3> = index
        .proxies()
        .iter()
        .map(|(_, aabb)| (aabb.max + 1.0).into())
        .collect();
    let (mut nearest, mut first) = (HitLists::default(), vec![]);
    index.k_nearest_of_each(&points, 3, 5.0, &mut nearest);
    let casts: Vec<_> = points
        .iter()
        .map(|point| RayCast3d::new(*point, Dir3::X, 20.0))
        .collect();
    index.cast_each(&casts, &mut first);
    for (near, first) in nearest.iter().zip(&first) {
        for hit in near.iter().chain(first) {
            (hit.proxy, hit.distance.to_bits()).hash(hasher);
        }
    }
}

/// Is run in a process of its own, by the test below; prints the hash of each scene.
#[test]
#[ignore = "a part of the other test"]
fn in_a_process_of_its_own() {
    let helpers = std::env::var(HELPERS).unwrap().parse().unwrap();
    let pool = ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(helpers).build());
    assert_eq!(pool.thread_num(), helpers);
    for scene in [
        StressScene::Brownian,
        StressScene::Gravity,
        StressScene::Static90,
    ] {
        println!("hash {scene} {}", run(scene));
    }
}

#[test]
fn the_pairs_and_their_order_are_the_same_at_any_number_of_threads() {
    let hashes = |threads: usize| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "threads::in_a_process_of_its_own",
                "--ignored",
                "--nocapture",
            ])
            .env(HELPERS, (threads - 1).to_string())
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let found: Vec<String> = text
            .lines()
            .filter_map(|line| Some(line.split_once("hash ")?.1.to_owned()))
            .collect();
        assert_eq!(found.len(), 3, "{threads} threads: {text}");
        found
    };
    let alone = hashes(1);
    for threads in [2, 4, 8] {
        assert_eq!(hashes(threads), alone, "{threads} threads");
    }
}
