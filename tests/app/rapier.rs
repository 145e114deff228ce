//! Side by side with `bevy_rapier3d`: shapes that follow colliders, contacts that are those of
//! Rapier, bounces of Rapier's bodies, and shapes without an end.

use crate::common;

use std::collections::BTreeSet;

use bevy::{
    ecs::{entity_disabling::Disabled, schedule::ScheduleLabel, system::RunSystemOnce},
    prelude::*,
};
use bevy_octree::{components::WorldAabb, narrow_phase::Shape, prelude::*};
use bevy_rapier3d::{
    parry::{math::Pose, query},
    plugin::ReadRapierContext,
    prelude as rapier,
    prelude::{Collider, RapierPhysicsPlugin, RigidBody},
};
use common::{warnings::warnings, *};

const STEP: f32 = 1.0 / TICKS_PER_SECOND;

/// An app in which Rapier and this crate make one step per update.
fn app_in(rapier: impl ScheduleLabel, ours: impl ScheduleLabel + Clone) -> App {
    app_of(rapier, ours.clone(), RapierInteropPlugin::default())
}

fn app_of(
    rapier: impl ScheduleLabel,
    ours: impl ScheduleLabel + Clone,
    interop: RapierInteropPlugin,
) -> App {
    let mut app = app_with(
        (TransformPlugin, OctreePlugins::new(ours.clone()), interop),
        ours,
    );
    app.insert_resource(rapier::TimestepMode::Fixed {
        dt: STEP,
        substeps: 1,
    })
    .add_plugins(RapierPhysicsPlugin::<()>::default().in_schedule(rapier));
    app.finish();
    app.cleanup();
    app
}

/// Both in the schedules recommended for fixed steps.
fn fixed_app() -> App {
    app_in(FixedUpdate, FixedPostUpdate)
}

/// An entity that has the shape of its collider.
pub fn spawn(app: &mut App, collider: Collider, at: Vec3, more: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((
            collider,
            ShapeFromRapier,
            Transform::from_translation(at),
            more,
        ))
        .id()
}

/// What this crate and Rapier say about the same places.
struct Verdicts {
    ours: BTreeSet<EntityPair>,
    placed: Vec<(Entity, Collider, Pose)>,
}

impl Verdicts {
    fn of_this_tick(app: &mut App) -> Self {
        let ours = contacts(app).into_iter().collect();
        let world = app.world_mut();
        let mut colliders = world.query::<(Entity, &Collider, &Transform)>();
        let pose = |at: &Transform| Pose::from_parts(at.translation, at.rotation);
        let placed = colliders
            .iter(world)
            .map(|(id, collider, at)| (id, collider.clone(), pose(at)))
            .collect();
        Self { ours, placed }
    }

    /// Compares them with what Rapier found for the same places, in its next step. Where the two
    /// differ, the shapes do no more than touch: parry finds them no further apart, and no deeper
    /// in each other, than twice the tolerance.
    fn compare(&self, app: &mut App) {
        let theirs = |context: ReadRapierContext| {
            let context = context.single().expect("there is one context");
            let pairs = context.simulation.intersection_pairs(context.colliders);
            pairs
                .filter(|(.., meet)| *meet)
                .map(|(a, b, _)| pair(a, b))
                .collect::<BTreeSet<_>>()
        };
        let theirs = app
            .world_mut()
            .run_system_once(theirs)
            .expect("the system runs");
        let find = |entity| {
            self.placed
                .iter()
                .find(|placed| placed.0 == entity)
                .expect("it was there")
        };
        for [a, b] in self.ours.symmetric_difference(&theirs) {
            let ((_, a, at_a), (_, b, at_b)) = (find(*a), find(*b));
            let contact =
                query::contact(at_a, &*a.raw, at_b, &*b.raw, 1.0).expect("the pair is supported");
            let distance = contact.map_or(f32::INFINITY, |contact| contact.dist);
            // Rapier asks what overlaps a height field for balls alone.
            let is_unasked = [a, b]
                .iter()
                .any(|collider| collider.raw.as_heightfield().is_some());
            let distance = if is_unasked {
                distance.max(0.0)
            } else {
                distance
            };
            assert!(
                distance.abs() <= 2e-4,
                "{a:?} and {b:?} are {distance} apart"
            );
        }
    }
}

fn some_shapes() -> Vec<Collider> {
    let tetrahedron = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_ONE];
    let halves = [-0.5, 0.5].map(|x| {
        (
            Vec3::X * x,
            Quat::from_rotation_z(x),
            Collider::cuboid(0.4, 0.2, 0.3),
        )
    });
    vec![
        Collider::ball(0.6),
        Collider::cuboid(0.5, 0.4, 0.7),
        Collider::capsule_y(0.5, 0.3),
        Collider::cylinder(0.5, 0.4),
        Collider::cone(0.6, 0.5),
        Collider::convex_hull(&tetrahedron).expect("four points are a hull"),
        Collider::compound(halves.into()),
        Collider::round_cuboid(0.3, 0.2, 0.4, 0.1),
    ]
}

/// Bodies of all kinds and shapes, all of them sensors, so that Rapier has a verdict on each pair.
fn spawn_scene(app: &mut App) {
    let mut random = fastrand::Rng::with_seed(7);
    let mut unit = || Vec3::from_array(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
    let sensor = || (rapier::Sensor, rapier::ActiveCollisionTypes::all());
    let mut place = |app: &mut App, collider, more: &mut dyn FnMut(&mut EntityWorldMut, Vec3)| {
        let turned = Quat::from_scaled_axis(unit() * 3.0);
        let transform =
            Transform::from_translation(unit() * Vec3::new(4.0, 3.0, 4.0)).with_rotation(turned);
        let mut entity = app
            .world_mut()
            .spawn((collider, ShapeFromRapier, transform, sensor()));
        more(&mut entity, unit());
    };
    for collider in some_shapes()
        .into_iter()
        .flat_map(|collider| vec![collider; 3])
    {
        let velocity = |v: Vec3| rapier::Velocity {
            linear: v * 3.0,
            angular: v.zxy() * 4.0,
        };
        place(app, collider.clone(), &mut |body, v| {
            body.insert((RigidBody::Dynamic, velocity(v), rapier::GravityScale(0.2)));
        });
        place(app, collider.clone(), &mut |body, v| {
            body.insert((RigidBody::KinematicVelocityBased, velocity(v)));
        });
        place(app, collider.clone(), &mut |body, v| {
            body.insert((RigidBody::KinematicPositionBased, Driven(v * STEP)));
        });
    }
    let grid: Vec<_> = (0..36)
        .map(|i| {
            Vec3::new(
                (i % 6) as f32 - 2.5,
                (i % 5) as f32 * 0.1,
                (i / 6) as f32 - 2.5,
            )
        })
        .collect();
    let triangles = (0..30)
        .filter(|i| i % 6 != 5)
        .flat_map(|i| [[i, i + 6, i + 1], [i + 1, i + 6, i + 7]])
        .collect();
    let mesh = Collider::trimesh(grid, triangles).expect("the mesh is fine");
    let heights = (0..25).map(|i| (i % 7) as f32 * 0.1).collect();
    let field = Collider::heightfield(heights, 5, 5, Vec3::new(6.0, 1.0, 6.0));
    for (collider, y) in [(mesh, -1.0), (field, 1.0)] {
        app.world_mut().spawn((
            collider,
            ShapeFromRapier,
            Transform::from_xyz(0.0, y, 0.0),
            RigidBody::Fixed,
            sensor(),
        ));
    }
    let slope = Transform::from_xyz(0.0, -3.0, 0.0).with_rotation(Quat::from_rotation_z(0.3));
    let ground = Collider::halfspace(Vec3::Y).expect("the normal has a length");
    app.world_mut()
        .spawn((ground, ShapeFromRapier, slope, RigidBody::Fixed, sensor()));
    app.add_systems(PreUpdate, |mut driven: Query<(&Driven, &mut Transform)>| {
        for (by, mut transform) in &mut driven {
            transform.translation += by.0;
            transform.rotate_local_x(0.02);
        }
    });
}

/// A kinematic body that the game moves.
#[derive(Component)]
struct Driven(Vec3);

#[test]
fn each_tick_contacts_are_those_of_rapier() {
    let apps = [
        app_in(PostUpdate, PostUpdate),
        app_in(FixedUpdate, FixedUpdate),
        fixed_app(),
    ];
    for mut app in apps {
        spawn_scene(&mut app);
        // Rapier's bodies begin to move in the first step, and it looks for contacts before.
        tick(&mut app, 2);
        let (mut seen, mut changes) = (0, 0);
        for _ in 0..120 {
            let verdicts = Verdicts::of_this_tick(&mut app);
            seen += verdicts.ours.len();
            tick(&mut app, 1);
            verdicts.compare(&mut app);
            changes += counters(&app).started + counters(&app).ended;
        }
        assert!(
            seen > 120 * 20 && changes > 200,
            "much happens: {seen} contacts, {changes} changes"
        );
    }
}

#[test]
fn a_shape_comes_changes_and_goes_with_its_collider() {
    let mut app = fixed_app();
    let probe = app
        .world_mut()
        .spawn((
            CollisionShape::sphere(0.1),
            Transform::from_xyz(2.0, 0.0, 0.0),
        ))
        .id();
    let stranger = app
        .world_mut()
        .spawn((Collider::ball(3.0), Transform::default()))
        .id();
    let entity = spawn(&mut app, Collider::ball(1.0), Vec3::ZERO, ());
    let touches = |app: &mut App| {
        tick(app, 1);
        assert!(app.world().get::<CollisionShape>(stranger).is_none());
        contacts(app) == [pair(probe, entity)]
    };
    assert!(!touches(&mut app));
    assert!(app.world().get::<CollisionShape>(entity).is_some());
    // Another collider.
    app.world_mut()
        .entity_mut(entity)
        .insert(Collider::ball(2.5));
    assert!(touches(&mut app));
    // Another scale: of the entity, and of the collider alone.
    get_mut::<Transform>(&mut app, entity).scale = Vec3::splat(0.5);
    assert!(!touches(&mut app));
    app.world_mut()
        .entity_mut(entity)
        .insert(rapier::ColliderScale::Absolute(Vec3::ONE));
    assert!(touches(&mut app));
    // Another shape, written in place.
    get_mut::<Collider>(&mut app, entity).raw = Collider::cuboid(1.0, 1.0, 1.0).raw;
    assert!(!touches(&mut app));
    get_mut::<Collider>(&mut app, entity).raw = Collider::cuboid(2.0, 1.0, 1.0).raw;
    assert!(touches(&mut app));
    // Without its collider it is out at once, and with one in again.
    app.world_mut().entity_mut(entity).remove::<Collider>();
    assert!(app.world().get::<CollisionShape>(entity).is_none());
    assert_eq!(index(&app).proxies().len(), 1);
    assert!(!touches(&mut app));
    app.world_mut()
        .entity_mut(entity)
        .insert(Collider::ball(2.5));
    assert!(touches(&mut app));
    // Changed while it is disabled.
    app.world_mut()
        .entity_mut(entity)
        .insert((Disabled, Collider::ball(1.0)));
    assert!(!touches(&mut app));
    app.world_mut().entity_mut(entity).remove::<Disabled>();
    assert!(!touches(&mut app));
    app.world_mut()
        .entity_mut(entity)
        .insert(Collider::ball(2.5));
    assert!(touches(&mut app));
    // The marker decides.
    app.world_mut()
        .entity_mut(entity)
        .remove::<ShapeFromRapier>();
    assert!(app.world().get::<CollisionShape>(entity).is_none());
    assert!(!touches(&mut app));
    app.world_mut().entity_mut(entity).insert(ShapeFromRapier);
    assert!(touches(&mut app));
    app.world_mut().despawn(entity);
    assert!(!touches(&mut app));
    assert_eq!(messages_about(&app, pair(probe, entity)), (6, 6));
}

#[test]
fn a_collider_that_is_as_it_was_is_no_change() {
    let mut app = fixed_app();
    let entity = spawn(&mut app, Collider::ball(1.0), Vec3::ZERO, ());
    tick(&mut app, 2);
    get_mut::<Collider>(&mut app, entity).set_changed();
    tick(&mut app, 1);
    assert_eq!(counters(&app).moved, 0);
}

#[test]
fn every_collider_takes_part_if_told_so() {
    let mut app = app_of(
        PostUpdate,
        PostUpdate,
        RapierInteropPlugin::default().for_all_colliders(),
    );
    let [a, b, c] = [0.0, 1.0, 1.5].map(|x| {
        app.world_mut()
            .spawn((Collider::ball(1.0), Transform::from_xyz(x, 0.0, 0.0)))
            .id()
    });
    app.world_mut().entity_mut(c).remove::<ShapeFromRapier>();
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(a, b)]);
}

#[test]
fn no_collider_is_taken_up_before_rapier_has_scaled_it() {
    // This crate comes before Rapier.
    let mut app = app_in(PostUpdate, FixedPostUpdate);
    let entity = app
        .world_mut()
        .spawn((Collider::cuboid(1.0, 1.0, 1.0), ShapeFromRapier))
        .id();
    app.world_mut()
        .entity_mut(entity)
        .insert(Transform::from_scale(Vec3::new(3.0, 1.0, 1.0)));
    tick(&mut app, 1);
    assert!(app.world().get::<CollisionShape>(entity).is_none());
    tick(&mut app, 1);
    let aabb = get::<WorldAabb>(&app, entity);
    assert!(
        (Vec3::from(aabb.max) - Vec3::new(3.0, 1.0, 1.0)).length() < 1e-3,
        "{aabb:?}"
    );
}

#[test]
fn in_another_schedule_contacts_are_a_frame_late() {
    for (mut app, late) in [(fixed_app(), 0), (app_in(PostUpdate, FixedPostUpdate), 1)] {
        let speed = rapier::Velocity::linear(Vec3::X * TICKS_PER_SECOND);
        spawn(
            &mut app,
            Collider::ball(0.4),
            Vec3::ZERO,
            (RigidBody::KinematicVelocityBased, speed),
        );
        spawn(
            &mut app,
            Collider::ball(0.4),
            Vec3::X * 5.0,
            RigidBody::Fixed,
        );
        // Five steps of length 1.
        tick(&mut app, 4 + late);
        assert!(contacts(&app).is_empty());
        tick(&mut app, 1);
        assert_eq!(contacts(&app).len(), 1);
    }
}

#[test]
fn a_bounce_changes_the_velocity_that_rapier_moves_by() {
    let reflect = Bounce::Reflect { restitution: 0.5 };
    for (bounce, after) in [
        (Bounce::Reverse, Vec3::new(-1.0, -0.5, 0.0)),
        (reflect, Vec3::new(-0.5, 0.5, 0.0)),
    ] {
        for mut app in [app_in(PostUpdate, PostUpdate), fixed_app()] {
            let wall = CollisionShape::from_half_size(Vec3::new(1.0, 9.0, 9.0));
            app.world_mut()
                .spawn((wall, Transform::from_xyz(3.0, 0.0, 0.0)));
            let velocity = rapier::Velocity {
                linear: Vec3::new(1.0, 0.5, 0.0) * 16.0,
                angular: Vec3::Y,
            };
            let more = (RigidBody::KinematicVelocityBased, velocity, bounce);
            let ball = spawn(&mut app, Collider::ball(0.5), Vec3::ZERO, more);
            // A quarter per tick: it touches after six.
            tick(&mut app, 5);
            assert_eq!(get::<rapier::Velocity>(&app, ball), &velocity);
            assert!(
                (get::<Transform>(&app, ball).translation - Vec3::new(1.25, 0.625, 0.0)).length()
                    < 1e-4
            );
            tick(&mut app, 1);
            let found = get::<rapier::Velocity>(&app, ball);
            assert!((found.linear - after * 16.0).length() < 1e-3, "{found:?}");
            assert_eq!((found.angular, counters(&app).bounces), (Vec3::Y, 1));
            tick(&mut app, 4);
            let expected = Vec3::new(1.5, 0.75, 0.0) + after;
            assert!((get::<Transform>(&app, ball).translation - expected).length() < 1e-3);
            // Rapier's velocity is the one that counts.
            get_mut::<rapier::Velocity>(&mut app, ball).linear = Vec3::ZERO;
            tick(&mut app, 2);
            assert_eq!(get::<Velocity>(&app, ball).0, Vec3::ZERO);
            app.world_mut()
                .entity_mut(ball)
                .remove::<rapier::Velocity>();
            assert!(
                app.world().get::<Velocity>(ball).is_none()
                    && app.world().get::<MovedElsewhere>(ball).is_none()
            );
        }
    }
}

#[test]
fn a_velocity_of_ours_moves_a_kinematic_body() {
    let mut app = fixed_app();
    let velocity = Velocity(Vec3::X * TICKS_PER_SECOND);
    let more = (RigidBody::KinematicPositionBased, velocity, Bounce::Reverse);
    let body = spawn(&mut app, Collider::ball(0.5), Vec3::ZERO, more);
    tick(&mut app, 8);
    assert_eq!(get::<Transform>(&app, body).translation, Vec3::X * 8.0);
    assert!(app.world().get::<MovedElsewhere>(body).is_none());
}

/// Rapier moves it, as fast as it moves anything, sixty times its size per step: it is met on the
/// way, and told to turn around.
#[test]
fn what_rapier_moves_is_swept_too() {
    let mut app = fixed_app();
    let paper = spawn(
        &mut app,
        Collider::cuboid(0.001, 5.0, 5.0),
        Vec3::X * 2.0,
        rapier::Sensor,
    );
    let start = rapier::Velocity::linear(Vec3::X * 400.0);
    let body = (
        RigidBody::KinematicVelocityBased,
        start,
        rapier::Sensor,
        Swept::default(),
    );
    let bounce = Bounce::Reflect { restitution: 1.0 };
    let bullet = spawn(
        &mut app,
        Collider::ball(0.05),
        Vec3::X * -20.0,
        (body, bounce),
    );
    let mut met = Vec::new();
    for n in 1..=4 {
        tick(&mut app, 1);
        if !contacts(&app).is_empty() {
            assert_eq!(contacts(&app), [pair(paper, bullet)]);
            met.push((
                n,
                get::<Transform>(&app, bullet).translation.x,
                get::<rapier::Velocity>(&app, bullet).linear.x,
            ));
        }
    }
    let [(4, x, speed)] = met[..] else {
        panic!("{met:?}")
    };
    assert!(
        x > 2.1 && speed < 0.0,
        "Rapier has the last word on where it is, we on where it goes: {met:?}"
    );
}

/// A bullet and a floor without an end.
#[test]
fn what_is_swept_bounces_off_half_spaces() {
    let mut app = app(BroadPhaseMethod::default());
    let floor = app.world_mut().spawn(half_space()).id();
    let bounce = Bounce::Reflect { restitution: 1.0 };
    let velocity = Velocity(Vec3::new(30.0, -100.0, 0.0) * TICKS_PER_SECOND);
    let bullet = ball(
        &mut app,
        Vec3::Y * 40.0,
        (Swept::default(), velocity, bounce),
    );
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(floor, bullet)]);
    let end = get::<Transform>(&app, bullet).translation;
    let radius = 0.5;
    assert!(
        end.distance(Vec3::new(30.0, 60.0 + 2.0 * radius, 0.0)) < 1e-2,
        "{end}"
    );
}

fn half_space() -> CollisionShape {
    Shape::from(&Collider::halfspace(Vec3::Y).unwrap()).into()
}

fn ball(app: &mut App, at: Vec3, more: impl Bundle) -> Entity {
    app.world_mut()
        .spawn((
            CollisionShape::sphere(0.5),
            Transform::from_translation(at),
            more,
        ))
        .id()
}

#[test]
fn half_spaces_meet_what_brute_force_says_by_every_method() {
    for method in ["auto", "linear", "object", "exhaustive"] {
        let mut app = app(method.parse().unwrap());
        let mut random = fastrand::Rng::with_seed(3);
        for i in 0..90 {
            let at = Vec3::from_array(std::array::from_fn(|_| random.f32() * 20.0 - 10.0));
            let entity = ball(&mut app, at, ());
            if i % 3 > 0 {
                app.world_mut()
                    .entity_mut(entity)
                    .insert(Velocity((at.zxy() * 0.3).round()));
            }
        }
        let slopes: Vec<_> = (0..3)
            .map(|i| {
                let turned = Quat::from_euler(EulerRot::XYZ, i as f32, 0.5, 0.0);
                let at = Transform::from_xyz(0.0, -4.0, i as f32 * 3.0).with_rotation(turned);
                app.world_mut().spawn((half_space(), at)).id()
            })
            .collect();
        for step in 0..60 {
            match step {
                10 | 20 => {
                    get_mut::<Transform>(&mut app, slopes[step / 20])
                        .translation
                        .y += 2.0;
                }
                30 => {
                    app.world_mut().despawn(slopes[1]);
                    app.world_mut()
                        .spawn((half_space(), Transform::from_xyz(0.0, -8.0, 0.0)));
                }
                // A box from now on; and no longer.
                40 => get_mut::<CollisionShape>(&mut app, slopes[2]).0 = Shape::sphere(4.0),
                50 => *get_mut::<CollisionShape>(&mut app, slopes[2]) = half_space(),
                _ => {}
            }
            tick(&mut app, 1);
            assert_eq!(
                contacts(&app),
                brute_force_contacts(&mut app),
                "{method}, step {step}"
            );
        }
    }
}

#[test]
fn what_touches_a_half_space_meets_it_far_from_anywhere() {
    let mut random = fastrand::Rng::with_seed(5);
    for far in [1.0, 100.0, 10_000.0] {
        let mut app = app(BroadPhaseMethod::default());
        let mut unit = || Vec3::from_array(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
        let turned = Quat::from_scaled_axis(unit() * 3.0);
        let slope = Transform::from_translation(unit() * far).with_rotation(turned);
        app.world_mut().spawn((half_space(), slope));
        for _ in 0..300 {
            let (along, gap) = (unit() * far, unit().y * 3e-4);
            let entity = ball(&mut app, slope * Vec3::new(along.x, 0.5 + gap, along.z), ());
            // Boxes of the balls would touch.
            app.world_mut().entity_mut(entity).insert(StaticShape);
        }
        tick(&mut app, 1);
        let found = contacts(&app);
        assert!((50..250).contains(&found.len()), "{} contacts", found.len());
        let ground = found[0][0];
        let expected = brute_force_contacts(&mut app)
            .into_iter()
            .filter(|pair| pair.contains(&ground));
        assert_eq!(found, expected.collect::<Vec<_>>());
    }
}

#[test]
fn contacts_with_a_half_space_rest_and_end_like_others() {
    let mut app = app(BroadPhaseMethod::default());
    let ground = app
        .world_mut()
        .spawn((half_space(), Transform::default()))
        .id();
    let entity = ball(&mut app, Vec3::new(1e4, 0.25, 0.0), ());
    let other = ball(&mut app, Vec3::Y * 9.0, ());
    tick(&mut app, 1);
    assert_eq!(
        (contacts(&app), counters(&app).objects),
        (vec![pair(ground, entity)], 3)
    );
    // Nothing moves: nothing is tested, the contact stays, and is not told again.
    tick(&mut app, 1);
    assert_eq!(
        (counters(&app).candidates, counters(&app).resting_pairs),
        (0, 1)
    );
    // Another one moves, out of reach of the plane: no exact test.
    get_mut::<Transform>(&mut app, other).translation.x = 1.0;
    tick(&mut app, 1);
    assert_eq!((counters(&app).candidates, contacts(&app).len()), (0, 1));
    assert_eq!(messages_about(&app, pair(ground, entity)), (1, 0));
    // Off and on.
    app.world_mut().entity_mut(ground).insert(Disabled);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut().entity_mut(ground).remove::<Disabled>();
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, pair(ground, entity)), (2, 1));
    // Layers and static entities.
    app.world_mut()
        .entity_mut(ground)
        .insert((StaticShape, CollisionLayers::ALL));
    tick(&mut app, 1);
    assert_eq!(contacts(&app).len(), 1);
    app.world_mut().entity_mut(entity).insert(StaticShape);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut().entity_mut(entity).remove::<StaticShape>();
    tick(&mut app, 1);
    assert_eq!(contacts(&app).len(), 1);
    app.world_mut()
        .entity_mut(ground)
        .insert(CollisionLayers::NONE);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    app.world_mut()
        .entity_mut(ground)
        .remove::<CollisionLayers>();
    tick(&mut app, 1);
    // A place that is none.
    get_mut::<Transform>(&mut app, ground).translation.y = f32::NAN;
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty() && index(&app).proxies().unbounded().next().is_none());
    get_mut::<Transform>(&mut app, ground).translation.y = 0.0;
    tick(&mut app, 1);
    assert_eq!(messages_about(&app, pair(ground, entity)), (5, 4));
    app.world_mut().despawn(ground);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    assert_eq!(messages_about(&app, pair(ground, entity)), (5, 5));
}

#[test]
fn queries_see_half_spaces() {
    let mut app = app(BroadPhaseMethod::default());
    let ground = app
        .world_mut()
        .spawn((half_space(), Transform::from_xyz(0.0, -1.0, 0.0)))
        .id();
    let entity = ball(&mut app, Vec3::new(0.0, -5.0, 0.0), ());
    tick(&mut app, 1);
    let ask = move |spatial: SpatialQuery| {
        let all = SpatialQueryFilter::DEFAULT;
        let down = |x: f32| Ray3d::new(Vec3::new(x, 1.0, 0.0), Dir3::NEG_Y);
        let hit = spatial.cast_ray(down(0.0), 100.0, &all).unwrap();
        assert_eq!(
            (hit.entity, hit.distance, hit.normal),
            (ground, 2.0, Vec3::Y)
        );
        let hit = spatial.cast_ray(down(1e4), 100.0, &all).unwrap();
        assert_eq!((hit.entity, hit.distance), (ground, 2.0));
        assert!(spatial.cast_ray(down(0.0), 1.5, &all).is_none());
        let below = SpatialQueryFilter::DEFAULT.except(ground);
        assert_eq!(
            spatial
                .cast_ray(down(0.0), 100.0, &below)
                .map(|hit| hit.entity),
            Some(entity)
        );
        let hit = spatial
            .cast_sphere(Vec3::Y, 0.5, Dir3::NEG_Y, 100.0, &all)
            .unwrap();
        assert!(
            hit.entity == ground && (hit.distance - 1.5).abs() < 1e-4,
            "{hit:?}"
        );
        let brick = CollisionShape::from_half_size(Vec3::splat(0.5));
        let start = Transform::from_xyz(7.0, 1.0, 0.0);
        let hit = spatial
            .cast_shape(&brick, &start, Dir3::NEG_Y, 100.0, &all)
            .unwrap();
        assert!(
            hit.entity == ground && (hit.distance - 1.5).abs() < 1e-4,
            "{hit:?}"
        );
        let near = spatial
            .nearest(Vec3::new(3.0, 2.0, 0.0), 100.0, &all)
            .unwrap();
        assert_eq!(
            (near.entity, near.distance, near.point),
            (ground, 3.0, Vec3::new(3.0, -1.0, 0.0))
        );
        assert!(spatial.nearest(Vec3::Y * 2.0, 2.0, &all).is_none());
        let mut found = vec![];
        spatial
            .for_each_sphere_intersection(Vec3::X * 50.0, 0.9, &all, |entity| found.push(entity));
        assert!(found.is_empty());
        spatial
            .for_each_sphere_intersection(Vec3::X * 50.0, 1.1, &all, |entity| found.push(entity));
        spatial.for_each_point_intersection(Vec3::Y * -5.0, &all, |entity| found.push(entity));
        let count = |of| found.iter().filter(|entity| **entity == of).count();
        assert_eq!((found.len(), count(ground), count(entity)), (3, 2, 1));
    };
    app.world_mut()
        .run_system_once(ask)
        .expect("the system runs");
}

#[test]
fn compounds_meshes_and_fields_are_what_they_look_like() {
    let mut app = fixed_app();
    let bars = [-2.0, 2.0].map(|x| (Vec3::X * x, Quat::IDENTITY, Collider::cuboid(0.5, 2.0, 0.5)));
    let gate = spawn(&mut app, Collider::compound(bars.into()), Vec3::ZERO, ());
    let flat = vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Z * 2.0];
    let mesh = spawn(
        &mut app,
        Collider::trimesh(flat, vec![[0, 1, 2]]).unwrap(),
        Vec3::Y * 10.0,
        (),
    );
    let field = Collider::heightfield(vec![0.0; 4], 2, 2, Vec3::splat(4.0));
    let field = spawn(&mut app, field, Vec3::Y * 20.0, ());
    let probe = ball(&mut app, Vec3::Y * 100.0, ());
    tick(&mut app, 1);
    let mut touches = |at: Vec3, scale: f32| {
        get_mut::<Transform>(&mut app, probe).translation = at;
        get_mut::<Transform>(&mut app, gate).scale = Vec3::splat(scale);
        tick(&mut app, 1);
        contacts(&app)
            .into_iter()
            .flatten()
            .find(|entity| *entity != probe)
    };
    assert_eq!(touches(Vec3::ZERO, 1.0), None);
    assert_eq!(touches(Vec3::X * 1.1, 1.0), Some(gate));
    assert_eq!(touches(Vec3::X * 1.1, 2.0), None);
    assert_eq!(touches(Vec3::X * 4.0, 2.0), Some(gate));
    assert_eq!(touches(Vec3::new(0.5, 10.4, 0.5), 1.0), Some(mesh));
    assert_eq!(
        touches(Vec3::new(2.0, 10.4, 2.0), 1.0),
        None,
        "in its box, past its edge"
    );
    assert_eq!(touches(Vec3::new(1.0, 20.4, -1.0), 1.0), Some(field));
    assert_eq!(touches(Vec3::new(1.0, 21.0, -1.0), 1.0), None);
    // Scaled to nothing along an axis.
    get_mut::<Transform>(&mut app, gate).scale = Vec3::new(1.0, 0.0, 1.0);
    get_mut::<Transform>(&mut app, probe).translation = Vec3::new(2.0, 0.4, 0.0);
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(gate, probe)]);
}

#[test]
fn what_parry_does_not_support_is_apart() {
    let mut app = fixed_app();
    let up = || Collider::halfspace(Vec3::Y).unwrap();
    spawn(&mut app, up(), Vec3::ZERO, ());
    spawn(&mut app, up(), Vec3::ZERO, ());
    let ball = spawn(&mut app, Collider::ball(1.0), Vec3::ZERO, ());
    tick(&mut app, 2);
    assert_eq!(contacts(&app).len(), 2);
    assert!(contacts(&app).iter().all(|pair| pair.contains(&ball)));
}

#[test]
fn an_observer_may_despawn_what_rapier_knows() {
    let mut app = fixed_app();
    let more = (RigidBody::Dynamic, rapier::Sensor, CollisionEventsEnabled);
    let falling = spawn(
        &mut app,
        Collider::ball(0.5),
        Vec3::new(3.0, 1.0, 0.0),
        more,
    );
    let floor = spawn(
        &mut app,
        Collider::halfspace(Vec3::Y).unwrap(),
        Vec3::ZERO,
        rapier::Sensor,
    );
    app.world_mut().entity_mut(falling).observe(
        |event: On<CollisionStarted>, mut commands: Commands| {
            let contact = event.contact.expect("events have one");
            assert!(
                (contact.normal - Vec3::NEG_Y).length() < 1e-4
                    && (contact.point.x - 3.0).abs() < 1e-4
            );
            commands.entity(event.a).despawn();
        },
    );
    tick(&mut app, 60);
    assert!(app.world().get_entity(falling).is_err());
    assert_eq!(messages_about(&app, pair(falling, floor)), (1, 1));
    assert!(contacts(&app).is_empty());
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Elsewhere;

#[test]
fn the_plugin_may_be_added_first_and_goes_where_the_ticks_are() {
    let mut app = App::new();
    app.init_schedule(Elsewhere)
        .insert_resource(rapier::TimestepMode::Fixed {
            dt: STEP,
            substeps: 1,
        })
        .add_plugins((
            RapierInteropPlugin::default(),
            MinimalPlugins,
            TransformPlugin,
        ))
        .add_plugins((
            OctreePlugins::new(Elsewhere),
            RapierPhysicsPlugin::<()>::default(),
        ));
    assert_eq!(warnings(|| app.finish()), 0);
    app.cleanup();
    let still = (RigidBody::Fixed, rapier::Sensor);
    let a = spawn(&mut app, Collider::ball(1.0), Vec3::ZERO, still);
    let b = spawn(
        &mut app,
        Collider::ball(1.0),
        Vec3::X,
        (still, Bounce::default(), rapier::Velocity::default()),
    );
    app.update();
    assert!(
        app.world().get::<CollisionShape>(a).is_none(),
        "no tick has been made"
    );
    app.world_mut().run_schedule(Elsewhere);
    assert_eq!(contacts(&app), [pair(a, b)]);
    assert!(
        app.world().entity(b).contains::<MovedElsewhere>(),
        "velocities are in step, too"
    );
}

#[test]
fn the_plugin_without_ticks_says_so() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        RapierInteropPlugin::default(),
    ));
    app.add_plugins(RapierPhysicsPlugin::<()>::default());
    assert_eq!(warnings(|| app.finish()), 1);
}
