//! From nothing to the pairs of all objects: insertion, the first update, the first search.

use bevy_octree::{broad_phase::SpatialIndex, scene::stress::StressScene};
use criterion::{BatchSize, Criterion};

use crate::setup;

pub fn bench(criterion: &mut Criterion) {
    let scene = StressScene::Brownian;
    let mut group = setup::group(criterion, "build", scene);
    setup::each_method(&mut group, |group, id, method, objects| {
        let simulation = setup::simulation(scene, objects);
        group.bench_function(id, |bencher| {
            bencher.iter_batched(
                || SpatialIndex::new(method),
                |mut index| {
                    setup::insert(&mut index, simulation.boxes());
                    index.find_pairs();
                    index
                },
                BatchSize::PerIteration,
            );
        });
    });
}
