//! Measures continuous detection: bodies in a crowd, and balls in free flight.
//!
//! `cargo run --release -p study -- swept --help` explains the arguments.

use std::{num::NonZero, time::Instant};

use bevy::prelude::*;
use bevy_octree::{counters::CollisionCounters, prelude::*};
use clap::{Args, ValueEnum};
use fastrand::Rng;

use crate::{outcome::Outcome, quantile::quantile, threads::use_threads};

/// Measures what a tick costs a swept body.
///
/// In a *crowd*, bodies of one side or diameter move by up to that per tick, in a closed room that
/// they fill to a share, and reflect off each other and off the walls. In *flight*, balls of one
/// diameter pass between a fifth as many resting walls, few of which they meet.
///
/// Prints a line for each shape: `us_per_body` is the median over ticks of the microseconds that a
/// tick takes, by body; `impacts` the number of bounces of a body in a tick.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// Where the bodies are.
    #[arg(long, value_enum, default_value_t = Place::Crowd)]
    place: Place,
    /// What the bodies of a crowd are; in flight, all are balls.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Body::Ball, Body::Upright, Body::Turned, Body::Convex])]
    shapes: Vec<Body>,
    /// How many bodies there are: 1000 in a crowd, 10000 in flight, if not given.
    #[arg(long)]
    bodies: Option<usize>,
    /// The share of the room that the bodies of a crowd fill.
    #[arg(long, default_value_t = 0.15)]
    density: f32,
    /// How many sides the fastest cover per tick, and in flight all.
    #[arg(long, default_value_t = 1.0)]
    speed: f32,
    /// How many ticks are measured, after a tenth as many that are not.
    #[arg(long, default_value_t = NonZero::new(60).unwrap_or(NonZero::<u32>::MIN))]
    ticks: NonZero<u32>,
    /// Bodies without `Swept`, for comparison.
    #[arg(long)]
    unswept: bool,
    /// Another seed gives another crowd.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Place {
    Crowd,
    Flight,
}

/// Each with a side or a diameter of one.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Body {
    Ball,
    /// A cuboid along the axes.
    Upright,
    /// A cuboid that is turned, and does not turn any further.
    Turned,
    /// An octahedron, turned.
    Convex,
    /// Twenty triangles, turned.
    Icosahedron,
    /// A cuboid that turns by a tenth of a radian per tick.
    Turning,
}

impl Body {
    fn shape(self) -> Outcome<CollisionShape> {
        Ok(match self {
            Self::Ball => CollisionShape::sphere(0.5),
            Self::Upright | Self::Turned | Self::Turning => CollisionShape::cuboid(1.0, 1.0, 1.0),
            Self::Convex => {
                let ends = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis * 0.5, axis * -0.5]);
                hull(&ends.concat())?
            }
            Self::Icosahedron => {
                let golden = f32::midpoint(1.0, 5f32.sqrt());
                let corners = [
                    (1.0, golden),
                    (1.0, -golden),
                    (-1.0, golden),
                    (-1.0, -golden),
                ];
                let corners = corners.map(|(a, b)| {
                    [
                        Vec3::new(0.0, a, b),
                        Vec3::new(a, b, 0.0),
                        Vec3::new(b, 0.0, a),
                    ]
                });
                let corners = corners.concat().into_iter();
                let corners: Vec<_> = corners.map(|corner| corner.normalize() * 0.5).collect();
                hull(&corners)?
            }
        })
    }

    /// The share of the cube around it that it fills.
    fn volume(self) -> f32 {
        match self {
            Self::Ball => std::f32::consts::FRAC_PI_6,
            Self::Upright | Self::Turned | Self::Turning => 1.0,
            Self::Convex => 1.0 / 6.0,
            Self::Icosahedron => 0.3170,
        }
    }

    fn rotation(self, rng: &mut Rng) -> Quat {
        match self {
            Self::Ball | Self::Upright => Quat::IDENTITY,
            _ => Quat::from_scaled_axis(direction(rng) * 3.0),
        }
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    use_threads(NonZero::<usize>::MIN)?;
    match arguments.place {
        Place::Crowd => {
            for body in &arguments.shapes {
                let app = crowd(*body, arguments)?;
                measure(app, &format!("{body:?}").to_lowercase(), arguments);
            }
        }
        Place::Flight => measure(flight(arguments), "ball", arguments),
    }
    Ok(())
}

#[inline(never)]
fn tick(app: &mut App) {
    app.update();
}

fn measure(mut app: App, name: &str, arguments: &Arguments) {
    let ticks = arguments.ticks.get();
    for _ in 0..ticks.div_ceil(10) {
        app.update();
    }
    let bodies = app.world_mut().query_filtered::<(), With<Velocity>>();
    let bodies = { bodies }.iter(app.world()).count().max(1);
    let bounces = |app: &App| app.world().resource::<CollisionCounters>().total.bounces;
    let before = bounces(&app);
    let mut times = Vec::new();
    for _ in 0..ticks {
        let start = Instant::now();
        tick(&mut app);
        times.push(start.elapsed().as_secs_f64() * 1e6 / bodies as f64);
    }
    let bounces = (bounces(&app) - before) as f64 / bodies as f64 / f64::from(ticks);
    println!(
        "shape={name} bodies={bodies} us_per_body={:.3} fastest={:.3} impacts={bounces:.3} contacts={}",
        quantile(&times, 0.5),
        quantile(&times, 0.0),
        app.world().resource::<Contacts>().len(),
    );
}

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0),
        });
    app
}

/// The solid whose faces are all triangles of points with nothing beyond them, which have to be few.
fn hull(points: &[Vec3]) -> Outcome<CollisionShape> {
    let mut triangles = Vec::new();
    for i in 0..points.len() {
        for j in 0..points.len() {
            for k in 0..points.len() {
                let normal = (points[j] - points[i]).cross(points[k] - points[i]);
                let is_first = i < j && i < k && j != k;
                let height = |point: &Vec3| normal.dot(*point - points[i]);
                if is_first
                    && normal.length() > 1e-3
                    && points.iter().all(|point| height(point) < 1e-4)
                {
                    triangles.push([i, j, k].map(|corner| corner as u32));
                }
            }
        }
    }
    Ok(CollisionShape::convex(points, triangles)?)
}

fn direction(rng: &mut Rng) -> Vec3 {
    let mut next = || 2.0 * rng.f32() - 1.0;
    loop {
        let direction = Vec3::new(next(), next(), next());
        if (0.01..=1.0).contains(&direction.length_squared()) {
            return direction.normalize();
        }
    }
}

fn turn(mut turning: Query<&mut Transform, With<Velocity>>) {
    for mut transform in &mut turning {
        transform.rotate(Quat::from_rotation_y(0.1));
    }
}

fn crowd(body: Body, arguments: &Arguments) -> Outcome<App> {
    let mut app = app();
    if body == Body::Turning {
        app.add_systems(Update, turn.in_set(CollisionSystems::Motion));
    }
    let mut rng = Rng::with_seed(arguments.seed);
    let count = arguments.bodies.unwrap_or(1000);
    let spacing = (body.volume() / arguments.density).cbrt();
    let side = (count as f64).cbrt().ceil() as usize;
    let half = 0.5 * spacing * side as f32;
    for (axis, sign) in [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [(axis, 1.0), (axis, -1.0)])
    {
        let size = Vec3::splat(2.0 * half + 8.0) * (Vec3::ONE - axis) + axis * 4.0;
        let wall = CollisionShape::cuboid(size.x, size.y, size.z);
        let at = Transform::from_translation(axis * sign * (half + 2.0));
        app.world_mut().spawn((wall, StaticShape, at));
    }
    let shape = body.shape()?;
    for number in 0..count {
        let cell = [number % side, number / side % side, number / side / side];
        let at = Vec3::from_array(cell.map(|cell| (cell as f32 + 0.5) * spacing - half));
        let speed = arguments.speed * rng.f32();
        let mut entity = app.world_mut().spawn((
            shape.clone(),
            Velocity(direction(&mut rng) * speed),
            Bounce::Reflect { restitution: 1.0 },
            Transform::from_translation(at).with_rotation(body.rotation(&mut rng)),
        ));
        if !arguments.unswept {
            entity.insert(Swept::default());
        }
    }
    Ok(app)
}

/// Walls stand where few meet them, and the balls fly in all directions in a room that keeps them
/// no longer than the measurement takes.
fn flight(arguments: &Arguments) -> App {
    let mut app = app();
    let mut rng = Rng::with_seed(arguments.seed);
    let count = arguments.bodies.unwrap_or(10_000);
    let half = 5.0 * (count as f32).cbrt();
    let place = |rng: &mut Rng| Vec3::from_array([(); 3].map(|()| (2.0 * rng.f32() - 1.0) * half));
    for _ in 0..count / 5 {
        let at = Transform::from_translation(place(&mut rng));
        let wall = CollisionShape::cuboid(0.1, 2.0, 2.0);
        app.world_mut().spawn((wall, StaticShape, at));
    }
    for _ in 0..count {
        let mut entity = app.world_mut().spawn((
            CollisionShape::sphere(0.5),
            Velocity(direction(&mut rng) * arguments.speed),
            Transform::from_translation(place(&mut rng)),
        ));
        if !arguments.unswept {
            entity.insert(Swept::default());
        }
    }
    app
}
