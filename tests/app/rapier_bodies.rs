//! Bodies that Rapier moves: what they rest on, and how fast they count when something of ours
//! meets them.

use crate::{common, rapier::spawn};

use std::sync::Arc;

use bevy::{
    ecs::{entity_disabling::Disabled, system::RunSystemOnce},
    prelude::*,
};
use bevy_octree::{narrow_phase::Shape, prelude::*};
use bevy_rapier3d::{
    parry::{
        bounding_volume::{Aabb, BoundingSphere},
        mass_properties::MassProperties,
        math::IVector,
        query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection},
        shape::{self, Ball, FeatureId, SharedShape},
    },
    prelude as rapier,
    prelude::{Collider, RapierPhysicsPlugin, RigidBody},
};
use common::{
    warnings::{on_this_thread, told},
    *,
};

/// An app in which Rapier and this crate make one step per update.
fn rapier_app() -> App {
    let mut app = app_with(
        (
            TransformPlugin,
            OctreePlugins::default(),
            RapierInteropPlugin::default(),
        ),
        FixedPostUpdate,
    );
    app.insert_resource(rapier::TimestepMode::Fixed {
        dt: 1.0 / TICKS_PER_SECOND,
        substeps: 1,
    })
    .add_plugins(RapierPhysicsPlugin::<()>::default().in_schedule(FixedUpdate));
    app.finish();
    app.cleanup();
    app
}

fn voxels() -> Collider {
    let cells: Vec<_> = (-6..6)
        .flat_map(|x| (-6..6).map(move |z| IVector::new(x, -1, z)))
        .collect();
    SharedShape::voxels(Vec3::ONE, &cells).into()
}

#[test]
fn what_rests_on_a_floor_is_in_contact_with_it_whatever_the_two_are() {
    let flat = Collider::heightfield(vec![0.0; 81], 9, 9, Vec3::new(20.0, 1.0, 20.0));
    let heights = (0..81).map(|i| ((i * 13) % 7) as f32 * 0.15).collect();
    let hills = Collider::heightfield(heights, 9, 9, Vec3::new(20.0, 1.0, 20.0));
    let hull: Vec<_> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5)
        .collect();
    let bodies = [
        Collider::ball(0.5),
        Collider::cuboid(0.5, 0.5, 0.5),
        Collider::capsule_x(0.5, 0.3),
        Collider::cylinder(0.5, 0.4),
        Collider::cone(0.5, 0.4),
        Collider::convex_hull(&hull).expect("it has a volume"),
        Collider::round_cuboid(0.4, 0.4, 0.4, 0.1),
        Collider::compound(vec![(
            Vec3::ZERO,
            Quat::IDENTITY,
            Collider::cuboid(0.5, 0.5, 0.5),
        )]),
    ];
    for floor in [flat, hills, voxels()] {
        let mut app = rapier_app();
        let ground = spawn(&mut app, floor, Vec3::ZERO, RigidBody::Fixed);
        let bodies: Vec<_> = bodies
            .iter()
            .enumerate()
            .map(|(i, body)| {
                let at = Vec3::new((i % 3) as f32 * 3.0 - 3.1, 1.2, (i / 3) as f32 * 3.0 - 2.9);
                spawn(
                    &mut app,
                    body.clone(),
                    at,
                    (RigidBody::Dynamic, rapier::Sleeping::disabled()),
                )
            })
            .collect();
        tick(&mut app, 200);
        let mut seen = vec![0; bodies.len()];
        for _ in 0..100 {
            tick(&mut app, 1);
            let found = contacts(&app);
            for (body, seen) in bodies.iter().zip(&mut seen) {
                *seen += usize::from(found.contains(&pair(ground, *body)));
            }
        }
        // What rolls off a hill may hop for a tick.
        assert!(seen.iter().all(|seen| *seen >= 95), "{seen:?}");
    }
}

#[test]
fn shapes_of_ours_touch_height_fields_and_voxels() {
    let heights = vec![0.0; 81];
    let field = Collider::heightfield(heights, 9, 9, Vec3::new(20.0, 1.0, 20.0));
    let corners: Vec<_> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5)
        .collect();
    let faces = SIDES;
    let shapes = [
        CollisionShape::try_sphere(0.5),
        CollisionShape::try_from_half_size(Vec3::splat(0.5)),
        Shape::mesh(corners.clone(), faces).map(CollisionShape),
        Shape::convex(corners, faces).map(CollisionShape),
    ];
    for floor in [field, voxels()] {
        for shape in shapes.clone().map(|shape| shape.expect("it is fine")) {
            let mut app = rapier_app();
            let ground = spawn(&mut app, floor.clone(), Vec3::ZERO, ());
            let events = CollisionEventsEnabled;
            let probe = app
                .world_mut()
                .spawn((shape, Transform::from_xyz(1.3, 0.49, 0.7), events))
                .id();
            tick(&mut app, 2);
            assert_eq!(contacts(&app), [pair(ground, probe)]);
            let found = app
                .world()
                .resource::<Contacts>()
                .iter()
                .next()
                .expect("there is one");
            let geometry = found.contact.expect("somebody asked");
            assert!(
                geometry.depth < 1.0 && geometry.normal.is_normalized(),
                "{geometry:?}"
            );
            get_mut::<Transform>(&mut app, probe).translation.y = 0.51;
            tick(&mut app, 1);
            assert!(contacts(&app).is_empty());
        }
    }
}

/// A shape that somebody else made: a ball that nothing is known of but how rays and points meet
/// it.
#[derive(Clone, Debug)]
struct Unheard(Ball);

impl RayCast for Unheard {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max: f32,
        solid: bool,
    ) -> Option<RayIntersection> {
        self.0.cast_local_ray_and_get_normal(ray, max, solid)
    }
}

impl PointQuery for Unheard {
    fn project_local_point(&self, point: Vec3, solid: bool) -> PointProjection {
        self.0.project_local_point(point, solid)
    }
    fn project_local_point_and_get_feature(&self, point: Vec3) -> (PointProjection, FeatureId) {
        self.0.project_local_point_and_get_feature(point)
    }
}

impl shape::Shape for Unheard {
    fn compute_local_aabb(&self) -> Aabb {
        self.0.compute_local_aabb()
    }
    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        self.0.compute_local_bounding_sphere()
    }
    fn clone_dyn(&self) -> Box<dyn shape::Shape> {
        Box::new(self.clone())
    }
    fn scale_dyn(&self, _: Vec3, _: u32) -> Option<Box<dyn shape::Shape>> {
        None
    }
    fn mass_properties(&self, density: f32) -> MassProperties {
        shape::Shape::mass_properties(&self.0, density)
    }
    fn shape_type(&self) -> shape::ShapeType {
        shape::ShapeType::Custom
    }
    fn as_typed_shape(&self) -> shape::TypedShape<'_> {
        shape::TypedShape::Custom(self)
    }
    fn ccd_thickness(&self) -> f32 {
        self.0.radius
    }
    fn ccd_angular_thickness(&self) -> f32 {
        0.0
    }
}

#[test]
fn a_pair_that_nothing_is_known_of_is_told_once_with_both_entities() {
    let mut entities = None;
    let told = told(|| {
        let mut app = app(BroadPhaseMethod::default());
        // Who listens hears this thread alone.
        on_this_thread(&mut app, FixedPostUpdate);
        let unheard = || CollisionShape::from(SharedShape(Arc::new(Unheard(Ball::new(0.5)))));
        let [near, far] = [0.0, 100.0].map(|x| {
            app.world_mut()
                .spawn((unheard(), Transform::from_xyz(x, 0.0, 0.0)))
                .id()
        });
        let cube = CollisionShape::from_half_size(Vec3::splat(0.5));
        let other = app
            .world_mut()
            .spawn((cube, Transform::from_xyz(0.2, 0.0, 0.0)))
            .id();
        for _ in 0..4 {
            tick(&mut app, 1);
            get_mut::<Transform>(&mut app, other).translation.x += 0.01;
        }
        assert!(contacts(&app).is_empty());
        let ray = |spatial: SpatialQuery| {
            let ray = Ray3d::new(Vec3::new(100.0, 5.0, 0.0), Dir3::NEG_Y);
            spatial
                .cast_ray(ray, 100.0, &SpatialQueryFilter::DEFAULT)
                .map(|hit| (hit.entity, hit.distance))
        };
        assert_eq!(
            app.world_mut()
                .run_system_once(ray)
                .expect("the system runs"),
            Some((far, 4.5))
        );
        entities = Some((near, other));
    });
    let (a, b) = entities.expect("it was run");
    let [message] = &told[..] else {
        panic!("{told:?}")
    };
    assert!(
        message.contains(&a.to_string()) && message.contains(&b.to_string()),
        "{message}"
    );
}

const REFLECT: Bounce = Bounce::Reflect { restitution: 1.0 };

/// A ball of ours that flies along the first axis, until its velocity changes: what to?
fn flies_against(app: &mut App, from: f32, speed: f32, more: impl Bundle) -> f32 {
    let flying = (
        CollisionShape::sphere(0.5),
        Velocity(Vec3::X * speed),
        REFLECT,
    );
    let ball = app
        .world_mut()
        .spawn((flying, Transform::from_xyz(from, 0.0, 0.0), more))
        .id();
    for _ in 0..120 {
        tick(app, 1);
        let after = get::<Velocity>(app, ball).0;
        if after != Vec3::X * speed {
            assert!(after.yz().length() < 1e-3, "{after}");
            app.world_mut().despawn(ball);
            return after.x;
        }
    }
    panic!("it meets nothing");
}

/// A wall that Rapier moves.
fn wall(app: &mut App, x: f32, speed: f32, more: impl Bundle) -> Entity {
    let velocity = rapier::Velocity::linear(Vec3::X * speed);
    spawn(
        app,
        Collider::cuboid(1.0, 1.0, 1.0),
        Vec3::X * x,
        (RigidBody::KinematicVelocityBased, velocity, more),
    )
}

#[test]
fn a_wall_of_rapiers_counts_with_its_velocity_whether_it_bounces_or_not() {
    let close = |found: f32, expected: f32| {
        assert!((found - expected).abs() < 1e-3, "{found}, not {expected}");
    };
    let mut app = rapier_app();
    wall(&mut app, 8.0, -10.0, ());
    close(flies_against(&mut app, 0.0, 0.0, ()), -20.0);
    let mut app = rapier_app();
    wall(&mut app, 8.0, -10.0, ());
    close(flies_against(&mut app, 0.0, 4.0, Swept::default()), -24.0);
    // One that flees is caught up with.
    let mut app = rapier_app();
    wall(&mut app, 3.0, 2.0, ());
    close(flies_against(&mut app, 0.0, 10.0, ()), -6.0);
    // What Rapier does not move is at rest, whatever velocity it is given.
    for still in [RigidBody::Fixed, RigidBody::KinematicPositionBased] {
        let mut app = rapier_app();
        let entity = wall(&mut app, 3.0, -10.0, ());
        app.world_mut().entity_mut(entity).insert(still);
        close(flies_against(&mut app, 0.0, 4.0, ()), -4.0);
    }
    let mut app = rapier_app();
    wall(&mut app, 3.0, -10.0, rapier::RigidBodyDisabled);
    close(flies_against(&mut app, 0.0, 4.0, ()), -4.0);
    // From one kind to another, and back.
    let mut app = rapier_app();
    let entity = wall(&mut app, 40.0, -10.0, ());
    tick(&mut app, 2);
    app.world_mut().entity_mut(entity).insert(RigidBody::Fixed);
    get_mut::<Transform>(&mut app, entity).translation.x = 3.0;
    tick(&mut app, 2);
    close(flies_against(&mut app, 0.0, 4.0, ()), -4.0);
    app.world_mut()
        .entity_mut(entity)
        .insert(RigidBody::KinematicVelocityBased);
    get_mut::<rapier::Velocity>(&mut app, entity).linear = Vec3::X * -2.0;
    tick(&mut app, 2);
    close(flies_against(&mut app, -2.0, 4.0, ()), -8.0);
}

#[test]
fn a_body_that_does_not_bounce_any_more_counts_as_it_moves_now() {
    let mut app = rapier_app();
    let body = wall(&mut app, -50.0, 10.0, REFLECT);
    tick(&mut app, 3);
    assert_eq!(get::<Velocity>(&app, body).0, Vec3::X * 10.0);
    app.world_mut().entity_mut(body).remove::<Bounce>();
    get_mut::<rapier::Velocity>(&mut app, body).linear = Vec3::ZERO;
    get_mut::<Transform>(&mut app, body).translation = Vec3::X * 1.7;
    tick(&mut app, 3);
    assert!((flies_against(&mut app, -0.2, 4.0, ()) + 4.0).abs() < 1e-3);
    // Contacts do not change its velocity, and do again.
    get_mut::<rapier::Velocity>(&mut app, body).linear = Vec3::X * -4.0;
    tick(&mut app, 1);
    flies_against(&mut app, -1.0, 4.0, ());
    assert_eq!(get::<rapier::Velocity>(&app, body).linear, Vec3::X * -4.0);
    app.world_mut().entity_mut(body).insert(REFLECT);
    flies_against(&mut app, -3.0, 4.0, ());
    assert!((get::<rapier::Velocity>(&app, body).linear.x - 4.0).abs() < 1e-3);
}

#[test]
fn a_velocity_is_mirrored_while_it_is_of_use() {
    let is_mirrored = |app: &App, body: Entity| {
        let body = app.world().entity(body);
        assert_eq!(
            body.contains::<Velocity>(),
            body.contains::<MovedElsewhere>()
        );
        body.contains::<Velocity>()
    };
    let mut app = rapier_app();
    let body = wall(&mut app, 0.0, 1.0, REFLECT);
    let stranger = (
        RigidBody::KinematicVelocityBased,
        rapier::Velocity::linear(Vec3::X),
        Collider::ball(0.5),
    );
    let stranger = app.world_mut().spawn((stranger, Transform::default())).id();
    tick(&mut app, 1);
    assert!(
        is_mirrored(&app, body) && !is_mirrored(&app, stranger),
        "colliders that do not take part are left alone"
    );
    // By its collider, by its bounces, by neither.
    app.world_mut().entity_mut(body).remove::<Bounce>();
    assert!(is_mirrored(&app, body));
    app.world_mut().entity_mut(body).remove::<ShapeFromRapier>();
    assert!(!is_mirrored(&app, body));
    app.world_mut().entity_mut(body).insert(REFLECT);
    tick(&mut app, 1);
    assert!(is_mirrored(&app, body));
    app.world_mut().entity_mut(body).remove::<Bounce>();
    assert!(!is_mirrored(&app, body));
    app.world_mut().entity_mut(body).insert(ShapeFromRapier);
    tick(&mut app, 1);
    assert!(is_mirrored(&app, body));
    // Without a velocity, also while it is disabled.
    app.world_mut()
        .entity_mut(body)
        .remove::<rapier::Velocity>();
    assert!(!is_mirrored(&app, body));
    app.world_mut()
        .entity_mut(body)
        .insert((rapier::Velocity::linear(Vec3::Y), Disabled));
    tick(&mut app, 1);
    assert!(!is_mirrored(&app, body));
    app.world_mut().entity_mut(body).remove::<Disabled>();
    tick(&mut app, 1);
    assert!(is_mirrored(&app, body));
    app.world_mut().entity_mut(body).insert(Disabled);
    app.world_mut()
        .entity_mut(body)
        .remove::<rapier::Velocity>();
    assert!(!is_mirrored(&app, body));
    app.world_mut().entity_mut(body).remove::<Disabled>();
    app.world_mut()
        .entity_mut(body)
        .insert(rapier::Velocity::linear(Vec3::Y));
    tick(&mut app, 1);
    assert!(is_mirrored(&app, body));
    // Without its collider it takes part in nothing, and again with one.
    app.world_mut().entity_mut(body).remove::<Collider>();
    tick(&mut app, 2);
    assert!(app.world().get::<CollisionShape>(body).is_none());
    app.world_mut().entity_mut(body).insert(Collider::ball(0.5));
    tick(&mut app, 2);
    assert!(is_mirrored(&app, body) && app.world().get::<CollisionShape>(body).is_some());
    // A velocity of one's own is one's own.
    let own = Velocity(Vec3::X);
    let driven = (
        RigidBody::KinematicPositionBased,
        rapier::Velocity::zero(),
        own,
    );
    let driven = spawn(&mut app, Collider::ball(0.5), Vec3::Y * 50.0, driven);
    tick(&mut app, 3);
    assert_eq!(get::<Velocity>(&app, driven), &own);
    app.world_mut()
        .entity_mut(driven)
        .remove::<(rapier::Velocity, ShapeFromRapier)>();
    assert_eq!(get::<Velocity>(&app, driven), &own);
}
