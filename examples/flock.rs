//! A flock of 300 birds: each heeds its seven nearest neighbours, looks ahead, and keeps off what is
//! beside it. The flock passes pillars, and a wall with gaps.
//!
//! Each of the three is one question for all birds at once. Who heeds all that are near, however
//! many, finds the pairs by `SpatialQuery::for_each_pair_among`. Fails if a bird is ever in an
//! obstacle, if the flock falls apart, or if a bird is not past the wall in the end. `cargo run
//! --example flock`

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
/// The same where something is right ahead.
const AVOID: f32 = 36.0;
/// How many others a bird heeds, how far away, and how near these may come.
const NEIGHBOURS: usize = 7;
const SIGHT: f32 = 8.0;
const ROOM: f32 = 1.0;
/// How far a bird looks ahead, and how near an obstacle may come to its middle.
const LOOK: f32 = 5.0;
const CLEARANCE: f32 = 0.5;
/// With something ahead, in how many directions to each side of the way home it looks, and by which
/// angle these differ.
const TURNS: u32 = 12;
const TURN: f32 = PI / 12.0;
/// Beyond the wall.
const ROOST: Vec3 = Vec3::new(85.0, 10.0, 0.0);
const WALL: f32 = 40.0;
/// No bird is ever farther from the middle of the flock.
const SPREAD: f32 = 20.0;

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
    for _ in 0..510 {
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
    for [from, to] in [[-50.0, -7.0], [-2.0, 3.0], [8.0, 50.0]] {
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
            apart * 10.0 + along * share * 1.5 + together * share * 2.0 + home * 3.0
        })
        .collect();
    for ((.., mut velocity), wish) in birds.iter_mut().zip(wishes) {
        velocity.0 += wish.clamp_length_max(FORCE) * TICK;
    }
}

/// From what is ahead, into the direction nearest to the way home that is free; and never nearer to
/// what is beside.
fn avoid(
    mut birds: Query<(&Transform, &mut Velocity), With<Bird>>,
    spatial: SpatialQuery,
    mut met: Local<Vec<Option<RayHit>>>,
    mut beside: Local<Vec<Option<PointHit>>>,
) {
    let ahead = birds.iter().map(|(at, velocity)| {
        let way = Dir3::new(velocity.0).unwrap_or(Dir3::X);
        Ray3d::new(at.translation, way)
    });
    let ahead: Vec<Ray3d> = ahead.collect();
    let places: Vec<Vec3> = ahead.iter().map(|ray| ray.origin).collect();
    let obstacles = SpatialQueryFilter::DEFAULT.on(Layer::Obstacle);
    spatial.cast_rays(&ahead, LOOK, &obstacles, &mut met);
    spatial.nearest_of_each(&places, CLEARANCE, &obstacles, &mut beside);

    for ((((_, mut velocity), ray), met), beside) in
        birds.iter_mut().zip(ahead).zip(&met).zip(&beside)
    {
        if let Some(hit) = met {
            // Few birds have anything ahead: these look around, left and right in turn.
            let home = Dir3::new(ROOST - ray.origin).unwrap_or(ray.direction);
            let mut ways = (0..=TURNS).flat_map(|turn| {
                let turn = TURN * turn as f32;
                [turn, -turn].map(|turn| Quat::from_rotation_y(turn) * home)
            });
            let is_free =
                |way: &Dir3| !spatial.ray_meets_any(Ray3d::new(ray.origin, *way), LOOK, &obstacles);
            let free = ways.find(is_free);
            let change = free.map_or(hit.normal, Vec3::from) * SPEED[1] - velocity.0;
            let urgency = 1.0 - hit.distance / LOOK;
            velocity.0 += change.normalize_or_zero() * AVOID * urgency * TICK;
        }
        let speed = velocity.length().clamp(SPEED[0], SPEED[1]);
        velocity.0 = velocity.normalize_or(Vec3::X) * speed;
        if let Some(hit) = beside {
            // Along it at most. The clearance is more than a bird flies in a tick.
            let out = (ray.origin - hit.point).normalize_or_zero();
            let inwards = velocity.dot(out).min(0.0);
            velocity.0 -= out * inwards;
        }
    }
}

/// No bird is in an obstacle, and none is far from the others.
fn watch(
    birds: Query<(&Transform, &Velocity), With<Bird>>,
    contacts: Res<Contacts>,
    clock: Res<CollisionClock>,
) {
    // Obstacles are static, and birds meet no birds: no other contacts are looked for.
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
