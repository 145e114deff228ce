//! The stress scenes through the broad phases.

use bevy_octree::{
    broad_phase::{
        BroadPhaseMethod, Exhaustive, ObjectOctreeSettings, Pair, PairSearch, ProxyId, SpatialIndex,
    },
    scene::stress::{StressScene, StressSimulation},
};

const OBJECTS: usize = 300;
const TICKS: usize = 60;

/// An index that follows a simulation.
struct Follower {
    index: SpatialIndex,
    objects: Vec<ProxyId>,
}

impl Follower {
    fn new(mut index: SpatialIndex, simulation: &StressSimulation) -> Self {
        let objects = simulation
            .boxes()
            .iter()
            .map(|aabb| index.insert(*aabb).unwrap())
            .collect();
        Self { index, objects }
    }

    /// The pairs of this tick, sorted.
    fn pairs(&mut self, simulation: &StressSimulation) -> Vec<Pair> {
        for (object, aabb) in self.objects.iter().zip(simulation.boxes()) {
            self.index.set(*object, aabb).unwrap();
        }
        self.index.update();
        let mut pairs: Vec<_> = self.index.find_pairs().iter().collect();
        pairs.sort_unstable();
        pairs
    }
}

#[test]
fn every_method_finds_the_same_pairs_in_every_scene() {
    let methods = [
        BroadPhaseMethod::default(),
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::default()),
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(4)),
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings {
            search: PairSearch::Leaves,
            ..ObjectOctreeSettings::with_max_objects(16)
        }),
    ];
    for scene in StressScene::ALL {
        let mut simulation = StressSimulation::new(scene, OBJECTS, 11);
        let mut reference = Follower::new(
            SpatialIndex::with_engine(Box::<Exhaustive>::default()),
            &simulation,
        );
        let mut followers = methods
            .each_ref()
            .map(|method| Follower::new(SpatialIndex::new(method), &simulation));
        let mut total = 0;
        for tick in 0..TICKS {
            let expected = reference.pairs(&simulation);
            total += expected.len();
            for (follower, method) in followers.iter_mut().zip(&methods) {
                assert_eq!(
                    follower.pairs(&simulation),
                    expected,
                    "{scene} by {method:?} at tick {tick}"
                );
            }
            simulation.step();
        }
        assert!(total > 20, "{scene}: {total} pairs in {TICKS} ticks");
    }
}

#[test]
fn what_rests_in_a_scene_rests_in_the_index() {
    let mut simulation = StressSimulation::new(StressScene::Static90, 1000, 2);
    let mut follower = Follower::new(SpatialIndex::default(), &simulation);
    follower.pairs(&simulation);
    for _ in 0..10 {
        simulation.step();
        follower.pairs(&simulation);
        assert_eq!(follower.index.proxies().moved().len(), 100);
    }
}
