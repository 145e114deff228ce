//! Detection that is one-way: who hears of whom, and who bounces.

use crate::common;

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use bevy_octree::prelude::*;
use common::*;

collision_layers! {
    enum Layer { Guard, Thief }
}

/// What each entity was told, as `(target, other, started)`.
#[derive(Resource, Default)]
struct Told(Vec<(Entity, Entity, bool)>);

/// An app in which everybody who may hear does so, with a guard that looks for thieves, and a thief
/// that looks for nobody, in one place; the thief has the lower handle.
fn watch(method: BroadPhaseMethod, guard: impl Bundle, thief: impl Bundle) -> (App, [Entity; 2]) {
    watch_in(app(method), guard, thief)
}

fn watch_in(mut app: App, guard: impl Bundle, thief: impl Bundle) -> (App, [Entity; 2]) {
    app.init_resource::<Told>();
    app.add_observer(|event: On<CollisionStarted>, mut told: ResMut<Told>| {
        told.0.push((event.a, event.b, true));
    });
    app.add_observer(|event: On<CollisionEnded>, mut told: ResMut<Told>| {
        told.0.push((event.a, event.b, false));
    });
    let all = || {
        (
            CollisionShape::default(),
            CollisionEventsEnabled,
            CollidingEntities::default(),
        )
    };
    let on_thief = CollisionLayers::new(Layer::Thief, LayerMask::NONE);
    let on_guard = CollisionLayers::new(Layer::Guard, Layer::Thief);
    let thief = app.world_mut().spawn((all(), on_thief, thief)).id();
    let guard = app.world_mut().spawn((all(), on_guard, guard)).id();
    tick(&mut app, 1);
    (app, [guard, thief])
}

fn take_told(app: &mut App) -> Vec<(Entity, Entity, bool)> {
    std::mem::take(&mut app.world_mut().resource_mut::<Told>().0)
}

/// Who has whom in its list, and by [`Collisions`].
fn hears(app: &mut App, entity: Entity) -> Vec<Entity> {
    let list: Vec<_> = get::<CollidingEntities>(app, entity)
        .iter()
        .copied()
        .collect();
    let asked = app
        .world_mut()
        .run_system_once(move |collisions: Collisions| {
            let of = collisions.of(entity).map(|collision| collision.b);
            assert!(of.eq(collisions.colliding_with(entity)));
            collisions.colliding_with(entity).collect::<Vec<_>>()
        });
    let of_all = app.world().resource::<Contacts>().of(entity);
    assert!(of_all.map(|collision| collision.b).eq(list.iter().copied()));
    assert_eq!(asked.expect("the plugins are there"), list);
    list
}

/// The messages of the last tick about contacts that started and ended.
fn messages(app: &mut App) -> (Vec<CollisionStarted>, Vec<CollisionEnded>) {
    let started = app
        .world_mut()
        .resource_mut::<Messages<CollisionStarted>>()
        .drain()
        .collect();
    let ended = app
        .world_mut()
        .resource_mut::<Messages<CollisionEnded>>()
        .drain()
        .collect();
    (started, ended)
}

#[test]
fn only_the_detector_hears() {
    for name in ["linear", "object", "exhaustive"] {
        let method: BroadPhaseMethod = name.parse().expect("a method");
        // Without it, neither does, and there is no pair.
        let (app, _) = watch(method.clone(), (), ());
        assert!(app.world().resource::<Contacts>().is_empty());
        // Nor does the thief by being one: it looks for nobody.
        let (app, _) = watch(method.clone(), (), Detector);
        assert!(app.world().resource::<Contacts>().is_empty());

        let (mut app, [guard, thief]) = watch(method, Detector, Detector);
        assert_eq!(take_told(&mut app), [(guard, thief, true)]);
        assert_eq!(hears(&mut app, guard), [thief]);
        assert!(hears(&mut app, thief).is_empty());
        let contacts = app.world().resource::<Contacts>();
        assert!(
            contacts.len() == 1
                && contacts.contains(guard, thief)
                && contacts.contains(thief, guard)
        );
        assert_eq!(
            contacts.between(guard, thief).unwrap().hears(),
            [true, false]
        );
        assert_eq!(
            contacts.between(thief, guard).unwrap().hears(),
            [false, true]
        );
        let (started, _) = messages(&mut app);
        assert!(
            matches!(&started[..], [one] if (one.a, one.b, one.hears()) == (guard, thief, [true, false]))
        );
        // Away.
        app.world_mut()
            .entity_mut(thief)
            .insert(Transform::from_xyz(9.0, 0.0, 0.0));
        tick(&mut app, 1);
        assert_eq!(take_told(&mut app), [(guard, thief, false)]);
        assert!(hears(&mut app, guard).is_empty());
        let (_, ended) = messages(&mut app);
        assert!(
            matches!(&ended[..], [one] if (one.a, one.b, one.hears()) == (guard, thief, [true, false]))
        );
    }
}

#[test]
fn messages_for_some_are_for_those_that_hear() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    let (mut app, [guard, thief]) = watch_in(app, Detector, ());
    app.world_mut()
        .resource_mut::<CollisionEventSettings>()
        .messages = EventScope::Enabled;
    messages(&mut app);
    // Only the thief has opted in, which hears of nothing.
    app.world_mut()
        .entity_mut(guard)
        .remove::<CollisionEventsEnabled>();
    tick(&mut app, 2);
    let (started, ended) = messages(&mut app);
    assert!(started.is_empty() && matches!(&ended[..], [one] if (one.a, one.b) == (guard, thief)));
    // Nor where observers of all are told.
    take_told(&mut app);
    app.world_mut()
        .resource_mut::<CollisionEventSettings>()
        .observers = EventScope::All;
    tick(&mut app, 1);
    app.world_mut()
        .entity_mut(guard)
        .insert(Transform::from_xyz(0.1, 0.0, 0.0));
    tick(&mut app, 1);
    assert_eq!(take_told(&mut app), [(guard, thief, true)]);
}

#[test]
fn who_hears_may_change_during_a_contact() {
    let (mut app, [guard, thief]) = watch(BroadPhaseMethod::default(), Detector, ());
    take_told(&mut app);
    let set = |app: &mut App, layers| {
        app.world_mut().entity_mut(thief).insert(layers);
        tick(app, 1);
        take_told(app)
    };
    let careful = CollisionLayers::new(Layer::Thief, Layer::Guard);
    assert_eq!(set(&mut app, careful), [(thief, guard, true)]);
    assert_eq!(hears(&mut app, thief), [guard]);
    let careless = CollisionLayers::new(Layer::Thief, LayerMask::NONE);
    assert_eq!(set(&mut app, careless), [(thief, guard, false)]);
    assert!(hears(&mut app, thief).is_empty());
    // Both count as one contact all the time.
    let (started, ended) = messages(&mut app);
    assert!(started.len() <= 1 && ended.is_empty());
    app.world_mut().entity_mut(guard).remove::<Detector>();
    tick(&mut app, 1);
    assert_eq!(take_told(&mut app), [(guard, thief, false)]);
    assert!(app.world().resource::<Contacts>().is_empty());
    app.world_mut().entity_mut(guard).insert(Detector);
    tick(&mut app, 1);
    assert_eq!(take_told(&mut app), [(guard, thief, true)]);
}

#[test]
fn who_does_not_hear_does_not_bounce() {
    const SPEED: f32 = 4.0;
    let elastic = Bounce::Reflect { restitution: 1.0 };
    for (bounce, swept) in [(Bounce::Reverse, false), (elastic, false), (elastic, true)] {
        // A small step from touch, towards each other.
        let body = |x: f32| {
            (
                bounce,
                Transform::from_xyz(x, 0.0, 0.0),
                Velocity(Vec3::X * -SPEED * x.signum()),
            )
        };
        let (mut app, [guard, thief]) = watch(
            BroadPhaseMethod::default(),
            (Detector, body(-0.52)),
            body(0.52),
        );
        if swept {
            app.world_mut().entity_mut(guard).insert(Swept::default());
            app.world_mut().entity_mut(thief).insert(Swept::default());
        }
        let speed = |app: &App, entity| get::<Velocity>(app, entity).0.x;
        for _ in 0..4 {
            if app.world().resource::<Contacts>().is_empty() {
                assert_eq!([speed(&app, guard), speed(&app, thief)], [SPEED, -SPEED]);
                tick(&mut app, 1);
            }
        }
        assert_eq!(
            app.world().resource::<Contacts>().len(),
            1,
            "{bounce:?} {swept}"
        );
        // From a wall that comes, twice as fast.
        let expected = if bounce == elastic {
            -3.0 * SPEED
        } else {
            -SPEED
        };
        assert_eq!(
            [speed(&app, guard), speed(&app, thief)],
            [expected, -SPEED],
            "{bounce:?} {swept}"
        );
    }
}
