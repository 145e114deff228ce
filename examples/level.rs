//! A level in one mesh: a thousand balls and a hundred bricks roll down hills of 100 000 triangles,
//! and a hundred bullets fly between them.
//!
//! `cargo run --release --example level`; with `--features rapier`, beside it the same level as a
//! mesh of Rapier's, tick by tick in turns. Fails if anything falls through.

use std::{process::ExitCode, time::Instant};

use arguments::Arguments;
use bevy::prelude::*;
use bevy_octree::{
    contacts::EventScope,
    motion::{MotionSettings, Step},
    prelude::*,
};
use outcome::{Outcome, exit};
use progress::Progress;

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/progress.rs"]
mod progress;

const HELP: &str = "
Balls and bricks roll down the hills of a level that is one mesh, and bullets fly over them, in a headless app: how long a
tick takes, how much is in contact, and whether anything fell through.

With --features rapier, the same with the level as a mesh of Rapier's: the two take turns.

Usage: level [OPTIONS]

Options:
  --ticks <TICKS>      How many ticks to run, a 60th of a second each [default: 600]
  --balls <BALLS>      How many balls roll [default: 1000]
  --bricks <BRICKS>    How many bricks roll [default: 100]
  --bullets <BULLETS>  How many bullets fly, each of them swept [default: 100]
  -h, --help           Print help
";

collision_layers! {
    /// Bullets fly through what rolls: it would be too fast for the ground.
    enum Layer {
        Level,
        Rolling,
        Bullet,
    }
}

/// Squares of the level along x and z, of a length unit each, cut into two triangles.
const SQUARES: [u32; 2] = [250, 200];
const TICK: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.8;
/// What is left of a speed after a second on the ground, about.
const ROLLING: f32 = 0.6;
const BALL: f32 = 0.5;
const BRICK: Vec3 = Vec3::new(0.5, 0.3, 0.4);
const BULLET: f32 = 0.05;
/// Fifty times its diameter per tick.
const MUZZLE: f32 = 300.0;
/// What is lower than this over the ground has fallen through: rounding has its share.
const THROUGH: f32 = -0.05;
/// How high the sky is, off which bullets bounce.
const SKY: f32 = 40.0;

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

fn run(mut arguments: Arguments) -> Outcome {
    let ticks: u32 = arguments.option("--ticks")?.unwrap_or(600);
    let count = Count {
        balls: arguments.option("--balls")?.unwrap_or(1000),
        bricks: arguments.option("--bricks")?.unwrap_or(100),
        bullets: arguments.option("--bullets")?.unwrap_or(100),
    };
    let [] = arguments.rest([])?;

    let (vertices, triangles) = hills();
    let start = Instant::now();
    let mesh = CollisionShape::mesh(vertices.clone(), &triangles)?;
    println!(
        "{} triangles, built in {:.0} ms; {} balls, {} bricks, {} bullets",
        triangles.len(),
        start.elapsed().as_secs_f64() * 1e3,
        count.balls,
        count.bricks,
        count.bullets
    );
    let mut levels = vec![Level::new("mesh", mesh, &count)];
    #[cfg(feature = "rapier")]
    {
        use bevy_octree::narrow_phase::Shape;
        use bevy_rapier3d::parry::shape::SharedShape;
        let mesh = Shape::from(SharedShape::trimesh(vertices, triangles)?);
        levels.push(Level::new("Rapier's mesh", CollisionShape(mesh), &count));
    }

    let mut progress = Progress::new(ticks.into());
    for tick in 1..=ticks {
        progress.begin(format!("tick {tick}"));
        for level in &mut levels {
            level.tick();
        }
    }
    drop(progress);
    println!("level           ms/tick   slowest  contacts/tick   lowest  fallen through");
    for level in &mut levels {
        level.report();
    }
    if let [ours, rapiers] = levels.as_mut_slice() {
        println!(
            "tick_ratio={:.2} (Rapier's mesh / mesh)",
            rapiers.median() / ours.median()
        );
    }
    match levels.iter().map(|level| level.fallen).max() {
        Some(1..) => Err("something fell through the level".into()),
        _ => Ok(()),
    }
}

struct Count {
    balls: u32,
    bricks: u32,
    bullets: u32,
}

/// The height of the ground at a corner of a square: hills, and a rim that keeps all within.
fn height(x: u32, z: u32) -> f32 {
    let place = Vec2::new(x as f32, z as f32);
    let waves = 3.0 * (place.x / 9.0).sin() * (place.y / 7.0).cos()
        + 0.6 * (place.x / 2.1 + place.y / 2.7).sin()
        + 0.2 * (place.x * 1.7).sin() * (place.y * 2.3).cos();
    let middle = UVec2::from(SQUARES).as_vec2() * 0.5;
    let rim = ((place - middle) / middle).abs().max_element().powi(16);
    waves + 20.0 * rim
}

/// Vertices and triangles, two of these per square.
fn hills() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let [columns, rows] = SQUARES;
    let vertices = (0..=rows)
        .flat_map(|z| (0..=columns).map(move |x| Vec3::new(x as f32, height(x, z), z as f32)));
    let triangles = (0..rows).flat_map(|z| {
        (0..columns).flat_map(move |x| {
            let a = z * (columns + 1) + x;
            let [b, c, d] = [a + columns + 1, a + columns + 2, a + 1];
            [[a, b, c], [a, c, d]]
        })
    });
    (vertices.collect(), triangles.collect())
}

/// How high a point is over the ground.
fn over_ground(point: Vec3) -> f32 {
    let [columns, rows] = SQUARES;
    let place = point.xz().clamp(Vec2::ZERO, UVec2::from(SQUARES).as_vec2());
    let (x, z) = (
        (place.x as u32).min(columns - 1),
        (place.y as u32).min(rows - 1),
    );
    let share = place - Vec2::new(x as f32, z as f32);
    let (low, high) = (height(x, z), height(x + 1, z + 1));
    // From the lower corner along one side, then along the other.
    let ground = if share.x > share.y {
        let corner = height(x + 1, z);
        low + (corner - low) * share.x + (high - corner) * share.y
    } else {
        let corner = height(x, z + 1);
        low + (corner - low) * share.y + (high - corner) * share.x
    };
    point.y - ground
}

/// An app with a level, and what came of it.
struct Level {
    name: &'static str,
    app: App,
    /// Milliseconds of each tick.
    times: Vec<f64>,
    contacts: usize,
    fallen: usize,
    lowest: f32,
}

/// The level itself.
#[derive(Component)]
struct Ground;

/// What gravity pulls, and how far its middle is from what it rolls on.
#[derive(Component)]
struct Rolls(f32);

/// What fell through the level.
#[derive(Component)]
struct Fallen;

impl Level {
    fn new(name: &'static str, level: CollisionShape, count: &Count) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
            .insert_resource(MotionSettings {
                step: Step::Seconds(TICK),
            })
            // Where contacts are, and how deep, is asked for all.
            .insert_resource(CollisionEventSettings {
                geometry: EventScope::All,
                ..default()
            })
            .add_systems(Update, fall.before(CollisionSystems::Motion))
            .add_systems(Update, roll.after(CollisionSystems::Response));
        let world = app.world_mut();
        let fixed = (
            StaticShape,
            CollisionLayers::new(Layer::Level, LayerMask::ALL),
        );
        world.spawn((Ground, fixed, level));
        let [width, depth] = SQUARES.map(|squares| squares as f32);
        for side in [-1.0, 1.0] {
            // Walls and a sky, for bullets; the ground is open below them.
            let wall = CollisionShape::cuboid(1.0, 200.0, depth + 10.0);
            let x = width / 2.0 + side * (width / 2.0 + 0.5);
            world.spawn((fixed, wall, Transform::from_xyz(x, 0.0, depth / 2.0)));
            let wall = CollisionShape::cuboid(width + 10.0, 200.0, 1.0);
            let z = depth / 2.0 + side * (depth / 2.0 + 0.5);
            world.spawn((fixed, wall, Transform::from_xyz(width / 2.0, 0.0, z)));
        }
        let sky = CollisionShape::cuboid(width + 10.0, 1.0, depth + 10.0);
        let above = Transform::from_xyz(width / 2.0, SKY, depth / 2.0);
        world.spawn((fixed, sky, above));

        let mut random = fastrand::Rng::with_seed(1);
        let mut place = |height: f32| {
            let share = [0.05 + 0.9 * random.f32(), 0.05 + 0.9 * random.f32()];
            let mut place = Vec3::new(share[0] * width, 0.0, share[1] * depth);
            place.y = height - over_ground(place);
            (place, random.f32() * 6.3)
        };
        let rolling = CollisionLayers::new(Layer::Rolling, Layer::Level | Layer::Rolling);
        for _ in 0..count.balls {
            let (place, _) = place(1.5);
            let ball = (CollisionShape::sphere(BALL), Rolls(BALL));
            world.spawn((
                ball,
                mover(0.3, rolling),
                Transform::from_translation(place),
            ));
        }
        for _ in 0..count.bricks {
            let (place, turn) = place(1.5);
            let brick = (CollisionShape::from_half_size(BRICK), Rolls(BRICK.y));
            let turned = Transform::from_translation(place)
                .with_rotation(Quat::from_scaled_axis(Vec3::splat(turn)));
            world.spawn((brick, mover(0.2, rolling), turned));
        }
        for _ in 0..count.bullets {
            let (place, turn) = place(4.0);
            let direction = Vec3::new(turn.cos(), -0.2, turn.sin()).normalize();
            let layers = CollisionLayers::new(Layer::Bullet, Layer::Level);
            let bullet = (CollisionShape::sphere(BULLET), Swept::default(), layers);
            let flight = (
                Velocity(direction * MUZZLE),
                Bounce::Reflect { restitution: 1.0 },
            );
            world.spawn((bullet, flight, Transform::from_translation(place)));
        }
        // The first tick has all that is new to it.
        app.update();
        Self {
            name,
            app,
            times: vec![],
            contacts: 0,
            fallen: 0,
            lowest: f32::INFINITY,
        }
    }

    fn tick(&mut self) {
        let start = Instant::now();
        self.app.update();
        self.times.push(start.elapsed().as_secs_f64() * 1e3);
        let world = self.app.world_mut();
        self.contacts += world.resource::<Contacts>().len();
        let mut moving = world.query_filtered::<(Entity, &Transform), With<Velocity>>();
        let heights: Vec<_> = moving
            .iter(world)
            .map(|(entity, at)| (entity, over_ground(at.translation)))
            .collect();
        for (entity, height) in heights {
            self.lowest = self.lowest.min(height);
            if height < THROUGH && world.get::<Fallen>(entity).is_none() {
                world.entity_mut(entity).insert(Fallen);
                self.fallen += 1;
            }
        }
    }

    fn median(&mut self) -> f64 {
        self.times.sort_by(f64::total_cmp);
        self.times
            .get(self.times.len() / 2)
            .copied()
            .unwrap_or(f64::NAN)
    }

    fn report(&mut self) {
        let median = self.median();
        println!(
            "{:<14} {median:>8.3} {:>9.3} {:>14.1} {:>8.3} {:>15}",
            self.name,
            self.times.last().copied().unwrap_or(f64::NAN),
            self.contacts as f64 / self.times.len() as f64,
            self.lowest,
            self.fallen
        );
    }
}

fn mover(restitution: f32, layers: CollisionLayers) -> impl Bundle {
    let bounce = Bounce::Reflect { restitution };
    (Velocity::default(), bounce, layers)
}

fn fall(mut rolling: Query<&mut Velocity, With<Rolls>>) {
    for mut velocity in &mut rolling {
        velocity.y -= GRAVITY * TICK;
    }
}

/// Bounces change velocities. Who has come to be in the ground by then is lifted out of it, and
/// turns as what rolls does.
fn roll(
    contacts: Res<Contacts>,
    ground: Single<Entity, With<Ground>>,
    mut rolling: Query<(&mut Transform, &mut Velocity, &Rolls)>,
) {
    for collision in contacts.iter() {
        let collision = match *ground {
            ground if collision.a == ground => collision.reversed(),
            ground if collision.b == ground => collision,
            _ => continue,
        };
        let (Some(contact), Ok((mut at, mut velocity, Rolls(radius)))) =
            (collision.contact, rolling.get_mut(collision.a))
        else {
            continue;
        };
        let up = -contact.normal;
        at.translation += up * contact.depth;
        let turn = up.cross(velocity.0) * (TICK / radius);
        at.rotation = (Quat::from_scaled_axis(turn) * at.rotation).normalize();
        velocity.0 *= 1.0 - (1.0 - ROLLING) * TICK;
    }
}
