//! Ticks that others interfere with: updates of the index at any moment, sets that are skipped,
//! resources that are missing. Whenever the index is updated, no change is lost to the next search.

use crate::common;

use bevy::{
    ecs::{entity::EntityHashSet, entity_disabling::Disabled, system::RunSystemOnce},
    prelude::*,
};
use bevy_octree::{
    diagnostics::STAGES,
    motion::{MotionSettings, Step},
    narrow_phase::Shape,
    prelude::*,
};
use common::{interrupted::*, *};
use fastrand::Rng;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

/// What is done between any two sets, and before them all, in the tick to come.
type Act = Box<dyn FnMut(&mut World) + Send + Sync>;

#[derive(Resource, Default)]
struct Plan(Vec<(usize, Act)>);

impl Plan {
    fn add(app: &mut App, gap: usize, act: impl FnMut(&mut World) + Send + Sync + 'static) {
        app.world_mut()
            .resource_mut::<Self>()
            .0
            .push((gap, Box::new(act)));
    }

    /// Does what is planned for a gap.
    fn act(world: &mut World, gap: usize) {
        let plan = std::mem::take(&mut world.resource_mut::<Self>().0);
        let (now, later): (Vec<_>, Vec<_>) = plan.into_iter().partition(|(place, _)| *place == gap);
        world.resource_mut::<Self>().0.extend(later);
        now.into_iter().for_each(|(_, mut act)| act(world));
    }
}

/// The gaps: before each set but the first.
const GAPS: std::ops::Range<usize> = 1..SETS.len();
const AFTER_BROAD_PHASE: usize = 5;

/// An app in which something can be done between any two sets.
fn planned_app() -> App {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Plan>();
    for gap in GAPS {
        let act = move |world: &mut World| Plan::act(world, gap);
        app.add_systems(FixedPostUpdate, act.after(SETS[gap - 1]).before(SETS[gap]));
    }
    app
}

/// An app in which any set can be [skipped](skip), with what it tells of contacts.
fn skipping_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let_sets_be_skipped(&mut app);
    app
}

fn place(app: &mut App, entity: Entity, x: f32) {
    get_mut::<Transform>(app, entity).translation.x = x;
}

/// A swept ball that bounces in each tick, far from everything.
fn bouncing_elsewhere(app: &mut App) {
    for x in [95.0, 105.0] {
        app.world_mut().spawn((
            CollisionShape::from_half_size(Vec3::new(0.1, 5.0, 5.0)),
            Transform::from_xyz(x, 0.0, 0.0),
        ));
    }
    let moving = (
        Velocity(Vec3::X * 7.0 * TICKS_PER_SECOND),
        ELASTIC,
        Swept::default(),
    );
    app.world_mut().spawn((
        CollisionShape::sphere(0.1),
        moving,
        Transform::from_xyz(100.0, 0.0, 0.0),
    ));
}

/// Ways in which a contact of two ends though nothing moves.
const PARTINGS: [fn(&mut World, EntityPair); 4] = [
    |world, [a, b]| world.insert_batch([(a, StaticShape), (b, StaticShape)]),
    |world, [a, b]| _ = world.entity_mut(a).insert(IgnoreCollisions::from([b])),
    |world, [_, b]| {
        let other = world.spawn_empty().id();
        world.entity_mut(b).insert(InCollisionWorld(other));
    },
    |world, [_, b]| _ = world.entity_mut(b).insert(CollisionLayers::from_bits(1, 2)),
];

#[test]
fn what_ends_a_contact_in_the_middle_of_a_tick_ends_it_by_the_next() {
    for elsewhere in [false, true] {
        for flushes in 0..3 {
            for (number, parting) in PARTINGS.into_iter().enumerate() {
                for gap in GAPS {
                    let mut app = planned_app();
                    let pair = [0.0, 0.9].map(|x| block(&mut app, x));
                    if elsewhere {
                        bouncing_elsewhere(&mut app);
                    }
                    tick(&mut app, 3);
                    assert!(contacts(&app).contains(&pair));
                    Plan::add(&mut app, gap, move |world| {
                        parting(world, pair);
                        (0..flushes).for_each(|_| update_spatial_index(world));
                    });
                    tick(&mut app, 2);
                    let what = (elsewhere, flushes, number, gap);
                    assert!(!contacts(&app).contains(&pair), "{what:?}");
                    tick(&mut app, 2);
                    assert_eq!(messages_about(&app, pair), (1, 1), "{what:?}");
                }
            }
        }
    }
}

/// Two part from each other and others meet, and the index is updated in the middle of that tick.
#[test]
fn updates_between_the_search_and_the_exact_tests_change_nothing() {
    for flushes in 0..4 {
        for gap in GAPS {
            let mut app = planned_app();
            let [a, b, c, d, e] = [0.0, 0.9, 20.0, 40.0, 40.9].map(|x| block(&mut app, x));
            tick(&mut app, 2);
            place(&mut app, b, 19.5);
            Plan::add(&mut app, gap, move |world| {
                (0..flushes).for_each(|_| update_spatial_index(world));
            });
            tick(&mut app, 1);
            assert_eq!(
                contacts(&app),
                [[b, c], [d, e]],
                "{flushes} flushes in gap {gap}"
            );
            tick(&mut app, 2);
            let told = [[a, b], [b, c], [d, e]].map(|pair| messages_about(&app, pair));
            assert_eq!(told, [(1, 1), (1, 0), (1, 0)]);
        }
    }
}

/// One of two that rest goes right before the exact tests, and another gets its handle.
#[test]
fn a_handle_that_is_used_again_in_the_middle_of_a_tick_brings_no_contact_with_it() {
    let mut app = planned_app();
    let [a, b] = [0.0, 0.9].map(|x| block(&mut app, x));
    tick(&mut app, 2);
    Plan::add(&mut app, AFTER_BROAD_PHASE, move |world| {
        world.despawn(a);
        (0..3).for_each(|_| update_spatial_index(world));
        world.spawn((
            CollisionShape::default(),
            Transform::from_xyz(500.0, 0.0, 0.0),
        ));
        (0..2).for_each(|_| update_spatial_index(world));
    });
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    assert_eq!(messages_about(&app, [a, b]), (1, 1));
}

/// A shape that is written between any two sets, whether its entity moves or not.
#[test]
fn a_shape_that_changes_at_any_moment_counts_by_the_next_tick() {
    for moves in [false, true] {
        for gap in GAPS {
            let mut app = planned_app();
            let [a, b] = [0.0, 3.0].map(|x| block(&mut app, x));
            if moves {
                app.world_mut()
                    .entity_mut(a)
                    .insert(Velocity(Vec3::Y * 0.01));
            }
            for (half_size, expected) in [(2.6, vec![[a, b]]), (0.5, vec![])] {
                tick(&mut app, 2);
                Plan::add(&mut app, gap, move |world| {
                    world.get_mut::<CollisionShape>(a).unwrap().0 =
                        Shape::from_half_size(Vec3::splat(half_size));
                });
                tick(&mut app, 2);
                let what = (moves, gap, half_size);
                assert_eq!(contacts(&app), expected, "{what:?}");
                let look = |spatial: SpatialQuery| {
                    let mut found = Vec::new();
                    spatial.for_each_point_intersection(
                        Vec3::X * 2.0,
                        &SpatialQueryFilter::DEFAULT,
                        |entity| {
                            found.push(entity);
                        },
                    );
                    found
                };
                let found = app.world_mut().run_system_once(look).unwrap();
                assert_eq!(found.contains(&a), half_size > 2.0, "{what:?}");
            }
        }
    }
}

/// The sets whose work is to be done however often they are skipped: all but `Motion`.
fn stages() -> &'static [CollisionSystems] {
    &STAGES[1..]
}

#[test]
fn what_changes_while_a_set_is_skipped_counts_once_it_runs() {
    for &set in stages() {
        let mut app = skipping_app();
        let [a, b] = [0.0, 0.9].map(|x| block(&mut app, x));
        for (x, is_contact) in [(0.9, true), (50.0, false), (0.9, true), (50.0, false)] {
            place(&mut app, b, x);
            skip(&mut app, &[set]);
            tick(&mut app, 2);
            skip(&mut app, &[]);
            tick(&mut app, 1);
            let expected = if is_contact { vec![[a, b]] } else { vec![] };
            assert_eq!(
                (contacts(&app), told(&app)),
                (expected.clone(), expected),
                "{set:?}"
            );
            tick(&mut app, 2);
        }
    }
}

#[test]
fn contacts_that_are_gone_for_a_tick_or_from_another_time_are_made_anew() {
    #[derive(Clone, Copy, Debug)]
    enum Back {
        Same,
        Older,
        New,
    }
    for back in [Back::Same, Back::Older, Back::New] {
        let mut app = skipping_app();
        app.set_error_handler(bevy::ecs::error::ignore);
        let [a, b, c] = [0.0, 0.9, 50.0].map(|x| block(&mut app, x));
        tick(&mut app, 1);
        let older = app.world().resource::<Contacts>().clone();
        place(&mut app, c, 50.5);
        tick(&mut app, 1);
        let same = app.world_mut().remove_resource::<Contacts>().unwrap();
        place(&mut app, b, 49.5);
        tick(&mut app, 1);
        app.insert_resource(match back {
            Back::Same => same,
            Back::Older => older,
            Back::New => Contacts::default(),
        });
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [[b, c]], "{back:?}: {a} is left");
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [[b, c]], "{back:?}");
    }
}

/// A bounce that is not answered in its tick is not answered in the next one either, when the ball
/// is elsewhere.
#[test]
fn what_a_skipped_response_was_to_do_is_not_done_later() {
    let mut app = skipping_app();
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0),
    });
    let wall = (
        CollisionShape::from_half_size(Vec3::new(0.1, 5.0, 5.0)),
        Transform::from_xyz(2.5, 0.0, 0.0),
    );
    app.world_mut().spawn(wall);
    let ball = (
        CollisionShape::sphere(0.1),
        Velocity(Vec3::X),
        ELASTIC,
        Swept::default(),
    );
    let ball = app.world_mut().spawn((ball, Transform::default())).id();
    tick(&mut app, 2);
    skip(&mut app, &[CollisionSystems::Response]);
    tick(&mut app, 1);
    skip(&mut app, &[]);
    tick(&mut app, 1);
    assert_eq!(get::<Transform>(&app, ball).translation, Vec3::X * 4.0);
    assert_eq!(get::<Velocity>(&app, ball).0, Vec3::X);
}

/// Skipped sets at random: whenever all have run, contacts are those of brute force, and all is
/// told.
#[test]
fn any_sets_may_be_skipped_in_any_tick() {
    let mut seen = 0;
    for seed in 0..60 {
        let mut rng = Rng::with_seed(seed);
        let mut app = skipping_app();
        let blocks: Vec<_> = (0..12)
            .map(|place| block(&mut app, place as f32 * 0.7))
            .collect();
        for round in 0..40 {
            for _ in 0..rng.u8(0..4) {
                place(&mut app, blocks[rng.usize(0..12)], rng.f32() * 8.0);
            }
            let mut skipped = stages().to_vec();
            let often = rng.bool();
            skipped.retain(|_| often && rng.u8(0..3) == 0);
            skip(&mut app, &skipped);
            tick(&mut app, 1);
            if skipped.is_empty() {
                let found = contacts(&app);
                assert_eq!(
                    found,
                    brute_force_contacts(&mut app),
                    "seed {seed}, round {round}"
                );
                seen += found.len();
            }
            if !skipped.contains(&CollisionSystems::Report) {
                assert_eq!(told(&app), contacts(&app), "seed {seed}, round {round}");
            }
        }
    }
    assert!(seen > 5_000, "{seen}");
}

/// What one tick of a history was like: contacts, what was told, and places, with numbers for
/// entities.
type Seen = (Vec<[usize; 2]>, Vec<[usize; 2]>, Vec<[usize; 2]>, Vec<Vec3>);

/// A random history in which things change before ticks, with or without updates of the index
/// anywhere in them.
///
/// Where things come and go, nothing bounces: `contact_histories` has both.
fn history(seed: u64, flush: bool, bounces: bool) -> Vec<Seen> {
    const COUNT: usize = 16;
    let mut rng = Rng::with_seed(seed);
    let mut flushes = Rng::with_seed(seed + 1_000);
    let mut app = planned_app();
    let vector = |rng: &mut Rng, reach: f32| {
        Vec3::from_array([0; 3].map(|_| (rng.f32() * 2.0 - 1.0) * reach))
    };
    let mut objects: Vec<Entity> = Vec::new();
    let spawn = |app: &mut App, rng: &mut Rng| {
        let shape = if rng.bool() {
            CollisionShape::sphere(0.4)
        } else {
            CollisionShape::default()
        };
        let mut object = app
            .world_mut()
            .spawn((shape, Transform::from_translation(vector(rng, 2.5))));
        if bounces && rng.u8(0..3) > 0 {
            object.insert((Velocity(vector(rng, 1.0) * TICKS_PER_SECOND), ELASTIC));
        }
        if rng.bool() {
            object.insert(Swept::default());
        }
        object.id()
    };
    for _ in 0..COUNT {
        objects.push(spawn(&mut app, &mut rng));
    }
    if bounces {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-1.0, 1.0] {
                let shape = CollisionShape::from_half_size(
                    Vec3::splat(5.0) * (Vec3::ONE - axis) + axis * 0.5,
                );
                let wall = (shape, Transform::from_translation(axis * side * 4.0));
                objects.push(app.world_mut().spawn(wall).id());
            }
        }
    }
    let other_world = app.world_mut().spawn_empty().id();
    tick(&mut app, 1);
    let mut seen = Vec::new();
    for _ in 0..30 {
        for _ in 0..rng.u8(0..4) {
            let which = rng.usize(0..COUNT);
            let (entity, other) = (objects[which], objects[rng.usize(0..COUNT)]);
            let to = vector(&mut rng, 2.5);
            let kind = rng.u8(0..if bounces { 9 } else { 13 });
            let mut object = app.world_mut().entity_mut(entity);
            match kind {
                0 => object.get_mut::<Transform>().unwrap().translation = to,
                1 => object.get_mut::<Transform>().unwrap().set_changed(),
                2 => _ = object.insert((Swept::default(), Transform::from_translation(to))),
                3 => {
                    object.get_mut::<CollisionShape>().unwrap().0 =
                        Shape::from_half_size(to.abs() * 0.3 + 0.1);
                }
                4 => _ = object.insert(IgnoreCollisions::from([other])),
                5 => _ = object.remove::<IgnoreCollisions>(),
                6 => _ = object.insert(CollisionLayers::from_bits(1, 2)),
                7 => _ = object.remove::<CollisionLayers>(),
                8 => _ = object.insert(CollisionEventsEnabled),
                9 => _ = object.insert(InCollisionWorld(other_world)),
                10 => _ = object.remove::<InCollisionWorld>(),
                11 if object.contains::<Disabled>() => _ = object.remove::<Disabled>(),
                11 => _ = object.insert(Disabled),
                _ => {
                    object.despawn();
                    let new = spawn(&mut app, &mut rng);
                    // The numbers of those that are gone stay theirs.
                    let gone = std::mem::replace(&mut objects[which], new);
                    objects.push(gone);
                }
            }
        }
        if flush {
            for gap in GAPS {
                let count = flushes.u8(0..8).saturating_sub(4);
                Plan::add(&mut app, gap, move |world| {
                    (0..count).for_each(|_| update_spatial_index(world));
                });
            }
            (0..flushes.u8(0..3)).for_each(|_| update_spatial_index(app.world_mut()));
        }
        app.world_mut().resource_mut::<Log>().started.clear();
        app.world_mut().resource_mut::<Log>().ended.clear();
        tick(&mut app, 1);
        let number = |entity: Entity| objects.iter().position(|object| *object == entity).unwrap();
        let numbers = |pairs: &mut dyn Iterator<Item = EntityPair>| {
            let mut pairs: Vec<_> = pairs
                .map(|pair| pair.map(number))
                .map(|[a, b]| [a.min(b), a.max(b)])
                .collect();
            pairs.sort_unstable();
            pairs
        };
        let log = app.world().resource::<Log>();
        let touching = numbers(&mut contacts(&app).into_iter());
        let started = numbers(&mut log.started.iter().map(|(_, pair)| *pair));
        let ended = numbers(&mut log.ended.iter().map(|(_, pair)| *pair));
        let places = objects
            .iter()
            .filter_map(|object| app.world().get::<Transform>(*object))
            .map(|at| at.translation);
        seen.push((touching, started, ended, places.collect()));
    }
    seen
}

#[test]
fn results_are_the_same_with_and_without_updates_anywhere() {
    let mut contacts = 0;
    for seed in 0..40 {
        for bounces in [false, true] {
            let (without, with) = (history(seed, false, bounces), history(seed, true, bounces));
            for (number, (without, with)) in without.iter().zip(&with).enumerate() {
                assert_eq!(
                    without, with,
                    "seed {seed}, bounces {bounces}, tick {number}"
                );
            }
            contacts += without
                .iter()
                .map(|(touching, ..)| touching.len())
                .sum::<usize>();
        }
    }
    assert!(contacts > 5_000, "{contacts}");
}

/// Things move, come and go between any two sets, and the index is updated in the same tick: after
/// a tick in which nothing changed, contacts are those of brute force.
#[test]
fn whatever_happens_in_a_tick_the_next_one_is_right() {
    let mut seen = 0;
    for seed in 0..60 {
        let mut rng = Rng::with_seed(seed);
        let mut app = planned_app();
        if seed % 2 == 0 {
            bouncing_elsewhere(&mut app);
        }
        for place in 0..12 {
            block(&mut app, place as f32 * 0.7);
        }
        tick(&mut app, 1);
        for round in 0..20 {
            for _ in 0..rng.usize(1..5) {
                let (gap, which, x, kind, flushes) = (
                    rng.usize(GAPS),
                    rng.usize(0..12),
                    rng.f32() * 8.0,
                    rng.u8(0..5),
                    rng.u8(0..3),
                );
                Plan::add(&mut app, gap, move |world| {
                    let blocks =
                        world.query_filtered::<Entity, (With<CollisionShape>, Without<Velocity>)>();
                    let blocks: Vec<_> = blocks.iter_manual(world).collect();
                    let block = blocks[which % blocks.len()];
                    // The walls of another place stay.
                    if world.get::<Transform>(block).unwrap().translation.x < 90.0 {
                        match kind {
                            0 => world.get_mut::<Transform>(block).unwrap().translation.x = x,
                            1 => world.get_mut::<Transform>(block).unwrap().set_changed(),
                            2 => {
                                let half_size = Vec3::splat(0.3 + x * 0.1);
                                world.get_mut::<CollisionShape>(block).unwrap().0 =
                                    Shape::from_half_size(half_size);
                            }
                            3 => {
                                world.despawn(block);
                                world.spawn((
                                    CollisionShape::default(),
                                    Transform::from_xyz(x, 0.0, 0.0),
                                ));
                            }
                            _ => {
                                world
                                    .entity_mut(block)
                                    .insert(IgnoreCollisions(EntityHashSet::default()));
                            }
                        }
                    }
                    (0..flushes).for_each(|_| update_spatial_index(world));
                });
            }
            tick(&mut app, 2);
            let found: Vec<_> = contacts(&app)
                .into_iter()
                .filter(|pair| is_near(&app, *pair))
                .collect();
            let expected = brute_force_contacts(&mut app);
            let expected: Vec<_> = expected
                .into_iter()
                .filter(|pair| is_near(&app, *pair))
                .collect();
            assert_eq!(found, expected, "seed {seed}, round {round}");
            seen += found.len();
        }
    }
    assert!(seen > 5_000, "{seen}");

    fn is_near(app: &App, pair: EntityPair) -> bool {
        pair.into_iter().all(|entity| {
            app.world()
                .get::<Transform>(entity)
                .is_some_and(|at| at.translation.x < 90.0)
        })
    }
}
