//! What becomes of contacts when entities come, go and change. Numbered cases.

use crate::common;

use bevy::{ecs::entity_disabling::Disabled, prelude::*};
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    components::{BroadPhaseProxy, WorldAabb},
    motion::CollisionClock,
    narrow_phase::Shape,
    prelude::*,
    scene::{Cube, Motion, ObjectDescription, SceneDescription, ShapeDescription},
};
use common::*;

/// The contact of two cubes has ended, once, and nothing is left of it.
fn assert_over(app: &App, cubes: EntityPair) {
    assert!(contacts(app).is_empty());
    assert!(index(app).pairs().is_empty());
    assert_eq!(messages_about(app, cubes), (1, 1));
}

fn world_box(app: &App, entity: Entity) -> (Vec3, Vec3) {
    let aabb = get::<WorldAabb>(app, entity).0;
    (
        ((aabb.min + aabb.max) * 0.5).into(),
        (aabb.max - aabb.min).into(),
    )
}

fn assert_world_box(app: &App, entity: Entity, center: Vec3, size: Vec3) {
    let found = world_box(app, entity);
    assert!(
        (found.0 - center).length() < 1e-3 && (found.1 - size).length() < 1e-3,
        "{found:?}"
    );
}

#[test]
fn case_01_a_despawned_entity_ends_its_contacts_once() {
    for which in [0, 1] {
        let (mut app, cubes) = in_contact();
        app.world_mut().despawn(cubes[which]);
        for _ in 0..3 {
            tick(&mut app, 1);
            assert_over(&app, cubes);
            assert_eq!(index(&app).proxies().len(), 1);
        }
    }
}

#[test]
fn case_02_despawn_and_respawn_in_one_tick_are_two_contacts() {
    let (mut app, cubes) = in_contact();
    app.world_mut().despawn(cubes[1]);
    let again = block(&mut app, 0.9);
    tick(&mut app, 2);
    assert_eq!(contacts(&app), [pair(cubes[0], again)]);
    assert_eq!(messages_about(&app, cubes), (1, 1));
    assert_eq!(messages_about(&app, pair(cubes[0], again)), (1, 0));
}

#[test]
fn case_03_an_entity_without_its_shape_is_out() {
    let (mut app, cubes) = in_contact();
    app.world_mut()
        .entity_mut(cubes[1])
        .remove::<CollisionShape>();
    tick(&mut app, 1);
    assert_over(&app, cubes);
    app.world_mut()
        .entity_mut(cubes[1])
        .insert(CollisionShape::default());
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, cubes), (2, 1));
}

#[test]
fn case_04_a_lost_or_replaced_proxy_leaves_no_ghost() {
    let (mut app, cubes) = in_contact();
    app.world_mut()
        .entity_mut(cubes[1])
        .insert(BroadPhaseProxy::default());
    tick(&mut app, 2);
    assert_eq!(
        (contacts(&app), index(&app).proxies().len()),
        (vec![cubes], 2)
    );
    app.world_mut()
        .entity_mut(cubes[1])
        .remove::<BroadPhaseProxy>();
    tick(&mut app, 2);
    assert_eq!((contacts(&app), index(&app).proxies().len()), (vec![], 1));
    app.world_mut().entity_mut(cubes[0]).remove::<WorldAabb>();
    tick(&mut app, 1);
    assert!(index(&app).proxies().is_empty());
}

#[test]
fn case_05_a_clone_is_an_object_of_its_own() {
    let (mut app, cubes) = in_contact();
    let clone = app.world_mut().entity_mut(cubes[1]).clone_and_spawn();
    get_mut::<Transform>(&mut app, clone).translation.x = -0.9;
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [cubes, [cubes[0], clone]]);
    app.world_mut().despawn(clone);
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), index(&app).proxies().len()),
        (vec![cubes], 2)
    );
}

#[test]
fn case_06_a_disabled_entity_is_out_until_enabled() {
    let (mut app, cubes) = in_contact();
    app.world_mut().entity_mut(cubes[1]).insert(Disabled);
    tick(&mut app, 2);
    assert_over(&app, cubes);
    app.world_mut().entity_mut(cubes[1]).remove::<Disabled>();
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), messages_about(&app, cubes)),
        (vec![cubes], (2, 1))
    );
    // It may move, or go, while it is disabled.
    app.world_mut().entity_mut(cubes[1]).insert(Disabled);
    tick(&mut app, 1);
    get_mut::<Transform>(&mut app, cubes[1]).translation.x = 50.0;
    tick(&mut app, 1);
    app.world_mut().entity_mut(cubes[1]).remove::<Disabled>();
    tick(&mut app, 1);
    assert_world_box(&app, cubes[1], Vec3::X * 50.0, Vec3::ONE);
    app.world_mut().entity_mut(cubes[1]).insert(Disabled);
    app.world_mut().despawn(cubes[1]);
    tick(&mut app, 1);
    assert_eq!(
        (messages_about(&app, cubes), index(&app).proxies().len()),
        ((2, 2), 1)
    );
}

/// A parent, a child with a shape at (2, 0, 0) from it, and the app, one tick old.
fn family() -> (App, [Entity; 2]) {
    let mut app = app(BroadPhaseMethod::default());
    let parent = app
        .world_mut()
        .spawn(Transform::from_xyz(10.0, 0.0, 0.0))
        .id();
    let child = block(&mut app, 2.0);
    app.world_mut().entity_mut(parent).add_child(child);
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::X * 12.0, Vec3::ONE);
    (app, [parent, child])
}

#[test]
fn case_07_a_child_follows_its_parent_in_the_same_tick() {
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let at_10 = Transform::from_xyz(10.0, 0.0, 0.0);
    let cases = [
        (
            Transform::from_xyz(0.0, 5.0, 0.0),
            Vec3::new(2.0, 5.0, 0.0),
            Vec3::ONE,
        ),
        (
            at_10.with_rotation(quarter),
            Vec3::new(10.0, 2.0, 0.0),
            Vec3::ONE,
        ),
        (
            at_10.with_scale(Vec3::splat(3.0)),
            Vec3::new(16.0, 0.0, 0.0),
            Vec3::splat(3.0),
        ),
        (
            at_10.with_scale(Vec3::new(-1.0, 2.0, 4.0)),
            Vec3::new(8.0, 0.0, 0.0),
            Vec3::new(1.0, 2.0, 4.0),
        ),
    ];
    for (transform, center, size) in cases {
        let (mut app, [parent, child]) = family();
        let beside = app
            .world_mut()
            .spawn((
                CollisionShape::default(),
                Transform::from_translation(center),
            ))
            .id();
        *get_mut(&mut app, parent) = transform;
        tick(&mut app, 1);
        assert_world_box(&app, child, center, size);
        assert_eq!(contacts(&app), [pair(child, beside)]);
        tick(&mut app, 1);
        assert_eq!(counters(&app).moved, 0);
    }
}

#[test]
fn case_08_reparenting_takes_effect_in_the_same_tick() {
    let (mut app, [parent, child]) = family();
    let other = app
        .world_mut()
        .spawn(Transform::from_xyz(0.0, 7.0, 0.0))
        .id();
    app.world_mut().entity_mut(child).insert(ChildOf(other));
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::new(2.0, 7.0, 0.0), Vec3::ONE);
    // A grandparent, which comes and goes.
    app.world_mut().entity_mut(other).insert(ChildOf(parent));
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::new(12.0, 7.0, 0.0), Vec3::ONE);
    app.world_mut().entity_mut(other).remove::<ChildOf>();
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::new(2.0, 7.0, 0.0), Vec3::ONE);
    app.world_mut().entity_mut(child).remove::<ChildOf>();
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::X * 2.0, Vec3::ONE);
    app.world_mut().entity_mut(child).insert(ChildOf(parent));
    tick(&mut app, 1);
    app.world_mut().despawn(parent);
    tick(&mut app, 1);
    assert!(index(&app).proxies().is_empty());
}

#[test]
fn case_09_a_disabled_parent_still_places_its_children() {
    let (mut app, [parent, child]) = family();
    app.world_mut().entity_mut(parent).insert(Disabled);
    get_mut::<Transform>(&mut app, child).translation.x = 3.0;
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::X * 13.0, Vec3::ONE);
    // It loses its own parent while it is disabled.
    let grandparent = app
        .world_mut()
        .spawn(Transform::from_xyz(0.0, 1.0, 0.0))
        .id();
    app.world_mut()
        .entity_mut(parent)
        .insert(ChildOf(grandparent));
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::new(13.0, 1.0, 0.0), Vec3::ONE);
    app.world_mut().entity_mut(parent).remove::<ChildOf>();
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::X * 13.0, Vec3::ONE);
}

#[test]
fn case_10_changed_shapes_and_teleports_count_in_the_same_tick() {
    let (mut app, cubes) = in_contact();
    *get_mut(&mut app, cubes[1]) = CollisionShape::sphere(0.25);
    tick(&mut app, 1);
    assert_over(&app, cubes);
    app.world_mut()
        .entity_mut(cubes[1])
        .insert(CollisionShape::from_half_size(Vec3::splat(9.0)));
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, cubes), (2, 1));
    get_mut::<Transform>(&mut app, cubes[0]).translation = Vec3::splat(1e6);
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), messages_about(&app, cubes)),
        (vec![], (2, 2))
    );
    get_mut::<Transform>(&mut app, cubes[0]).translation = Vec3::ZERO;
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, cubes), (3, 2));
}

/// Turned about its centre a cube keeps its box, but not its contacts.
#[test]
fn case_11_turning_inside_the_box_is_a_change() {
    let mut app = app(BroadPhaseMethod::default());
    let thin = CollisionShape::from_half_size(Vec3::new(1.0, 0.05, 0.05));
    let eighth = |sign: f32| Quat::from_rotation_z(sign * std::f32::consts::FRAC_PI_4);
    let rod = app
        .world_mut()
        .spawn((thin, Transform::from_rotation(eighth(1.0))))
        .id();
    let ball = (
        CollisionShape::sphere(0.1),
        Transform::from_xyz(0.6, 0.6, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    for (sign, expected) in [(1.0, 1), (-1.0, 0), (1.0, 1)] {
        get_mut::<Transform>(&mut app, rod).rotation = eighth(sign);
        tick(&mut app, 1);
        assert_eq!(contacts(&app).len(), expected);
    }
    assert_eq!(messages_about(&app, [rod, ball]), (2, 1));
}

#[test]
fn case_12_what_is_not_finite_is_out_until_it_is() {
    let bad = [
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(0.0, f32::NEG_INFINITY, 0.0),
        Transform::from_scale(Vec3::new(1.0, f32::INFINITY, 1.0)),
        Transform::from_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        Transform::from_translation(Vec3::MAX).with_scale(Vec3::MAX),
    ];
    for transform in bad {
        let (mut app, cubes) = in_contact();
        let good = *get::<Transform>(&app, cubes[1]);
        *get_mut(&mut app, cubes[1]) = transform;
        tick(&mut app, 2);
        assert_over(&app, cubes);
        assert_eq!(
            (
                index(&app).proxies().len(),
                get::<BroadPhaseProxy>(&app, cubes[1]).id()
            ),
            (1, None)
        );
        *get_mut(&mut app, cubes[1]) = good;
        tick(&mut app, 1);
        assert_eq!(messages_about(&app, cubes), (2, 1));
    }
    let (mut app, cubes) = in_contact();
    *get_mut(&mut app, cubes[1]) = CollisionShape(Shape::Sphere { radius: f32::NAN });
    tick(&mut app, 1);
    assert_over(&app, cubes);
}

#[test]
fn case_13_a_velocity_that_is_not_finite_moves_nothing() {
    for velocity in [Vec3::splat(f32::INFINITY), Vec3::new(0.0, f32::NAN, 1.0)] {
        for bounce in [Bounce::Reverse, Bounce::Reflect { restitution: 1.0 }] {
            let (mut app, cubes) = in_contact();
            app.world_mut()
                .entity_mut(cubes[1])
                .insert((bounce, Velocity(velocity)));
            tick(&mut app, 3);
            assert_eq!(contacts(&app), [cubes]);
            assert_eq!(get::<Transform>(&app, cubes[1]).translation, Vec3::X * 0.9);
        }
    }
    // The largest finite velocity leads out of the world, in a few ticks.
    let (mut app, cubes) = in_contact();
    app.world_mut()
        .entity_mut(cubes[1])
        .insert(Velocity(Vec3::MAX));
    tick(&mut app, 100);
    assert_over(&app, cubes);
}

/// Has `act` done once, at the third tick, right after a set, by a system of the user's.
fn after_set(app: &mut App, place: usize, mut act: impl FnMut(&mut World) + Send + Sync + 'static) {
    let system = move |world: &mut World| {
        if world.resource::<CollisionClock>().tick() == 2 {
            act(world);
        }
    };
    match SETS.get(place + 1) {
        Some(next) => app.add_systems(FixedPostUpdate, system.after(SETS[place]).before(*next)),
        // After the last set the clock advances.
        None => app.add_systems(FixedPostUpdate, system.in_set(SETS[place])),
    };
}

#[test]
fn case_14_an_entity_may_come_between_any_two_sets() {
    for (place, set) in SETS.into_iter().enumerate() {
        let (mut app, cubes) = in_contact();
        after_set(&mut app, place, |world| {
            world.spawn((Cube, Transform::from_xyz(0.9, 0.9, 0.0)));
        });
        tick(&mut app, 3);
        assert_eq!(contacts(&app).len(), 3, "after {set:?}");
        assert_eq!(app.world().resource::<Log>().started.len(), 3);
        assert_eq!(messages_about(&app, cubes), (1, 0));
    }
}

#[test]
fn case_15_an_entity_may_go_between_any_two_sets() {
    for (place, set) in SETS.into_iter().enumerate() {
        for turning in [false, true] {
            let (mut app, cubes) = in_contact();
            if turning {
                app.add_systems(FixedUpdate, |mut moving: Query<&mut Transform>| {
                    moving
                        .iter_mut()
                        .for_each(|mut transform| transform.set_changed());
                });
            }
            after_set(&mut app, place, move |world| {
                world.despawn(cubes[1]);
            });
            tick(&mut app, 2);
            // Where there still was something to decide, the contact is over in the same tick.
            let decided = place
                >= SETS
                    .iter()
                    .position(|set| *set == CollisionSystems::NarrowPhase)
                    .unwrap();
            assert_eq!(contacts(&app).len(), usize::from(decided), "after {set:?}");
            for _ in 0..3 {
                tick(&mut app, 1);
                assert_over(&app, cubes);
                assert_eq!(index(&app).proxies().len(), 1, "after {set:?}");
            }
            // Its handle may be taken over by others.
            block(&mut app, 0.9);
            tick(&mut app, 3);
            assert_eq!(contacts(&app).len(), 1);
            assert_eq!(messages_about(&app, cubes), (1, 1));
        }
    }
}

#[test]
fn case_16_entities_without_a_shape_are_nothing_to_it() {
    let mut app = app(BroadPhaseMethod::default());
    let ghost = (
        Transform::from_xyz(0.0, 0.0, 0.0),
        Velocity(Vec3::X * TICKS_PER_SECOND),
        Bounce::Reverse,
    );
    let ghost = app.world_mut().spawn(ghost).id();
    block(&mut app, 0.0);
    tick(&mut app, 2);
    assert_eq!(get::<Transform>(&app, ghost).translation.x, 2.0);
    assert_eq!((counters(&app).objects, counters(&app).contacts), (1, 0));
    assert!(app.world().get::<WorldAabb>(ghost).is_none());
}

/// A lattice of cubes that touch their neighbours along z.
fn lattice(side: usize) -> impl Iterator<Item = (CollisionShape, Transform)> {
    (0..side * side * side).map(move |i| {
        let place = Vec3::new(
            (i / side / side) as f32 * 2.0,
            (i / side % side) as f32 * 2.0,
            (i % side) as f32,
        );
        (
            CollisionShape::default(),
            Transform::from_translation(place),
        )
    })
}

#[test]
fn case_17_thousands_may_go_in_one_tick() {
    let mut app = app(BroadPhaseMethod::default());
    let blocks: Vec<_> = app.world_mut().spawn_batch(lattice(28)).collect();
    assert!(blocks.len() > 20_000);
    tick(&mut app, 1);
    let pairs = 28 * 28 * 27;
    assert_eq!(counters(&app).contacts, pairs);
    for entity in &blocks[1..] {
        app.world_mut().despawn(*entity);
    }
    tick(&mut app, 1);
    assert_eq!(
        (
            counters(&app).ended,
            counters(&app).contacts,
            index(&app).proxies().len()
        ),
        (pairs, 0, 1)
    );
}

#[test]
fn case_18_what_rests_costs_nothing() {
    for method in [BroadPhaseMethod::default(), BroadPhaseMethod::Exhaustive] {
        let mut app = app(method);
        app.world_mut().spawn_batch(lattice(6)).for_each(drop);
        tick(&mut app, 1);
        assert_eq!(
            (counters(&app).moved, counters(&app).candidates),
            (216, 6 * 6 * 5)
        );
        for _ in 0..3 {
            tick(&mut app, 1);
            let counters = counters(&app);
            assert!(index(&app).proxies().moved().is_empty());
            assert_eq!(
                (counters.objects, counters.contacts, counters.resting_pairs),
                (216, 180, 180)
            );
            assert_eq!(
                (counters.moved, counters.candidates, counters.pairs_tested),
                (0, 0, 0)
            );
            assert_eq!(counters.stages, Default::default());
        }
        // One that moves among them is all that is looked at.
        let mover = Transform::from_xyz(0.0, 0.0, 2.5);
        let mover = app
            .world_mut()
            .spawn((CollisionShape::default(), mover, Velocity(Vec3::Y)))
            .id();
        tick(&mut app, 2);
        assert_eq!((counters(&app).moved, counters(&app).candidates), (1, 2));
        get_mut::<Velocity>(&mut app, mover).y = 0.0;
        tick(&mut app, 1);
        assert_eq!((counters(&app).moved, counters(&app).candidates), (0, 0));
    }
}

#[test]
fn case_19_memory_stays_flat_at_constant_count() {
    let mut app = app(BroadPhaseMethod::ObjectOctree(
        ObjectOctreeSettings::with_max_objects(4),
    ));
    let mut rng = fastrand::Rng::with_seed(5);
    let mut place = move || Transform::from_xyz(rng.f32() * 9.0, rng.f32() * 9.0, rng.f32() * 9.0);
    let mut alive: std::collections::VecDeque<Entity> = std::collections::VecDeque::new();
    let mut bytes = Vec::new();
    for number in 0..1000 {
        while alive.len() < 60 {
            alive.push_back(
                app.world_mut()
                    .spawn((CollisionShape::default(), place()))
                    .id(),
            );
        }
        tick(&mut app, 1);
        alive.drain(..10).for_each(|entity| {
            app.world_mut().despawn(entity);
        });
        if number % 250 == 249 {
            bytes.push(index(&app).memory_bytes());
        }
    }
    assert!(bytes[3] < bytes[0] * 5 / 4, "{bytes:?}");
    // Handles are used again.
    assert!(index(&app).proxies().capacity() < 100);
}

#[test]
fn case_20_a_hierarchy_and_a_scene_come_and_go_by_commands() {
    let mut app = app(BroadPhaseMethod::default());
    let wall = block(&mut app, 0.0);
    let part = |x: f32| (CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0));
    let tank = (
        Transform::from_xyz(0.0, 0.75, 0.0),
        children![
            part(0.25),
            (part(-0.25), children![part(20.0)]),
            Transform::default()
        ],
    );
    let tank = app.world_mut().commands().spawn(tank).id();
    tick(&mut app, 1);
    // The wall with both, these with each other, the third out of reach.
    assert_eq!((counters(&app).objects, counters(&app).contacts), (4, 3));
    app.world_mut().commands().entity(tank).despawn();
    tick(&mut app, 1);
    assert_eq!(
        (
            counters(&app).objects,
            counters(&app).contacts,
            counters(&app).ended
        ),
        (1, 0, 3)
    );

    let ball = |x: f32, motion: Motion| ObjectDescription {
        position: Vec3::X * x,
        motion,
        ..ObjectDescription::new(ShapeDescription::Sphere { radius: 0.5 })
    };
    let balls = [
        ball(0.75, Motion::Static),
        ball(-0.75, Motion::Velocity(Vec3::Y)),
    ];
    let scene = SceneDescription::new("two balls", balls);
    let balls = scene.spawn(&mut app.world_mut().commands()).unwrap();
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [[wall, balls[0]], [wall, balls[1]]]);
    balls
        .iter()
        .for_each(|ball| app.world_mut().commands().entity(*ball).despawn());
    tick(&mut app, 1);
    assert_eq!(
        (
            counters(&app).objects,
            counters(&app).contacts,
            counters(&app).ended
        ),
        (1, 0, 2)
    );
}

#[test]
fn case_21_the_work_of_a_mass_spawn_is_linear() {
    let per_object = |side: usize| {
        // Without the log of the other cases, which is not linear.
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
        tick(&mut app, 1);
        let blocks: Vec<_> = app.world_mut().spawn_batch(lattice(side)).collect();
        let pairs = side * side * (side - 1);
        tick(&mut app, 1);
        assert_eq!(
            (counters(&app).contacts, counters(&app).started),
            (pairs as u64, pairs as u64)
        );
        let (objects, tested) = (
            counters(&app).objects as f64,
            counters(&app).pairs_tested as f64,
        );
        let bytes = index(&app).memory_bytes() as f64;
        tick(&mut app, 1);
        assert_eq!((counters(&app).moved, counters(&app).pairs_tested), (0, 0));
        for entity in blocks {
            app.world_mut().despawn(entity);
        }
        tick(&mut app, 1);
        assert_eq!(
            (
                counters(&app).objects,
                counters(&app).contacts,
                counters(&app).pairs_tested
            ),
            (0, 0, 0)
        );
        assert_eq!(counters(&app).ended, pairs as u64);
        (tested / objects, bytes / objects)
    };
    // 50 653 and 205 379 at once.
    let (few, many) = (per_object(37), per_object(59));
    assert!(
        many.0 < few.0 * 1.25 && many.1 < few.1 * 1.5,
        "{few:?} {many:?}"
    );
}

/// A scale of zero makes a point, a segment or a rectangle, which meets what it touches; a negative
/// one mirrors.
#[test]
fn case_22_scales_may_be_zero_or_negative() {
    let shapes = [CollisionShape::default(), CollisionShape::sphere(0.5)];
    for shape in shapes {
        for scale in [Vec3::ZERO, -Vec3::ONE, Vec3::new(0.0, -1.0, 1.0)] {
            let mut app = app(BroadPhaseMethod::default());
            let wall = block(&mut app, 0.0);
            // A ball stays one, by the largest of the three.
            let is_ball = matches!(shape.0, Shape::Sphere { .. });
            let reach = 0.5
                + 0.5
                    * if is_ball {
                        scale.abs().max_element()
                    } else {
                        scale.x.abs()
                    };
            let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0).with_scale(scale);
            let small = app
                .world_mut()
                .spawn((shape.clone(), at(reach - 0.01)))
                .id();
            tick(&mut app, 1);
            assert_eq!(contacts(&app), [[wall, small]], "{scale} {shape:?}");
            *get_mut(&mut app, small) = at(reach + 0.01);
            tick(&mut app, 1);
            assert_over(&app, [wall, small]);
            *get_mut(&mut app, small) = at(reach - 0.01).with_scale(Vec3::ONE);
            tick(&mut app, 1);
            assert_eq!(messages_about(&app, [wall, small]), (2, 1));
        }
    }
}

/// The children of a parent that is nowhere are out with it, and nobody else.
#[test]
fn case_23_children_of_what_is_not_finite_are_out_until_it_is() {
    let bad = [
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_scale(Vec3::splat(f32::INFINITY)),
        Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, f32::NAN)),
    ];
    for transform in bad {
        let (mut app, [parent, child]) = family();
        let grandchild = block(&mut app, 0.5);
        app.world_mut().entity_mut(child).add_child(grandchild);
        let beside = [block(&mut app, 12.25), block(&mut app, 13.0)];
        tick(&mut app, 1);
        assert_eq!(counters(&app).contacts, 6);
        *get_mut(&mut app, parent) = transform;
        tick(&mut app, 1);
        assert_eq!(
            (contacts(&app), index(&app).proxies().len()),
            (vec![beside], 2)
        );
        *get_mut(&mut app, parent) = Transform::from_xyz(10.0, 0.0, 0.0);
        tick(&mut app, 1);
        assert_eq!(
            (
                counters(&app).contacts,
                messages_about(&app, [child, grandchild])
            ),
            (6, (2, 1))
        );
        // One that never was anywhere.
        let (lost, found) = (
            Transform::from_xyz(0.0, f32::INFINITY, 0.0),
            Transform::default(),
        );
        let lost = app
            .world_mut()
            .spawn((lost, children![(CollisionShape::default(), found)]))
            .id();
        tick(&mut app, 1);
        assert_eq!(index(&app).proxies().len(), 4);
        app.world_mut().despawn(lost);
        app.world_mut().despawn(parent);
        tick(&mut app, 1);
        assert_eq!(contacts(&app), [beside]);
    }
}

/// Takes another entity with it when it goes or comes, by a component hook.
#[derive(Component)]
#[component(on_add = Self::on_add, on_remove = Self::on_remove)]
struct Doom {
    other: Entity,
    on_add: bool,
}

impl Doom {
    fn on_add(
        mut world: bevy::ecs::world::DeferredWorld,
        context: bevy::ecs::lifecycle::HookContext,
    ) {
        Self::strike(&mut world, context.entity, true);
    }

    fn on_remove(
        mut world: bevy::ecs::world::DeferredWorld,
        context: bevy::ecs::lifecycle::HookContext,
    ) {
        Self::strike(&mut world, context.entity, false);
    }

    fn strike(world: &mut bevy::ecs::world::DeferredWorld, entity: Entity, added: bool) {
        if let Some(&Self { other, on_add }) = world.get::<Self>(entity)
            && on_add == added
        {
            world.commands().entity(other).try_despawn();
        }
    }
}

#[test]
fn case_24_hooks_may_despawn_between_any_two_sets() {
    for (place, set) in SETS.into_iter().enumerate() {
        for on_add in [true, false] {
            let (mut app, cubes) = in_contact();
            let third = block(&mut app, 1.8);
            if !on_add {
                app.world_mut().entity_mut(cubes[0]).insert(Doom {
                    other: cubes[1],
                    on_add,
                });
            }
            after_set(&mut app, place, move |world| {
                let mut entity = world.entity_mut(cubes[0]);
                if on_add {
                    entity.insert(Doom {
                        other: cubes[1],
                        on_add,
                    });
                } else {
                    // Gone itself, and the other with it.
                    entity.despawn();
                }
            });
            tick(&mut app, 3);
            assert_over(&app, cubes);
            assert_eq!(
                messages_about(&app, [cubes[1], third]),
                (1, 1),
                "after {set:?}"
            );
            assert_eq!(
                index(&app).proxies().len(),
                if on_add { 2 } else { 1 },
                "after {set:?}"
            );
        }
    }
}

#[test]
fn case_25_layers_that_match_nothing_end_contacts_and_give_them_back() {
    for rounds in 1..=2 {
        let (mut app, cubes) = in_contact();
        for round in 1..=rounds {
            app.world_mut()
                .entity_mut(cubes[1])
                .insert(CollisionLayers::NONE);
            tick(&mut app, 1);
            assert_eq!(
                (contacts(&app), messages_about(&app, cubes)),
                (vec![], (round, round))
            );
            assert!(index(&app).pairs().is_empty());
            tick(&mut app, 1);
            assert_eq!((counters(&app).moved, index(&app).proxies().len()), (0, 2));
            app.world_mut()
                .entity_mut(cubes[1])
                .remove::<CollisionLayers>();
            tick(&mut app, 1);
            assert_eq!(
                (contacts(&app), messages_about(&app, cubes)),
                (vec![cubes], (round + 1, round))
            );
        }
    }
}

#[test]
fn case_26_a_new_shape_place_and_parent_in_one_tick() {
    let (mut app, [parent, child]) = family();
    let before = block(&mut app, 12.0);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [[child, before]]);
    let other = app
        .world_mut()
        .spawn(Transform::from_xyz(0.0, 7.0, 0.0))
        .id();
    let after = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(-3.0, 10.0, 0.0),
        ))
        .id();
    let ball = CollisionShape::sphere(2.0);
    app.world_mut().entity_mut(child).insert((
        ChildOf(other),
        ball,
        Transform::from_xyz(-3.0, 0.75, 0.0),
    ));
    // And the old parent goes in the same tick: what was its child stays.
    app.world_mut().despawn(parent);
    tick(&mut app, 1);
    assert_world_box(&app, child, Vec3::new(-3.0, 7.75, 0.0), Vec3::splat(4.0));
    assert_eq!(
        (contacts(&app), messages_about(&app, [child, before])),
        (vec![pair(child, after)], (1, 1))
    );
}

/// What is taken off and put on again within a frame is new: its contacts end and start. What is
/// overwritten is changed.
#[test]
fn case_27_a_shape_removed_and_inserted_in_one_frame_starts_anew() {
    let (mut app, cubes) = in_contact();
    app.world_mut()
        .entity_mut(cubes[1])
        .insert(CollisionShape::default());
    tick(&mut app, 2);
    assert_eq!(
        (contacts(&app), messages_about(&app, cubes)),
        (vec![cubes], (1, 0))
    );
    app.world_mut()
        .entity_mut(cubes[1])
        .remove::<CollisionShape>()
        .insert(CollisionShape::default());
    tick(&mut app, 2);
    assert_eq!(
        (contacts(&app), messages_about(&app, cubes)),
        (vec![cubes], (2, 1))
    );
    // All that came with it, and elsewhere.
    app.world_mut()
        .entity_mut(cubes[1])
        .remove_with_requires::<CollisionShape>();
    let anew = (
        CollisionShape::default(),
        Transform::from_xyz(-0.9, 0.0, 0.0),
    );
    app.world_mut().entity_mut(cubes[1]).insert(anew);
    tick(&mut app, 1);
    assert_eq!(
        (
            contacts(&app),
            messages_about(&app, cubes),
            index(&app).proxies().len()
        ),
        (vec![cubes], (3, 2), 2)
    );
    assert_world_box(&app, cubes[1], Vec3::X * -0.9, Vec3::ONE);
}
