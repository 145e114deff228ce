use bevy::math::{Vec3, bounding::Aabb3d};
use proptest::prelude::*;

use super::{LinearOctree, upkeep::TOO_LOOSE};
use crate::broad_phase::{
    block::WIDTH,
    checked::{Checked, a_step, replay},
    proxy::Proxies,
};

fn checked() -> Checked {
    Checked::new(Box::new(LinearOctree::default()))
}

/// Objects at random places in a cube, with random velocities.
fn swarm(rng: &mut fastrand::Rng, count: usize, side: f32, speed: f32) -> Vec<(Vec3, Vec3)> {
    let mut vector = |scale: f32| Vec3::from(std::array::from_fn(|_| (rng.f32() - 0.5) * scale));
    (0..count).map(|_| (vector(side), vector(speed))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_step_of_a_random_history_is_right(steps in prop::collection::vec(a_step(), 1..150)) {
        replay(checked(), &steps);
    }

    #[test]
    fn swarms_are_right_at_every_speed(
        seed in any::<u64>(), count in 1_usize..300, speed in prop::sample::select(vec![0.0, 0.01, 0.1, 0.5, 4.0]),
        share_moving in 1_usize..40,
    ) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut objects = swarm(&mut rng, count, 8.0, speed);
        let mut checked = checked();
        let half = Vec3::splat(0.5);
        let ids: Vec<_> =
            objects.iter().map(|(at, _)| checked.index.insert(Aabb3d::new(*at, half)).unwrap()).collect();
        for _ in 0..25 {
            checked.step();
            for ((at, velocity), id) in objects.iter_mut().zip(&ids).filter(|(_, id)| id.index() % share_moving == 0) {
                if rng.u32(0..20) == 0 {
                    *velocity = -*velocity;
                }
                *at += *velocity;
                checked.index.set(*id, &Aabb3d::new(*at, half)).unwrap();
            }
        }
    }
}

#[test]
fn a_far_away_object_does_not_spoil_the_order() {
    let mut rng = fastrand::Rng::with_seed(5);
    let mut octree = LinearOctree::default();
    let mut proxies = Proxies::default();
    let objects = swarm(&mut rng, 4000, 40.0, 0.0);
    for (at, _) in &objects {
        proxies.insert(Aabb3d::new(*at, Vec3::splat(0.5))).unwrap();
    }
    let mut compared = Vec::new();
    for far in [None, Some(1e20)] {
        if let Some(far) = far {
            proxies
                .insert(Aabb3d::new(Vec3::splat(far), Vec3::ONE))
                .unwrap();
        }
        proxies.touch_all();
        proxies.begin_update();
        octree.refresh(&proxies);
        let bounds = octree.tree.as_slice()[1]
            .iter()
            .flat_map(|block| (0..WIDTH).map(|lane| block.get(lane)));
        let side = |aabb: Aabb3d| (aabb.max - aabb.min).max_element();
        compared.push(
            bounds
                .map(side)
                .filter(|side| side.is_finite() && *side < 1e6)
                .sum::<f32>(),
        );
    }
    assert!(
        compared[1] < compared[0] * 1.5,
        "leaves are as small as before: {compared:?}"
    );
}

#[test]
fn objects_that_jump_do_not_leave_the_tree_loose() {
    let mut rng = fastrand::Rng::with_seed(6);
    let mut checked = checked();
    let objects = swarm(&mut rng, 3000, 40.0, 0.0);
    let half = Vec3::splat(0.5);
    let ids: Vec<_> = objects
        .iter()
        .map(|(at, _)| checked.index.insert(Aabb3d::new(*at, half)).unwrap())
        .collect();
    checked.step();
    for share in [300, 20, 8, 5, 2, 1] {
        for (id, (at, _)) in ids
            .iter()
            .step_by(share)
            .zip(swarm(&mut rng, 3000, 40.0, 0.0))
        {
            checked.index.set(*id, &Aabb3d::new(at, half)).unwrap();
        }
        checked.index.update();
        let octree: &LinearOctree = checked.index.engine_as().unwrap();
        let growth = octree.tree.looseness();
        let searches = octree.escaped.len().max(1) as f64;
        assert!(
            growth * searches <= 3000.0,
            "one in {share}: {growth} times as loose, searched {searches} times"
        );
        assert!(
            growth <= TOO_LOOSE || !octree.near.are_all_wanted(),
            "one in {share}: {growth}"
        );
        checked.step();
    }
}

#[test]
fn resting_objects_are_not_searched_for() {
    let mut checked = checked();
    let ids: Vec<_> = (0..100)
        .map(|x| {
            checked
                .index
                .insert(Aabb3d::new(Vec3::X * x as f32, Vec3::splat(0.5)))
                .unwrap()
        })
        .collect();
    checked.step();
    checked.step();
    assert_eq!(checked.index.pairs_tested(), 0);
    checked
        .index
        .set(ids[0], &Aabb3d::new(Vec3::X * 0.5, Vec3::splat(0.5)))
        .unwrap();
    checked.step();
    assert!(checked.index.pairs_tested() < 10);
}

#[test]
fn memory_stays_flat_while_objects_come_and_go() {
    let mut rng = fastrand::Rng::with_seed(9);
    let mut checked = checked();
    let mut ids = std::collections::VecDeque::new();
    let mut bytes = Vec::new();
    for tick in 0..600 {
        for (at, _) in swarm(&mut rng, 4, 20.0, 0.0) {
            ids.push_back(
                checked
                    .index
                    .insert(Aabb3d::new(at, Vec3::splat(0.5)))
                    .unwrap(),
            );
        }
        if ids.len() > 200 {
            for id in ids.drain(..4) {
                checked.index.remove(id);
            }
        }
        checked.step();
        if tick % 150 == 149 {
            bytes.push(checked.index.memory_bytes());
        }
    }
    assert!(bytes[3] < bytes[1] * 5 / 4, "{bytes:?}");
}
