//! Triangles by formulas in 64-bit numbers.

use bevy::{
    math::{DMat3, DVec3},
    prelude::*,
};

/// Where a shape is, in 64-bit numbers.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    turn: DMat3,
    scale: DVec3,
    position: DVec3,
}

impl From<&Transform> for Pose {
    fn from(at: &Transform) -> Self {
        Self {
            turn: DMat3::from_quat(at.rotation.as_dquat().normalize()),
            scale: at.scale.as_dvec3(),
            position: at.translation.as_dvec3(),
        }
    }
}

impl Pose {
    /// Where a point of the shape is.
    pub fn of(&self, point: Vec3) -> DVec3 {
        self.position + self.turn * (point.as_dvec3() * self.scale)
    }
}

/// A triangle in the world.
pub type Triangle = [DVec3; 3];

/// The point of a segment that is closest to another.
fn on_segment(a: DVec3, b: DVec3, point: DVec3) -> DVec3 {
    let way = b - a;
    let share = (point - a).dot(way) / way.length_squared();
    if share.is_finite() {
        a + way * share.clamp(0.0, 1.0)
    } else {
        a
    }
}

/// The three numbers by which a point of the plane of a triangle is a mean of its corners; not finite
/// if it has no area.
fn shares([a, b, c]: Triangle, point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let share = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) / area;
    [share(b, c), share(c, a), share(a, b)]
}

/// How far a point is from a triangle.
pub fn distance(triangle: Triangle, point: DVec3) -> f64 {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let above = (point - a).dot(normal);
    let is_above_it = shares(triangle, point - normal * above)
        .iter()
        .all(|share| *share >= 0.0);
    if is_above_it {
        return above.abs();
    }
    [(a, b), (b, c), (c, a)]
        .iter()
        .map(|(from, to)| on_segment(*from, *to, point).distance(point))
        .fold(f64::INFINITY, f64::min)
}

/// Where a ray meets a triangle for certain: well within it, and not along it.
pub fn meets(triangle: Triangle, origin: DVec3, direction: DVec3) -> Option<f64> {
    const WITHIN: f64 = 1e-2;
    const STEEP: f64 = 0.05;
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let steep = normal.dot(direction);
    if steep.abs() < STEEP {
        return None;
    }
    let along = (a - origin).dot(normal) / steep;
    let is_within = shares(triangle, origin + direction * along)
        .iter()
        .all(|share| *share > WITHIN);
    (is_within && along >= 0.0).then_some(along)
}

/// How often triangles wind around a point.
pub fn winding(triangles: &[Triangle], point: DVec3) -> f64 {
    let angles = triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        let above = a.dot(b.cross(c));
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * above.atan2(below)
    });
    angles.sum::<f64>() / (4.0 * std::f64::consts::PI)
}
