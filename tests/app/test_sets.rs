//! The report's test sets t0 to t3, 200 ticks on every path: the same contacts tick by tick, and
//! those that the geometry of the sets foretells.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    prelude::*,
    scene::{Cube, TestCube, TestSet},
};
use common::*;

const TICKS: usize = 200;

fn octree(max_objects: u32) -> BroadPhaseMethod {
    BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(max_objects))
}

fn methods() -> [BroadPhaseMethod; 5] {
    [
        BroadPhaseMethod::Exhaustive,
        BroadPhaseMethod::LinearOctree,
        octree(1),
        octree(5),
        octree(16),
    ]
}

/// What happened in a tick.
#[derive(Debug, PartialEq)]
struct Frame {
    contacts: Vec<EntityPair>,
    bounces: u64,
    started: u64,
    ended: u64,
}

impl Frame {
    fn of(app: &App) -> Self {
        let counters = counters(app);
        Self {
            contacts: contacts(app),
            bounces: counters.bounces,
            started: counters.started,
            ended: counters.ended,
        }
    }
}

fn spawn(app: &mut App, set: &TestSet) -> Vec<(Entity, TestCube)> {
    let spawn = |cube: TestCube| {
        let transform =
            Transform::from_translation(cube.position).with_scale(Vec3::splat(set.side));
        let velocity = Velocity(cube.velocity * TICKS_PER_SECOND);
        (
            app.world_mut().spawn((Cube, transform, velocity)).id(),
            cube,
        )
    };
    set.cubes().map(spawn).collect()
}

/// Runs a set, and calls `before` with the number of each tick, from 1, before it.
fn run(
    set: &TestSet,
    method: BroadPhaseMethod,
    mut before: impl FnMut(&mut App, usize),
) -> (App, Vec<Frame>) {
    let mut app = app(method);
    spawn(&mut app, set);
    let frames = (1..=TICKS)
        .map(|number| {
            before(&mut app, number);
            tick(&mut app, 1);
            Frame::of(&app)
        })
        .collect();
    (app, frames)
}

/// Each cube meets the one opposite when the two rings meet, and for one tick only.
fn foretold(set: &TestSet, cubes: &[(Entity, TestCube)], tick: usize) -> Frame {
    let (left, right) = cubes.split_at(cubes.len() / 2);
    let meeting = |tick: usize| {
        let opposite = left.iter().zip(right);
        opposite.filter(move |((_, cube), _)| set.first_contact_tick(cube.ring) == tick as u64)
    };
    let mut contacts: Vec<_> = meeting(tick).map(|((a, _), (b, _))| pair(*a, *b)).collect();
    contacts.sort_by_key(|pair| pair.map(Entity::index_u32));
    let started = contacts.len() as u64;
    Frame {
        contacts,
        bounces: 2 * started,
        started,
        ended: meeting(tick - 1).count() as u64,
    }
}

#[test]
fn every_path_finds_the_contacts_foretold() {
    for set in [0, 1, 2, 3].map(TestSet::new) {
        for method in methods() {
            let mut app = app(method.clone());
            let cubes = spawn(&mut app, &set);
            for number in 1..=TICKS {
                tick(&mut app, 1);
                let expected = foretold(&set, &cubes, number);
                assert_eq!(
                    Frame::of(&app),
                    expected,
                    "{}, tick {number}, {method:?}",
                    set.name()
                );
            }
            let total = app.world().resource::<CollisionCounters>().total;
            assert_eq!(
                total.bounces,
                set.object_count() as u64,
                "every cube bounces once"
            );
        }
    }
}

#[test]
fn the_planes_stay_mirror_images_and_go_back_where_they_came_from() {
    let set = TestSet::new(2);
    let mut app = app(octree(5));
    let cubes = spawn(&mut app, &set);
    for number in 1..=TICKS {
        tick(&mut app, 1);
        let (left, right) = cubes.split_at(cubes.len() / 2);
        for ((a, cube), (b, _)) in left.iter().zip(right) {
            let [a, b] = [a, b].map(|cube| get::<Transform>(&app, *cube).translation);
            assert_eq!(a * Vec3::new(-1.0, 1.0, 1.0), b, "tick {number}");
            let turn = set.first_contact_tick(cube.ring) as f32;
            let forward = turn - (number as f32 - turn).abs();
            assert_eq!(a, cube.position + cube.velocity * forward, "tick {number}");
        }
    }
}

#[test]
fn the_octree_is_well_formed_at_each_tick() {
    for (rings, max_objects) in [(0, 1), (1, 1), (2, 5), (3, 16)] {
        let set = TestSet::new(rings);
        let mut mirror = Mirror::new(ObjectOctreeSettings::with_max_objects(max_objects));
        let mut app = app(octree(max_objects));
        spawn(&mut app, &set);
        for _ in 0..80 {
            tick(&mut app, 1);
            mirror.follow(&mut app);
            assert_eq!(index(&app).stats().nodes, mirror.stats().nodes);
        }
    }
}

#[test]
fn the_octree_compares_fewer_pairs() {
    let tested = |method| {
        let (app, _) = run(&TestSet::new(3), method, |_, _| ());
        app.world()
            .resource::<CollisionCounters>()
            .total
            .pairs_tested
    };
    assert_eq!(
        tested(BroadPhaseMethod::Exhaustive),
        TICKS as u64 * 98 * 97 / 2
    );
    for max_objects in [1, 5, 16] {
        assert!(
            tested(octree(max_objects)) < tested(BroadPhaseMethod::Exhaustive) / 2,
            "N = {max_objects}"
        );
    }
}

#[test]
fn the_method_can_be_switched_at_any_tick() {
    let set = TestSet::new(2);
    let (steady, expected) = run(&set, BroadPhaseMethod::Exhaustive, |_, _| ());
    let mut methods = methods().into_iter().cycle();
    let (switching, frames) = run(&set, octree(5), |app, number| {
        // Most ticks, those with contacts and those without.
        if !number.is_multiple_of(3) {
            app.world_mut().resource_mut::<BroadPhaseSettings>().method = methods.next().unwrap();
        }
    });
    assert_eq!(frames, expected);
    assert_eq!(
        switching.world().resource::<Log>(),
        steady.world().resource::<Log>()
    );
}

#[test]
fn a_switch_keeps_the_contacts_of_resting_objects() {
    let mut app = app(octree(1));
    let row = [0, 1, 2].map(|x| {
        let place = Transform::from_xyz(x as f32, 0.0, 0.0);
        app.world_mut()
            .spawn((CollisionShape::default(), place))
            .id()
    });
    tick(&mut app, 3);
    for method in methods() {
        app.world_mut().resource_mut::<BroadPhaseSettings>().method = method;
        tick(&mut app, 2);
        assert_eq!(contacts(&app), [[row[0], row[1]], [row[1], row[2]]]);
    }
    assert_eq!(app.world().resource::<Log>().started.len(), 2);
    assert!(app.world().resource::<Log>().ended.is_empty());
}
