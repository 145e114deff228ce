//! Shapes taken apart: the convex shapes and half-spaces that they consist of, and which of those
//! of two shapes come near each other.

use bevy::math::DVec3;

use super::convex::{Convex, Isometry};
use super::foreign::Foreign;
use super::gap::Gap;
use super::gjk;
use super::posed_mesh::PosedMesh;
use super::probe::{Probe, Search};
use super::segment_triangle;

/// So often may one on its way look how far the other is: more often only if they no more than
/// graze each other.
const MOST_STEPS: usize = 64;
/// How close to its border a point counts as on a triangle, as a share of its height.
const BORDER: f64 = 1e-9;
/// The least sine of the angle between a ray and a triangle that it crosses.
const STEEP: f64 = 1e-9;

/// A shape in its place, as something that can be asked.
#[derive(Clone, Copy)]
pub enum PosedShape<'a> {
    Part(Part<'a>),
    /// A mesh of ours, that is not convex.
    Mesh(PosedMesh<'a>),
    /// What somebody else knows the parts of.
    #[cfg_attr(
        not(feature = "rapier"),
        expect(dead_code, reason = "nobody else is there")
    )]
    Foreign(Foreign<'a>),
}

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

impl<'a> PosedShape<'a> {
    pub fn isometry(&self) -> Isometry {
        match self {
            Self::Part(Part::Convex(convex)) => convex.at,
            Self::Part(Part::HalfSpace { .. }) => Isometry::IDENTITY,
            Self::Mesh(mesh) => mesh.at,
            Self::Foreign(foreign) => foreign.isometry(),
        }
    }

    /// Centre and half extents of the box around the shape, in its own axes; `None` if it has no
    /// end.
    pub fn local_box(&self) -> Option<[DVec3; 2]> {
        match self {
            Self::Part(Part::Convex(convex)) => Some(convex.local_box()),
            Self::Part(Part::HalfSpace { .. }) => None,
            Self::Mesh(mesh) => Some(mesh.local_box()),
            Self::Foreign(foreign) => Some(foreign.local_box()),
        }
    }

    /// Is it made of triangles that have numbers?
    pub fn has_triangles(&self) -> bool {
        match self {
            Self::Part(_) => false,
            Self::Mesh(_) => true,
            Self::Foreign(foreign) => foreign.has_triangles(),
        }
    }

    /// Half the diagonal of that box; infinite without an end.
    pub fn size(&self) -> f64 {
        self.local_box()
            .map_or(f64::INFINITY, |[_, half]| half.length())
    }

    /// Where it is, and that it goes in a direction, as seen from another.
    pub fn probe(&self, whole: Isometry, direction: DVec3) -> Probe {
        if let Self::Part(Part::HalfSpace { normal, offset }) = self {
            return Probe::HalfSpace {
                normal: whole.direction_to_local(*normal),
                offset: offset - normal.dot(whole.translation),
                approach: normal.dot(direction).max(0.0),
            };
        }
        let Some(bounds) = self.local_box() else {
            return Probe::Everywhere;
        };
        let [center, half] = whole.bounds_to_local(&self.isometry(), bounds);
        Probe::Box {
            center,
            half,
            direction: whole.direction_to_local(direction),
        }
    }

    /// Calls `visit` with all parts that a probe admits, and again with their parts. False if there
    /// is one about which nothing can be said.
    pub fn each(
        &self,
        probe: &Probe,
        search: &Search,
        visit: &mut dyn FnMut(&PosedShape) -> bool,
    ) -> bool {
        match *self {
            Self::Part(_) => visit(self),
            Self::Mesh(mesh) => {
                let mut is_known = true;
                mesh.each(probe, search, &mut |polygon, corners| {
                    search.triangle.set(Some(mesh.mesh.source(polygon)));
                    let part = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
                    is_known &= visit(&PosedShape::Part(Part::Convex(part)));
                });
                is_known
            }
            Self::Foreign(foreign) => foreign.each(probe, search, visit),
        }
    }

    /// A point of the shape, or of each of its parts if these need not hang together.
    pub fn each_point(&self, visit: &mut dyn FnMut(DVec3)) {
        let search = Search::within(f64::INFINITY);
        match self {
            Self::Part(Part::Convex(convex)) => visit(convex.furthest(DVec3::X)),
            Self::Part(Part::HalfSpace { .. }) => {}
            // Those of a compound are shapes of their own.
            Self::Foreign(foreign) if foreign.is_compound() => {
                self.each(&Probe::Everywhere, &search, &mut |part| {
                    part.each_point(visit);
                    true
                });
            }
            _ => {
                self.each(&Probe::Everywhere, &search, &mut |part| {
                    if search.goes_on() {
                        part.each_point(visit);
                    }
                    search.end();
                    true
                });
            }
        }
    }
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

    fn moved(&self, by: DVec3) -> Self {
        match *self {
            Self::Convex(convex) => Self::Convex(convex.moved(by)),
            Self::HalfSpace { normal, offset } => Self::HalfSpace {
                normal,
                offset: offset + normal.dot(by),
            },
        }
    }
}

/// Calls `visit` with all pairs of what two shapes consist of that are near each other: the two
/// boxes, or that of the first on its way and the other. False if there are such about which nothing
/// can be said.
pub fn pairs(
    search: &Search,
    a: &PosedShape,
    b: &PosedShape,
    visit: &mut dyn FnMut(&Part, &Part) -> bool,
) -> bool {
    match (a, b) {
        (PosedShape::Part(a), PosedShape::Part(b)) => visit(a, b),
        // A mesh of ours is searched for each part of the other.
        (PosedShape::Part(_), _) | (PosedShape::Mesh(_), PosedShape::Foreign(_)) => {
            let probe = a.probe(b.isometry(), search.direction);
            b.each(&probe, search, &mut |part| pairs(search, a, part, visit))
        }
        _ => {
            let probe = b.probe(a.isometry(), -search.direction);
            a.each(&probe, search, &mut |part| pairs(search, part, b, visit))
        }
    }
}

/// The gap between two that have no parts; see [`gjk::gap`]. An error if nothing can be said about
/// it.
pub fn gap(a: &Part, b: &Part, limit: f64, with_depth: bool) -> Result<Option<Gap>, Unknown> {
    match (a, b) {
        (Part::Convex(a), Part::Convex(b)) => Ok(gjk::gap(a, b, limit, with_depth)),
        (Part::HalfSpace { normal, offset }, Part::Convex(b)) => {
            let lowest = b.furthest(-*normal) - *normal * b.radius;
            let distance = lowest.dot(*normal) - offset;
            let points = [lowest - *normal * distance, lowest];
            let between = points[0].midpoint(points[1]);
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
        return Ok(first_zero(direction, 0.0, limit, near, |time| {
            gap(&a.moved(direction * time), b, f64::INFINITY, false).ok()?
        }));
    };
    let start = if let Some(corners) = b.core_triangle() {
        near_from(a, corners, direction, [b.radius, near[0]], limit)
    } else if let Some(corners) = a.core_triangle() {
        near_from(b, corners, -direction, [a.radius, near[0]], limit)
    } else {
        Some(0.0)
    };
    let Some(start) = start else {
        return Ok(None);
    };
    // What does not change on the way is looked up once.
    let radii = [a.radius, b.radius];
    if let (Some(segment), Some(corners)) = (a.core_segment(), b.core_triangle()) {
        return Ok(first_zero(direction, start, limit, near, |time| {
            let segment = segment.map(|end| end + direction * time);
            let gap = segment_triangle::gap(segment, corners, f64::INFINITY, false)?;
            Some(gap.grown(radii))
        }));
    }
    Ok(first_zero(direction, start, limit, near, |time| {
        gjk::gap(&a.moved(direction * time), b, f64::INFINITY, false)
    }))
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
) -> Option<f64> {
    let Some(up) = (b - a).cross(c - a).try_normalize() else {
        return Some(0.0);
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
        return Some(0.0);
    }
    // Along the plane or away from it, never.
    let start = if low > 0.0 { -low } else { -high } / up.dot(direction);
    (start >= 0.0 && start <= limit).then_some(start)
}

/// When the gap of one that goes in a direction and another is first no more than nothing, and how
/// they then are to each other. They have not met before `start`.
fn first_zero(
    direction: DVec3,
    start: f64,
    limit: f64,
    near: [f64; 2],
    gap_at: impl Fn(f64) -> Option<Gap>,
) -> Option<(f64, Gap)> {
    let (mut time, mut last) = (start, None);
    for _ in 0..MOST_STEPS {
        let gap = gap_at(time)?;
        let closing = gap.normal.dot(direction);
        if gap.distance <= near[usize::from(time > 0.0)] {
            // What is left of the way, but for rounding; the normal of what overlaps is that of the
            // step before.
            let rest = if time > 0.0 && closing > 0.0 {
                (gap.distance / closing).max(0.0)
            } else {
                0.0
            };
            let gap = if gap.distance > 0.0 {
                gap
            } else {
                last.unwrap_or(gap)
            };
            return Some(((time + rest).min(limit), gap));
        }
        if closing <= 0.0 {
            return None;
        }
        time += gap.distance / closing;
        last = Some(gap);
        if time > limit || time.is_nan() {
            return None;
        }
    }
    None
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

/// Where two shapes are closest to each other. `None` if nothing can be said about them, or one is
/// empty.
pub fn nearest(a: &PosedShape, b: &PosedShape) -> Option<Gap> {
    if let (PosedShape::Part(a), PosedShape::Part(b)) = (a, b) {
        return gap(a, b, f64::INFINITY, false).ok()?;
    }
    let sizes = [a.size(), b.size()].map(|size| if size.is_finite() { size } else { 0.0 });
    let apart = b.probe(a.isometry(), DVec3::ZERO).distance(a.local_box());
    let everything = apart + 4.0 * (sizes[0] + sizes[1]);
    // What is found is the closest, if it is closer than where it was looked for: everywhere, where
    // near parts come first.
    let mut margin = match (a, b) {
        (PosedShape::Part(_), PosedShape::Mesh(_)) | (PosedShape::Mesh(_), PosedShape::Part(_)) => {
            f64::INFINITY
        }
        _ => apart + (0.25 * sizes[0].min(sizes[1])).max(1e-3 * sizes[0].max(sizes[1])),
    };
    loop {
        let search = Search::nearest(margin);
        let mut best: Option<Gap> = None;
        let is_known = pairs(&search, a, b, &mut |a, b| {
            let limit = best.map_or(f64::INFINITY, |best| best.distance);
            let Ok(found) = gap(a, b, limit, false) else {
                return false;
            };
            if let Some(found) = found.filter(|found| found.distance < limit) {
                best = Some(found);
                search.margin.set(search.margin.get().min(found.distance));
                if found.distance <= 0.0 {
                    search.end();
                }
            }
            true
        });
        match best {
            _ if !is_known => return None,
            Some(found) if found.distance <= margin => return best,
            Some(found) => margin = found.distance,
            None if margin > everything => return None,
            None => margin *= 4.0,
        }
    }
}

/// Nothing can be said about two shapes.
#[derive(Clone, Copy, Debug)]
pub struct Unknown;
