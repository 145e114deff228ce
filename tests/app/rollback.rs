//! Who goes back in time and simulates again has what one has who never did.

use bevy::{
    ecs::entity::{EntityHashMap, MapEntities},
    platform::collections::HashMap,
    prelude::*,
};
use bevy_octree::{
    broad_phase::BroadPhaseMethod,
    collision_index::CollisionIndex,
    prelude::*,
    rollback::{CollisionSnapshot, RollbackPlugin},
};

use crate::order::{self, COUNT, Seen, plain_app, seen};

/// What of somebody is saved.
type Changing = (
    Transform,
    Option<Velocity>,
    Option<KinematicCharacter>,
    Option<CharacterHits>,
);

/// A state of all: the components of each by its number, and the snapshot, with the numbers of its entities.
#[derive(Clone)]
pub struct Saved {
    all: HashMap<u64, Changing>,
    numbers: EntityHashMap<u64>,
    snapshot: CollisionSnapshot,
}

/// Only what is spawned by number: parts come with their bodies.
fn is_whole(number: u64) -> bool {
    number < COUNT
}

type Read<'a> = (
    &'a Transform,
    Option<&'a Velocity>,
    Option<&'a KinematicCharacter>,
    Option<&'a CharacterHits>,
);

pub fn save(app: &mut App) -> Saved {
    let world = app.world_mut();
    let mut all = world.query::<(Entity, &CollisionOrder, Read)>();
    let all: Vec<_> = all
        .iter(world)
        .map(|(entity, order, (at, velocity, walking, hits))| {
            let changing = (*at, velocity.copied(), walking.copied(), hits.cloned());
            (entity, order.0, changing)
        })
        .collect();
    Saved {
        numbers: all
            .iter()
            .map(|(entity, number, ..)| (*entity, *number))
            .collect(),
        all: all
            .into_iter()
            .filter(|(_, number, ..)| is_whole(*number))
            .map(|(_, number, changing)| (number, changing))
            .collect(),
        snapshot: world.resource::<CollisionSnapshot>().clone(),
    }
}

fn entities(app: &mut App) -> HashMap<u64, Entity> {
    let world = app.world_mut();
    let mut all = world.query::<(Entity, &CollisionOrder)>();
    all.iter(world)
        .map(|(entity, order)| (order.0, entity))
        .collect()
}

/// Goes back: who has come since goes, who has gone is spawned again, under another name.
pub fn restore(app: &mut App, saved: &Saved) {
    for (number, entity) in entities(app) {
        if is_whole(number) && !saved.all.contains_key(&number) {
            app.world_mut().despawn(entity);
        }
    }
    let there = entities(app);
    let mut missing: Vec<_> = saved
        .all
        .keys()
        .filter(|number| !there.contains_key(*number))
        .collect();
    missing.sort_unstable();
    missing
        .into_iter()
        .for_each(|number| _ = order::spawn(app, *number));
    let there = entities(app);
    let mut names: EntityHashMap<Entity> = saved
        .numbers
        .iter()
        .map(|(entity, number)| (*entity, there[number]))
        .collect();
    for (number, (at, velocity, walking, hits)) in &saved.all {
        let mut entity = app.world_mut().entity_mut(there[number]);
        entity.insert(*at);
        velocity.map(|velocity| _ = entity.insert(velocity));
        if let (Some(mut walking), Some(mut hits)) = (*walking, hits.clone()) {
            MapEntities::map_entities(&mut walking, &mut names);
            MapEntities::map_entities(&mut hits, &mut names);
            entity.insert((walking, hits));
        }
    }
    let mut snapshot = saved.snapshot.clone();
    snapshot.map_entities(&mut names);
    app.insert_resource(snapshot);
}

/// What everybody does in a tick: some go and come, one is steered.
fn act(app: &mut App, tick: u64, push: Vec3) {
    if tick % 11 == 10 {
        order::respawn(app, COUNT, tick, false);
    }
    let number = 6 + tick * 7 % (COUNT - 6);
    let entity = entities(app)[&number];
    if let Some(mut velocity) = app.world_mut().get_mut::<Velocity>(entity) {
        velocity.0 += push;
    }
}

fn input(tick: u64) -> Vec3 {
    Vec3::new((tick as f32).sin(), (tick as f32 * 0.7).cos(), 0.5).round() * 4.0
}

fn step(app: &mut App, tick: u64, push: Vec3) -> Seen {
    act(app, tick, push);
    app.update();
    seen(app)
}

fn client(order: &[u64]) -> App {
    let mut app = order::room(order, BroadPhaseMethod::default());
    app.add_plugins(RollbackPlugin);
    app
}

#[test]
fn who_goes_back_has_what_one_has_who_never_did() {
    let mut straight = client(&(0..COUNT).collect::<Vec<_>>());
    let mut other = client(&order::shuffled(3));
    // What the other knew at the start of each of the last ticks.
    let mut history: Vec<Saved> = Vec::new();
    let (mut told, mut wrong) = (0, 0);
    for tick in 0..150 {
        let expected = step(&mut straight, tick, input(tick));
        told += expected.started.len() + expected.ended.len() + expected.events.len();
        history.push(save(&mut other));
        // What it thought to be going on.
        let foreseen = step(&mut other, tick, Vec3::ZERO);
        wrong += usize::from(foreseen != expected);
        let back = tick.min(7);
        if tick % 4 == 3 {
            // Now it knows better.
            history.truncate(history.len() - back as usize);
            restore(&mut other, history.last().unwrap());
            for again in tick - back..=tick {
                if again > tick - back {
                    history.push(save(&mut other));
                }
                let now = step(&mut other, again, input(again));
                if again == tick {
                    assert_eq!(now, expected, "in tick {tick}");
                }
            }
        }
    }
    assert!(told > 1000 && wrong > 75, "{told} told, {wrong} wrong");
}

#[test]
fn a_restore_without_a_change_tells_nothing() {
    let mut app = client(&order::shuffled(5));
    (0..20).for_each(|tick| _ = step(&mut app, tick, input(tick)));
    let mut again = client(&order::shuffled(5));
    (0..20).for_each(|tick| _ = step(&mut again, tick, input(tick)));
    // Once one goes back to where it is.
    let saved = save(&mut again);
    assert!(saved.snapshot.contacts() > 10);
    restore(&mut again, &saved);
    for tick in 20..30 {
        let [expected, now] = [&mut app, &mut again].map(|app| step(app, tick, input(tick)));
        assert_eq!(expected, now, "in tick {tick}");
    }
    let taken = app.world().resource::<CollisionSnapshot>();
    assert_eq!(taken, again.world().resource::<CollisionSnapshot>());
    assert_eq!(taken.tick(), 30);
}

#[test]
fn what_is_gone_ends_and_what_began_since_never_was() {
    let mut app = plain_app(BroadPhaseMethod::default());
    app.add_plugins(RollbackPlugin);
    let [a, b, c] = [0.0, 0.5, 9.0].map(|x| cube(&mut app, x));
    let tick = |app: &mut App| {
        let [started, ended, _] = told(app);
        (started, ended)
    };
    assert_eq!(tick(&mut app), (vec![[a, b]], vec![]));
    let saved = app.world().resource::<CollisionSnapshot>().clone();
    // One comes, and is in contact with both; then it never was.
    app.world_mut().entity_mut(c).insert(Transform::default());
    assert_eq!(tick(&mut app), (vec![[a, c], [b, c]], vec![]));
    app.world_mut()
        .entity_mut(c)
        .insert(Transform::from_xyz(9.0, 0.0, 0.0));
    app.insert_resource(saved.clone());
    assert_eq!(tick(&mut app), (vec![], vec![]));
    // What starts again is told again.
    app.world_mut().entity_mut(c).insert(Transform::default());
    assert_eq!(tick(&mut app), (vec![[a, c], [b, c]], vec![]));
    // What is gone for good, ends.
    app.world_mut().despawn(b);
    app.world_mut()
        .entity_mut(c)
        .insert(Transform::from_xyz(9.0, 0.0, 0.0));
    app.insert_resource(saved);
    assert_eq!(tick(&mut app), (vec![], vec![[a, b]]));
    assert_eq!(tick(&mut app), (vec![], vec![]));
    // To before the first tick: nothing was in contact.
    app.insert_resource(CollisionSnapshot::default());
    app.world_mut().entity_mut(c).insert(Transform::default());
    assert_eq!(tick(&mut app), (vec![[a, c]], vec![]));
}

/// A state that was written to a file, or sent, is the same state.
#[cfg(all(feature = "serialize", feature = "reports"))]
#[test]
fn what_is_saved_is_written_and_read() {
    let mut app = client(&order::shuffled(7));
    (0..20).for_each(|tick| _ = step(&mut app, tick, input(tick)));
    let mut saved = save(&mut app);
    let text = serde_json::to_string(&saved.snapshot).unwrap();
    let read: CollisionSnapshot = serde_json::from_str(&text).unwrap();
    assert_eq!(read, saved.snapshot);
    assert!(read.contacts() > 10);
    let ahead: Vec<_> = (20..25)
        .map(|tick| step(&mut app, tick, input(tick)))
        .collect();
    saved.snapshot = read;
    restore(&mut app, &saved);
    let again: Vec<_> = (20..25)
        .map(|tick| step(&mut app, tick, input(tick)))
        .collect();
    assert_eq!(ahead, again);
    // Characters, with what they stand on.
    let ground = Ground {
        entity: Entity::PLACEHOLDER,
        point: Vec3::X,
        normal: Vec3::Y,
        velocity: Vec3::Z,
        pose: Transform::from_xyz(0.1, 0.2, 0.3),
    };
    let character = KinematicCharacter {
        velocity: Vec3::new(0.1, 1e-30, 3e8),
        ground: Some(ground),
        ..default()
    };
    let text = serde_json::to_string(&character).unwrap();
    assert_eq!(
        serde_json::from_str::<KinematicCharacter>(&text).unwrap(),
        character
    );
}

fn cube(app: &mut App, x: f32) -> Entity {
    let at = Transform::from_xyz(x, 0.0, 0.0);
    app.world_mut().spawn((CollisionShape::default(), at)).id()
}

/// What is told in a tick: contacts that started and ended, and those of bodies that ended.
fn told(app: &mut App) -> [Vec<[Entity; 2]>; 3] {
    app.update();
    let world = app.world_mut();
    let started = world
        .resource_mut::<Messages<CollisionStarted>>()
        .drain()
        .map(|told| [told.a, told.b])
        .collect();
    let ended = world
        .resource_mut::<Messages<CollisionEnded>>()
        .drain()
        .map(|told| [told.a, told.b])
        .collect();
    let bodies = world
        .resource_mut::<Messages<BodyCollisionEnded>>()
        .drain()
        .map(|told| [told.a, told.b])
        .collect();
    [started, ended, bodies]
}

fn two_cubes() -> (App, [Entity; 2], CollisionSnapshot) {
    let mut app = plain_app(BroadPhaseMethod::default());
    app.add_plugins(RollbackPlugin);
    let cubes = [0.0, 0.5].map(|x| cube(&mut app, x));
    assert_eq!(told(&mut app), [vec![cubes], vec![], vec![]]);
    let saved = app.world().resource::<CollisionSnapshot>().clone();
    (app, cubes, saved)
}

/// Of a body that is its only part, the contact is one of bodies all the same.
#[test]
fn bodies_with_a_shape_of_their_own_are_told_of_ends() {
    let (mut app, [body, wall], _) = two_cubes();
    app.world_mut()
        .entity_mut(body)
        .insert(CollisionBody::default());
    app.update();
    let saved = app.world().resource::<CollisionSnapshot>().clone();
    app.update();
    app.insert_resource(saved);
    app.world_mut()
        .entity_mut(wall)
        .insert(Transform::from_xyz(9.0, 0.0, 0.0));
    let [_, ended, bodies] = told(&mut app);
    assert_eq!((ended, bodies), (vec![[body, wall]], vec![[body, wall]]));
}

/// What leaves and comes back in the tick that is simulated again, ends and starts, as it did the first time.
#[test]
fn what_leaves_in_the_first_tick_ends_and_starts() {
    let (mut app, [_, cube], saved) = two_cubes();
    let leave = move |mut commands: Commands, clock: Res<bevy_octree::motion::CollisionClock>| {
        if clock.tick() == 1 {
            commands
                .entity(cube)
                .remove::<CollisionShape>()
                .insert(CollisionShape::default());
        }
    };
    app.add_systems(Update, leave.in_set(CollisionSystems::First));
    let first = told(&mut app);
    assert_eq!([first[0].len(), first[1].len()], [1, 1]);
    app.insert_resource(saved);
    assert_eq!(told(&mut app), first);
}

/// A snapshot that is put back during a pause is taken up when that is over.
#[test]
fn a_pause_loses_no_snapshot() {
    #[derive(Resource)]
    struct Paused(bool);

    let (mut app, [_, cube], saved) = two_cubes();
    app.insert_resource(Paused(false));
    for set in crate::common::SETS {
        app.configure_sets(Update, set.run_if(|paused: Res<Paused>| !paused.0));
    }
    let at = |x| Transform::from_xyz(x, 0.0, 0.0);
    app.world_mut().entity_mut(cube).insert(at(5.0));
    assert_eq!(told(&mut app)[1].len(), 1);
    app.world_mut().entity_mut(cube).insert(at(0.5));
    app.insert_resource(saved);
    app.insert_resource(Paused(true));
    (0..2).for_each(|_| app.update());
    app.insert_resource(Paused(false));
    assert!(told(&mut app).iter().all(Vec::is_empty));
}

/// Two that a map makes one are in contact with themselves no more.
#[test]
fn two_that_are_mapped_to_one_do_no_harm() {
    let (mut app, [a, b], mut saved) = two_cubes();
    let other = cube(&mut app, 9.0);
    app.update();
    saved.map_entities(&mut EntityHashMap::from_iter([(a, other), (b, other)]));
    app.insert_resource(saved);
    // It ends for the one, who knows nothing of it, or not at all: what is there, starts.
    let [started, ..] = told(&mut app);
    assert_eq!(started, [[a, b]]);
}

/// The sets that are left out of the tick to come.
#[derive(Resource, Default)]
struct LeftOut(Vec<CollisionSystems>);

/// What is told, and which bodies are in contact by which parts, in a tick without these sets.
fn told_without(
    app: &mut App,
    sets: &[CollisionSystems],
) -> impl PartialEq + std::fmt::Debug + use<> {
    app.world_mut().resource_mut::<LeftOut>().0 = sets.to_vec();
    let told = told(app);
    let contacts = app.world().resource::<Contacts>();
    let bodies: Vec<_> = contacts.body_pairs().collect();
    let parts = |pair: &BodyCollision| {
        let parts = contacts.between_bodies(pair.a, pair.b);
        let all = parts.chain(contacts.of_body(pair.a));
        all.map(|part| (part.a, part.b, part.bodies))
            .collect::<Vec<_>>()
    };
    let parts: Vec<_> = bodies.iter().map(parts).collect();
    let all: Vec<_> = contacts.iter().collect();
    (told, bodies, parts, all)
}

/// Where the exact tests are left out of the tick that is simulated again, it is as without going back: nothing ends that
/// did not end, and what is yet to be told is told.
#[test]
fn a_tick_without_exact_tests_is_as_it_was() {
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    // Is there anything yet to be told when the snapshot is taken? Does one go back?
    let run = |is_pending: bool, goes_back: bool| {
        let mut app = plain_app(BroadPhaseMethod::default());
        app.add_plugins(RollbackPlugin).init_resource::<LeftOut>();
        for set in crate::common::SETS {
            let is_in = move |left_out: Res<LeftOut>| !left_out.0.contains(&set);
            app.configure_sets(Update, set.run_if(is_in));
        }
        let sensor = (CollisionShape::default(), Sensor, at(1.0));
        let parts = children![CollisionShape::default(), sensor];
        let body = (CollisionBody::default(), at(0.0), parts);
        let body = app.world_mut().spawn(body).id();
        let own = (CollisionBody::default(), CollisionShape::default(), at(5.0));
        let own = app.world_mut().spawn(own).id();
        let [wall, other, one, two] = [0.5, 5.5, 20.0, 20.5].map(|x| cube(&mut app, x));
        let late = cube(&mut app, 30.0);
        told(&mut app);
        if is_pending {
            app.world_mut().entity_mut(late).insert(at(-0.5));
            app.world_mut().entity_mut(other).insert(at(9.0));
            drop(told_without(&mut app, &[CollisionSystems::Report]));
        }
        let saved = app.world().resource::<CollisionSnapshot>().clone();
        if goes_back {
            let places =
                [body, own, wall].map(|entity| *app.world().get::<Transform>(entity).unwrap());
            for (number, entity) in [body, own, wall].into_iter().enumerate() {
                app.world_mut()
                    .entity_mut(entity)
                    .insert(at(100.0 * number as f32));
            }
            drop(told_without(&mut app, &[]));
            for (entity, place) in [body, own, wall].into_iter().zip(places) {
                app.world_mut().entity_mut(entity).insert(place);
            }
            app.insert_resource(saved);
        }
        app.world_mut().despawn(two);
        let ticks: [&[CollisionSystems]; 3] = [&[CollisionSystems::NarrowPhase], &[], &[]];
        (one, ticks.map(|sets| told_without(&mut app, sets)))
    };
    for is_pending in [false, true] {
        assert_eq!(
            run(is_pending, true),
            run(is_pending, false),
            "{is_pending}"
        );
    }
}

/// Cubes in a row, each in touch with the next, some of them parts: by their numbers, and the numbers by them.
fn row(app: &mut App, numbers: impl IntoIterator<Item = u64>) -> HashMap<u64, Entity> {
    let mut row = HashMap::default();
    for number in numbers {
        let own = (
            CollisionOrder(number),
            CollisionEventsEnabled,
            Transform::from_xyz(number as f32 * 0.75, 0.0, 0.0),
        );
        let entity = app.world_mut().spawn(own).id();
        row.insert(number, entity);
        if number % 3 == 0 {
            app.world_mut()
                .entity_mut(entity)
                .insert(CollisionBody::default());
            let part = (CollisionShape::default(), CollisionOrder(100 + number));
            let part = app.world_mut().spawn((part, ChildOf(entity))).id();
            row.insert(100 + number, part);
        } else {
            app.world_mut()
                .entity_mut(entity)
                .insert(CollisionShape::default());
        }
    }
    row
}

/// Ends are told in the order of numbers, those of who is gone included, though the index has never known them.
#[test]
fn ends_have_an_order_in_another_app() {
    #[derive(Resource, Default)]
    struct Heard(Vec<[Entity; 2]>);

    const ROW: u64 = 12;
    let is_left = |number: &u64| number % 4 == 1;
    let client = || {
        let mut app = plain_app(BroadPhaseMethod::default());
        app.add_plugins(RollbackPlugin).init_resource::<Heard>();
        app.add_observer(|event: On<CollisionEnded>, mut heard: ResMut<Heard>| {
            heard.0.push([event.a, event.b]);
        });
        app.add_observer(|event: On<BodyCollisionEnded>, mut heard: ResMut<Heard>| {
            heard.0.push([event.a, event.b]);
        });
        app
    };
    // All that is told, by numbers.
    let told = |app: &mut App, row: &HashMap<u64, Entity>| {
        let numbers: EntityHashMap<u64> = row
            .iter()
            .map(|(number, entity)| (*entity, *number))
            .collect();
        let [started, ended, bodies] = told(app);
        let heard = std::mem::take(&mut app.world_mut().resource_mut::<Heard>().0);
        [started, ended, bodies, heard].map(|told| {
            told.iter()
                .map(|two| two.map(|entity| numbers[&entity]))
                .collect::<Vec<_>>()
        })
    };
    let mut app = client();
    let known = row(&mut app, 0..ROW);
    assert_eq!(told(&mut app, &known)[0].len(), ROW as usize - 1);
    let saved = app.world().resource::<CollisionSnapshot>().clone();
    let go = |app: &mut App| {
        for number in (0..ROW).filter(|number| !is_left(number)) {
            app.world_mut().despawn(known[&number]);
        }
    };
    // In the same app, with the index that has known them all, and with another.
    let mut another = client();
    let same = row(&mut another, 0..ROW);
    assert_eq!(same, known);
    told(&mut another, &same);
    go(&mut app);
    let expected = told(&mut app, &known);
    assert_eq!(expected.each_ref().map(Vec::len), [0, 11, 7, 29]);
    go(&mut another);
    another.insert_resource(CollisionIndex::default());
    another.insert_resource(saved.clone());
    assert_eq!(told(&mut another, &same), expected);
    // In one in which nobody was who is gone, and others have other names.
    for seed in 0..8 {
        let mut other = client();
        let mut numbers: Vec<_> = known.keys().copied().collect();
        numbers.sort_unstable();
        fastrand::Rng::with_seed(seed).shuffle(&mut numbers);
        let mut there = HashMap::default();
        for number in numbers {
            let is_part = number >= ROW;
            if !is_left(&(number % 100)) {
                there.insert(number, other.world_mut().spawn_empty().id());
            } else if !is_part {
                there.extend(row(&mut other, [number]));
            }
        }
        for (number, entity) in &there {
            if other.world().get::<CollisionOrder>(*entity).is_none() {
                other.world_mut().despawn(there[number]);
            }
        }
        let mut names: EntityHashMap<Entity> = known
            .iter()
            .map(|(number, entity)| (*entity, there[number]))
            .collect();
        let mut mapped = saved.clone();
        mapped.map_entities(&mut names);
        other.insert_resource(mapped);
        assert_eq!(told(&mut other, &there), expected, "{seed}");
    }
}
