//! Adding objects, without what the next update does with them: the same for all methods.

use bevy_octree::{broad_phase::SpatialIndex, scene::stress::StressScene};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput};

use crate::setup;

pub fn bench(criterion: &mut Criterion) {
    let scene = StressScene::Brownian;
    let mut group = setup::group(criterion, "insert", scene);
    for objects in setup::SIZES {
        let simulation = setup::simulation(scene, objects);
        group.throughput(Throughput::Elements(objects as u64));
        group.bench_function(BenchmarkId::from_parameter(objects), |bencher| {
            bencher.iter_batched(
                SpatialIndex::default,
                |mut index| {
                    setup::insert(&mut index, simulation.boxes());
                    index
                },
                BatchSize::PerIteration,
            );
        });
    }
}
