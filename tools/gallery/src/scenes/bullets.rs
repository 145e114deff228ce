//! Bullets: what is swept never passes a wall, however thin, and bounces where it met it.

use std::collections::VecDeque;

use bevy::prelude::*;
use bevy_octree::{
    filters::{CollisionLayers, LayerMask},
    prelude::*,
};

use crate::{
    look::OwnLook,
    play::Tick,
    scene::{AddScene as _, Scene, showing},
};

const NAME: &str = "bullets";
/// Half the sides of the range.
const ROOM: Vec3 = Vec3::new(12.0, 4.0, 8.0);
const RADIUS: f32 = 0.12;
/// Ten times its diameter in a tick.
const SPEED: f32 = 150.0;
/// How many ticks a trail is long.
const TRAIL: usize = 5;

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "bullets among sheets of paper",
        "Balls that fly ten times their diameter in a tick, between walls that are a fiftieth thick. \
         One in four is not swept: it is gone at once. The others bounce, several times a tick if need \
         be, and stay.",
        spawn,
    );
    app.add_scene(
        scene
            .view(Vec3::new(10.0, 13.0, 22.0), Vec3::new(0.0, -0.5, 0.0))
            .objects(120, 4000)
            .best_tick(40)
            .caption(say),
    )
    .add_systems(
        Tick,
        trail.in_set(CollisionSystems::Last).run_if(showing(NAME)),
    )
    .add_systems(Update, draw.run_if(showing(NAME)));
}

/// Where a bullet was, last tick last.
#[derive(Component, Clone, Default)]
struct Trail(VecDeque<Vec3>);

fn spawn(world: &mut World, objects: usize) {
    let mut random = fastrand::Rng::with_seed(9);
    let mut share = || random.f32() * 2.0 - 1.0;
    // Bullets pass each other.
    let flying = CollisionLayers::new(LayerMask::layer(1), LayerMask::layer(0));
    for number in 0..objects {
        let course = Vec3::new(share(), 0.4 * share(), share()).normalize_or(Vec3::X);
        let at = Vec3::new(share(), share(), share()) * (ROOM - 1.0);
        let bullet = (
            CollisionShape::sphere(RADIUS),
            Velocity(course * SPEED),
            Bounce::Reflect { restitution: 1.0 },
            flying,
            Trail::default(),
            Transform::from_translation(at),
        );
        let mut bullet = world.spawn(bullet);
        if number % 4 != 3 {
            bullet.insert(Swept::default());
        }
    }
    let paper = 0.01;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut half_size = ROOM;
            half_size[axis] = paper;
            let mut at = Vec3::ZERO;
            at[axis] = side * ROOM[axis];
            let place = Transform::from_translation(at);
            let mut wall = world.spawn((
                CollisionShape::from_half_size(half_size),
                StaticShape,
                place,
            ));
            // Open to those who look in.
            if (axis, side) != (1, -1.0) && (axis, side) != (0, -1.0) && (axis, side) != (2, -1.0) {
                wall.insert(OwnLook);
            }
        }
    }
    for number in 0..9 {
        let at = Vec3::new(
            -8.0 + 8.0 * (number % 3) as f32,
            -1.5,
            -4.5 + 4.5 * (number / 3) as f32,
        );
        let turn = Quat::from_rotation_y(0.7 * number as f32);
        let place = Transform::from_translation(at).with_rotation(turn);
        let sheet = CollisionShape::from_half_size(Vec3::new(1.4, 2.5, paper));
        world.spawn((sheet, StaticShape, place));
    }
}

fn trail(mut bullets: Query<(&Transform, &mut Trail)>) {
    for (place, mut trail) in &mut bullets {
        if trail.0.len() == TRAIL {
            trail.0.pop_front();
        }
        trail.0.push_back(place.translation);
    }
}

fn draw(bullets: Query<(&Trail, Has<Swept>)>, mut gizmos: Gizmos) {
    for (trail, is_swept) in &bullets {
        let color = if is_swept {
            Color::srgba(0.34, 0.71, 0.91, 0.6)
        } else {
            Color::srgba(0.95, 0.35, 0.1, 0.9)
        };
        gizmos.linestrip(trail.0.iter().copied(), color);
    }
}

fn say(world: &mut World) -> String {
    let mut bullets = world.query_filtered::<(&Transform, Has<Swept>), With<Trail>>();
    let mut counts = [[0; 2]; 2];
    for (place, is_swept) in bullets.iter(world) {
        let is_inside = place.translation.abs().cmple(ROOM).all();
        counts[usize::from(is_swept)][usize::from(is_inside)] += 1;
    }
    let [[gone, kept], [lost, stayed]] = counts;
    format!(
        "between the walls: {stayed} of {} swept, {kept} of {} others",
        stayed + lost,
        kept + gone
    )
}
