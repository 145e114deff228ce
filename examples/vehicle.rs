//! A vehicle on four wheels, each of them a ray: it drives over a bumpy field and a ramp, through
//! gates.
//!
//! The crate tells how far the ground is under each wheel, and which gate is passed; springs, tyres
//! and the motion of the body are this example's. Fails if the vehicle falls through the ground,
//! turns over or misses a gate, or if its springs are beyond their travel. `cargo run --example
//! vehicle`

use bevy::prelude::*;
use bevy_octree::{motion::CollisionClock, prelude::*};

const TICK: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.81;
/// The body: in metres, kilograms, and newtons.
const SIZE: Vec3 = Vec3::new(1.6, 0.6, 3.6);
const MASS: f32 = 1200.0;
/// Where springs begin, in the space of the body, which looks along −z: front wheels first.
const WHEELS: [Vec3; 4] = [
    Vec3::new(-0.8, 0.0, -1.3),
    Vec3::new(0.8, 0.0, -1.3),
    Vec3::new(-0.8, 0.0, 1.3),
    Vec3::new(0.8, 0.0, 1.3),
];
const RADIUS: f32 = 0.35;
/// How long a spring is without load, and by how much it can be pressed together.
const SPRING: f32 = 0.5;
const TRAVEL: f32 = 0.35;
const STIFFNESS: f32 = 25_000.0;
const DAMPING: f32 = 2_500.0;
/// The stiffness of the rubber at the end of the travel.
const STOP: f32 = 100_000.0;
/// Newtons per metre per second that a tyre slips sideways, and how much of its load it holds.
const GRIP: f32 = 8_000.0;
const FRICTION: f32 = 0.9;
/// The most that each of the rear wheels drives.
const DRIVE: f32 = 3_000.0;
const CRUISE: f32 = 11.0;
const MAX_STEER: f32 = 0.5;
/// The field, along x and z, in cells of a metre.
const CELLS: [usize; 2] = [160, 40];
/// The course leads along x: gates, with the ramp between the third and the fourth.
const GATES: [Vec2; 6] = [
    Vec2::new(-45.0, 5.0),
    Vec2::new(-25.0, -5.0),
    Vec2::new(-10.0, 0.0),
    Vec2::new(16.0, 0.0),
    Vec2::new(38.0, 5.0),
    Vec2::new(56.0, -3.0),
];
const RAMP: Vec3 = Vec3::new(8.0, 1.0, 8.0);

fn main() {
    let mut app = App::new();
    // A tick per update, of fixed length: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(TICK),
        })
        .init_resource::<Record>()
        .add_systems(Startup, spawn)
        // Rays see what was where at the end of the last tick, as the vehicle still is.
        .add_systems(Update, drive.in_set(CollisionSystems::Motion))
        .add_systems(Update, watch.in_set(CollisionSystems::Last));
    println!("tick        x       z   height   m/s   springs, pressed together: front, rear");
    for _ in 0..1050 {
        app.update();
    }
    let record = app.world().resource::<Record>();
    let all: u32 = record.springs.iter().sum();
    let [within, air, beyond] = record
        .springs
        .map(|count| count as f32 / all as f32 * 100.0);
    println!(
        "springs: {within:.1} % within their travel, {air:.1} % in the air, {beyond:.1} % beyond; \
         the body scraped in {} ticks",
        record.scrapes
    );
    assert!(
        within > 80.0,
        "springs are within their travel most of the time"
    );
    assert_eq!(record.gates, GATES.len(), "it has passed all gates");
    let mut vehicles = app.world_mut().query::<&Vehicle>();
    let vehicle = vehicles.single(app.world()).expect("there is one vehicle");
    assert!(vehicle.velocity.length() < 0.1, "it has come to rest");
}

fn height(x: f32, z: f32) -> f32 {
    0.3 * (x / 7.0).sin() * (z / 9.0).cos() + 0.08 * (x * 1.1).sin() * (z * 0.9).sin()
}

fn spawn(mut commands: Commands) {
    let [columns, rows] = CELLS.map(|cells| cells + 1);
    let field = HeightField::from_fn(rows, columns, Vec2::ONE, height).expect("it has cells");
    commands.spawn((CollisionShape(Shape::from(field)), StaticShape));
    // A wedge: up, and off its end.
    let Vec3 { x, y, z } = RAMP / 2.0;
    let corners = [-z, z].map(|z| [[-x, -y], [x, -y], [x, y]].map(|[x, y]| Vec3::new(x, y, z)));
    let wedge = CollisionShape::convex_hull(corners.concat()).expect("it is no plane");
    commands.spawn((wedge, StaticShape, Transform::from_xyz(0.0, y - 0.2, 0.0)));
    for (number, gate) in (1..).zip(GATES) {
        commands.spawn((
            Name::new(format!("gate {number}")),
            CollisionShape::cuboid(0.5, 6.0, 6.0),
            Sensor,
            Transform::from_xyz(gate.x, 2.0, gate.y),
        ));
    }
    commands.spawn((
        Vehicle::default(),
        CollisionShape::from_half_size(SIZE / 2.0),
        Transform::from_xyz(-70.0, 1.5, 0.0).looking_to(Vec3::X, Vec3::Y),
    ));
}

#[derive(Component, Default)]
struct Vehicle {
    /// In metres per second.
    velocity: Vec3,
    /// Around which axis it turns, and how fast, in radians per second.
    spin: Vec3,
    /// By how much each spring is pressed together; nothing in the air.
    pressed: [f32; 4],
}

impl Vehicle {
    /// How fast a point of it moves, given from its middle.
    fn velocity_at(&self, arm: Vec3) -> Vec3 {
        self.velocity + self.spin.cross(arm)
    }
}

fn drive(
    vehicle: Single<(Entity, &mut Vehicle, &mut Transform)>,
    spatial: SpatialQuery,
    mut hits: Local<Vec<Option<RayHit>>>,
) {
    let (entity, mut vehicle, mut at) = vehicle.into_inner();
    // All four at once, past the vehicle's own body, and through gates.
    let others = SpatialQueryFilter::DEFAULT.except(entity).without_sensors();
    let rays = WHEELS.map(|wheel| Ray3d::new(at.transform_point(wheel), at.down()));
    spatial.cast_rays(&rays, SPRING + RADIUS, &others, &mut hits);

    // Positive to the left.
    let (steer, cruise) = match next_gate(&at) {
        Some(way) => ((-way.x).atan2(-way.z).clamp(-MAX_STEER, MAX_STEER), CRUISE),
        None => (0.0, 0.0),
    };
    let mut force = Vec3::NEG_Y * GRAVITY * MASS;
    let mut torque = Vec3::ZERO;
    for (wheel, (ray, hit)) in rays.iter().zip(hits.iter()).enumerate() {
        vehicle.pressed[wheel] = 0.0;
        let Some(hit) = hit else { continue };
        let pressed = SPRING + RADIUS - hit.distance;
        vehicle.pressed[wheel] = pressed;
        let up = at.up();
        // Springs push, and never pull.
        let rising = vehicle.velocity_at(ray.origin - at.translation).dot(*up);
        let stop = (pressed - TRAVEL).max(0.0) * STOP;
        let load = (STIFFNESS * pressed + stop - DAMPING * rising).max(0.0);

        // The tyre holds against what slips sideways, and drives ahead, along the ground.
        let arm = hit.point - at.translation;
        let is_front = wheel < 2;
        let turn = if is_front { steer } else { 0.0 };
        let ahead = Quat::from_axis_angle(*up, turn) * *at.forward();
        let ahead = ahead.reject_from(hit.normal).normalize_or_zero();
        let side = hit.normal.cross(ahead);
        let slip = vehicle.velocity_at(arm);
        let throttle = (cruise - slip.dot(ahead)).clamp(-1.0, 1.0);
        let driven = if is_front { 0.0 } else { throttle * DRIVE };
        let tyre = ahead * driven - side * slip.dot(side) * GRIP;
        let push = up * load + tyre.clamp_length_max(FRICTION * load);
        force += push;
        torque += arm.cross(push);
    }
    vehicle.advance(&mut at, force, torque);
}

/// The next gate in the space of the body, as a driver sees it; none after the last.
fn next_gate(at: &Transform) -> Option<Vec3> {
    let is_ahead = |gate: &&Vec2| gate.x > at.translation.x + 4.0;
    let gate = GATES.iter().find(is_ahead)?;
    let way = Vec3::new(gate.x, at.translation.y, gate.y) - at.translation;
    Some(at.rotation.inverse() * way)
}

impl Vehicle {
    /// A tick of a rigid body: velocities first, and by these, where it is.
    fn advance(&mut self, at: &mut Transform, force: Vec3, torque: Vec3) {
        self.velocity += force / MASS * TICK;
        // Of a box, around its own axes.
        let squares = SIZE * SIZE;
        let sums = Vec3::splat(squares.element_sum()) - squares;
        let inertia = MASS / 12.0 * sums;
        let to_body = at.rotation.inverse();
        let (spin, torque) = (to_body * self.spin, to_body * torque);
        let change = (torque - spin.cross(inertia * spin)) / inertia;
        self.spin = at.rotation * (spin + change * TICK);
        at.translation += self.velocity * TICK;
        at.rotation = (Quat::from_scaled_axis(self.spin * TICK) * at.rotation).normalize();
    }
}

/// What was seen of the vehicle.
#[derive(Resource, Default)]
struct Record {
    /// Of all wheels in all ticks: how many were on the ground with their springs within their
    /// travel, how many were in the air, and how many beyond the travel.
    springs: [u32; 3],
    /// Ticks in which the body touched the ground.
    scrapes: u32,
    gates: usize,
}

fn watch(
    vehicle: Single<(Entity, &Vehicle, &Transform)>,
    collisions: Collisions,
    mut started: MessageReader<CollisionStarted>,
    gates: Query<&Name, With<Sensor>>,
    clock: Res<CollisionClock>,
    mut record: ResMut<Record>,
) {
    let (entity, vehicle, at) = *vehicle;
    for message in started.read() {
        let gate = message
            .other(entity)
            .and_then(|other| gates.get(other).ok());
        if let Some(name) = gate {
            println!("{:4}   {name}", clock.tick());
            record.gates += 1;
        }
    }
    let mut touched = collisions.colliding_with(entity);
    record.scrapes += u32::from(touched.any(|other| !gates.contains(other)));
    for pressed in vehicle.pressed {
        let kind = match pressed {
            0.0 => 1,
            TRAVEL.. => 2,
            _ => 0,
        };
        record.springs[kind] += 1;
    }
    let Vec3 { x, y, z } = at.translation;
    let over = y - height(x, z);
    assert!(over > 0.0, "it does not fall through the ground");
    assert!(at.up().y > 0.7, "it does not turn over");
    if clock.tick().is_multiple_of(30) {
        let springs = vehicle.pressed.map(|pressed| format!("{pressed:4.2}"));
        println!(
            "{:4} {x:8.2} {z:7.2} {over:8.2} {:5.1}   {}",
            clock.tick(),
            vehicle.velocity.length(),
            springs.join(" ")
        );
    }
}
