use bevy::math::{Vec3, bounding::Aabb3d};
use proptest::prelude::*;

use super::*;
use crate::{
    broad_phase::{
        BroadPhase, ProxyId,
        checked::{Checked, a_step, replay},
    },
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

/// Settings with another N, for a tree the leaves of which are searched.
fn with_n(max_objects: u32) -> ObjectOctreeSettings {
    ObjectOctreeSettings {
        max_objects,
        search: PairSearch::Leaves,
        ..Default::default()
    }
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
    let root = RootPolicy::Cube {
        center: Vec3::ZERO,
        half_size: 4.0,
    };
    let mut checked = checked(ObjectOctreeSettings { root, ..with_n(1) });
    let middle = checked.index.insert(cube(0.0, 0.0, 0.0, 0.5)).unwrap();
    let edge = checked.index.insert(cube(-0.5, 3.0, 3.0, 0.5)).unwrap();
    let below = checked.index.insert(cube(-0.75, -3.0, 3.0, 0.5)).unwrap();
    checked.step();
    assert_eq!(octree(&checked).leaves_of(middle).len(), 8);
    assert_eq!(
        octree(&checked).leaves_of(edge).len(),
        2,
        "touching the upper cell's lower border counts"
    );
    assert_eq!(octree(&checked).leaves_of(below).len(), 1);
}

#[test]
fn coincident_objects_stop_splitting() {
    for count in [3, 40] {
        let mut checked = checked(ObjectOctreeSettings {
            max_depth: 12,
            ..with_n(2)
        });
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
    let mut checked = checked(ObjectOctreeSettings {
        max_doublings: 2,
        ..with_n(1)
    });
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
    checked
        .index
        .set(ids[1], &cube(9.0, 0.0, 0.0, 1.0))
        .unwrap();
    checked.step();
    let after = octree(&checked).root_cell().unwrap();
    assert_eq!((after.max - after.min).x, 2.0 * (before.max - before.min).x);
    assert!(after.max.x >= 10.0);
}

/// How many pairs the last search compared.
fn step(checked: &mut Checked) -> u64 {
    checked.step();
    checked.index.pairs_tested()
}

fn half_size(checked: &Checked) -> f32 {
    let root = octree(checked).root_cell().unwrap();
    (root.max - root.min).x * 0.5
}

/// Cubes in a grid of 6 × 6 × 6, and one that goes far away and comes back.
#[test]
fn the_root_shrinks_after_an_excursion() {
    for policy in [
        RootPolicy::default(),
        RootPolicy::Cube {
            center: Vec3::splat(9.0),
            half_size: 16.0,
        },
    ] {
        let mut checked = checked(ObjectOctreeSettings {
            root: policy,
            ..with_n(4)
        });
        let at = |i: u16| Vec3::from([i % 6, i / 6 % 6, i / 36].map(|c| 3.0 * f32::from(c)));
        let ids: Vec<_> = (0..216)
            .map(|i| checked.index.insert(Aabb3d::new(at(i), Vec3::ONE)).unwrap())
            .collect();
        let tick = |checked: &mut Checked, wanderer: Vec3, share: usize| {
            checked
                .index
                .set(ids[0], &Aabb3d::new(wanderer, Vec3::ONE))
                .unwrap();
            ids.iter()
                .step_by(share)
                .for_each(|id| assert!(checked.index.touch(*id)));
            step(checked)
        };
        checked.step();
        let (before, compared) = (half_size(&checked), tick(&mut checked, Vec3::ZERO, 1));
        // Whether all others move, or next to none.
        for share in [1, 100] {
            tick(&mut checked, Vec3::splat(1e6), share);
            assert!(half_size(&checked) >= 5e5);
            assert!(tick(&mut checked, Vec3::splat(1e6), 1) > 4 * compared);
            let back = (0..2000).find(|_| {
                tick(&mut checked, Vec3::ZERO, share);
                half_size(&checked) <= before * 2.0
            });
            assert!(
                back.is_some(),
                "{policy:?}, {share}: it is still {}",
                half_size(&checked)
            );
            assert_eq!(tick(&mut checked, Vec3::ZERO, 1), compared);
        }
        // From one tick to the next, across the border and back: it is not laid anew each time.
        for (far, most) in [(-15.0, 2), (-100.0, 60)] {
            let mut roots = Vec::new();
            for tick_number in 0..600 {
                tick(
                    &mut checked,
                    if tick_number % 2 == 0 {
                        Vec3::ZERO
                    } else {
                        Vec3::splat(far)
                    },
                    1,
                );
                roots.push(half_size(&checked));
            }
            roots.dedup();
            assert!(roots.len() <= most, "{far}: {roots:?}");
        }
    }
}

#[test]
fn a_root_that_may_not_double_any_more_is_laid_anew_where_many_need_it() {
    for max_doublings in [0, 2] {
        let mut checked = checked(ObjectOctreeSettings {
            max_doublings,
            ..with_n(4)
        });
        let ids: Vec<_> = (0..200)
            .map(|_| checked.index.insert(cube(0.0, 0.0, 0.0, 0.01)).unwrap())
            .collect();
        checked.step();
        let mut compared = 0;
        for tick in 0..400_u16 {
            let shift = f32::from(tick % 2);
            for (id, slot) in ids.iter().zip(0_u16..) {
                let at =
                    [slot % 6, slot / 6 % 6, slot / 36].map(|c| 1e4 + 10.0 * f32::from(c) + shift);
                checked
                    .index
                    .set(*id, &cube(at[0], at[1], at[2], 1.0))
                    .unwrap();
            }
            checked.index.update();
            checked.index.find_pairs();
            compared = checked.index.pairs_tested();
        }
        checked.step();
        assert!(compared < 200 * 20, "{max_doublings}: {compared}");
    }
}

/// Boxes that no octree tells apart by cells: each is as large as the crowd, or far smaller than
/// the smallest cell.
#[test]
fn crowds_that_share_their_cells_are_not_compared_each_with_each() {
    const COUNT: u16 = 3000;
    let rod = |i: u16| {
        Aabb3d::new(
            Vec3::new(0.0, f32::from(i), 0.0),
            Vec3::new(2000.0, 0.45, 0.45),
        )
    };
    let plate = |i: u16| {
        Aabb3d::new(
            Vec3::new(0.0, f32::from(i), 0.0),
            Vec3::new(2000.0, 0.45, 2000.0),
        )
    };
    let grid = |i: u16| Vec3::from([i % 15, i / 15 % 15, i / 225].map(f32::from));
    let small = |i: u16| Aabb3d::new(grid(i) * 1e-4, Vec3::splat(4e-5));
    let scales = |i: u16| {
        let scale = 2_f32.powi(i32::from(i % 80) - 40);
        Aabb3d::new(
            Vec3::new(1.0, 0.01 * f32::from(i / 80), 0.0) * scale,
            Vec3::splat(0.004 * scale),
        )
    };
    let scenes: [(&str, &dyn Fn(u16) -> Aabb3d); 4] = [
        ("rods", &rod),
        ("plates", &plate),
        ("far from one another", &small),
        ("scales", &scales),
    ];
    for (name, scene) in scenes {
        let mut checked = checked(with_n(64));
        let mut boxes: Vec<Aabb3d> = (0..COUNT).map(scene).collect();
        boxes.push(cube(1e7, 1e7, 1e7, 1.0));
        let ids: Vec<_> = boxes
            .iter()
            .map(|aabb| checked.index.insert(*aabb).unwrap())
            .collect();
        // Once with all that move, once with half of them.
        let all = step(&mut checked);
        for id in &ids {
            checked.index.touch(*id);
        }
        let again = step(&mut checked);
        for id in ids.iter().step_by(2) {
            checked.index.touch(*id);
        }
        let half = step(&mut checked);
        let bound = 64 * u64::from(COUNT);
        assert!(
            all.max(again).max(half) < bound,
            "{name}: {all}, {again}, {half} compared"
        );
    }
}

/// The same crowd, some of whom meet.
#[test]
fn a_crowd_finds_the_pairs_that_a_few_find() {
    let mut rng = fastrand::Rng::with_seed(9);
    let mut checked = checked(ObjectOctreeSettings {
        max_depth: 1,
        ..with_n(1)
    });
    let mut random = |scale: f32| Vec3::from(std::array::from_fn(|_| (rng.f32() - 0.5) * scale));
    let mut ids = Vec::new();
    for layer in 0..1200 {
        let filter = crate::broad_phase::PairFilter {
            memberships: 1 << (layer % 3),
            filters: 0b110,
            is_static: layer % 5 == 0,
            ..Default::default()
        };
        let id = checked
            .index
            .insert(Aabb3d::new(random(20.0), random(4.0).abs()))
            .unwrap();
        checked.index.set_filter(id, filter).unwrap();
        ids.push(id);
    }
    checked.step();
    for share in [1, 2, 1] {
        for id in ids.iter().step_by(share) {
            let by = random(0.5);
            let old = *checked.index.proxies().get(*id).unwrap();
            let moved = Aabb3d {
                min: old.min + bevy::math::Vec3A::from(by),
                max: old.max + bevy::math::Vec3A::from(by),
            };
            checked.index.set(*id, &moved).unwrap();
        }
        checked.step();
    }
    assert!(checked.index.pairs().len() > 1000);
}

#[test]
fn memory_stays_flat_over_a_long_run() {
    fastrand::seed(7);
    let mut checked = checked(with_n(4));
    let spot = || Vec3::new(fastrand::f32(), fastrand::f32(), fastrand::f32()) * 20.0;
    let ids: Vec<_> = (0..200)
        .map(|_| {
            checked
                .index
                .insert(Aabb3d::new(spot(), Vec3::splat(0.5)))
                .unwrap()
        })
        .collect();
    let mut bytes = Vec::new();
    for tick in 0..400 {
        for id in &ids {
            checked
                .index
                .set(*id, &Aabb3d::new(spot(), Vec3::splat(0.5)))
                .unwrap();
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
        for search in [PairSearch::Blocks, PairSearch::Leaves] {
            replay(checked(ObjectOctreeSettings { max_objects, max_depth, max_doublings, search, ..Default::default() }), &steps);
        }
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
    let left = octree(&checked)
        .tree()
        .neighbor(node, "L".parse::<Direction>().unwrap())
        .unwrap();
    assert_eq!(octree(&checked).tree().data(left).listed(), [0]);
}
