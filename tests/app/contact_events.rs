//! Who is told about contacts, what, and when.

use crate::common;

use bevy::{
    ecs::{entity_disabling::Disabled, system::RunSystemOnce},
    prelude::*,
};
use bevy_octree::{contacts::Collision, narrow_phase::Contact, prelude::*};
use common::*;

/// As an editor or a remote client hears of it, and tells of it.
#[test]
fn events_and_messages_are_known_to_reflection() {
    let mut app = listening_app();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let [a, b] = [(); 2].map(|()| app.world_mut().spawn_empty().id());
    let layers = [CollisionLayers::default(); 2];
    let started = CollisionStarted {
        a,
        b,
        bodies: [a, b],
        contact: None,
        layers,
        time: 1.0,
    };
    let ended = CollisionEnded {
        a,
        b,
        bodies: [a, b],
        contact: None,
        layers,
    };
    for event in [&started as &dyn Reflect, &ended] {
        let registration = registry
            .get(event.as_any().type_id())
            .expect("it is registered");
        registration
            .data::<ReflectEvent>()
            .expect("an event")
            .trigger(app.world_mut(), event, &registry);
        registration
            .data::<ReflectMessage>()
            .expect("a message")
            .write_message(app.world_mut(), event, &registry);
    }
    assert_eq!(
        app.world().resource::<Heard>().told,
        [Started(a, b), Ended(a, b)]
    );
    assert_eq!(app.world().resource::<Messages<CollisionEnded>>().len(), 1);
    assert_eq!(
        app.world().resource::<Messages<CollisionStarted>>().len(),
        1
    );
}

/// What the observers of an entity were told.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    Started(Entity, Entity),
    Ended(Entity, Entity),
}
use Told::{Ended, Started};

#[derive(Resource, Default)]
struct Heard {
    told: Vec<Told>,
    contacts: Vec<Contact>,
}

/// An app in which all events are listened to.
fn listening_app() -> App {
    listen(app(BroadPhaseMethod::default()))
}

fn listen(mut app: App) -> App {
    app.init_resource::<Heard>()
        .add_observer(|event: On<CollisionStarted>, mut heard: ResMut<Heard>| {
            heard.told.push(Started(event.a, event.b));
            heard.contacts.extend(event.contact);
        })
        .add_observer(|event: On<CollisionEnded>, mut heard: ResMut<Heard>| {
            heard.told.push(Ended(event.a, event.b));
            heard.contacts.extend(event.contact);
        });
    app
}

/// What was heard since this was last asked. Every event brought its contact.
fn heard(app: &mut App) -> Vec<Told> {
    let heard = std::mem::take(&mut *app.world_mut().resource_mut::<Heard>());
    assert_eq!(heard.contacts.len(), heard.told.len());
    heard.told
}

/// A static unit cube, with or without the marker. Takes a tick, elsewhere, so that handles are in
/// the order of calls.
fn block(app: &mut App, x: f32, enabled: bool) -> Entity {
    let block = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(0.0, 1000.0, 0.0),
        ))
        .id();
    tick(app, 1);
    *get_mut(app, block) = Transform::from_xyz(x, 0.0, 0.0);
    if enabled {
        enable(app, block);
    }
    block
}

fn enable(app: &mut App, entity: Entity) {
    app.world_mut()
        .entity_mut(entity)
        .insert(CollisionEventsEnabled);
}

fn disable(app: &mut App, entity: Entity) {
    app.world_mut()
        .entity_mut(entity)
        .remove::<CollisionEventsEnabled>();
}

fn place(app: &mut App, entity: Entity, x: f32) {
    get_mut::<Transform>(app, entity).translation.x = x;
}

/// Two cubes that overlap by a tenth, one tick old.
fn in_contact(enabled: [bool; 2]) -> (App, EntityPair) {
    let mut app = listening_app();
    let cubes = [
        block(&mut app, 0.0, enabled[0]),
        block(&mut app, 0.9, enabled[1]),
    ];
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes]);
    (app, cubes)
}

/// The messages since this was last asked.
fn messages<M: Message>(app: &mut App) -> Vec<M> {
    app.world_mut()
        .resource_mut::<Messages<M>>()
        .drain()
        .collect()
}

fn assert_contact(contact: Option<Contact>, normal: Vec3, depth: f32) {
    let contact = contact.expect("it was asked for");
    assert!(
        (contact.normal - normal).length() < 1e-5 && (contact.depth - depth).abs() < 1e-5,
        "{contact:?}"
    );
    assert!((contact.point.x - 0.45).abs() < 0.06, "{contact:?}");
}

#[test]
fn messages_go_to_all_and_events_to_those_who_opted_in() {
    for enabled in [[false, false], [true, false], [false, true], [true, true]] {
        let (mut app, [a, b]) = in_contact(enabled);
        let both = [(a, b), (b, a)];
        let expected = |told: fn(Entity, Entity) -> Told| -> Vec<_> {
            both.into_iter()
                .zip(enabled)
                .filter(|(_, enabled)| *enabled)
                .map(|((a, b), _)| told(a, b))
                .collect()
        };
        assert_eq!(heard(&mut app), expected(Started));
        let [started] = messages::<CollisionStarted>(&mut app)[..] else {
            panic!("one message")
        };
        assert_eq!(
            (started.a, started.b, started.contact.is_some()),
            (a, b, enabled != [false, false])
        );
        tick(&mut app, 2);
        assert_eq!(heard(&mut app), []);
        place(&mut app, b, 5.0);
        tick(&mut app, 1);
        assert_eq!(heard(&mut app), expected(Ended));
        let [ended] = messages::<CollisionEnded>(&mut app)[..] else {
            panic!("one message")
        };
        assert_eq!((ended.a, ended.b, ended.contact), (a, b, started.contact));
        tick(&mut app, 2);
        assert_eq!(
            (heard(&mut app), messages_about(&app, [a, b])),
            (vec![], (1, 1))
        );
    }
}

#[test]
fn an_observer_of_an_entity_sees_it_first_and_the_normal_away_from_it() {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Heard>();
    let cubes = [block(&mut app, 0.0, true), block(&mut app, 0.9, true)];
    for (entity, other, normal) in [
        (cubes[0], cubes[1], Vec3::X),
        (cubes[1], cubes[0], Vec3::NEG_X),
    ] {
        app.world_mut()
            .entity_mut(entity)
            .observe(
                move |event: On<CollisionStarted>, mut heard: ResMut<Heard>| {
                    assert_eq!(
                        (event.event_target(), event.a, event.b),
                        (entity, entity, other)
                    );
                    assert_contact(event.contact, normal, 0.1);
                    heard.told.push(Started(event.a, event.b));
                },
            )
            .observe(move |event: On<CollisionEnded>, mut heard: ResMut<Heard>| {
                assert_eq!(
                    (event.event_target(), event.a, event.b),
                    (entity, entity, other)
                );
                assert_contact(event.contact, normal, 0.1);
                heard.told.push(Ended(event.a, event.b));
            });
    }
    tick(&mut app, 1);
    place(&mut app, cubes[1], 5.0);
    tick(&mut app, 1);
    let [a, b] = cubes;
    assert_eq!(
        app.world().resource::<Heard>().told,
        [Started(a, b), Started(b, a), Ended(a, b), Ended(b, a)]
    );
}

#[test]
fn the_end_carries_the_contact_that_was_found_last() {
    let (mut app, [a, b]) = in_contact([true, false]);
    // Deeper, and then at rest for some ticks.
    place(&mut app, b, 0.8);
    tick(&mut app, 3);
    app.world_mut().despawn(b);
    tick(&mut app, 1);
    let [ended] = messages::<CollisionEnded>(&mut app)[..] else {
        panic!("one message")
    };
    assert_eq!((ended.a, ended.b), (a, b));
    assert_contact(ended.contact, Vec3::X, 0.2);
    assert_eq!(heard(&mut app), [Started(a, b), Ended(a, b)]);
}

#[test]
fn the_dead_are_told_of_the_end_where_all_are_listened_to() {
    let (mut app, [a, b]) = in_contact([true, true]);
    app.world_mut().despawn(a);
    app.world_mut().despawn(b);
    tick(&mut app, 3);
    assert_eq!(
        heard(&mut app),
        [Started(a, b), Started(b, a), Ended(a, b), Ended(b, a)]
    );
}

#[test]
fn opting_in_or_out_during_a_contact_starts_or_ends_it() {
    let (mut app, [a, b]) = in_contact([false, false]);
    tick(&mut app, 2);
    for _ in 0..2 {
        enable(&mut app, b);
        tick(&mut app, 1);
        assert_eq!(counters(&app).candidates, 0, "they rest");
        assert_eq!(heard(&mut app), [Started(b, a)]);
        enable(&mut app, a);
        tick(&mut app, 1);
        assert_eq!(heard(&mut app), [Started(a, b)]);
        disable(&mut app, b);
        tick(&mut app, 1);
        assert_eq!(heard(&mut app), [Ended(b, a)]);
        disable(&mut app, a);
        tick(&mut app, 1);
        assert_eq!(heard(&mut app), [Ended(a, b)]);
        tick(&mut app, 1);
        assert_eq!(
            (heard(&mut app), messages_about(&app, [a, b])),
            (vec![], (1, 0))
        );
    }
    // In and out between two ticks is nothing.
    enable(&mut app, a);
    disable(&mut app, a);
    tick(&mut app, 1);
    assert_eq!(heard(&mut app), []);
}

#[test]
fn settings_may_change_during_a_contact() {
    // Without the log of the other tests, which wants messages about all contacts.
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let mut app = listen(app);
    let [a, b, c] =
        [(0.0, false), (0.9, true), (-0.9, false)].map(|(x, enabled)| block(&mut app, x, enabled));
    tick(&mut app, 1);
    let starts = |app: &mut App| {
        messages::<CollisionStarted>(app)
            .iter()
            .map(|m| (m.a, m.b))
            .collect::<Vec<_>>()
    };
    let ends = |app: &mut App| {
        messages::<CollisionEnded>(app)
            .iter()
            .map(|m| (m.a, m.b))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        (heard(&mut app), starts(&mut app)),
        (vec![Started(b, a)], vec![(a, b), (a, c)])
    );
    let set = |app: &mut App, messages, observers, geometry| {
        *app.world_mut().resource_mut() = CollisionEventSettings {
            messages,
            observers,
            geometry,
            ..default()
        };
        tick(app, 1);
    };
    use EventScope::{All, Enabled};
    set(&mut app, Enabled, All, Enabled);
    assert_eq!(
        heard(&mut app),
        [Started(a, b), Started(a, c), Started(c, a)]
    );
    assert_eq!((starts(&mut app), ends(&mut app)), (vec![], vec![(a, c)]));
    let counted = counters(&app);
    assert_eq!(
        (counted.started, counted.ended, counted.contacts),
        (0, 0, 2),
        "as for the contacts, nothing happened"
    );
    tick(&mut app, 1);
    assert_eq!(
        (heard(&mut app), starts(&mut app), ends(&mut app)),
        (vec![], vec![], vec![])
    );
    set(&mut app, All, Enabled, Enabled);
    assert_eq!(heard(&mut app), [Ended(a, b), Ended(a, c), Ended(c, a)]);
    assert_eq!((starts(&mut app), ends(&mut app)), (vec![(a, c)], vec![]));
    // Messages with contacts for all, and events for some.
    set(&mut app, All, Enabled, All);
    app.world_mut().despawn(c);
    tick(&mut app, 1);
    assert_contact(
        messages::<CollisionEnded>(&mut app)[0]
            .contact
            .map(mirrored),
        Vec3::X,
        0.1,
    );
    assert_eq!(heard(&mut app), []);
}

/// As seen in a mirror at the origin.
fn mirrored(contact: Contact) -> Contact {
    Contact {
        normal: -contact.normal,
        point: -contact.point,
        ..contact
    }
}

/// Whatever observers do to the entities of a contact, and to who is told, each start is followed
/// by one end.
#[test]
fn observers_may_change_the_world_they_are_told_about() {
    type Act = fn(&mut EntityCommands);
    let acts: [Act; 6] = [
        |entity| entity.despawn(),
        |entity| {
            entity.remove::<CollisionEventsEnabled>();
        },
        |entity| {
            entity.remove::<CollisionShape>();
        },
        |entity| {
            entity.insert(Disabled);
        },
        |entity| {
            entity.insert(Transform::from_xyz(0.0, 100.0, 0.0));
        },
        |entity| {
            entity.insert((CollidingEntities::default(), CollisionEventsEnabled));
        },
    ];
    for (which, act) in acts.into_iter().enumerate() {
        for case in 0..8 {
            let (on_start, first, both) = (case & 1 == 0, case & 2 == 0, case & 4 == 0);
            let mut app = listening_app();
            let acting = move |commands: &mut Commands, [a, b]: [Entity; 2]| {
                for entity in [(first || both).then_some(a), (!first || both).then_some(b)]
                    .into_iter()
                    .flatten()
                {
                    if let Ok(mut entity) = commands.get_entity(entity) {
                        act(&mut entity);
                    }
                }
            };
            if on_start {
                app.add_observer(move |e: On<CollisionStarted>, mut commands: Commands| {
                    acting(&mut commands, [e.a, e.b]);
                });
            } else {
                app.add_observer(move |e: On<CollisionEnded>, mut commands: Commands| {
                    acting(&mut commands, [e.a, e.b]);
                });
            }
            // A row, each in contact with the next, and then taken apart.
            let row: Vec<_> = (0..6)
                .map(|number| block(&mut app, 20.0 * number as f32, true))
                .collect();
            for (number, cube) in row.iter().enumerate() {
                place(&mut app, *cube, 0.9 * number as f32);
            }
            for step in 0..8 {
                tick(&mut app, 1);
                if step == 3 {
                    for (number, cube) in row.iter().enumerate() {
                        if let Some(mut transform) = app.world_mut().get_mut::<Transform>(*cube) {
                            transform.translation.x = 20.0 * number as f32;
                        }
                    }
                }
            }
            let mut open = Vec::new();
            let told = heard(&mut app);
            assert_eq!(
                told[..10]
                    .iter()
                    .filter(|told| matches!(told, Started(..)))
                    .count(),
                10,
                "act {which}, case {case}: {told:?}"
            );
            for told in told {
                match told {
                    Started(a, b) => {
                        assert!(
                            !open.contains(&(a, b)),
                            "act {which}, case {case}: {a} {b} started twice"
                        );
                        open.push((a, b));
                    }
                    Ended(a, b) => {
                        let place = open.iter().position(|pair| *pair == (a, b));
                        open.swap_remove(
                            place.unwrap_or_else(|| panic!("act {which}, case {case}: {a} {b}")),
                        );
                    }
                }
            }
            let touching = contacts(&app)
                .into_iter()
                .flat_map(|[a, b]| [(a, b), (b, a)]);
            let enabled =
                |(a, _): &(Entity, Entity)| app.world().get::<CollisionEventsEnabled>(*a).is_some();
            let mut expected: Vec<_> = touching.filter(enabled).collect();
            expected.sort_unstable();
            open.sort_unstable();
            assert_eq!(open, expected, "act {which}, case {case}");
        }
    }
}

#[test]
fn an_observer_may_go_while_it_is_told() {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Heard>();
    let [a, b] = [block(&mut app, 0.0, true), block(&mut app, 0.9, true)];
    app.world_mut().entity_mut(a).observe(
        |event: On<CollisionStarted>, mut heard: ResMut<Heard>, mut commands: Commands| {
            heard.told.push(Started(event.a, event.b));
            commands.entity(event.observer()).despawn();
        },
    );
    for x in [5.0, 0.9, 5.0] {
        tick(&mut app, 1);
        place(&mut app, b, x);
    }
    tick(&mut app, 1);
    assert_eq!(
        (heard_of(&app), messages_about(&app, [a, b])),
        (vec![Started(a, b)], (2, 2))
    );
}

fn heard_of(app: &App) -> Vec<Told> {
    app.world().resource::<Heard>().told.clone()
}

#[derive(Resource, Default)]
struct Changes(Vec<Entity>);

fn note_changes(lists: Query<Entity, Changed<CollidingEntities>>, mut changes: ResMut<Changes>) {
    changes.0 = lists.iter().collect();
}

fn list(app: &App, entity: Entity) -> Vec<Entity> {
    let mut list: Vec<_> = get::<CollidingEntities>(app, entity)
        .iter()
        .copied()
        .collect();
    list.sort_unstable();
    list
}

#[test]
fn colliding_entities_change_with_the_contacts_and_only_then() {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Changes>()
        .add_systems(Update, note_changes);
    let [a, b, c] = [0.0, 0.9, -0.9].map(|x| block(&mut app, x, false));
    app.world_mut()
        .entity_mut(a)
        .insert(CollidingEntities::default());
    let ticked = |app: &mut App| {
        tick(app, 1);
        (
            list(app, a),
            !app.world().resource::<Changes>().0.is_empty(),
        )
    };
    let sorted = |mut entities: Vec<Entity>| {
        entities.sort_unstable();
        entities
    };
    assert_eq!(ticked(&mut app), (sorted(vec![b, c]), true));
    assert_eq!(ticked(&mut app), (sorted(vec![b, c]), false));
    // It moves, and the set stays what it is.
    place(&mut app, b, 0.8);
    assert_eq!(ticked(&mut app), (sorted(vec![b, c]), false));
    app.world_mut().despawn(b);
    assert_eq!(ticked(&mut app), (vec![c], true));
    // As many as before, but others.
    app.world_mut().despawn(c);
    let d = block(&mut app, 0.5, false);
    assert_eq!(ticked(&mut app), (vec![d], true));
    // What others write is undone.
    get_mut::<CollidingEntities>(&mut app, a).0.clear();
    assert_eq!(ticked(&mut app), (vec![d], true));
    app.world_mut()
        .entity_mut(a)
        .insert(CollidingEntities::default());
    assert_eq!(ticked(&mut app), (vec![d], true));
    // A clone has a list of its own if it asks for one.
    let clone = app.world_mut().entity_mut(a).clone_and_spawn();
    assert!(app.world().get::<CollidingEntities>(clone).is_none());
    app.world_mut().despawn(clone);
    app.world_mut().entity_mut(a).insert(Disabled);
    tick(&mut app, 1);
    assert_eq!(list(&app, a), []);
    app.world_mut().entity_mut(a).remove::<Disabled>();
    assert_eq!(ticked(&mut app), (vec![d], true));
    app.world_mut().entity_mut(a).remove::<CollisionShape>();
    assert_eq!(ticked(&mut app), (vec![], true));
    assert_eq!(ticked(&mut app), (vec![], false));
}

#[test]
fn collisions_are_those_of_the_list_by_entity() {
    let mut app = app(BroadPhaseMethod::default());
    let mut random = fastrand::Rng::with_seed(4);
    let mut point = move || Vec3::new(random.f32(), random.f32(), random.f32()) * 5.0;
    let cubes: Vec<_> = (0..100)
        .map(|number| {
            let place = (
                CollisionShape::default(),
                Transform::from_translation(point()),
            );
            let cube = app.world_mut().spawn(place).id();
            if number % 3 == 0 {
                enable(&mut app, cube);
            }
            cube
        })
        .collect();
    for round in 0..3 {
        for cube in cubes.iter().skip(round).step_by(7) {
            get_mut::<Transform>(&mut app, *cube).translation = point();
        }
        tick(&mut app, 1);
        let expected = brute_force_contacts(&mut app);
        assert!(expected.len() > 50);
        let enabled: Vec<_> = cubes.iter().copied().step_by(3).collect();
        let world = app.world_mut();
        let cubes = cubes.clone();
        let check = move |collisions: Collisions| {
            assert_eq!(
                (collisions.len(), collisions.is_empty()),
                (expected.len(), false)
            );
            for &a in &cubes {
                let of: Vec<Collision> = collisions.of(a).collect();
                let others: Vec<_> = collisions.colliding_with(a).collect();
                assert_eq!(
                    of.iter()
                        .map(|collision| (collision.a, collision.b))
                        .collect::<Vec<_>>(),
                    others.iter().map(|b| (a, *b)).collect::<Vec<_>>()
                );
                for &b in &cubes {
                    let touching = expected.contains(&pair(a, b));
                    assert_eq!(
                        (collisions.contains(a, b), others.contains(&b)),
                        (touching, touching)
                    );
                    let found = collisions.between(a, b);
                    assert_eq!(found, of.iter().find(|collision| collision.b == b).copied());
                    let asked = enabled.contains(&a) || enabled.contains(&b);
                    assert_eq!(
                        found.is_some_and(|found| found.contact.is_some()),
                        touching && asked
                    );
                    assert_eq!(collisions.between(b, a), found.map(Collision::reversed));
                }
            }
            let in_order: Vec<_> = collisions
                .iter()
                .filter(|collision| collision.a == cubes[0] || collision.b == cubes[0])
                .map(|c| if c.a == cubes[0] { c.b } else { c.a })
                .collect();
            assert_eq!(
                collisions.colliding_with(cubes[0]).collect::<Vec<_>>(),
                in_order
            );
        };
        world.run_system_once(check).unwrap();
    }
    // Who is gone, has none.
    app.world_mut().despawn(cubes[0]);
    let gone = cubes[0];
    let none = move |collisions: Collisions| {
        collisions.of(gone).count() + collisions.colliding_with(gone).count()
    };
    assert_eq!(app.world_mut().run_system_once(none).unwrap(), 0);
}

#[test]
fn events_come_in_the_order_of_contacts_ends_first() {
    let (mut app, [a, b]) = in_contact([true, true]);
    let c = block(&mut app, 20.0, true);
    tick(&mut app, 1);
    heard(&mut app);
    place(&mut app, a, 20.9);
    place(&mut app, b, -20.0);
    tick(&mut app, 1);
    assert_eq!(
        heard(&mut app),
        [Ended(a, b), Ended(b, a), Started(a, c), Started(c, a)]
    );
}

const RED: CollisionLayers = CollisionLayers::from_bits(0b10, 0b111);
const BLUE: CollisionLayers = CollisionLayers::from_bits(0b100, 0b11);

/// The layers in the messages since this was last asked.
fn layers_told(app: &mut App) -> (Vec<[CollisionLayers; 2]>, Vec<[CollisionLayers; 2]>) {
    let started = messages::<CollisionStarted>(app)
        .iter()
        .map(|message| message.layers)
        .collect();
    (
        started,
        messages::<CollisionEnded>(app)
            .iter()
            .map(|message| message.layers)
            .collect(),
    )
}

#[derive(Resource, Default)]
struct LayersHeard(Vec<(Entity, [CollisionLayers; 2])>);

#[test]
fn the_end_names_the_layers_of_one_that_is_gone() {
    let (mut app, [a, b]) = in_contact([true, true]);
    app.init_resource::<LayersHeard>().add_observer(
        |event: On<CollisionEnded>, mut heard: ResMut<LayersHeard>| {
            heard.0.push((event.a, event.layers));
        },
    );
    let plain = CollisionLayers::default();
    assert_eq!(layers_told(&mut app), (vec![[plain; 2]], vec![]));
    // Layers that change during the contact: the latest count.
    app.world_mut().entity_mut(a).insert(BLUE);
    tick(&mut app, 1);
    app.world_mut().entity_mut(a).insert(RED);
    tick(&mut app, 2);
    let world = app.world_mut();
    let told = world
        .run_system_once(move |collisions: Collisions| collisions.between(b, a).unwrap().layers)
        .unwrap();
    assert_eq!(told, [plain, RED]);
    app.world_mut().despawn(a);
    tick(&mut app, 1);
    assert_eq!(layers_told(&mut app), (vec![], vec![[RED, plain]]));
    let heard = &app.world().resource::<LayersHeard>().0;
    assert_eq!(*heard, [(a, [RED, plain]), (b, [plain, RED])]);
}

#[test]
fn layers_that_end_a_contact_are_not_those_it_had() {
    let (mut app, [a, _]) = in_contact([false, false]);
    let plain = CollisionLayers::default();
    app.world_mut().entity_mut(a).insert(CollisionLayers::NONE);
    tick(&mut app, 1);
    assert_eq!(layers_told(&mut app), (vec![[plain; 2]], vec![[plain; 2]]));
    app.world_mut().entity_mut(a).insert(BLUE);
    tick(&mut app, 1);
    assert_eq!(layers_told(&mut app), (vec![[BLUE, plain]], vec![]));
}

/// Whatever comes, goes, moves and changes its layers: each message is about the layers that its
/// pair had in the last tick in which it was in contact; and a second run says the same.
#[test]
fn messages_name_the_layers_that_pairs_had() {
    let runs = [(); 2].map(|()| layers_in_a_random_history());
    assert_eq!(runs[0], runs[1]);
    assert!(runs[0].len() > 300, "{}", runs[0].len());
}

fn layers_in_a_random_history() -> Vec<CollisionEnded> {
    let (mut app, mut random) = (
        app(BroadPhaseMethod::default()),
        fastrand::Rng::with_seed(9),
    );
    let layers = [None, Some(RED), Some(BLUE), Some(CollisionLayers::NONE)];
    let mut cubes: Vec<Entity> = Vec::new();
    let mut known = std::collections::HashMap::new();
    let mut all_ended = Vec::new();
    for _ in 0..60 {
        for _ in 0..12 {
            let at = Vec3::new(random.f32(), random.f32(), random.f32()) * 4.0;
            let place = random.usize(..cubes.len().max(1));
            let chosen = *random.choice(&layers).unwrap();
            match (random.u8(..6), cubes.get(place).copied()) {
                (0 | 1, _) | (_, None) => {
                    let place = Transform::from_translation(at);
                    cubes.push(
                        app.world_mut()
                            .spawn((CollisionShape::default(), place, chosen.unwrap_or_default()))
                            .id(),
                    );
                }
                (2, Some(cube)) => {
                    app.world_mut().despawn(cube);
                    cubes.swap_remove(place);
                }
                (3, Some(cube)) => get_mut::<Transform>(&mut app, cube).translation = at,
                (4, Some(cube)) => match chosen {
                    Some(chosen) => _ = app.world_mut().entity_mut(cube).insert(chosen),
                    None => _ = app.world_mut().entity_mut(cube).remove::<CollisionLayers>(),
                },
                _ => update_spatial_index(app.world_mut()),
            }
        }
        tick(&mut app, 1);
        let of = |entity: Entity| {
            app.world()
                .get::<CollisionLayers>(entity)
                .copied()
                .unwrap_or_default()
        };
        let now: std::collections::HashMap<_, _> = app
            .world()
            .resource::<Contacts>()
            .iter()
            .map(|contact| ((contact.a, contact.b), [contact.a, contact.b].map(of)))
            .collect();
        let (started, ended) = (
            messages::<CollisionStarted>(&mut app),
            messages::<CollisionEnded>(&mut app),
        );
        assert!(
            started
                .iter()
                .all(|message| now[&(message.a, message.b)] == message.layers)
        );
        assert!(
            ended
                .iter()
                .all(|message| known[&(message.a, message.b)] == message.layers)
        );
        known = now;
        all_ended.extend(ended);
    }
    all_ended
}
