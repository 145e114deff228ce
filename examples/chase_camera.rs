//! A camera behind a walker, which keeps out of walls: a ball is swept from the walker's head
//! towards where the camera is to be.
//!
//! What is in the way brings the camera in at once; afterwards a spring takes it out again. The
//! walker turns away from a wall with a pillar, and goes through a doorway. Fails if the camera
//! touches a wall or loses sight of the walker. `cargo run --example chase_camera`

use bevy::prelude::*;
use bevy_octree::prelude::*;

collision_layers! {
    /// The camera gives way to the level alone: not to who walks there.
    enum Layer {
        Level,
        Character,
    }
}

const TICK: f32 = 1.0 / 60.0;
/// Where the walker goes, along x and z.
const WAY: [Vec2; 3] = [
    Vec2::new(-4.0, 0.0),
    Vec2::new(0.0, 0.0),
    Vec2::new(0.0, 16.0),
];
const PACE: f32 = 3.0;
/// How high the walker's eyes are over its middle.
const EYES: f32 = 0.6;
/// How far the camera is from these in the open.
const DISTANCE: f32 = 5.0;
/// How far up it looks from behind, in radians.
const PITCH: f32 = 0.35;
/// No wall comes nearer to the camera: the near plane of its view is to fit into this ball.
const BALL: f32 = 0.25;
/// What is swept is larger by this, so that rounding never makes the ball itself touch.
const MARGIN: f32 = 0.02;
/// How fast the spring takes the camera out, and how fast it turns, per second.
const SPRING: f32 = 4.0;
const TURN: f32 = 3.0;

fn main() {
    let mut app = App::new();
    // A tick per update, of fixed length: the example needs no clock.
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(TICK),
        })
        .add_systems(Startup, spawn)
        .add_systems(Update, walk.before(CollisionSystems::Motion))
        // The walker and all that moves have moved, and are seen where they are.
        .add_systems(
            Update,
            (follow, check).chain().in_set(CollisionSystems::Last),
        );
    println!("tick   walker at x, z   camera's distance            in the way");
    let mut met = Vec::new();
    for tick in 0..480 {
        app.update();
        let in_the_way = report(app.world_mut(), tick);
        if !met.contains(&in_the_way) {
            met.push(in_the_way);
        }
    }
    let mut cameras = app.world_mut().query::<&ChaseCamera>();
    let camera = cameras.single(app.world()).expect("there is one camera");
    assert!(
        DISTANCE - camera.distance < 0.01,
        "it is back at its distance"
    );
    for wall in ["wall", "pillar", "lintel"] {
        assert!(
            met.iter().any(|met| met == wall),
            "the {wall} came in the way"
        );
    }
}

/// Where it is to go next.
#[derive(Component, Default)]
struct Walker {
    corner: usize,
}

/// Beside a `Camera3d`, if there is something to be drawn.
#[derive(Component)]
struct ChaseCamera {
    /// Follows the walker's turn.
    turn: Quat,
    distance: f32,
    /// How fast the distance grows.
    speed: f32,
    /// What keeps the camera from going farther out.
    in_the_way: Option<Entity>,
}

fn spawn(mut commands: Commands) {
    // Of the wall with the doorway: a part on either side, and one above.
    for (name, [x, y, z], size) in [
        ("wall", [0.0, 2.0, -2.5], [24.0, 4.0, 0.4]),
        ("pillar", [-1.8, 2.0, -1.6], [0.6, 4.0, 0.6]),
        ("doorway", [-5.3, 2.0, 6.0], [9.0, 4.0, 0.4]),
        ("doorway", [5.3, 2.0, 6.0], [9.0, 4.0, 0.4]),
        ("lintel", [0.0, 3.15, 6.0], [1.6, 1.7, 0.4]),
        ("floor", [0.0, -0.1, 8.0], [30.0, 0.2, 30.0]),
    ] {
        commands.spawn((
            Name::new(name),
            CollisionShape::from_half_size(Vec3::from(size) / 2.0),
            StaticShape,
            CollisionLayers::new(Layer::Level, LayerMask::ALL),
            Transform::from_xyz(x, y, z),
        ));
    }
    let start = Transform::from_xyz(WAY[0].x, 1.0, WAY[0].y).looking_to(Vec3::X, Vec3::Y);
    commands.spawn((
        Walker::default(),
        CollisionShape::capsule(0.4, 1.0),
        CollisionLayers::new(Layer::Character, LayerMask::ALL),
        Velocity::default(),
        start,
    ));
    commands.spawn((
        ChaseCamera {
            turn: start.rotation,
            distance: DISTANCE,
            speed: 0.0,
            in_the_way: None,
        },
        Transform::default(),
    ));
}

/// To the next corner of its way, and to rest at the last.
fn walk(walker: Single<(&mut Walker, &mut Transform, &mut Velocity)>) {
    let (mut walker, mut at, mut velocity) = walker.into_inner();
    let way = loop {
        let Some(corner) = WAY.get(walker.corner) else {
            velocity.0 = Vec3::ZERO;
            return;
        };
        let way = *corner - at.translation.xz();
        if way.length() > PACE * TICK {
            break Vec3::new(way.x, 0.0, way.y).normalize();
        }
        walker.corner += 1;
    };
    velocity.0 = way * PACE;
    at.look_to(way, Vec3::Y);
}

fn follow(
    walker: Single<&Transform, (With<Walker>, Without<ChaseCamera>)>,
    camera: Single<(&mut ChaseCamera, &mut Transform)>,
    spatial: SpatialQuery,
) {
    let (mut camera, mut at) = camera.into_inner();
    let head = walker.translation + Vec3::Y * EYES;
    camera.turn = camera
        .turn
        .slerp(walker.rotation, 1.0 - (-TURN * TICK).exp())
        .normalize();
    let out = camera.turn * Quat::from_rotation_x(-PITCH) * Dir3::Z;

    let level = SpatialQueryFilter::DEFAULT
        .on(Layer::Level)
        .without_sensors();
    // The walker is wider than the ball, so that it does not begin in a wall.
    let hit = spatial.cast_sphere(head, BALL + MARGIN, out, DISTANCE, &level);
    let free = hit.map_or(DISTANCE, |hit| hit.distance);
    camera.in_the_way = hit.map(|hit| hit.entity);
    if camera.distance > free {
        (camera.distance, camera.speed) = (free, 0.0);
    } else {
        // Going out takes its time, and stops where the way does.
        let (distance, speed) = spring(camera.distance, camera.speed, free);
        (camera.distance, camera.speed) = (distance.min(free), speed);
    }
    *at = Transform::from_translation(head + out * camera.distance).looking_to(-out, Vec3::Y);
}

/// A tick of a critically damped spring, exactly: it comes to rest at `goal` as fast as one can
/// that does not swing past it.
fn spring(distance: f32, speed: f32, goal: f32) -> (f32, f32) {
    let (off, fade) = (distance - goal, (-SPRING * TICK).exp());
    let pull = (speed + SPRING * off) * TICK;
    (goal + (off + pull) * fade, (speed - SPRING * pull) * fade)
}

/// The camera touches nothing, sees the walker, and goes out without a jump.
fn check(
    camera: Single<(&ChaseCamera, &Transform)>,
    spatial: SpatialQuery,
    mut walls: Local<Vec<Entity>>,
    mut before: Local<Option<f32>>,
) {
    let (camera, at) = *camera;
    let level = SpatialQueryFilter::DEFAULT.on(Layer::Level);
    spatial.shape_intersections(&Shape::sphere(BALL), at, &level, &mut walls);
    assert!(walls.is_empty(), "the camera touches no wall");

    let line_of_sight = Ray3d::new(at.translation, at.forward());
    let is_hidden = spatial.ray_meets_any(line_of_sight, camera.distance, &level);
    assert!(!is_hidden, "the camera sees the walker");

    let out = camera.distance - before.replace(camera.distance).unwrap_or(DISTANCE);
    // Such a spring is never faster than when it has been let go.
    let most = DISTANCE * SPRING * TICK / std::f32::consts::E;
    assert!(out <= most, "the camera goes out smoothly, not by {out}");
}

/// Prints a line four times a second; returns the name of what is in the way.
fn report(world: &mut World, tick: u32) -> String {
    let mut cameras = world.query::<&ChaseCamera>();
    let mut walkers = world.query_filtered::<&Transform, With<Walker>>();
    let (Ok(camera), Ok(walker)) = (cameras.single(world), walkers.single(world)) else {
        return String::new();
    };
    let name = camera.in_the_way.and_then(|wall| world.get::<Name>(wall));
    let name = name.map(ToString::to_string).unwrap_or_default();
    if tick.is_multiple_of(15) {
        let bar = "#".repeat((camera.distance * 4.0) as usize);
        let [x, _, z] = walker.translation.to_array();
        println!(
            "{tick:4} {x:9.2} {z:6.2}   {:4.2} {bar:<20}   {name}",
            camera.distance
        );
    }
    name
}
