//! Queries against an index that follows a scene.

use std::hint::black_box;

use bevy::math::{
    Dir3, Vec3, Vec3A,
    bounding::{Aabb3d, RayCast3d},
};
use bevy_octree::{broad_phase::SpatialIndex, scene::stress::StressScene};
use criterion::{Criterion, Throughput};
use fastrand::Rng;

use crate::setup::{self, Follower};

/// How many queries an iteration makes, each at another place.
const QUERIES: usize = 64;

/// Half the side of the regions, in sides of the scene's boxes.
const REACH: f32 = 2.0;

pub fn bench(criterion: &mut Criterion) {
    bench_query(criterion, "overlapping", |index, place, _| {
        let mut found = 0_u32;
        index.for_each_overlapping(&Aabb3d::new(place, Vec3::splat(REACH)), |_| found += 1);
        black_box(found);
    });
    bench_query(criterion, "cast", |index, origin, direction| {
        black_box(index.cast(&RayCast3d::new(origin, direction, f32::INFINITY)));
    });
    bench_query(criterion, "nearest", |index, point, _| {
        black_box(index.nearest(point, f32::INFINITY));
    });
}

/// Measures a query that is made at random places of the scene, in random directions.
fn bench_query(criterion: &mut Criterion, name: &str, query: impl Fn(&SpatialIndex, Vec3, Dir3)) {
    let scene = StressScene::Brownian;
    let mut group = setup::group(criterion, name, scene);
    setup::each_method(&mut group, |group, id, method, objects| {
        let follower = Follower::new(method, scene, objects);
        let index = follower.index();
        let arguments = places(index);
        group.throughput(Throughput::Elements(QUERIES as u64));
        group.bench_function(id, |bencher| {
            bencher.iter(|| {
                arguments
                    .iter()
                    .for_each(|(place, direction)| query(index, *place, *direction));
            });
        });
    });
}

/// Random places within the bounds of all objects, and random directions.
fn places(index: &SpatialIndex) -> Vec<(Vec3, Dir3)> {
    let boxes = index.proxies().boxes();
    let min = boxes
        .iter()
        .fold(Vec3A::INFINITY, |min, aabb| min.min(aabb.min));
    let max = boxes
        .iter()
        .fold(Vec3A::NEG_INFINITY, |max, aabb| max.max(aabb.max));
    let mut rng = Rng::with_seed(7);
    let mut vector = || Vec3::from_array(std::array::from_fn(|_| rng.f32()));
    let argument = |_| {
        let place = Vec3::from(min) + vector() * Vec3::from(max - min);
        (place, Dir3::new(vector() - 0.5).unwrap_or(Dir3::X))
    };
    (0..QUERIES).map(argument).collect()
}
