//! A flock of 300 birds: each heeds its seven nearest neighbours, looks ahead, and keeps off what is
//! beside it. The flock passes pillars, and a wall with gaps.
//!
//! Each of the three is one question for all birds at once. Fails if a bird is ever in an obstacle,
//! if the flock falls apart, or if a bird is not past the wall in the end. `cargo run --example
//! flock`

use std::f32::consts::PI;

use bevy::prelude::*;
use bevy_octree::{motion::CollisionClock, prelude::*};

collision_layers! {
    enum Layer {
        Obstacle,
        Bird,
    }
}

const TICK: f32 = 1.0 / 30.0;
const BIRDS: usize = 300;
const RADIUS: f32 = 0.15;
/// How fast birds are, per second: they cannot hover.
const SPEED: [f32; 2] = [3.0, 6.0];
/// The most that a bird can change its velocity in a second.
const FORCE: f32 = 12.0;
/// How many others a bird heeds, how far away, and how near these may come.
const NEIGHBOURS: usize = 7;
const SIGHT: f32 = 8.0;
const ROOM: f32 = 1.0;
/// How far a bird looks ahead, and how near an obstacle may come to its middle.
const LOOK: f32 = 5.0;
const CLEARANCE: f32 = 0.5;
/// In how many directions a bird looks.
const DIRECTIONS: usize = 24;
/// Beyond the wall.
const ROOST: Vec3 = Vec3::new(85.0, 10.0, 0.0);
const WALL: f32 = 40.0;
/// No bird is ever farther from the middle of the flock.
const SPREAD: f32 = 25.0;

fn main() {
    let mut app = App::new();
    // A tick per update, of fixed length: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(TICK),
        })
        .add_systems(Startup, spawn)
        // Birds have moved, and are found where they are; by their new velocities they move in the
        // next tick.
        .add_systems(
            Update,
            (watch, flock, avoid).chain().in_set(CollisionSystems::Last),
        );
    println!("tick   middle at x   spread   in line   past the wall");
    for _ in 0..750 {
        app.update();
    }
    let mut birds = app.world_mut().query_filtered::<&Transform, With<Bird>>();
    let is_past = |at: &Transform| at.translation.x > WALL + 1.0;
    assert!(
        birds.iter(app.world()).all(is_past),
        "all are past the wall"
    );
}

#[derive(Component)]
struct Bird;

fn spawn(mut commands: Commands) {
    let obstacle = (
        StaticShape,
        CollisionLayers::new(Layer::Obstacle, LayerMask::ALL),
    );
    for [x, z] in [
        [8.0, -4.0],
        [10.0, 3.0],
        [17.0, -1.0],
        [25.0, -5.0],
        [24.0, 4.0],
    ] {
        let pillar = CollisionShape::cylinder(1.0, 60.0);
        commands.spawn((obstacle, pillar, Transform::from_xyz(x, 0.0, z)));
    }
    // Its parts, along z: the gaps are between them.
    for [from, to] in [[-50.0, -8.0], [-4.0, 2.0], [7.0, 50.0]] {
        let part = CollisionShape::cuboid(1.0, 60.0, to - from);
        let middle = Transform::from_xyz(WALL, 0.0, (from + to) / 2.0);
        commands.spawn((obstacle, part, middle));
    }
    let mut random = fastrand::Rng::with_seed(1);
    let mut random = |size: f32| Vec3::from_array([(); 3].map(|()| (random.f32() - 0.5) * size));
    for _ in 0..BIRDS {
        commands.spawn((
            Bird,
            CollisionShape::sphere(RADIUS),
            // Birds are found by others, but no contacts between them are looked for.
            CollisionLayers::new(Layer::Bird, Layer::Obstacle),
            Velocity(Vec3::X * SPEED[0] + random(4.0)),
            Transform::from_translation(Vec3::new(-10.0, 10.0, 0.0) + random(12.0)),
        ));
    }
}

/// Away from those that are too near, along with the others, towards their middle; and to the roost.
fn flock(
    mut birds: Query<(Entity, &Transform, &mut Velocity), With<Bird>>,
    spatial: SpatialQuery,
    mut near: Local<HitLists<PointHit>>,
) {
    let places: Vec<Vec3> = birds.iter().map(|(_, at, _)| at.translation).collect();
    let flock = SpatialQueryFilter::DEFAULT.on(Layer::Bird);
    // Each finds itself first.
    spatial.k_nearest_of_each(&places, NEIGHBOURS + 1, SIGHT, &flock, &mut near);
    let wishes: Vec<Vec3> = birds
        .iter()
        .zip(near.iter())
        .map(|((bird, at, velocity), hits)| {
            let (mut apart, mut along, mut together, mut count) =
                (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, 0.0);
            let others = hits.iter().filter(|hit| hit.entity != bird);
            for (_, other, its_velocity) in others.filter_map(|hit| birds.get(hit.entity).ok()) {
                let way = other.translation - at.translation;
                apart -= way.normalize_or_zero() * (1.0 - way.length() / ROOM).max(0.0);
                along += its_velocity.0 - velocity.0;
                together += way;
                count += 1.0;
            }
            let share = f32::max(count, 1.0).recip();
            let home = (ROOST - at.translation).normalize_or_zero();
            apart * 10.0 + along * share * 1.5 + together * share * 1.0 + home * 2.0
        })
        .collect();
    for ((.., mut velocity), wish) in birds.iter_mut().zip(wishes) {
        velocity.0 += wish.clamp_length_max(FORCE) * TICK;
    }
}

/// Turns from what is ahead, into the direction nearest to its own that is free; and never nearer
/// to what is beside it.
fn avoid(
    mut birds: Query<(&Transform, &mut Velocity), With<Bird>>,
    spatial: SpatialQuery,
    mut ahead: Local<Vec<Option<RayHit>>>,
    mut beside: Local<Vec<Option<PointHit>>>,
) {
    let fan: Vec<Dir3> = (0..DIRECTIONS).map(direction).collect();
    let (mut places, mut rays) = (Vec::new(), Vec::new());
    for (at, velocity) in &birds {
        let turn = Quat::from_rotation_arc(Vec3::X, velocity.normalize_or(Vec3::X));
        places.push(at.translation);
        rays.extend(
            fan.iter()
                .map(|way| Ray3d::new(at.translation, turn * *way)),
        );
    }
    let obstacles = SpatialQueryFilter::DEFAULT.on(Layer::Obstacle);
    spatial.cast_rays(&rays, LOOK, &obstacles, &mut ahead);
    spatial.nearest_of_each(&places, CLEARANCE, &obstacles, &mut beside);

    let looks = rays.chunks(DIRECTIONS).zip(ahead.chunks(DIRECTIONS));
    for (((at, mut velocity), (rays, hits)), beside) in birds.iter_mut().zip(looks).zip(&beside) {
        if let Some(hit) = hits[0] {
            let free = rays.iter().zip(hits).find(|(_, hit)| hit.is_none());
            let way = free.map_or(hit.normal, |(ray, _)| *ray.direction);
            let urgency = 1.0 - hit.distance / LOOK;
            let turn = way * SPEED[1] - velocity.0;
            velocity.0 += turn.normalize_or_zero() * FORCE * 3.0 * urgency * TICK;
        }
        let speed = velocity.length().clamp(SPEED[0], SPEED[1]);
        velocity.0 = velocity.normalize_or(Vec3::X) * speed;
        if let Some(hit) = beside {
            // Along it at most: less than it keeps off is flown in a tick.
            let out = (at.translation - hit.point).normalize_or_zero();
            let inwards = velocity.dot(out).min(0.0);
            velocity.0 -= out * inwards;
        }
    }
}

/// Directions all around, the nearest to x first: on a spiral, by the golden angle.
fn direction(number: usize) -> Dir3 {
    let turn = number as f32 * PI * (3.0 - 5.0_f32.sqrt());
    let x = 1.0 - 2.0 * number as f32 / DIRECTIONS as f32;
    let (sin, cos) = turn.sin_cos();
    let across = (1.0 - x * x).sqrt();
    Dir3::from_xyz(x, across * sin, across * cos).unwrap_or(Dir3::X)
}

/// No bird is in an obstacle, and none is far from the others.
fn watch(
    birds: Query<(&Transform, &Velocity), With<Bird>>,
    contacts: Res<Contacts>,
    clock: Res<CollisionClock>,
) {
    assert!(contacts.is_empty(), "no bird flies into an obstacle");
    let count = birds.iter().len() as f32;
    let places = || birds.iter().map(|(at, _)| at.translation);
    let middle = places().sum::<Vec3>() / count;
    let far = places().map(|place| place.distance(middle));
    let spread = far.fold(0.0, f32::max);
    assert!(spread < SPREAD, "the flock stays together");
    if clock.tick().is_multiple_of(30) {
        // 1 if all fly the same way.
        let ways = birds
            .iter()
            .map(|(_, velocity)| velocity.normalize_or_zero());
        let in_line = ways.sum::<Vec3>().length() / count;
        let past = places().filter(|place| place.x > WALL).count();
        println!(
            "{:4} {:13.1} {spread:8.1} {in_line:9.2} {past:15}",
            clock.tick(),
            middle.x
        );
    }
}
