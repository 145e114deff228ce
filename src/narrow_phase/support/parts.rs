//! What shapes consist of: convex shapes and half-spaces, and how two of these are to each other.

use bevy::math::DVec3;

use super::convex::{Convex, Isometry};
use super::gap::Gap;
use super::gjk;
use super::segment_triangle;

/// So often may one on its way look how far the other is: more often only if they no more than
/// graze each other.
const MOST_STEPS: usize = 64;
/// How close to its border a point counts as on a triangle, as a share of its height.
const BORDER: f64 = 1e-9;
/// The least sine of the angle between a ray and a triangle that it crosses.
const STEEP: f64 = 1e-9;

/// What has no parts.
#[derive(Clone, Copy)]
pub enum Part<'a> {
    Convex(Convex<'a>),
    /// A half-space, by its plane and the normal that points out of it.
    HalfSpace {
        normal: DVec3,
        offset: f64,
    },
}

impl Part<'_> {
    /// All that is behind the plane through where something is, by its normal there.
    pub fn half_space(normal: DVec3, at: Isometry) -> Self {
        let normal = at.rotation * normal.normalize_or(DVec3::Y);
        Self::HalfSpace {
            normal,
            offset: normal.dot(at.translation),
        }
    }

    /// The normal of a triangle.
    pub fn face(&self) -> Option<DVec3> {
        let Self::Convex(convex) = self else {
            return None;
        };
        let [a, b, c] = convex.as_triangle()?;
        (b - a).cross(c - a).try_normalize()
    }

    pub fn moved(&self, by: DVec3) -> Self {
        match *self {
            Self::Convex(convex) => Self::Convex(convex.moved(by)),
            Self::HalfSpace { normal, offset } => Self::HalfSpace {
                normal,
                offset: offset + normal.dot(by),
            },
        }
    }
}

/// How far from a shape a point is that counts as in it, as a share of a depth.
const IN_SHAPE: f64 = 1e-6;

/// The gap between two that have no parts; see [`gjk::gap`]. An error if nothing can be said about
/// it.
pub fn gap(a: &Part, b: &Part, limit: f64, with_depth: bool) -> Result<Option<Gap>, Unknown> {
    match (a, b) {
        (Part::Convex(a), Part::Convex(b)) => Ok(gjk::gap(a, b, limit, with_depth)),
        (Part::HalfSpace { normal, offset }, Part::Convex(b)) => {
            let lowest = b.furthest(-*normal) - *normal * b.radius;
            let distance = lowest.dot(*normal) - offset;
            let points = [lowest - *normal * distance, lowest];
            // What is above the deepest point need not be in the shape.
            let middle = points[0].midpoint(points[1]);
            let is_in_shape = || {
                let near = -distance * IN_SHAPE;
                gjk::gap(&Convex::point(middle), b, near, false).is_some()
            };
            let between = if distance >= 0.0 || with_depth && is_in_shape() {
                middle
            } else {
                lowest
            };
            Ok((distance <= limit).then_some(Gap {
                distance,
                normal: *normal,
                points,
                between,
            }))
        }
        (Part::Convex(_), Part::HalfSpace { .. }) => {
            Ok(gap(b, a, limit, with_depth)?.map(Gap::reversed))
        }
        (Part::HalfSpace { .. }, Part::HalfSpace { .. }) => Err(Unknown),
    }
}

/// How far the first of two that have no parts goes until it meets the other, and how they then are
/// to each other. They touch if they are no further apart than `near`: the first is for the start,
/// the other for the way.
///
/// The distance of two convex shapes along a way is a convex function, whose slope is that of the
/// normal: Newton's method comes to its zero from before, and never goes past it.
pub fn first_impact(
    a: &Part,
    b: &Part,
    direction: DVec3,
    limit: f64,
    near: [f64; 2],
) -> Result<Option<(f64, Gap)>, Unknown> {
    if let (Part::Convex(ray), Part::Convex(target)) = (a, b)
        && ray.is_point()
        && let Some(corners) = target.as_triangle()
        && let Some(found) = ray_triangle(ray.at.translation, direction, corners, near[0])
    {
        return Ok(found.filter(|(distance, _)| *distance <= limit));
    }
    let (Part::Convex(a), Part::Convex(b)) = (a, b) else {
        if matches!((a, b), (Part::HalfSpace { .. }, Part::HalfSpace { .. })) {
            return Err(Unknown);
        }
        let approach = Approach::from_the_start([limit, 0.0], near);
        return Ok(approach.first_zero(direction, |time| {
            gap(&a.moved(direction * time), b, f64::INFINITY, false).ok()?
        }));
    };
    let mut approach = Approach::from_the_start([limit, a.radius + b.radius], near);
    let parted = if let Some(corners) = b.core_triangle() {
        near_from(a, corners, direction, [b.radius, near[0]], limit)
    } else if let Some(corners) = a.core_triangle() {
        near_from(b, corners, -direction, [a.radius, near[0]], limit).map(Parted::reversed)
    } else {
        Some(Parted::default())
    };
    match parted {
        Some(parted) => approach.parted = parted,
        None => return Ok(None),
    }
    // What does not change on the way is looked up once.
    let radii = [a.radius, b.radius];
    if let (Some(segment), Some(corners)) = (a.core_segment(), b.core_triangle()) {
        return Ok(approach.first_zero(direction, |time| {
            let segment = segment.map(|end| end + direction * time);
            let gap = segment_triangle::gap(segment, corners, f64::INFINITY, false)?;
            Some(gap.grown(radii))
        }));
    }
    Ok(approach.first_zero(direction, |time| {
        gjk::gap(&a.moved(direction * time), b, f64::INFINITY, false)
    }))
}

/// Until when a plane certainly parts two on their way, and the plane's normal, from the first to the second.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parted {
    pub until: f64,
    normal: Option<DVec3>,
}

impl Parted {
    fn reversed(self) -> Self {
        let normal = self.normal.map(|normal| -normal);
        Self { normal, ..self }
    }
}

/// From when on a shape may touch a triangle if it goes in a direction: at once, if it begins no
/// further than `near` from the triangle's plane, with a radius around it; `None` if it never does
/// within `limit`.
pub fn near_from(
    body: &Convex,
    [a, b, c]: [DVec3; 3],
    direction: DVec3,
    [radius, near]: [f64; 2],
    limit: f64,
) -> Option<Parted> {
    let Some(up) = (b - a).cross(c - a).try_normalize() else {
        return Some(Parted::default());
    };
    let [low, high] = match body.core_segment() {
        Some(ends) => {
            let [one, other] = ends.map(|end| up.dot(end - a));
            [one.min(other), one.max(other)]
        }
        None => [-up, up].map(|way| up.dot(body.furthest(way) - a)),
    };
    let reach = body.radius + radius;
    let (low, high) = (low - reach, high + reach);
    if low <= near && high >= -near {
        return Some(Parted::default());
    }
    // Along the plane or away from it, never.
    let (distance, normal) = if low > 0.0 { (low, -up) } else { (-high, up) };
    let until = distance / normal.dot(direction);
    (until >= 0.0 && until <= limit).then_some(Parted {
        until,
        normal: Some(normal),
    })
}

/// One on its way to another.
struct Approach {
    parted: Parted,
    limit: f64,
    /// How far from their cores the two shapes reach.
    radii: f64,
    near: [f64; 2],
}

impl Approach {
    fn from_the_start([limit, radii]: [f64; 2], near: [f64; 2]) -> Self {
        let parted = Parted::default();
        Self {
            parted,
            limit,
            radii,
            near,
        }
    }

    /// When the gap of one that goes in a direction and another is first no more than nothing, and how
    /// they then are to each other.
    fn first_zero(
        &self,
        direction: DVec3,
        gap_at: impl Fn(f64) -> Option<Gap>,
    ) -> Option<(f64, Gap)> {
        let near = self.near;
        let (mut time, mut last) = (self.parted.until, self.parted.normal);
        for _ in 0..MOST_STEPS {
            let gap = gap_at(time)?;
            if gap.distance <= near[usize::from(time > 0.0)] {
                // Of cores that touch, the normal is that of rounding; and the plane of the step before,
                // which parted them, comes to where they are as near as that.
                let is_told = gap.distance + self.radii > near[1];
                let normal = last.filter(|_| !is_told).unwrap_or(gap.normal);
                let closing = normal.dot(direction);
                // What is left of the way, but for rounding.
                let mut rest = 0.0;
                if time > 0.0 && gap.distance > 0.0 && closing > 0.0 {
                    rest = gap.distance / closing;
                    // Where that is further off, they only graze, and are no nearer before.
                    if rest > near[1]
                        && gap_at(time + rest).is_none_or(|after| after.distance > gap.distance)
                    {
                        rest = 0.0;
                    }
                }
                return Some(((time + rest).min(self.limit), Gap { normal, ..gap }));
            }
            let closing = gap.normal.dot(direction);
            if closing <= 0.0 {
                return None;
            }
            time += gap.distance / closing;
            last = Some(gap.normal);
            if time > self.limit || time.is_nan() {
                return None;
            }
        }
        None
    }
}

/// Where a ray meets a triangle. `None` if it starts near its plane, or runs along it: then the
/// distance decides.
fn ray_triangle(
    origin: DVec3,
    direction: DVec3,
    [a, b, c]: [DVec3; 3],
    near: f64,
) -> Option<Option<(f64, Gap)>> {
    let across = (b - a).cross(c - a);
    let normal = across.try_normalize()?;
    let (height, steep) = (normal.dot(origin - a), normal.dot(direction));
    if height.abs() <= near || steep.abs() <= STEEP {
        return None;
    }
    let distance = -height / steep;
    let point = origin + direction * distance;
    let [u, v, w] =
        [[a, b], [b, c], [c, a]].map(|[from, to]| (to - from).cross(point - from).dot(across));
    // No ray slips through where triangles join.
    let least = -BORDER * across.length_squared();
    let meets = distance >= 0.0 && u.min(v).min(w) >= least;
    let normal = if steep > 0.0 { normal } else { -normal };
    Some(meets.then_some((
        distance,
        Gap {
            distance: 0.0,
            normal,
            points: [point; 2],
            between: point,
        },
    )))
}

/// Nothing can be said about two shapes.
#[derive(Clone, Copy, Debug)]
pub struct Unknown;
