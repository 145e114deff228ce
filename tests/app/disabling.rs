//! Entities that are disabled by a component of the app are disabled as by Bevy's own.

use bevy::{
    ecs::{
        entity_disabling::{DefaultQueryFilters, Disabled},
        system::SystemState,
    },
    prelude::*,
};
use bevy_octree::{broad_phase::BroadPhaseMethod, prelude::*};

use crate::{common::EntityPair, order::plain_app};

#[derive(Component, Default)]
struct Asleep;

fn let_asleep_disable(app: &mut App) {
    let id = app.world_mut().register_component::<Asleep>();
    let mut filters = app.world_mut().resource_mut::<DefaultQueryFilters>();
    filters.register_disabling_component(id);
}

/// A ball that bounces off a cube, below a parent that is turned, scaled, and stays where it is.
fn bounced(swept: bool, stop: fn(EntityWorldMut)) -> (Transform, Vec3) {
    let mut app = plain_app(BroadPhaseMethod::default());
    let_asleep_disable(&mut app);
    let at = Transform::from_rotation(Quat::from_rotation_z(1.0)).with_scale(Vec3::splat(2.0));
    let parent = app.world_mut().spawn((at, Velocity(Vec3::Y * 7.0))).id();
    let ball = (
        CollisionShape::sphere(0.5),
        Bounce::Reflect { restitution: 1.0 },
        Velocity(Vec3::X * 20.0),
    );
    let mut ball =
        app.world_mut()
            .spawn((ball, Transform::from_xyz(-1.5, 0.0, 0.0), ChildOf(parent)));
    if swept {
        ball.insert(Swept::default());
    }
    let ball = ball.id();
    app.world_mut().spawn(CollisionShape::default());
    stop(app.world_mut().entity_mut(parent));
    (0..8).for_each(|_| app.update());
    let world = app.world();
    (
        *world.get(ball).unwrap(),
        world.get::<Velocity>(ball).unwrap().0,
    )
}

#[test]
fn a_disabled_parent_is_where_it_is_and_moves_no_more() {
    for swept in [false, true] {
        let expected = bounced(swept, |mut parent| _ = parent.remove::<Velocity>());
        assert_eq!(
            bounced(swept, |mut parent| _ = parent.insert(Disabled)),
            expected
        );
        assert_eq!(
            bounced(swept, |mut parent| _ = parent.insert(Asleep)),
            expected
        );
    }
}

#[test]
fn bodies_that_came_before_the_plugins_are_counted() {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    let_asleep_disable(&mut app);
    let body = (CollisionBody::default(), Transform::default(), Asleep);
    let body = app.world_mut().spawn(body).id();
    let part = app.world_mut().spawn(CollisionShape::default()).id();
    app.add_plugins(OctreePlugins::new(Update));
    app.update();
    app.world_mut().entity_mut(part).insert(ChildOf(body));
    app.update();
    let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
    assert_eq!(state.get(app.world()).unwrap().body_of(part), body);
}

type Stop = fn(EntityWorldMut);

const STOPS: [Stop; 2] = [
    |mut entity| _ = entity.insert(Disabled),
    |mut entity| _ = entity.insert(Asleep),
];

/// A part that is disabled is still one: it may ask what is in the way of its body, and passes by the rest of it.
#[test]
fn a_disabled_part_knows_its_body() {
    for stop in STOPS {
        let mut app = plain_app(BroadPhaseMethod::default());
        let_asleep_disable(&mut app);
        let mut shape = |x, bundle: Option<ChildOf>| {
            let at = Transform::from_xyz(x, 0.0, 0.0);
            let mut shape = app.world_mut().spawn((CollisionShape::default(), at));
            if let Some(parent) = bundle {
                shape.insert(parent);
            }
            shape.id()
        };
        let body = shape(0.0, None);
        let [eye, hull] = [-1.0, 1.0].map(|x| shape(x, Some(ChildOf(body))));
        let wall = shape(5.0, None);
        app.world_mut()
            .entity_mut(body)
            .insert(CollisionBody::default());
        app.update();
        stop(app.world_mut().entity_mut(eye));
        app.update();
        let mut state = SystemState::<SpatialQuery>::new(app.world_mut());
        let spatial = state.get(app.world()).unwrap();
        assert_eq!(
            [eye, hull, body].map(|part| spatial.body_of(part)),
            [body; 3]
        );
        let filter = SpatialQueryFilter::DEFAULT.without_body(eye);
        let ray = Ray3d::new(Vec3::X * -3.0, Dir3::X);
        let first = |hit: Option<RayHit>| hit.map(|hit| hit.entity);
        assert_eq!(first(spatial.cast_ray(ray, 100.0, &filter)), Some(wall));
        let then = spatial.at([(wall, Transform::from_xyz(7.0, 0.0, 0.0))]);
        assert_eq!(first(then.cast_ray(ray, 100.0, &filter)), Some(wall));
        // Once it is despawned, it is part of nothing.
        app.world_mut().despawn(eye);
        let spatial = state.get(app.world()).unwrap();
        assert_eq!(spatial.body_of(eye), eye);
    }
}

/// What bodies were told: those that came together, and those that parted.
fn told_of_bodies(app: &mut App) -> [Vec<EntityPair>; 2] {
    app.update();
    let world = app.world_mut();
    let mut started = world.resource_mut::<Messages<BodyCollisionStarted>>();
    let started = started.drain().map(|told| [told.a, told.b]).collect();
    let mut ended = world.resource_mut::<Messages<BodyCollisionEnded>>();
    let ended = ended.drain().map(|told| [told.a, told.b]).collect();
    [started, ended]
}

/// Bodies have their place in the order of all, whether or not they are disabled; their parts are what is in contact.
#[test]
fn a_disabled_body_keeps_its_place() {
    for stop in STOPS {
        let mut app = plain_app(BroadPhaseMethod::default());
        let_asleep_disable(&mut app);
        let mut body = |number, x| {
            let at = Transform::from_xyz(x, 0.0, 0.0);
            let body = (CollisionBody::default(), CollisionOrder(number), at);
            let body = app.world_mut().spawn((body, CollisionEventsEnabled)).id();
            let part = (CollisionShape::default(), CollisionOrder(number + 10));
            app.world_mut().spawn((part, ChildOf(body)));
            body
        };
        // The later, the earlier in their order.
        let [c, b, a] = [3, 2, 1].map(|number| body(number, number as f32 * 0.75));
        assert_eq!(told_of_bodies(&mut app), [vec![[a, b], [b, c]], vec![]]);
        let pairs = |app: &App| {
            let contacts = app.world().resource::<Contacts>();
            let pairs = contacts.body_pairs().map(|pair| [pair.a, pair.b]);
            pairs.collect::<Vec<_>>()
        };
        stop(app.world_mut().entity_mut(a));
        stop(app.world_mut().entity_mut(b));
        for tick in 0..3 {
            let told = told_of_bodies(&mut app);
            assert!(told.iter().all(Vec::is_empty), "in tick {tick}: {told:?}");
            assert_eq!(pairs(&app), [[a, b], [b, c]]);
        }
        app.world_mut().entity_mut(b).remove::<(Disabled, Asleep)>();
        assert!(told_of_bodies(&mut app).iter().all(Vec::is_empty));
        // One that is gone is told of by its place, too.
        app.world_mut().despawn(a);
        assert_eq!(told_of_bodies(&mut app), [vec![], vec![[a, b]]]);
    }
}

/// Who is disabled hears of nothing: what it has heard of ends for it, and starts again once it is enabled.
#[test]
fn a_disabled_body_hears_of_nothing() {
    #[derive(Resource, Default)]
    struct Heard(Vec<(bool, Entity)>);

    for stop in STOPS {
        let mut app = plain_app(BroadPhaseMethod::default());
        let_asleep_disable(&mut app);
        app.init_resource::<Heard>();
        app.add_observer(
            |event: On<BodyCollisionStarted>, mut heard: ResMut<Heard>| {
                heard.0.push((true, event.a));
            },
        );
        app.add_observer(|event: On<BodyCollisionEnded>, mut heard: ResMut<Heard>| {
            heard.0.push((false, event.a));
        });
        let body = (
            CollisionBody::default(),
            CollisionEventsEnabled,
            CollidingEntities::default(),
        );
        let body = app
            .world_mut()
            .spawn((body, children![CollisionShape::default()]))
            .id();
        let wall = app.world_mut().spawn(CollisionShape::default()).id();
        let heard = |app: &mut App| {
            app.update();
            let touched = app.world().get::<CollidingEntities>(body).unwrap().len();
            let heard = std::mem::take(&mut app.world_mut().resource_mut::<Heard>().0);
            (heard, touched)
        };
        assert_eq!(heard(&mut app), (vec![(true, body)], 1));
        stop(app.world_mut().entity_mut(body));
        assert_eq!(heard(&mut app), (vec![(false, body)], 0));
        assert_eq!(heard(&mut app), (vec![], 0));
        let contacts = app.world().resource::<Contacts>();
        assert_eq!(contacts.body_pairs().count(), 1, "with {wall}");
        app.world_mut()
            .entity_mut(body)
            .remove::<(Disabled, Asleep)>();
        assert_eq!(heard(&mut app), (vec![(true, body)], 1));
    }
}
