//! Who is right where the two differ: each triangle looked at, in 64-bit floats, slow and plain.

use bevy::math::{DQuat, DVec3, Vec3};

use super::{
    engines::Answer,
    queries::{BALL, CAPSULE, CUBOID, Operation, Query, SWEEP},
    scenes::Mesh,
};

/// How much two answers may differ and count as the same, in length units: the shapes are about one
/// large.
pub const SAME: f64 = 1e-3;
/// How close to the surface a sweep comes before it has met it.
const MET: f64 = 1e-7;
/// Steps of a sweep.
const MOST_STEPS: usize = 20_000;

/// What is right.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// So far apart, less than zero if in touch: a hit if that is no more than the tolerance.
    Apart(f64),
    /// It meets after so long; or not, and comes so close.
    Way { met: Option<f64>, closest: f64 },
    /// Inside, or not.
    Inside(bool),
}

impl Truth {
    /// Is an answer right, given what counts as touching?
    pub fn allows(self, operation: Operation, answer: Answer, tolerance: f64) -> bool {
        let answer = answer.map(f64::from);
        match self {
            Self::Inside(inside) => answer.is_some() == inside,
            Self::Apart(distance) => match operation {
                Operation::ClosestPoint | Operation::Distance => {
                    let found = answer.unwrap_or(f64::INFINITY);
                    (found - distance.max(0.0)).abs() <= SAME + tolerance
                }
                _ => distance.abs() <= tolerance || answer.is_some() == (distance <= 0.0),
            },
            Self::Way { met, closest } => match (met, answer) {
                (Some(met), Some(found)) => (met - found).abs() <= SAME,
                (None, Some(_)) => closest <= tolerance,
                (Some(met), None) => met > f64::from(SWEEP) - SAME,
                (None, None) => true,
            },
        }
    }
}

/// What is right; nothing where it is not looked into.
pub fn truth(operation: Operation, mesh: &Mesh, query: &Query) -> Option<Truth> {
    use Operation as O;
    let start = query.position.as_dvec3();
    let body = match operation {
        O::Ray => {
            let met = ray(mesh, start, query.direction.as_dvec3());
            let closest = f64::INFINITY;
            return Some(Truth::Way { met, closest });
        }
        O::Contains => return Some(Truth::Inside(is_inside(mesh, start))),
        O::BallContact | O::BallSweep => Body::Ball(f64::from(BALL)),
        O::CuboidContact | O::CuboidIntersects | O::CuboidSweep | O::Distance => {
            Body::Cuboid(CUBOID.as_dvec3())
        }
        O::CapsuleContact | O::CapsuleSweep => Body::Capsule(CAPSULE.map(f64::from)),
        O::ClosestPoint => Body::Ball(0.0),
        _ => return None,
    };
    let turn = query.rotation.as_dquat().normalize();
    if matches!(operation, O::BallSweep | O::CuboidSweep | O::CapsuleSweep) {
        return Some(sweep(mesh, body, start, turn, query.direction.as_dvec3()));
    }
    let all = 0..mesh.triangles.len();
    Some(Truth::Apart(apart(mesh, all, body, start, turn)))
}

/// Does the mesh wind around a point? By a ray along x that meets no corner.
pub fn is_inside(mesh: &Mesh, point: DVec3) -> bool {
    let mut winding = 0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh
            .corners(triangle)
            .map(|corner| corner.as_dvec3() - point);
        let cross = |a: DVec3, b: DVec3| a.y * b.z - a.z * b.y;
        let areas = [cross(b, c), cross(c, a), cross(a, b)];
        let whole: f64 = areas.iter().sum();
        let same_side =
            areas.iter().all(|area| *area > 0.0) || areas.iter().all(|area| *area < 0.0);
        if same_side && (a.x * areas[0] + b.x * areas[1] + c.x * areas[2]) / whole > 0.0 {
            winding += if whole > 0.0 { 1 } else { -1 };
        }
    }
    winding != 0
}

#[derive(Clone, Copy)]
enum Body {
    Ball(f64),
    Capsule([f64; 2]),
    Cuboid(DVec3),
}

impl Body {
    fn radius(self) -> f64 {
        match self {
            Self::Ball(radius) => radius,
            Self::Capsule([half_length, radius]) => half_length + radius,
            Self::Cuboid(half) => half.length(),
        }
    }

    /// How far it is from a triangle; no more than negative if they overlap.
    fn distance(self, at: DVec3, turn: DQuat, corners: [DVec3; 3]) -> f64 {
        let local = corners.map(|corner| turn.inverse() * (corner - at));
        match self {
            Self::Ball(radius) => point_triangle(DVec3::ZERO, local) - radius,
            Self::Capsule([half_length, radius]) => {
                let ends = [DVec3::Y * half_length, DVec3::Y * -half_length];
                segment_triangle(ends, local) - radius
            }
            Self::Cuboid(half) => cuboid_triangle(half, local),
        }
    }
}

/// How far a body is from the nearest of some triangles.
fn apart(
    mesh: &Mesh,
    triangles: impl Iterator<Item = usize>,
    body: Body,
    at: DVec3,
    turn: DQuat,
) -> f64 {
    let radius = body.radius();
    let mut least = f64::INFINITY;
    for triangle in triangles {
        let corners = mesh.corners(triangle).map(Vec3::as_dvec3);
        if box_distance(at, corners) - radius < least {
            least = least.min(body.distance(at, turn, corners));
        }
    }
    least
}

fn box_distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    point.distance(point.clamp(a.min(b).min(c), a.max(b).max(c)))
}

/// Steps of as much as is certainly free.
fn sweep(mesh: &Mesh, body: Body, start: DVec3, turn: DQuat, direction: DVec3) -> Truth {
    let way = f64::from(SWEEP);
    let (middle, reach) = (start + direction * (way / 2.0), way / 2.0 + body.radius());
    let near: Vec<_> = (0..mesh.triangles.len())
        .filter(|triangle| {
            let corners = mesh.corners(*triangle).map(Vec3::as_dvec3);
            box_distance(middle, corners) <= reach
        })
        .collect();
    let (mut time, mut closest) = (0.0, f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let distance = apart(
            mesh,
            near.iter().copied(),
            body,
            start + direction * time,
            turn,
        );
        closest = f64::min(closest, distance);
        if distance <= MET {
            let met = Some(time);
            return Truth::Way { met, closest };
        }
        time += distance;
        if time > way {
            break;
        }
    }
    Truth::Way { met: None, closest }
}

fn ray(mesh: &Mesh, origin: DVec3, direction: DVec3) -> Option<f64> {
    let mut first = None::<f64>;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh
            .corners(triangle)
            .map(|corner| corner.as_dvec3() - origin);
        let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(direction));
        let whole: f64 = volumes.iter().sum();
        let is_hit = volumes.iter().all(|volume| volume * whole >= 0.0) && whole != 0.0;
        let distance = a.dot((b - a).cross(c - a)) / direction.dot((b - a).cross(c - a));
        if is_hit && distance >= 0.0 && first.is_none_or(|first| distance < first) {
            first = Some(distance);
        }
    }
    first
}

fn point_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|[from, to]| (to - from).cross(point - from).dot(normal) >= 0.0);
    if inside && normal != DVec3::ZERO {
        return (point - a).dot(normal).abs() / normal.length();
    }
    [[a, b], [b, c], [c, a]]
        .map(|side| point_segment(point, side))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

fn point_segment(point: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let share = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(a + along * if share.is_nan() { 0.0 } else { share })
}

fn segment_segment([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (u, v, w) = (b - a, d - c, a - c);
    let [uu, uv, vv] = [u.dot(u), u.dot(v), v.dot(v)];
    let whole = uu * vv - uv * uv;
    let mut least = [
        point_segment(a, [c, d]),
        point_segment(b, [c, d]),
        point_segment(c, [a, b]),
        point_segment(d, [a, b]),
    ]
    .into_iter()
    .fold(f64::INFINITY, f64::min);
    if whole > 1e-12 * uu * vv {
        let (uw, vw) = (u.dot(w), v.dot(w));
        let (s, t) = ((uv * vw - vv * uw) / whole, (uu * vw - uv * uw) / whole);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            least = least.min((a + u * s).distance(c + v * t));
        }
    }
    least
}

/// How far a segment is from a triangle; 0 if it goes through.
pub fn segment_triangle([a, b]: [DVec3; 2], corners: [DVec3; 3]) -> f64 {
    if crosses([a, b], corners) {
        return 0.0;
    }
    let [p, q, r] = corners;
    [[p, q], [q, r], [r, p]]
        .map(|side| segment_segment([a, b], side))
        .into_iter()
        .chain([a, b].map(|end| point_triangle(end, corners)))
        .fold(f64::INFINITY, f64::min)
}

fn crosses([a, b]: [DVec3; 2], [p, q, r]: [DVec3; 3]) -> bool {
    let normal = (q - p).cross(r - p);
    let heights = [a, b].map(|end| (end - p).dot(normal));
    if heights[0] * heights[1] > 0.0 || heights[0] == heights[1] {
        return false;
    }
    let at = a + (b - a) * (heights[0] / (heights[0] - heights[1]));
    [[p, q], [q, r], [r, p]]
        .iter()
        .all(|[from, to]| (to - from).cross(at - from).dot(normal) >= 0.0)
}

fn cuboid_triangle(half: DVec3, corners: [DVec3; 3]) -> f64 {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        half * DVec3::new(sign(0), sign(1), sign(2))
    };
    let mut least = f64::INFINITY;
    for point in corners {
        least = least.min(point.distance(point.clamp(-half, half)));
    }
    for i in 0..8 {
        for bit in (0..3).filter(|bit| i >> bit & 1 == 0) {
            let edge = [corner(i), corner(i | 1 << bit)];
            least = least.min(segment_triangle(edge, corners));
        }
    }
    // A side of the triangle that crosses the cuboid without coming near an edge.
    let [p, q, r] = corners;
    for [from, to] in [[p, q], [q, r], [r, p]] {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for axis in 0..3 {
            let (start, along) = (from[axis], to[axis] - from[axis]);
            if along == 0.0 {
                if start.abs() > half[axis] {
                    leave = -1.0;
                }
                continue;
            }
            let [one, other] = [-half[axis], half[axis]].map(|wall| (wall - start) / along);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        if enter <= leave {
            return -f64::MIN_POSITIVE;
        }
    }
    if least == 0.0 {
        -f64::MIN_POSITIVE
    } else {
        least
    }
}
