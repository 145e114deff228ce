//! Boxes that a moving attractor pulls about.

use bevy::math::{Vec3A, bounding::Aabb3d};
use fastrand::Rng;

use super::random::cube_root;

/// The largest speed of a box along an axis, but for what the attractor's own motion adds.
const SPEED: f32 = 0.5;
/// The radius of the cloud for one object and one overlap each. It grows as the cube root of the
/// number of objects.
///
/// Along an axis the centres are spread as a semicircle of radius R, whose square has the integral
/// 16 / (3π²R); two boxes of side 1 are within 1 of each other with twice that probability.
const RADIUS: f64 = 32.0 / (3.0 * std::f64::consts::PI * std::f64::consts::PI);

/// A cloud of boxes around an attractor that circles.
///
/// The pull grows with the distance, as that of a spring: every box then swings through the whole
/// cloud, all with the same period, and the cloud keeps its shape and its density for ever. (A pull
/// that falls with the distance would gather all boxes in one spot, with overlaps to match.)
#[derive(Clone, Debug)]
pub(super) struct Gravity {
    velocities: Vec<Vec3A>,
    /// Per tick and distance.
    pull: f32,
    attractor: Vec3A,
    attractor_velocity: Vec3A,
}

pub(super) fn new(objects: usize, mut rng: Rng) -> (Vec<Aabb3d>, Gravity) {
    let radius = (RADIUS * cube_root(objects.max(1) as f64)) as f32;
    let frequency = SPEED / radius;
    let mut velocities = Vec::with_capacity(objects);
    let boxes = (0..objects).map(|_| {
        // Along each axis, a random place and phase of the swing, which makes all times alike.
        let [x, y, z] = std::array::from_fn(|_| in_disc(&mut rng));
        velocities.push(SPEED * Vec3A::new(x[1], y[1], z[1]));
        let min = radius * Vec3A::new(x[0], y[0], z[0]) - 0.5;
        Aabb3d {
            min,
            max: min + 1.0,
        }
    });
    let boxes = boxes.collect();
    let attractor = Vec3A::X * (0.5 * radius);
    // It circles once while a box swings twice.
    let attractor_velocity = Vec3A::Z * (0.25 * SPEED);
    (
        boxes,
        Gravity {
            velocities,
            pull: frequency * frequency,
            attractor,
            attractor_velocity,
        },
    )
}

impl Gravity {
    pub(super) fn step(&mut self, boxes: &mut [Aabb3d]) {
        self.attractor_velocity -= self.attractor * (0.25 * self.pull);
        self.attractor += self.attractor_velocity;
        let target = self.attractor - 0.5;
        for (velocity, aabb) in self.velocities.iter_mut().zip(boxes) {
            *velocity += (target - aabb.min) * self.pull;
            aabb.min += *velocity;
            aabb.max = aabb.min + 1.0;
        }
    }
}

/// A point of the disc of radius 1.
fn in_disc(rng: &mut Rng) -> [f32; 2] {
    loop {
        let [x, y] = std::array::from_fn(|_| 2.0 * rng.f32() - 1.0);
        if x * x + y * y <= 1.0 {
            return [x, y];
        }
    }
}
