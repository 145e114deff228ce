//! What the index misses while it is out of the world, and what befalls the components that belong
//! to it.

use crate::common;

use bevy::{ecs::entity_disabling::Disabled, math::bounding::BoundingVolume, prelude::*};
use bevy_octree::{
    collision_index::CollisionIndex,
    components::{BroadPhaseProxy, WorldAabb},
    narrow_phase::NarrowPhase,
    prelude::*,
};
use common::*;

/// Who takes part, each by its own handle.
fn assert_in_index(app: &App, entities: &[Entity]) {
    let collisions = app.world().resource::<CollisionIndex>();
    let mut found: Vec<_> = collisions
        .index()
        .proxies()
        .iter()
        .map(|(id, _)| collisions.entity(id).unwrap())
        .collect();
    found.sort();
    let mut expected = entities.to_vec();
    expected.sort();
    assert_eq!(found, expected);
    for entity in entities {
        let id = get::<BroadPhaseProxy>(app, *entity).id().unwrap();
        assert_eq!(collisions.entity(id), Some(*entity));
    }
}

/// Does something while the index is not there.
fn meanwhile(app: &mut App, act: impl FnOnce(&mut World)) {
    app.world_mut()
        .resource_scope::<CollisionIndex, _>(|world, _| act(world));
}

#[test]
fn what_goes_while_the_index_is_away_leaves_no_ghost() {
    let acts: [fn(&mut World, Entity); 4] = [
        |world, entity| {
            world.despawn(entity);
        },
        |world, entity| {
            world.entity_mut(entity).remove::<CollisionShape>();
        },
        |world, entity| {
            world.entity_mut(entity).insert(Disabled);
        },
        |world, entity| {
            world.entity_mut(entity).remove::<BroadPhaseProxy>();
        },
    ];
    for (number, act) in acts.into_iter().enumerate() {
        let (mut app, cubes) = in_contact();
        let sparse = number != 0;
        meanwhile(&mut app, |world| act(world, cubes[1]));
        // What is swept meets nothing at its place, not even in the same tick.
        let ball = (
            CollisionShape::sphere(0.1),
            Swept::default(),
            Bounce::Reflect { restitution: 1.0 },
        );
        let ball = (
            ball,
            Velocity(Vec3::X * -TICKS_PER_SECOND),
            Transform::from_xyz(2.75, 0.0, 0.0),
        );
        let ball = app.world_mut().spawn(ball).id();
        tick(&mut app, 1);
        assert_eq!(
            (contacts(&app), messages_about(&app, cubes)),
            (vec![], (1, 1)),
            "act {number}"
        );
        assert_in_index(&app, &[cubes[0], ball]);
        app.world_mut().despawn(ball);
        tick(&mut app, 3);
        assert_eq!(messages_about(&app, cubes), (1, 1));
        if sparse {
            let mut back = app.world_mut().entity_mut(cubes[1]);
            back.remove::<Disabled>()
                .insert((CollisionShape::default(), BroadPhaseProxy::default()));
            tick(&mut app, 1);
            assert_eq!(
                (contacts(&app), messages_about(&app, cubes)),
                (vec![cubes], (2, 1)),
                "act {number}"
            );
            assert_in_index(&app, &cubes);
        }
        tick(&mut app, 1);
        assert_eq!(counters(&app).moved, 0);
    }
}

#[test]
fn filters_that_change_while_the_index_is_away_take_effect() {
    let (mut app, cubes) = in_contact();
    let elsewhere = app.world_mut().spawn_empty().id();
    type Act = fn(&mut World, [Entity; 3]);
    let acts: [[Act; 2]; 3] = [
        [
            |world, [a, b, _]| {
                world.entity_mut(a).insert(StaticShape);
                world.entity_mut(b).insert(StaticShape);
            },
            |world, [a, b, _]| {
                world.entity_mut(a).remove::<StaticShape>();
                world.entity_mut(b).remove::<StaticShape>();
            },
        ],
        [
            |world, [a, _, elsewhere]| {
                world.entity_mut(a).insert(InCollisionWorld(elsewhere));
            },
            |world, [a, ..]| {
                world.entity_mut(a).remove::<InCollisionWorld>();
            },
        ],
        [
            |world, [a, b, _]| {
                world.entity_mut(a).insert(IgnoreCollisions::from([b]));
            },
            |world, [a, ..]| {
                world.entity_mut(a).remove::<IgnoreCollisions>();
            },
        ],
    ];
    for (number, [part, meet]) in acts.into_iter().enumerate() {
        let three = [cubes[0], cubes[1], elsewhere];
        meanwhile(&mut app, |world| part(world, three));
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty(), "act {number}");
        meanwhile(&mut app, |world| meet(world, three));
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [cubes], "act {number}");
    }
    // Layers that go.
    app.world_mut()
        .entity_mut(cubes[0])
        .insert(CollisionLayers::NONE);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    meanwhile(&mut app, |world| {
        world.entity_mut(cubes[0]).remove::<CollisionLayers>();
    });
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes]);
}

#[test]
fn another_index_takes_up_all_entities() {
    let mut app = app(BroadPhaseMethod::default());
    let blocks: Vec<_> = (0..6).map(|x| block(&mut app, x as f32 * 5.0)).collect();
    tick(&mut app, 2);
    let old = app.world_mut().remove_resource::<CollisionIndex>().unwrap();
    app.init_resource::<CollisionIndex>();
    // Taken up in another order than in the first.
    for block in [3, 4, 5, 0, 1, 2] {
        get_mut::<Transform>(&mut app, blocks[block]).translation.y += 0.1;
        tick(&mut app, 1);
        assert_in_index(&app, &blocks);
    }
    // Gone while none, or the other, was there.
    app.world_mut().despawn(blocks[5]);
    let second = app.world_mut().remove_resource::<CollisionIndex>().unwrap();
    app.world_mut().despawn(blocks[4]);
    app.insert_resource(old);
    app.world_mut().despawn(blocks[3]);
    tick(&mut app, 1);
    assert_in_index(&app, &blocks[..3]);
    app.insert_resource(second);
    app.world_mut().despawn(blocks[2]);
    update_spatial_index(app.world_mut());
    assert_in_index(&app, &blocks[..2]);
    // Out and in again between two ticks, and what was despawned in between was in the one that
    // came back.
    let second = app.world_mut().remove_resource::<CollisionIndex>().unwrap();
    app.init_resource::<CollisionIndex>();
    app.world_mut().despawn(blocks[1]);
    app.insert_resource(second);
    tick(&mut app, 1);
    assert_in_index(&app, &blocks[..1]);
}

#[test]
fn a_copied_proxy_is_nobody_elses_entry() {
    let (mut app, cubes) = in_contact();
    let copy = *get::<BroadPhaseProxy>(&app, cubes[1]);
    let third = block(&mut app, 0.5);
    app.world_mut().entity_mut(third).insert(copy);
    tick(&mut app, 1);
    assert_in_index(&app, &[cubes[0], cubes[1], third]);
    assert_eq!(contacts(&app).len(), 3);
    // One that never comes to a tick.
    app.world_mut().entity_mut(third).insert(copy);
    app.world_mut().despawn(third);
    app.world_mut().spawn(copy);
    tick(&mut app, 1);
    assert_in_index(&app, &cubes);
    assert_eq!(
        (contacts(&app), messages_about(&app, cubes)),
        (vec![cubes], (1, 0))
    );
    // Nor does a change of its filter become that of the other.
    let fourth = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            copy,
            Transform::from_xyz(50.0, 0.0, 0.0),
        ))
        .id();
    app.world_mut()
        .entity_mut(fourth)
        .insert((StaticShape, CollisionLayers::NONE));
    tick(&mut app, 1);
    assert_in_index(&app, &[cubes[0], cubes[1], fourth]);
    assert_eq!(contacts(&app), [cubes]);
}

#[derive(Component)]
struct Parked;

#[derive(Component)]
struct Confirmed;

/// What disables an entity is what the app's queries leave out, whenever it says so.
#[test]
fn any_disabling_component_takes_an_entity_out() {
    for registered in 0..3 {
        let (mut app, cubes) = if registered == 0 {
            let mut app = app(BroadPhaseMethod::default());
            app.world_mut().register_disabling_component::<Parked>();
            app.world_mut().register_disabling_component::<Confirmed>();
            let cubes = [block(&mut app, 0.0), block(&mut app, 0.9)];
            tick(&mut app, 1);
            (app, cubes)
        } else {
            in_contact()
        };
        if registered == 2 {
            // It has one already.
            app.world_mut().entity_mut(cubes[1]).insert(Parked);
            tick(&mut app, 1);
            assert_eq!(contacts(&app), [cubes]);
        }
        if registered > 0 {
            app.world_mut().register_disabling_component::<Parked>();
            app.world_mut().register_disabling_component::<Confirmed>();
        }
        let mut started = 1;
        for which in 0..7 {
            let mut entity = app.world_mut().entity_mut(cubes[1]);
            match which {
                0 | 3 => entity.insert(Parked),
                1 => entity.insert(Confirmed),
                2 => entity.insert((Disabled, Confirmed)),
                4 => entity.insert((Disabled, Parked)),
                5 => entity.insert((Parked, Disabled, Confirmed)),
                _ => entity.insert(Disabled),
            };
            for _ in 0..2 {
                tick(&mut app, 1);
                assert_in_index(&app, &cubes[..1]);
                assert_eq!(
                    (contacts(&app), messages_about(&app, cubes)),
                    (vec![], (started, started))
                );
            }
            // It moves meanwhile, and comes back with the last of them.
            get_mut::<Transform>(&mut app, cubes[1]).translation.x =
                if which % 2 == 0 { -0.9 } else { 0.9 };
            app.world_mut().entity_mut(cubes[1]).remove::<Disabled>();
            tick(&mut app, 1);
            app.world_mut().entity_mut(cubes[1]).remove::<Confirmed>();
            tick(&mut app, 1);
            assert_eq!(
                contacts(&app).len(),
                usize::from(which == 1 || which == 2 || which == 6),
                "{which}"
            );
            app.world_mut().entity_mut(cubes[1]).remove::<Parked>();
            tick(&mut app, 1);
            started += 1;
            assert_in_index(&app, &cubes);
            assert_eq!(
                (contacts(&app), messages_about(&app, cubes)),
                (vec![cubes], (started, started - 1))
            );
        }
    }
}

/// Where what disables is not in tables, boxes are computed row by row, not in slices.
#[test]
fn boxes_follow_whether_tables_are_slices_or_not() {
    #[derive(Component)]
    #[component(storage = "SparseSet")]
    struct Asleep;

    for sparse in [false, true] {
        let (mut app, cubes) = in_contact();
        if sparse {
            app.world_mut().register_disabling_component::<Asleep>();
        }
        get_mut::<Transform>(&mut app, cubes[1]).translation.x = 3.0;
        tick(&mut app, 1);
        assert_eq!(get::<WorldAabb>(&app, cubes[1]).center().x, 3.0);
        assert!(contacts(&app).is_empty());
        // What rests is left alone.
        let changed = |app: &App| {
            let entity = app.world().entity(cubes[1]);
            entity.get_ref::<WorldAabb>().unwrap().last_changed()
        };
        let before = changed(&app);
        tick(&mut app, 2);
        assert_eq!(changed(&app), before);
        *get_mut::<CollisionShape>(&mut app, cubes[1]) = CollisionShape::cuboid(6.0, 1.0, 1.0);
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [cubes]);
        if sparse {
            app.world_mut().entity_mut(cubes[1]).insert(Asleep);
            tick(&mut app, 1);
            assert!(contacts(&app).is_empty());
        }
    }
}

/// A box that was computed for another shape than there is now, or that somebody widened, decides
/// nothing.
#[test]
fn what_changes_after_the_boxes_were_computed_counts() {
    for widens in [false, true] {
        let (mut app, cubes) = in_contact();
        let change = move |mut shapes: Query<(Entity, &mut CollisionShape, &mut WorldAabb)>,
                           mut is_done: Local<bool>| {
            if std::mem::replace(&mut *is_done, true) {
                return;
            }
            let (_, mut shape, mut aabb) =
                shapes.iter_mut().find(|(e, ..)| *e == cubes[1]).unwrap();
            if widens {
                aabb.0 = aabb.grow(Vec3::splat(2.0));
            } else {
                *shape = CollisionShape::cuboid(0.1, 0.1, 0.1);
            }
        };
        let between = change
            .after(CollisionSystems::Bounds)
            .before(CollisionSystems::Maintenance);
        app.add_systems(FixedPostUpdate, between);
        get_mut::<Transform>(&mut app, cubes[1]).translation.x = if widens { 1.5 } else { 0.8 };
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
    }
}

#[test]
fn an_entity_spawned_disabled_stays_out_and_so_does_its_swept_way() {
    let (mut app, cubes) = in_contact();
    app.world_mut().register_disabling_component::<Parked>();
    let ball = (
        CollisionShape::sphere(0.1),
        Swept::default(),
        Parked,
        Transform::from_xyz(5.0, 0.0, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    tick(&mut app, 2);
    assert_in_index(&app, &cubes);
    get_mut::<Transform>(&mut app, ball).translation.x = -5.0;
    app.world_mut().entity_mut(ball).remove::<Parked>();
    tick(&mut app, 1);
    assert_in_index(&app, &[cubes[0], cubes[1], ball]);
    assert_eq!(contacts(&app), [cubes]);
}

#[test]
fn parents_disabled_by_whatever_place_their_children() {
    let mut app = app(BroadPhaseMethod::default());
    app.world_mut().register_disabling_component::<Parked>();
    let parent = app
        .world_mut()
        .spawn((Transform::from_xyz(10.0, 0.0, 0.0), Parked))
        .id();
    let child = (
        CollisionShape::sphere(0.25),
        Swept::default(),
        Transform::from_xyz(2.0, 0.0, 0.0),
    );
    let child = app.world_mut().spawn((child, ChildOf(parent))).id();
    let wall = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(12.0, 4.0, 0.0),
        ))
        .id();
    // On the way from the world's origin, it would have met this.
    block(&mut app, 5.0);
    tick(&mut app, 1);
    assert_eq!(get::<WorldAabb>(&app, child).center().x, 12.0);
    assert!(contacts(&app).is_empty());
    get_mut::<Transform>(&mut app, parent).translation.y = 8.0;
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(child, wall)]);
}

#[test]
fn an_entity_without_a_transform_is_out_until_it_has_one() {
    let (mut app, cubes) = in_contact();
    for round in 1..3 {
        app.world_mut().entity_mut(cubes[1]).remove::<Transform>();
        tick(&mut app, 2);
        assert_in_index(&app, &cubes[..1]);
        assert_eq!(
            (contacts(&app), messages_about(&app, cubes)),
            (vec![], (round, round))
        );
        app.world_mut()
            .entity_mut(cubes[1])
            .insert(Transform::from_xyz(-0.9, 0.0, 0.0));
        tick(&mut app, 1);
        assert_eq!(
            (contacts(&app), messages_about(&app, cubes)),
            (vec![cubes], (round + 1, round))
        );
    }
    // Its own, where it has a parent, and its parent's.
    let parent = app
        .world_mut()
        .spawn(Transform::from_xyz(10.0, 0.0, 0.0))
        .id();
    app.world_mut().entity_mut(cubes[1]).insert(ChildOf(parent));
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut().entity_mut(parent).remove::<Transform>();
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes]);
    tick(&mut app, 1);
    assert_eq!(counters(&app).moved, 0);
    app.world_mut()
        .entity_mut(parent)
        .insert(Transform::from_xyz(10.0, 0.0, 0.0));
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut().entity_mut(cubes[1]).remove::<Transform>();
    tick(&mut app, 1);
    assert_in_index(&app, &cubes[..1]);
}

#[test]
fn a_box_that_is_overwritten_or_was_removed_is_computed_anew() {
    for ticks in [0, 2] {
        let (mut app, cubes) = in_contact();
        app.world_mut()
            .entity_mut(cubes[1])
            .insert(WorldAabb::default());
        tick(&mut app, 2);
        assert_eq!(
            (contacts(&app), messages_about(&app, cubes)),
            (vec![cubes], (1, 0))
        );
        assert_in_index(&app, &cubes);
        app.world_mut().entity_mut(cubes[1]).remove::<WorldAabb>();
        tick(&mut app, ticks);
        app.world_mut()
            .entity_mut(cubes[1])
            .insert(WorldAabb::default());
        tick(&mut app, 1);
        assert_eq!(
            (contacts(&app), messages_about(&app, cubes)),
            (vec![cubes], (2, 1))
        );
        assert_in_index(&app, &cubes);
    }
}

#[test]
fn an_update_takes_up_a_new_tolerance() {
    let mut app = app(BroadPhaseMethod::default());
    let ball = (
        CollisionShape::sphere(0.5),
        Transform::from_xyz(5.0, 0.0, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    tick(&mut app, 1);
    update_spatial_index(app.world_mut());
    tick(&mut app, 1);
    app.insert_resource(NarrowPhase::new(0.5).unwrap());
    update_spatial_index(app.world_mut());
    let find = move |spatial: SpatialQuery| {
        let mut found = Vec::new();
        let at = Vec3::new(4.1, 0.0, 0.0);
        spatial.for_each_point_intersection(at, &SpatialQueryFilter::default(), |entity| {
            found.push(entity);
        });
        found
    };
    assert_eq!(app.world_mut().run_system_cached(find).unwrap(), [ball]);
}

#[cfg(feature = "rapier")]
#[test]
fn a_collider_that_changed_while_its_entity_was_disabled_is_taken_up() {
    use bevy_rapier3d::prelude::{Collider, RapierPhysicsPlugin, TimestepMode};

    let plugins = (
        TransformPlugin,
        OctreePlugins::new(PostUpdate),
        RapierInteropPlugin::default(),
    );
    let mut app = app_with(plugins, PostUpdate);
    app.insert_resource(TimestepMode::Fixed {
        dt: 1.0 / TICKS_PER_SECOND,
        substeps: 1,
    })
    .add_plugins(RapierPhysicsPlugin::<()>::default());
    app.finish();
    app.cleanup();
    app.world_mut().register_disabling_component::<Parked>();
    let probe = block(&mut app, 2.0);
    let ball = app
        .world_mut()
        .spawn((Collider::ball(1.0), ShapeFromRapier, Transform::default()))
        .id();
    tick(&mut app, 2);
    assert!(contacts(&app).is_empty());
    app.world_mut()
        .entity_mut(ball)
        .insert((Parked, Collider::ball(2.5)));
    tick(&mut app, 2);
    assert_in_index(&app, &[probe]);
    app.world_mut().entity_mut(ball).remove::<Parked>();
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(probe, ball)]);
}
