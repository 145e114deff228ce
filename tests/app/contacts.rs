//! What a tick makes of its verdicts: each contact once, with what is known of it, told in order.

use crate::common;

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use bevy_octree::{
    broad_phase::Pair, collision_index::CandidatePairs, components::BroadPhaseProxy,
    narrow_phase::Contact, prelude::*, schedule::PairFilterSystems,
};
use common::*;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

/// Who was told of starts and ends, in order.
#[derive(Resource, Default)]
struct Heard {
    started: Vec<CollisionStarted>,
    ended: Vec<CollisionEnded>,
}

fn listening_app() -> App {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Heard>()
        .add_observer(|event: On<CollisionStarted>, mut heard: ResMut<Heard>| {
            heard.started.push(*event);
        })
        .add_observer(|event: On<CollisionEnded>, mut heard: ResMut<Heard>| {
            heard.ended.push(*event);
        });
    app
}

fn wall(app: &mut App, center: Vec3) -> Entity {
    let shape = CollisionShape::from_half_size(Vec3::new(0.1, 1.0, 1.0));
    app.world_mut()
        .spawn((shape, Transform::from_translation(center)))
        .id()
}

fn ball(app: &mut App, radius: f32, center: Vec3, step: Vec3, parts: impl Bundle) -> Entity {
    let (shape, velocity) = (
        CollisionShape::sphere(radius),
        Velocity(step * TICKS_PER_SECOND),
    );
    app.world_mut()
        .spawn((shape, velocity, Transform::from_translation(center), parts))
        .id()
}

/// As the first of the two sees it, whichever has the lower handle.
fn geometry(app: &App, [a, b]: EntityPair) -> Option<Contact> {
    app.world().resource::<Contacts>().between(a, b)?.contact
}

/// All starts so far, as messages.
fn messages(app: &mut App) -> Vec<CollisionStarted> {
    app.world_mut()
        .resource_mut::<Messages<CollisionStarted>>()
        .drain()
        .collect()
}

/// Bullets that pass through walls in one tick, some of which have opted in: all of these are told,
/// whoever else is about.
#[test]
fn who_opted_in_is_told_of_what_it_meets_on_the_way_whoever_did_not() {
    for bits in 0..16_u32 {
        let mut app = listening_app();
        app.world_mut()
            .resource_mut::<CollisionEventSettings>()
            .messages = EventScope::Enabled;
        let pairs: Vec<_> = (0..4)
            .map(|lane| {
                let y = 10.0 * lane as f32;
                let bullet = ball(&mut app, 0.1, Vec3::Y * y, Vec3::X * 10.0, Swept::default());
                if bits >> lane & 1 == 1 {
                    app.world_mut()
                        .entity_mut(bullet)
                        .insert(CollisionEventsEnabled);
                }
                [bullet, wall(&mut app, Vec3::new(5.0, y, 0.0))]
            })
            .collect();
        let told: Vec<_> = pairs
            .iter()
            .enumerate()
            .filter(|(lane, _)| bits >> lane & 1 == 1)
            .map(|(_, p)| *p)
            .collect();
        // The log of all contacts does not hold for messages of some.
        app.world_mut()
            .resource_mut::<CollisionEventSettings>()
            .messages = EventScope::All;
        tick(&mut app, 1);
        assert_eq!(contacts(&app), pairs);
        for pair in &pairs {
            let normal = geometry(&app, *pair).map(|contact| contact.normal.x.abs());
            assert_eq!(normal, told.contains(pair).then_some(1.0), "{bits:b}");
        }
        tick(&mut app, 2);
        let heard = app.world().resource::<Heard>();
        assert_eq!(
            heard
                .started
                .iter()
                .map(|event| [event.a, event.b])
                .collect::<Vec<_>>(),
            told,
            "{bits:b}"
        );
        assert_eq!(
            heard
                .ended
                .iter()
                .map(|event| [event.a, event.b])
                .collect::<Vec<_>>(),
            told,
            "{bits:b}"
        );
        let same =
            |(start, end): (&CollisionStarted, &CollisionEnded)| start.contact == end.contact;
        assert!(heard.started.iter().zip(&heard.ended).all(same));
    }
}

/// A ball at rest touches a cube that moves, and is hit by another: it is found twice in contact
/// with the cube.
#[test]
fn what_is_found_at_the_end_and_on_the_way_is_one_contact() {
    let mut app = listening_app();
    let swept = (ELASTIC, Swept::default(), CollidingEntities::default());
    let a = ball(
        &mut app,
        0.5,
        Vec3::ZERO,
        Vec3::ZERO,
        (swept.clone(), CollisionEventsEnabled),
    );
    let cube = (
        CollisionShape::default(),
        Velocity(Vec3::Y * 0.1 * TICKS_PER_SECOND),
        Transform::from_xyz(1.0, 0.0, 0.0),
    );
    let c = app.world_mut().spawn(cube).id();
    let b = ball(&mut app, 0.1, Vec3::X * -3.0, Vec3::X * 6.0, swept);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [[a, c], [a, b]]);
    assert_eq!((counters(&app).contacts, counters(&app).started), (2, 2));
    assert_eq!(get::<CollidingEntities>(&app, a).len(), 2);
    // What is known of it is what happened first.
    let on_the_way = app
        .world()
        .resource::<Contacts>()
        .time_of_impact(a, c)
        .unwrap();
    assert!(on_the_way > 0.3 && on_the_way < 0.5, "{on_the_way}");
    assert_eq!(
        geometry(&app, [a, c]).map(|contact| contact.normal),
        Some(Vec3::X)
    );
    tick(&mut app, 3);
    for pair in [[a, b], [a, c]] {
        assert_eq!(messages_about(&app, pair).0, 1);
    }
    assert_eq!(app.world().resource::<Heard>().started.len(), 2);
}

/// Whatever a system makes of the list.
#[test]
fn a_candidate_is_one_contact_however_often_and_which_way_round_it_is_listed() {
    fn list_again(mut candidates: ResMut<CandidatePairs>) {
        let listed = candidates.clone();
        candidates.extend(listed.iter().map(|pair| Pair {
            a: pair.b,
            b: pair.a,
        }));
        candidates.extend(listed.iter().copied());
        candidates.extend(listed.iter().map(|pair| Pair {
            a: pair.a,
            b: pair.a,
        }));
    }
    for (events, swept) in [(false, false), (true, false), (false, true), (true, true)] {
        let run = |again: bool| {
            let mut app = app(BroadPhaseMethod::default());
            if again {
                app.add_systems(FixedPostUpdate, list_again.in_set(PairFilterSystems));
            }
            let mut balls = Vec::new();
            for (place, x) in [0.0, 0.9, 1.8, 7.0].into_iter().enumerate() {
                let ball = ball(
                    &mut app,
                    0.5,
                    Vec3::X * x,
                    Vec3::X * (3.0 - x),
                    [ELASTIC, Bounce::Reverse][place % 2],
                );
                if events {
                    app.world_mut()
                        .entity_mut(ball)
                        .insert(CollisionEventsEnabled);
                }
                if swept && place != 1 {
                    app.world_mut().entity_mut(ball).insert(Swept::default());
                }
                balls.push(ball);
            }
            let mut seen = Vec::new();
            for _ in 0..6 {
                tick(&mut app, 1);
                let places = balls
                    .iter()
                    .map(|ball| get::<Transform>(&app, *ball).translation)
                    .collect::<Vec<_>>();
                let known = app
                    .world_mut()
                    .run_system_once(|all: Collisions| all.iter().collect::<Vec<_>>())
                    .unwrap();
                seen.push((places, known, counters(&app).bounces));
            }
            (seen, app.world().resource::<Log>().clone())
        };
        let (once, again) = (run(false), run(true));
        assert_eq!(once, again, "events {events}, swept {swept}");
        assert!(once.0.iter().any(|(_, known, _)| known.len() > 1));
    }
}

#[test]
fn what_is_met_on_the_way_is_told_in_the_order_of_time() {
    let mut app = listening_app();
    // The handles have another order.
    let order = [30.0, 10.0, 50.0, 20.0, 40.0];
    let walls = order.map(|x| wall(&mut app, Vec3::X * x));
    let at_the_end = [4.0, 3.0].map(|y| wall(&mut app, Vec3::new(0.0, y, 0.0)));
    let opted_in = (Swept::default(), CollisionEventsEnabled);
    let bullet = ball(&mut app, 0.1, Vec3::X * 5.0, Vec3::X * 100.0, opted_in);
    tick(&mut app, 1);
    let mut in_time: Vec<_> = walls.into_iter().zip(order).collect();
    in_time.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut expected: Vec<_> = in_time
        .iter()
        .map(|(wall, _)| pair(*wall, bullet))
        .collect();
    let heard = &app.world().resource::<Heard>().started;
    assert_eq!(
        heard
            .iter()
            .map(|event| pair(event.a, event.b))
            .collect::<Vec<_>>(),
        expected
    );
    // What is met at the end of the tick comes last.
    expected.push(at_the_end);
    let told = messages(&mut app);
    assert_eq!(
        told.iter()
            .map(|message| pair(message.a, message.b))
            .collect::<Vec<_>>(),
        expected
    );
    assert!(told.is_sorted_by(|a, b| a.time <= b.time));
    // The list stays in the order of handles.
    let handle = |entity| get::<BroadPhaseProxy>(&app, entity).id();
    let all = app.world().resource::<Contacts>().iter();
    assert!(all.is_sorted_by_key(|contact| [contact.a, contact.b].map(handle)));
}

/// Between two ticks, an update of the index may give the handle of one to another.
#[test]
fn an_entity_has_no_contacts_of_who_had_its_handle() {
    let mut app = app(BroadPhaseMethod::default());
    let block = |app: &mut App, x: f32| {
        app.world_mut()
            .spawn((
                CollisionShape::default(),
                CollidingEntities::default(),
                Transform::from_xyz(x, 0.0, 0.0),
            ))
            .id()
    };
    let [a, b] = [0.0, 0.9].map(|x| block(&mut app, x));
    tick(&mut app, 1);
    let handle = get::<BroadPhaseProxy>(&app, a).id();
    app.world_mut().despawn(a);
    for _ in 0..3 {
        update_spatial_index(app.world_mut());
    }
    let other = block(&mut app, 500.0);
    update_spatial_index(app.world_mut());
    assert_eq!(get::<BroadPhaseProxy>(&app, other).id(), handle);
    let ask = move |all: Collisions| {
        let of = all.of(other).count() + all.colliding_with(other).count();
        (
            of,
            all.contains(other, b),
            all.contains(b, other),
            all.between(other, b),
            all.between(b, other),
        )
    };
    assert_eq!(
        app.world_mut().run_system_once(ask).unwrap(),
        (0, false, false, None, None)
    );
    tick(&mut app, 1);
    assert!(
        get::<CollidingEntities>(&app, other).is_empty()
            && get::<CollidingEntities>(&app, b).is_empty()
    );
    assert_eq!(messages_about(&app, [a, b]), (1, 1));
}
