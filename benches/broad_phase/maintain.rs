//! Keeping up with motion: every box set, and one update.

use criterion::Criterion;

use crate::setup::{self, Follower};

pub fn bench(criterion: &mut Criterion) {
    for scene in setup::SCENES {
        let mut group = setup::group(criterion, "maintain", scene);
        setup::each_method(&mut group, |group, id, method, objects| {
            let mut follower = Follower::new(method, scene, objects);
            group.bench_function(id, |bencher| {
                bencher.iter_custom(|ticks| (0..ticks).map(|_| follower.tick().maintain).sum());
            });
        });
    }
}
