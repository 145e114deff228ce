//! Very many objects that come at once, and go at once.

use bevy_octree::{broad_phase::SpatialIndex, scene::stress::StressScene};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput};

use crate::setup;

const OBJECTS: usize = 200_000;

pub fn bench(criterion: &mut Criterion) {
    let scene = StressScene::Brownian;
    let simulation = setup::simulation(scene, OBJECTS);
    let mut group = setup::group(criterion, "spawn_and_despawn", scene);
    group
        .sample_size(10)
        .throughput(Throughput::Elements(OBJECTS as u64));
    for method in setup::methods() {
        group.bench_function(BenchmarkId::new(method.to_string(), OBJECTS), |bencher| {
            bencher.iter_batched(
                || SpatialIndex::new(&method),
                |mut index| {
                    let ids = setup::insert(&mut index, simulation.boxes());
                    index.find_pairs();
                    for id in ids {
                        index.remove(id);
                    }
                    index.find_pairs();
                    index
                },
                BatchSize::PerIteration,
            );
        });
    }
}
