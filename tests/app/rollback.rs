//! Who goes back in time and simulates again has what one has who never did.

use bevy::{
    ecs::entity::{EntityHashMap, MapEntities},
    platform::collections::HashMap,
    prelude::*,
};
use bevy_octree::{
    broad_phase::BroadPhaseMethod,
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
