use bevy::math::{Vec3, bounding::Aabb3d};
use proptest::prelude::*;

use super::*;
use crate::{
    broad_phase::checked::{Checked, a_step, replay},
    octree::Direction,
};

fn checked(settings: ObjectOctreeSettings) -> Checked {
    Checked::new(Box::new(ObjectOctree::new(settings)))
}

fn octree(checked: &Checked) -> &ObjectOctree {
    checked.index.engine_as().unwrap()
}

fn nodes(checked: &Checked) -> usize {
    octree(checked).tree().node_count()
}

fn cube(x: f32, y: f32, z: f32, half: f32) -> Aabb3d {
    Aabb3d::new(Vec3::new(x, y, z), Vec3::splat(half))
}

fn with_n(max_objects: u32) -> ObjectOctreeSettings {
    ObjectOctreeSettings::with_max_objects(max_objects)
}

#[test]
fn an_empty_index_is_a_lone_root_and_becomes_one_again() {
    let mut checked = checked(with_n(1));
    checked.step();
    assert_eq!(nodes(&checked), 1);
    let ids = [-1.0, 1.0, 3.0].map(|x| checked.index.insert(cube(x, 0.1, 0.1, 0.1)).unwrap());
    checked.step();
    assert!(nodes(&checked) > 1);
    for id in ids {
        assert!(checked.index.remove(id));
        checked.step();
    }
    assert_eq!((nodes(&checked), octree(&checked).root_cell()), (1, None));
}

#[test]
fn the_object_after_the_nth_splits_the_root() {
    let mut checked = checked(with_n(2));
    for (x, expected) in [(-2.0, 1), (2.0, 1), (2.9, 9)] {
        checked.index.insert(cube(x, 1.0, 1.0, 0.25)).unwrap();
        checked.step();
        assert_eq!(nodes(&checked), expected);
    }
}

#[test]
fn a_straddler_is_listed_in_every_leaf_that_it_touches() {
    let root = RootPolicy::Cube { center: Vec3::ZERO, half_size: 4.0 };
    let mut checked = checked(ObjectOctreeSettings { root, ..with_n(1) });
    let middle = checked.index.insert(cube(0.0, 0.0, 0.0, 0.5)).unwrap();
    let edge = checked.index.insert(cube(-0.5, 3.0, 3.0, 0.5)).unwrap();
    let below = checked.index.insert(cube(-0.75, -3.0, 3.0, 0.5)).unwrap();
    checked.step();
    assert_eq!(octree(&checked).leaves_of(middle).len(), 8);
    assert_eq!(octree(&checked).leaves_of(edge).len(), 2, "touching the upper cell's lower border counts");
    assert_eq!(octree(&checked).leaves_of(below).len(), 1);
}

#[test]
fn coincident_objects_stop_splitting() {
    for count in [3, 40] {
        let mut checked = checked(ObjectOctreeSettings { max_depth: 12, ..with_n(2) });
        for _ in 0..count {
            checked.index.insert(cube(0.3, 0.2, 0.1, 0.5)).unwrap();
            checked.index.insert(cube(40.0, 0.2, 0.1, 0.0)).unwrap();
        }
        checked.step();
        assert!(nodes(&checked) < 12 * 8 * 10, "{} nodes", nodes(&checked));
    }
}

#[test]
fn objects_far_outside_the_root_are_found() {
    let mut checked = checked(ObjectOctreeSettings { max_doublings: 2, ..with_n(1) });
    let ids = [0.0, 3.0, 6.0, 9.0].map(|x| checked.index.insert(cube(x, 0.0, 0.0, 1.0)).unwrap());
    checked.step();
    assert!(checked.index.pairs().is_empty());
    for (id, x) in ids.into_iter().zip([1e6, 1e6 + 1.0, -1e30, 9.0]) {
        checked.index.set(id, &cube(x, 1e5, 0.0, 1.0)).unwrap();
        checked.step();
    }
    assert_eq!(checked.index.pairs().len(), 1);
}

#[test]
fn the_root_doubles_when_an_object_leaves_it() {
    let mut checked = checked(with_n(4));
    let ids = [0.0, 4.0].map(|x| checked.index.insert(cube(x, 0.0, 0.0, 1.0)).unwrap());
    checked.step();
    let before = octree(&checked).root_cell().unwrap();
    checked.index.set(ids[1], &cube(9.0, 0.0, 0.0, 1.0)).unwrap();
    checked.step();
    let after = octree(&checked).root_cell().unwrap();
    assert_eq!((after.max - after.min).x, 2.0 * (before.max - before.min).x);
    assert!(after.max.x >= 10.0);
}

#[test]
fn memory_stays_flat_over_a_long_run() {
    fastrand::seed(7);
    let mut checked = checked(with_n(4));
    let spot = || Vec3::new(fastrand::f32(), fastrand::f32(), fastrand::f32()) * 20.0;
    let ids: Vec<_> = (0..200).map(|_| checked.index.insert(Aabb3d::new(spot(), Vec3::splat(0.5))).unwrap()).collect();
    let mut bytes = Vec::new();
    for tick in 0..400 {
        for id in &ids {
            checked.index.set(*id, &Aabb3d::new(spot(), Vec3::splat(0.5))).unwrap();
        }
        checked.index.update();
        if tick % 100 == 99 {
            bytes.push(octree(&checked).stats().bytes);
        }
    }
    assert!(bytes[3] < bytes[1] * 5 / 4, "{bytes:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_step_of_a_random_history_is_well_formed(
        max_objects in 1_u32..6, max_depth in 1_u32..10, max_doublings in 0_u32..6,
        steps in prop::collection::vec(a_step(), 1..120),
    ) {
        replay(checked(ObjectOctreeSettings { max_objects, max_depth, max_doublings, ..Default::default() }), &steps);
    }

    #[test]
    fn merge_slack_keeps_pairs_and_lists_right(steps in prop::collection::vec(a_step(), 1..120)) {
        replay(checked(ObjectOctreeSettings { merge_slack: 2, ..with_n(4) }), &steps);
    }

    #[test]
    fn many_slow_objects_stay_well_formed(seed in any::<u64>(), max_objects in 1_u32..12) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut vector = move |scale: f32| Vec3::from(std::array::from_fn(|_| (rng.f32() - 0.5) * scale));
        let mut checked = checked(with_n(max_objects));
        let mut objects: Vec<_> = (0..60).map(|_| {
            let center = vector(10.0);
            let half = vector(2.0).abs();
            (checked.index.insert(Aabb3d::new(center, half)).unwrap(), center, half, vector(0.4))
        }).collect();
        for _ in 0..12 {
            checked.step();
            for (id, center, half, velocity) in &mut objects {
                *center += *velocity;
                checked.index.set(*id, &Aabb3d::new(*center, *half)).unwrap();
            }
        }
    }
}

#[test]
fn the_tree_prints_its_leaves() {
    let mut checked = checked(with_n(1));
    for x in [-2.0, 2.0] {
        checked.index.insert(cube(x, 1.0, 1.0, 0.25)).unwrap();
    }
    checked.step();
    let node = octree(&checked).leaves_of(ProxyId::new(1))[0];
    let left = octree(&checked).tree().neighbor(node, "L".parse::<Direction>().unwrap()).unwrap();
    assert_eq!(octree(&checked).tree().data(left).listed(), [0]);
}
