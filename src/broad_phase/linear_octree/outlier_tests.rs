//! Few objects that are unlike the others, by size, place or speed: what they cost, counted over
//! many ticks, and that all pairs are found.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};
use proptest::prelude::*;

use super::LinearOctree;
use crate::{
    broad_phase::{BroadPhase, Proxies, SpatialIndex, checked::Checked, overlap},
    scene::stress::{StressScene, StressSimulation},
};

const TICKS: usize = 300;

/// Objects that have skins, that have none, and that are of many sizes.
const SCENES: [StressScene; 3] = [
    StressScene::Brownian,
    StressScene::Gravity,
    StressScene::Sizes,
];

/// What was counted, all ticks together.
struct Counts {
    /// Pairs of blocks of boxes that overlap.
    blocks: f64,
    /// Objects that were given a new skin.
    skins: f64,
}

/// Counts what a scene costs with a few more boxes in it; `change` puts those of the scene
/// elsewhere, each tick.
fn count(
    scene: StressScene,
    objects: usize,
    more: &[Aabb3d],
    mut change: impl FnMut(usize, &mut [Aabb3d]),
) -> Counts {
    let mut simulation = StressSimulation::new(scene, objects, 7);
    let mut index = SpatialIndex::with_engine(Box::<LinearOctree>::default());
    let mut boxes = simulation.boxes().to_vec();
    change(0, &mut boxes);
    let ids: Vec<_> = boxes
        .iter()
        .map(|aabb| index.insert(*aabb).unwrap())
        .collect();
    more.iter()
        .for_each(|aabb| assert!(index.insert(*aabb).is_ok()));
    let mut counts = Counts {
        blocks: 0.0,
        skins: 0.0,
    };
    for tick in 1..=TICKS {
        simulation.step();
        boxes.copy_from_slice(simulation.boxes());
        change(tick, &mut boxes);
        for (id, aabb) in ids.iter().zip(&boxes) {
            index.set(*id, aabb).unwrap();
        }
        index.update();
        let octree: &LinearOctree = index.engine_as().unwrap();
        counts.skins += if octree.near.are_all_wanted() {
            objects
        } else {
            octree.escaped.len()
        } as f64;
        let blocks: Vec<_> = octree
            .tree
            .blocks_of_boxes()
            .map(|(bounds, _)| bounds)
            .collect();
        let overlapped =
            |(index, a): (usize, &Aabb3d)| blocks[index..].iter().filter(|b| overlap(a, b)).count();
        counts.blocks += blocks.iter().enumerate().map(overlapped).sum::<usize>() as f64;
        index.find_pairs();
    }
    counts
}

fn leave(_: usize, _: &mut [Aabb3d]) {}

/// The side of the space that a scene begins in.
fn side(scene: StressScene, objects: usize) -> f32 {
    let simulation = StressSimulation::new(scene, objects, 7);
    simulation
        .boxes()
        .iter()
        .map(|aabb| aabb.max.max_element())
        .fold(0.0, f32::max)
}

#[test]
fn a_few_objects_of_any_size_anywhere_do_not_leave_the_tree_loose() {
    let cube = |at: Vec3, half: f32| Aabb3d::new(at, Vec3::splat(half));
    let ground = |half: f32| Aabb3d::new(Vec3::NEG_Y * 0.5, Vec3::new(half, 0.5, half));
    let signs = [
        Vec3::ONE,
        Vec3::NEG_ONE,
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::X,
        Vec3::NEG_Y,
    ];
    let far = |distance: f32| signs.map(|sign| cube(sign * distance, 0.5));
    let huge = |half: f32| signs.map(|sign| cube(sign * half * 1.5, half));
    let more = [
        vec![ground(512.0)],
        vec![ground(1e3)],
        vec![ground(1e5)],
        vec![ground(1e5), ground(1e10), ground(1e30)],
        far(1e4).to_vec(),
        far(1e6).to_vec(),
        far(1e30).to_vec(),
        [&far(1e8)[..3], &huge(1e6)[..3], &huge(1e30)[..3]].concat(),
    ];
    for scene in SCENES {
        let alone = count(scene, 1000, &[], leave);
        for more in &more {
            let ratio = count(scene, 1000, more, leave).blocks / alone.blocks;
            assert!(
                ratio < 1.2,
                "{scene} with {} more, such as {:?}: {ratio}",
                more.len(),
                more[0]
            );
        }
    }
}

#[test]
fn objects_that_go_far_away_do_not_leave_the_tree_loose() {
    for scene in SCENES {
        let alone = count(scene, 1000, &[], leave);
        for distance in [1e4, 1e6, 1e30] {
            let ratio = count(scene, 1000, &[], |tick, boxes| {
                for (number, aabb) in boxes.iter_mut().step_by(100).enumerate() {
                    if tick > 10 + 20 * number {
                        let sign = if number % 2 == 0 {
                            Vec3A::ONE
                        } else {
                            Vec3A::NEG_X
                        };
                        (aabb.min, aabb.max) = (sign * distance, sign * distance + 1.0);
                    }
                }
            });
            let ratio = ratio.blocks / alone.blocks;
            assert!(
                ratio < 1.2,
                "{scene}, ten of which go {distance} away: {ratio}"
            );
        }
    }
}

#[test]
fn rooms_far_apart_are_as_good_as_one() {
    for scene in SCENES {
        let alone = count(scene, 1000, &[], leave);
        // From so far apart that cells of the curve hold a few objects each to so far that they
        // hold all.
        for (rooms, sides) in [(2, 50.0), (2, 150.0), (2, 1e3), (4, 1e3), (4, 1e5)] {
            let distance = sides * side(scene, 1000);
            let ratio = count(scene, 1000, &[], |_, boxes| {
                for (object, aabb) in boxes.iter_mut().enumerate() {
                    let room = object % rooms;
                    let corner = Vec3A::new((room / 2) as f32, (room % 2) as f32, 0.0) * distance;
                    (aabb.min, aabb.max) = (aabb.min + corner, aabb.max + corner);
                }
            });
            let ratio = ratio.blocks / alone.blocks;
            assert!(
                ratio < 1.2,
                "{scene} in {rooms} rooms, {sides} sides from each other: {ratio}"
            );
        }
    }
}

#[test]
fn a_huge_object_does_not_put_all_others_in_one_class_of_size() {
    let mut rng = fastrand::Rng::with_seed(8);
    let count = |more: &[Aabb3d], rng: &mut fastrand::Rng| {
        let mut proxies = Proxies::default();
        for number in 0..2000 {
            let half = if number % 40 == 0 { 8.0 } else { 0.05 };
            let at = Vec3::from(std::array::from_fn(|_| rng.f32())) * 20.0;
            proxies.insert(Aabb3d::new(at, Vec3::splat(half))).unwrap();
        }
        more.iter()
            .for_each(|aabb| assert!(proxies.insert(*aabb).is_ok()));
        proxies.begin_update();
        let mut octree = LinearOctree::default();
        octree.maintain(&proxies);
        let blocks: Vec<_> = octree
            .tree
            .blocks_of_boxes()
            .map(|(bounds, _)| bounds)
            .collect();
        blocks
            .iter()
            .map(|a| blocks.iter().filter(|b| overlap(a, b)).count())
            .sum::<usize>()
    };
    let alone = count(&[], &mut rng.clone());
    let with_huge = count(
        &[Aabb3d::new(Vec3::splat(10.0), Vec3::splat(1e30))],
        &mut rng,
    );
    assert!(
        with_huge as f64 <= 1.2 * alone as f64,
        "{with_huge} pairs of blocks, {alone} without it"
    );
}

#[test]
fn a_few_fast_objects_take_no_skins_from_the_others() {
    const OBJECTS: usize = 2000;
    let scene = StressScene::Brownian;
    let alone = count(scene, OBJECTS, &[], leave);
    let side = side(scene, OBJECTS);
    for speed in [0.5, 3.0, 30.0] {
        // One in 500 flies through all others, there and back.
        let fast = count(scene, OBJECTS, &[], |tick, boxes| {
            for (number, aabb) in boxes.iter_mut().step_by(500).enumerate() {
                let way = (tick as f32 * speed + number as f32 * 0.3 * side) % (2.0 * side);
                aabb.min = Vec3A::new(0.9, 0.7, 0.8) * (side - (way - side).abs());
                aabb.min[number % 3] = number as f32 * 0.25 * side;
                aabb.max = aabb.min + 1.0;
            }
        });
        let (skins, blocks) = (fast.skins / alone.skins, fast.blocks / alone.blocks);
        assert!(
            skins < 1.2 && blocks < 1.2,
            "{speed}: {skins} times as many new skins, {blocks} times as loose"
        );
    }
}

#[test]
fn slots_do_not_grow_with_time() {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut checked = Checked::new(Box::<LinearOctree>::default());
    let mut anywhere = || {
        Aabb3d::new(
            Vec3::from(std::array::from_fn(|_| rng.f32() * 20.0)),
            Vec3::splat(0.5),
        )
    };
    let ids: Vec<_> = (0..500)
        .map(|_| checked.index.insert(anywhere()).unwrap())
        .collect();
    for tick in 0..1000 {
        // Two that jump, in turns.
        for number in 0..2 {
            checked
                .index
                .set(ids[(2 * tick + number) % ids.len()], &anywhere())
                .unwrap();
        }
        checked.step();
        let octree: &LinearOctree = checked.index.engine_as().unwrap();
        assert!(
            octree.owners.len() <= 2 * ids.len(),
            "{} slots",
            octree.owners.len()
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn swarms_with_outliers_are_right(
        seed in any::<u64>(), count in 30_usize..300, speed in prop::sample::select(vec![0.0, 0.02, 0.1, 0.5]),
        share_fast in 15_usize..80, outliers in prop::collection::vec((0_usize..5, 0_usize..5, 0_usize..4), 0..12),
    ) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut vector = |scale: f32| Vec3::from(std::array::from_fn(|_| (rng.f32() - 0.5) * scale));
        let mut objects: Vec<_> = (0..count).map(|_| (vector(8.0), vector(speed), Vec3::splat(0.5))).collect();
        for (_, step, _) in objects.iter_mut().step_by(share_fast) {
            *step = vector(20.0);
        }
        for (far, size, fast) in outliers {
            let (at, step) = (vector([1.0, 8.0, 1e4, 1e6, 1e30][far]), vector([0.0, 0.1, 10.0, 1e6][fast]));
            objects.push((at, step, Vec3::new(1.0, 0.1, 0.7) * [0.0, 0.5, 8.0, 1e4, 1e30][size]));
        }
        let mut checked = Checked::new(Box::<LinearOctree>::default());
        let ids: Vec<_> =
            objects.iter().map(|(at, _, half)| checked.index.insert(Aabb3d::new(*at, *half)).unwrap()).collect();
        for tick in 0..30 {
            checked.step();
            for (number, ((at, step, half), id)) in objects.iter_mut().zip(&ids).enumerate() {
                *at += *step;
                // Those of the swarm turn round at walls; now and then one of them comes to rest,
                // or jumps.
                if number < count {
                    let outward = at.cmpgt(Vec3::splat(4.0)) | at.cmplt(Vec3::splat(-4.0));
                    *step = Vec3::select(outward, -at.signum() * step.abs(), *step);
                    match (number + tick * 7) % 400 {
                        0 => *step = Vec3::ZERO,
                        1 => *at = -*at,
                        _ => {}
                    }
                }
                checked.index.set(*id, &Aabb3d::new(*at, *half)).unwrap();
            }
        }
    }
}
