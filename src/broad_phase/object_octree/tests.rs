use bevy::math::{Vec3, bounding::Aabb3d};
use proptest::prelude::*;

use super::*;
use crate::{
    broad_phase::{PairSet, overlap},
    octree::Direction,
};

/// The boxes, the octree, and the pairs as a [`SpatialIndex`](crate::broad_phase::SpatialIndex) would keep them, with
/// everything checked after every step.
struct Checked {
    proxies: Proxies,
    octree: ObjectOctree,
    pairs: PairSet,
}

impl Checked {
    fn new(settings: ObjectOctreeSettings) -> Self {
        Self { proxies: Proxies::default(), octree: ObjectOctree::new(settings), pairs: PairSet::default() }
    }

    fn step(&mut self) {
        self.proxies.begin_update();
        self.octree.maintain(&self.proxies);
        self.octree.assert_well_formed(&self.proxies);
        let moving = self.pairs.begin(&self.proxies);
        self.octree.find_pairs(&self.proxies, moving);
        let mut found: Vec<Pair> = self.pairs.iter().collect();
        found.sort_unstable();
        assert_eq!(found, brute_force(&self.proxies));
    }

    fn nodes(&self) -> usize {
        self.octree.tree().node_count()
    }
}

fn brute_force(proxies: &Proxies) -> Vec<Pair> {
    let all: Vec<_> = proxies.iter().collect();
    let mut pairs = Vec::new();
    for (place, (a, box_a)) in all.iter().enumerate() {
        for (b, box_b) in &all[place + 1..] {
            if overlap(box_a, box_b) {
                pairs.push(Pair::new(*a, *b));
            }
        }
    }
    pairs
}

fn cube(x: f32, y: f32, z: f32, half: f32) -> Aabb3d {
    Aabb3d::new(Vec3::new(x, y, z), Vec3::splat(half))
}

fn with_n(max_objects: u32) -> ObjectOctreeSettings {
    ObjectOctreeSettings::with_max_objects(max_objects)
}

#[test]
fn an_empty_index_is_a_lone_root_and_becomes_one_again() {
    let mut checked = Checked::new(with_n(1));
    checked.step();
    assert_eq!(checked.nodes(), 1);
    let ids = [-1.0, 1.0, 3.0].map(|x| checked.proxies.insert(cube(x, 0.1, 0.1, 0.1)).unwrap());
    checked.step();
    assert!(checked.nodes() > 1);
    for id in ids {
        assert!(checked.proxies.remove(id));
        checked.step();
    }
    assert_eq!((checked.nodes(), checked.octree.root_cell()), (1, None));
}

#[test]
fn the_object_after_the_nth_splits_the_root() {
    let mut checked = Checked::new(with_n(2));
    for (x, nodes) in [(-2.0, 1), (2.0, 1), (2.9, 9)] {
        checked.proxies.insert(cube(x, 1.0, 1.0, 0.25)).unwrap();
        checked.step();
        assert_eq!(checked.nodes(), nodes);
    }
}

#[test]
fn a_straddler_is_listed_in_every_leaf_that_it_touches() {
    let root = RootPolicy::Cube { center: Vec3::ZERO, half_size: 4.0 };
    let mut checked = Checked::new(ObjectOctreeSettings { root, ..with_n(1) });
    let middle = checked.proxies.insert(cube(0.0, 0.0, 0.0, 0.5)).unwrap();
    let edge = checked.proxies.insert(cube(-0.5, 3.0, 3.0, 0.5)).unwrap();
    let below = checked.proxies.insert(cube(-0.75, -3.0, 3.0, 0.5)).unwrap();
    checked.step();
    assert_eq!(checked.octree.leaves_of(middle).len(), 8);
    assert_eq!(checked.octree.leaves_of(edge).len(), 2, "touching the upper cell's lower border counts");
    assert_eq!(checked.octree.leaves_of(below).len(), 1);
}

#[test]
fn coincident_objects_stop_splitting() {
    for count in [3, 40] {
        let mut checked = Checked::new(ObjectOctreeSettings { max_depth: 12, ..with_n(2) });
        for _ in 0..count {
            checked.proxies.insert(cube(0.3, 0.2, 0.1, 0.5)).unwrap();
            checked.proxies.insert(cube(40.0, 0.2, 0.1, 0.0)).unwrap();
        }
        checked.step();
        assert!(checked.nodes() < 12 * 8 * 10, "{} nodes", checked.nodes());
    }
}

#[test]
fn objects_far_outside_the_root_are_found() {
    let mut checked = Checked::new(ObjectOctreeSettings { max_doublings: 2, ..with_n(1) });
    let ids = [0.0, 3.0, 6.0, 9.0].map(|x| checked.proxies.insert(cube(x, 0.0, 0.0, 1.0)).unwrap());
    checked.step();
    assert!(checked.pairs.is_empty());
    for (id, x) in ids.into_iter().zip([1e6, 1e6 + 1.0, -1e30, 9.0]) {
        checked.proxies.set(id, &cube(x, 1e5, 0.0, 1.0)).unwrap();
        checked.step();
    }
    assert_eq!(checked.pairs.len(), 1);
}

#[test]
fn the_root_doubles_when_an_object_leaves_it() {
    let mut checked = Checked::new(with_n(4));
    let ids = [0.0, 4.0].map(|x| checked.proxies.insert(cube(x, 0.0, 0.0, 1.0)).unwrap());
    checked.step();
    let before = checked.octree.root_cell().unwrap();
    checked.proxies.set(ids[1], &cube(9.0, 0.0, 0.0, 1.0)).unwrap();
    checked.step();
    let after = checked.octree.root_cell().unwrap();
    assert_eq!((after.max - after.min).x, 2.0 * (before.max - before.min).x);
    assert!(after.max.x >= 10.0);
}

#[test]
fn memory_stays_flat_over_a_long_run() {
    fastrand::seed(7);
    let mut checked = Checked::new(with_n(4));
    let spot = || Vec3::new(fastrand::f32(), fastrand::f32(), fastrand::f32()) * 20.0;
    let ids: Vec<_> =
        (0..200).map(|_| checked.proxies.insert(Aabb3d::new(spot(), Vec3::splat(0.5))).unwrap()).collect();
    let mut bytes = Vec::new();
    for tick in 0..400 {
        for id in &ids {
            checked.proxies.set(*id, &Aabb3d::new(spot(), Vec3::splat(0.5))).unwrap();
        }
        checked.proxies.begin_update();
        checked.octree.maintain(&checked.proxies);
        if tick % 100 == 99 {
            bytes.push(checked.octree.stats().bytes);
        }
    }
    assert!(bytes[3] < bytes[1] * 5 / 4, "{bytes:?}");
}

/// One step of a random history. Places are in units of a 64th, so that borders are met exactly, and often.
#[derive(Clone, Debug)]
enum Step {
    Insert { at: [i16; 3], size: u16 },
    Shift { which: usize, by: [i8; 3] },
    Teleport { which: usize, to: [i16; 3] },
    Resize { which: usize, size: u16 },
    Touch { which: usize },
    Remove { which: usize },
    Tick,
}

fn a_step() -> impl Strategy<Value = Step> {
    let at = || prop::array::uniform3(-640_i16..640);
    // 1:1000, the small ones more often.
    let size = || (0_u32..1000).prop_map(|s| (s * s / 1000).max(1) as u16);
    prop_oneof![
        4 => (at(), size()).prop_map(|(at, size)| Step::Insert { at, size }),
        8 => (any::<usize>(), prop::array::uniform3(-40_i8..40)).prop_map(|(which, by)| Step::Shift { which, by }),
        2 => (any::<usize>(), at()).prop_map(|(which, to)| Step::Teleport { which, to }),
        1 => (any::<usize>(), size()).prop_map(|(which, size)| Step::Resize { which, size }),
        1 => any::<usize>().prop_map(|which| Step::Touch { which }),
        2 => any::<usize>().prop_map(|which| Step::Remove { which }),
        4 => Just(Step::Tick),
    ]
}

fn run(settings: ObjectOctreeSettings, steps: &[Step]) {
    const UNIT: f32 = 1.0 / 64.0;
    let place = |at: [i16; 3]| Vec3::from(at.map(f32::from)) * UNIT;
    let mut checked = Checked::new(settings);
    let mut objects: Vec<(ProxyId, Vec3, f32)> = Vec::new();
    for step in steps {
        let count = objects.len().max(1);
        let mut change = |which: &usize, f: &mut dyn FnMut(&mut Vec3, &mut f32)| {
            if let Some((id, center, half)) = objects.get_mut(which % count) {
                f(center, half);
                checked.proxies.set(*id, &Aabb3d::new(*center, Vec3::splat(*half))).unwrap();
            }
        };
        match step {
            Step::Insert { at, size } => {
                let (center, half) = (place(*at), f32::from(*size) * UNIT);
                let id = checked.proxies.insert(Aabb3d::new(center, Vec3::splat(half))).unwrap();
                objects.push((id, center, half));
            }
            Step::Shift { which, by } => {
                change(which, &mut |center, _| *center += Vec3::from(by.map(f32::from)) * UNIT)
            }
            Step::Teleport { which, to } => change(which, &mut |center, _| *center = place(*to)),
            Step::Resize { which, size } => change(which, &mut |_, half| *half = f32::from(*size) * UNIT),
            Step::Touch { which } => {
                if let Some((id, ..)) = objects.get(which % count) {
                    checked.proxies.touch(*id);
                }
            }
            Step::Remove { which } => {
                if !objects.is_empty() {
                    let (id, ..) = objects.swap_remove(which % count);
                    assert!(checked.proxies.remove(id));
                }
            }
            Step::Tick => checked.step(),
        }
    }
    checked.step();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_step_of_a_random_history_is_well_formed(
        max_objects in 1_u32..6, max_depth in 1_u32..10, max_doublings in 0_u32..6,
        steps in prop::collection::vec(a_step(), 1..120),
    ) {
        run(ObjectOctreeSettings { max_objects, max_depth, max_doublings, ..Default::default() }, &steps);
    }

    #[test]
    fn merge_slack_keeps_pairs_and_lists_right(steps in prop::collection::vec(a_step(), 1..120)) {
        run(ObjectOctreeSettings { merge_slack: 2, ..with_n(4) }, &steps);
    }

    #[test]
    fn many_slow_objects_stay_well_formed(seed in any::<u64>(), max_objects in 1_u32..12) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut vector = move |scale: f32| Vec3::from(std::array::from_fn(|_| (rng.f32() - 0.5) * scale));
        let mut checked = Checked::new(with_n(max_objects));
        let mut objects: Vec<_> = (0..60).map(|_| {
            let center = vector(10.0);
            let half = vector(2.0).abs();
            (checked.proxies.insert(Aabb3d::new(center, half)).unwrap(), center, half, vector(0.4))
        }).collect();
        for _ in 0..12 {
            checked.step();
            for (id, center, half, velocity) in &mut objects {
                *center += *velocity;
                checked.proxies.set(*id, &Aabb3d::new(*center, *half)).unwrap();
            }
        }
    }
}

#[test]
fn the_tree_prints_its_leaves() {
    let mut checked = Checked::new(with_n(1));
    for x in [-2.0, 2.0] {
        checked.proxies.insert(cube(x, 1.0, 1.0, 0.25)).unwrap();
    }
    checked.step();
    let node = checked.octree.leaves_of(ProxyId::new(1))[0];
    let left = checked.octree.tree().neighbor(node, "L".parse::<Direction>().unwrap()).unwrap();
    assert_eq!(checked.octree.tree().data(left).listed(), [0]);
}
