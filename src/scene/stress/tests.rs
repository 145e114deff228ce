use bevy::math::bounding::Aabb3d;

use super::*;

fn same_bits(a: &Aabb3d, b: &Aabb3d) -> bool {
    let bits =
        |aabb: &Aabb3d| [aabb.min, aabb.max].map(|corner| corner.to_array().map(f32::to_bits));
    bits(a) == bits(b)
}

/// How many of the boxes each overlaps, on average.
fn overlaps_each(boxes: &[Aabb3d]) -> f64 {
    let overlap = |a: &Aabb3d, b: &Aabb3d| a.min.cmple(b.max).all() && a.max.cmpge(b.min).all();
    let pairs: usize = boxes
        .iter()
        .enumerate()
        .map(|(i, a)| boxes[i + 1..].iter().filter(|b| overlap(a, b)).count())
        .sum();
    2.0 * pairs as f64 / boxes.len() as f64
}

fn after(scene: StressScene, objects: usize, ticks: usize) -> StressSimulation {
    let mut simulation = StressSimulation::new(scene, objects, 1);
    (0..ticks).for_each(|_| simulation.step());
    simulation
}

/// FNV-1a over the bits of all boxes.
fn hash(boxes: &[Aabb3d]) -> u64 {
    let words = boxes
        .iter()
        .flat_map(|aabb| [aabb.min, aabb.max])
        .flat_map(|corner| corner.to_array());
    let bytes = words.flat_map(f32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn a_seed_gives_the_same_bits_on_any_machine() {
    let hashes = StressScene::ALL.map(|scene| hash(after(scene, 500, 100).boxes()));
    let expected = [
        0x7093_8da2_5b25_c3ad,
        0xa31a_e767_6ed6_c3b2,
        0x8c29_1b2d_ed5f_3c6a,
        0xccac_b8a2_0264_3dd5,
        0x9044_5dab_26e7_39f4,
        0xdb46_be0d_bd90_9bf9,
        0x204f_5d18_f4b5_bf78,
        0x3c70_c4a7_92e3_ea66,
        0xd94e_7026_d460_6a8f,
        0x6ecc_1197_4c43_6074,
    ];
    assert_eq!(hashes, expected, "{hashes:#018x?}");
}

#[test]
fn another_seed_gives_another_scene() {
    for scene in StressScene::ALL {
        let [a, b] = [1, 2].map(|seed| StressSimulation::new(scene, 100, seed));
        assert_ne!(hash(a.boxes()), hash(b.boxes()), "{scene}");
    }
}

#[test]
fn any_number_of_objects_is_exact_and_its_boxes_are_in_order() {
    for scene in StressScene::ALL {
        for objects in [0, 1, 2, 7, 99, 1000, 1001] {
            let mut simulation = StressSimulation::new(scene, objects, 3);
            for tick in 0..50 {
                assert_eq!(
                    (
                        simulation.boxes().len(),
                        simulation.tick(),
                        simulation.scene()
                    ),
                    (objects, tick, scene)
                );
                for aabb in simulation.boxes() {
                    assert!(
                        aabb.min.is_finite()
                            && aabb.max.is_finite()
                            && aabb.min.cmplt(aabb.max).all(),
                        "{aabb:?}"
                    );
                }
                simulation.step();
            }
        }
    }
}

#[test]
fn overlaps_are_as_many_as_documented_and_stay_so() {
    let expected = [
        (StressScene::Brownian, 1.0),
        (StressScene::Gravity, 1.0),
        (StressScene::Static90, 1.0),
        (StressScene::Sizes, 4.0),
        (StressScene::Clusters, 1.8),
        (StressScene::Outlier, 1.0),
        (StressScene::Rooms, 1.0),
    ];
    for (scene, expected) in expected {
        for ticks in [0, 100, 500] {
            let found = overlaps_each(after(scene, 2000, ticks).boxes());
            assert!(
                (found / expected - 1.0).abs() < 0.2,
                "{scene} after {ticks} ticks: {found}"
            );
        }
    }
    for ticks in [0, 20, 40, 60, 80, 100, 500] {
        let found = overlaps_each(after(StressScene::Freefall, 2000, ticks).boxes());
        assert!(
            (0.5..4.0).contains(&found),
            "freefall after {ticks} ticks: {found}"
        );
    }
}

#[test]
fn overlaps_do_not_grow_with_the_number_of_objects() {
    for scene in StressScene::ALL {
        let [few, many] =
            [1000, 6000].map(|objects| overlaps_each(after(scene, objects, 100).boxes()));
        assert!(many < 1.3 * few + 0.05, "{scene}: {few} and {many}");
    }
}

#[test]
fn drifting_boxes_move_by_the_stated_speed_and_stay_in_the_room() {
    for scene in [StressScene::Brownian, StressScene::Sizes] {
        let mut simulation = after(scene, 500, 0);
        let start = simulation.boxes().to_vec();
        let hull = |boxes: &[Aabb3d]| {
            boxes
                .iter()
                .map(|aabb| aabb.max)
                .reduce(bevy::math::Vec3A::max)
        };
        for _ in 0..1000 {
            let before = simulation.boxes().to_vec();
            simulation.step();
            for (a, b) in before.iter().zip(simulation.boxes()) {
                let moved = ((b.min - a.min) / (a.max - a.min)).abs();
                assert!(
                    moved.min_element() > 0.049 && moved.max_element() < 0.101,
                    "{scene}: {moved}"
                );
            }
        }
        let [first, last] = [hull(&start), hull(simulation.boxes())].map(Option::unwrap_or_default);
        assert!(
            (last / first).max_element() < 1.2,
            "{scene}: {first} {last}"
        );
    }
}

#[test]
fn nine_in_ten_never_move_in_static90_and_all_others_do() {
    let start = after(StressScene::Static90, 1000, 0);
    let end = after(StressScene::Static90, 1000, 100);
    let resting = start
        .boxes()
        .iter()
        .zip(end.boxes())
        .filter(|(a, b)| same_bits(a, b))
        .count();
    assert_eq!(resting, 900);
}

#[test]
fn a_ground_is_under_all_others_and_never_moves() {
    let simulation = after(StressScene::Ground, 1000, 300);
    let (ground, cubes) = simulation.boxes().split_last().unwrap();
    assert!(same_bits(
        ground,
        &StressSimulation::new(StressScene::Ground, 1000, 1).boxes()[999]
    ));
    assert!(
        cubes
            .iter()
            .all(|cube| ground.min.x < cube.min.x - 1000.0 && ground.max.z > cube.max.z + 1000.0)
    );
    let on_it = cubes
        .iter()
        .filter(|cube| cube.min.y <= ground.max.y)
        .count();
    assert!((20..200).contains(&on_it), "{on_it}");
}

#[test]
fn an_outlier_goes_far_away_and_rests_there() {
    let far = |ticks| {
        let simulation = after(StressScene::Outlier, 1000, ticks);
        let far: Vec<_> = simulation
            .boxes()
            .iter()
            .copied()
            .filter(|aabb| aabb.min.min_element() > 1e5)
            .collect();
        far
    };
    assert_eq!([0, 3, 4, 300].map(|ticks| far(ticks).len()), [0, 0, 1, 1]);
    assert!(same_bits(&far(4)[0], &far(300)[0]));
}

#[test]
fn rooms_are_far_apart_and_each_holds_its_share() {
    let simulation = after(StressScene::Rooms, 1000, 300);
    let in_room = |corner: bevy::math::Vec3A| {
        simulation
            .boxes()
            .iter()
            .filter(|aabb| (aabb.min - corner).abs().max_element() < 100.0)
            .count()
    };
    let corners = [
        bevy::math::Vec3A::ZERO,
        bevy::math::Vec3A::X,
        bevy::math::Vec3A::Y,
        bevy::math::Vec3A::Z,
    ];
    assert_eq!(corners.map(|corner| in_room(corner * 10_000.0)), [250; 4]);
}

#[test]
fn falling_boxes_come_to_rest_on_the_floor_or_each_other() {
    let resting_after = |ticks| {
        let mut simulation = after(StressScene::Freefall, 2000, ticks);
        let before = simulation.boxes().to_vec();
        simulation.step();
        before
            .iter()
            .zip(simulation.boxes())
            .filter(|(a, b)| same_bits(a, b))
            .count()
    };
    assert_eq!(resting_after(0), 0);
    assert!(resting_after(50) > 500);
    assert!((1700..2000).contains(&resting_after(100)));
    assert_eq!(resting_after(1100), 2000);

    let simulation = after(StressScene::Freefall, 2000, 1100);
    for aabb in simulation.boxes() {
        let supports =
            |below: &Aabb3d| below.max.y == aabb.min.y && (below.min.x - aabb.min.x).abs() < 0.3;
        assert!(aabb.min.y == 0.0 || simulation.boxes().iter().any(supports));
    }
}

#[test]
fn speeds_around_the_attractor_are_bounded() {
    for objects in [100, 3000] {
        let mut simulation = after(StressScene::Gravity, objects, 0);
        let mut fastest = 0.0_f32;
        for _ in 0..1000 {
            let before = simulation.boxes().to_vec();
            simulation.step();
            for (a, b) in before.iter().zip(simulation.boxes()) {
                fastest = fastest.max((b.min - a.min).abs().max_element());
            }
        }
        assert!(
            (0.5..1.0).contains(&fastest),
            "{objects} objects: {fastest}"
        );
    }
}

#[test]
fn planes_meet_turn_and_meet_again() {
    let mut simulation = after(StressScene::Planes, 98, 0);
    let touching = |simulation: &StressSimulation| overlaps_each(simulation.boxes()) > 0.0;
    let met: Vec<_> = (0..100)
        .filter(|_| {
            simulation.step();
            touching(&simulation)
        })
        .collect();
    // The four rings of the report's t3, first when the report says, and then every other way there
    // and back.
    assert_eq!(met[..4], [16, 20, 24, 28]);
    assert_eq!(met[4], 16 + 34);
}

#[test]
fn objects_come_in_no_spatial_order() {
    for scene in StressScene::ALL {
        let simulation = after(scene, 4000, 0);
        let boxes = simulation.boxes();
        // Those of a ground would outweigh all others.
        let distance = |a: &Aabb3d, b: &Aabb3d| (a.min - b.min).abs().element_sum().min(1000.0);
        let mean = |far: usize| {
            boxes
                .iter()
                .zip(&boxes[far..])
                .map(|(a, b)| distance(a, b))
                .sum::<f32>()
        };
        // Neighbours in memory are as far apart as any two.
        let ratio = mean(1) / mean(1777) * (4000.0 - 1777.0) / 3999.0;
        assert!((0.9..1.1).contains(&ratio), "{scene}: {ratio}");
    }
}
