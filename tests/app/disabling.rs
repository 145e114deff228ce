//! Entities that are disabled by a component of the app are disabled as by Bevy's own.

use bevy::{
    ecs::{
        entity_disabling::{DefaultQueryFilters, Disabled},
        system::SystemState,
    },
    prelude::*,
};
use bevy_octree::{broad_phase::BroadPhaseMethod, prelude::*};

use crate::order::plain_app;

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
