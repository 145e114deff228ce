//! Shapes of `bevy_rapier3d`: what is asked about a pair in which there is one. One question decides all of it, the distance
//! of the convex shapes that the two consist of.

use std::cell::Cell;
use std::sync::{Arc, OnceLock};

use bevy::math::{DVec3, Dir3, Vec3, Vec3A, primitives::HalfSpace};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::query;
use bevy_rapier3d::parry::shape::{SharedShape, TriMesh};

use super::contact::LocalContact;
use super::convex::{Convex, Place};
use super::edge_polygon;
use super::gjk::Gap;
use super::large::length;
use super::oriented_box::effective_scale;
use super::pair::{Pair, ROUNDING};
use super::parts::{self, Body, Search, Simple};
use super::ray;
use super::triangulate::triangulate;
use super::{BoundsError, Impact, NarrowPhase, Placed, PolygonMesh, Shape, Workspace};

/// Half extents beyond this stand for infinity: parry gives endless shapes boxes of this order.
const ENDLESS: f32 = f32::MAX / 8.0;

/// How near something on its way comes to what it is going to touch before the rest is taken as straight, as a share of the
/// sizes of both.
const NEAR: f64 = 1e-7;

/// A mesh as parry knows it, made when it first meets a Rapier shape; `None` if parry refuses it.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache(OnceLock<Option<Arc<TriMesh>>>);

impl From<SharedShape> for Shape {
    fn from(shape: SharedShape) -> Self {
        Self::Rapier(shape)
    }
}

impl From<&Collider> for Shape {
    /// The collider as `bevy_rapier3d` has it now, its scale baked in.
    fn from(collider: &Collider) -> Self {
        Self::Rapier(collider.raw.clone())
    }
}

/// Centre, half extents and bounding radius of the unplaced shape.
pub(super) fn local_bounds(shape: &SharedShape) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
    let aabb = shape.compute_local_aabb();
    let (min, max) = (Vec3A::from(aabb.mins), Vec3A::from(aabb.maxs));
    if min.is_nan() || max.is_nan() {
        return Err(BoundsError::NonFinite);
    }
    let half = (max * 0.5 - min * 0.5).max(Vec3A::ZERO);
    if half.max_element() > ENDLESS {
        return Err(BoundsError::Unbounded);
    }
    Ok((min * 0.5 + max * 0.5, half, length(half)))
}

/// A half-space where it is in the world, grown by a margin and by rounding. `None` for other shapes.
pub(super) fn side(shape: &SharedShape, at: &Transform, margin: f32) -> Option<HalfSpace> {
    let outwards = at.rotation.normalize() * shape.as_halfspace()?.normal;
    let grown = margin + ROUNDING * at.translation.abs().element_sum();
    // Bevy's normals point inside.
    Some(HalfSpace::new((-outwards).extend(outwards.dot(at.translation) + grown)))
}

/// Two cuboids, of which one or both are Rapier's, as cuboids of our own: parry's test for them asserts
/// in debug builds that rounding is kind, which it is not where they touch.
pub(super) fn cuboids<T>(pair: &Pair, f: impl FnOnce(&Pair) -> T) -> Option<T> {
    let own = |placed: Placed| match placed.shape {
        Shape::Cuboid { .. } => Some((placed.shape.clone(), *placed.transform)),
        Shape::Rapier(shape) => {
            let half_size = shape.as_cuboid()?.half_extents;
            let transform = placed.transform.with_scale(Vec3::ONE);
            Some((Shape::Cuboid { half_size }, transform))
        }
        _ => None,
    };
    let ((a, at_a), (b, at_b)) = (own(pair.a)?, own(pair.b)?);
    // Boxes and tolerance are the same.
    Some(f(&Pair { a: Placed::new(&a, &at_a), b: Placed::new(&b, &at_b), ..*pair }))
}

/// Whether two shapes are no further apart than the tolerance; `None` if nothing can be said about the two.
pub(super) fn intersects(a: Placed, b: Placed, tolerance: f32) -> Option<bool> {
    let tolerance = f64::from(tolerance);
    let search = Search::within(tolerance);
    let mut found = false;
    let origin = a.transform.translation;
    let is_known = search.pairs(&body(a, origin)?, &body(b, origin)?, &mut |a, b| {
        let Ok(gap) = parts::gap(a, b, tolerance, false) else { return false };
        if gap.is_some() {
            found = true;
            search.end();
        }
        true
    });
    (found || is_known).then_some(found)
}

/// The contact of two shapes: where they are deepest in each other.
pub(super) fn contact(a: Placed, b: Placed, tolerance: f32) -> Option<LocalContact> {
    let tolerance = f64::from(tolerance);
    let search = Search::within(tolerance);
    let mut deepest: Option<Gap> = None;
    let origin = a.transform.translation;
    search.pairs(&body(a, origin)?, &body(b, origin)?, &mut |a, b| {
        let Ok(found) = parts::gap(a, b, tolerance, true) else { return false };
        if let Some(gap) = found.filter(|gap| deepest.is_none_or(|deepest| gap.distance < deepest.distance)) {
            deepest = Some(gap);
            // Beside a plane, what is further is less deep.
            if matches!((a, b), (Simple::Side { .. }, _) | (_, Simple::Side { .. })) {
                search.margin.set(gap.distance);
            }
        }
        true
    });
    deepest.map(|gap| LocalContact {
        normal: gap.normal.as_vec3a(),
        point: gap.between.as_vec3a(),
        depth: (-gap.distance).max(0.0) as f32,
    })
}

/// Where a ray meets a shape. Solids are solid.
pub(super) fn cast_ray(target: Placed, origin: Vec3, direction: Dir3, max_distance: f32) -> Option<Impact> {
    let Some(body) = body(target, origin) else { return ray_by_itself(target, origin, direction, max_distance) };
    let ray = Body::Simple(Simple::Convex(Convex::point(DVec3::ZERO)));
    let from_place = origin.as_dvec3() - target.transform.translation.as_dvec3();
    impact(&ray, (origin, ray::slack(origin, from_place)), direction, max_distance, &body)
}

/// What a shape says of which nothing else is known.
fn ray_by_itself(target: Placed, origin: Vec3, direction: Dir3, max_distance: f32) -> Option<Impact> {
    let Shape::Rapier(shape) = target.shape else { return None };
    let ray = query::Ray::new(origin - target.transform.translation, *direction);
    let met = shape.cast_ray_and_get_normal(&turn(target), &ray, max_distance.min(f32::MAX), true)?;
    let distance = met.time_of_impact;
    // No normal inside.
    let normal = met.normal.try_normalize().filter(|_| distance > 0.0).unwrap_or(-*direction);
    let normal = ray::against(normal, direction);
    let is_within = distance >= 0.0 && distance <= max_distance;
    is_within.then(|| Impact { distance, point: origin + direction * distance, normal })
}

/// How a shape is turned, at the origin.
fn turn(placed: Placed) -> Pose {
    Pose::from_parts(Vec3::ZERO, placed.transform.rotation.normalize())
}

/// Where a shape on its way meets another that it does not touch at the start.
pub(super) fn sweep(moving: Placed, direction: Dir3, max_distance: f32, target: Placed) -> Option<Impact> {
    let origin = moving.transform.translation;
    impact(&body(moving, origin)?, (origin, 0.0), direction, max_distance, &body(target, origin)?)
}

/// Where a body on its way meets another. Both are given relative to an origin, beside which is how far apart two may be at
/// the start and count as touching.
fn impact(
    moving: &Body,
    (origin, touching): (Vec3, f64),
    direction: Dir3,
    max_distance: f32,
    target: &Body,
) -> Option<Impact> {
    let way = direction.as_dvec3();
    let sizes = [moving, target].map(|body| body.size()).into_iter().filter(|size| size.is_finite());
    let near = NEAR * sizes.sum::<f64>();
    let search = Search { direction: way, limit: Cell::new(max_distance.into()), ..Search::within(near.max(touching)) };
    let mut first: Option<(f64, Gap)> = None;
    search.pairs(moving, target, &mut |a, b| {
        let Ok(found) = parts::first_impact(a, b, way, search.limit.get(), [near.max(touching), near]) else {
            return false;
        };
        if let Some((distance, _)) = found.filter(|found| first.is_none_or(|first| found.0 < first.0)) {
            search.limit.set(distance);
            first = found;
        }
        true
    });
    let (distance, gap) = first?;
    let normal = if distance > 0.0 { -gap.normal.as_vec3() } else { -*direction };
    // What overlaps at the start meets where both are: a ray from inside, where it starts.
    let met = if gap.distance < 0.0 { gap.between } else { gap.points[1] };
    let point = (origin.as_dvec3() + met).as_vec3();
    let (distance, normal) = (distance as f32, ray::against(normal, direction));
    (distance.is_finite() && point.is_finite()).then_some(Impact { distance, point, normal })
}

/// The point of a shape that is closest to another; that one itself, if it is inside.
pub(super) fn closest_point(target: Placed, point: Vec3) -> Option<Vec3> {
    let Some(body) = body(target, point) else {
        let Shape::Rapier(shape) = target.shape else { return None };
        let at = target.transform.translation;
        return Some(at + shape.project_point(&turn(target), point - at, true).point);
    };
    let at_point = Body::Simple(Simple::Convex(Convex::point(DVec3::ZERO)));
    let gap = parts::nearest(&body, &at_point)?;
    Some(if gap.distance > 0.0 { (point.as_dvec3() + gap.points[0]).as_vec3() } else { point })
}

/// A shape of Rapier's as one of ours, if it is a cuboid or a ball.
pub(super) fn own(placed: Placed) -> Option<(Shape, Transform)> {
    let Shape::Rapier(shape) = placed.shape else { return None };
    let cuboid = shape.as_cuboid().map(|cuboid| Shape::Cuboid { half_size: cuboid.half_extents });
    let own = cuboid.or_else(|| shape.as_ball().map(|ball| Shape::Sphere { radius: ball.radius }))?;
    Some((own, placed.transform.with_scale(Vec3::ONE)))
}

/// Calls `f` with two shapes, of which one or both are Rapier's cuboids or balls, as ours. `None` if neither is, or one is
/// another shape of Rapier's.
pub(super) fn with_own<T>(a: Placed, b: Placed, f: impl FnOnce(Placed, Placed) -> T) -> Option<T> {
    let is_rapier = |placed: Placed| matches!(placed.shape, Shape::Rapier(_));
    let known = |placed: Placed| match placed.shape {
        Shape::Rapier(_) => own(placed),
        shape => Some((shape.clone(), *placed.transform)),
    };
    if !is_rapier(a) && !is_rapier(b) {
        return None;
    }
    let ((a, at_a), (b, at_b)) = (known(a)?, known(b)?);
    Some(f(Placed::new(&a, &at_a), Placed::new(&b, &at_b)))
}

/// The closest points of two shapes, relative to the place of the first: the same one twice, if the two overlap.
pub(super) fn closest_points(a: Placed, b: Placed) -> Option<[Vec3A; 2]> {
    let origin = a.transform.translation;
    let gap = parts::nearest(&body(a, origin)?, &body(b, origin)?)?;
    let points = if gap.distance > 0.0 { gap.points } else { [gap.between; 2] };
    Some(points.map(|point| point.as_vec3a()))
}

/// A point of a Rapier shape, if a closed mesh is around it, given that the surfaces do not meet: parts of meshes are
/// surfaces, without an inside.
pub(super) fn enclosed(pair: &Pair, workspace: &mut Workspace) -> Option<Vec3A> {
    // The mesh second.
    let pair = match (pair.a.shape, pair.b.shape) {
        (Shape::Rapier(_), Shape::Mesh(mesh)) if mesh.is_closed() => *pair,
        (Shape::Mesh(mesh), Shape::Rapier(_)) if mesh.is_closed() => pair.swapped(),
        _ => return None,
    };
    // In the frame of the pair, by way of the centre of the box.
    let inner = body(pair.a, pair.a.transform.translation)?;
    let [center, _] = inner.local_box()?;
    let place = inner.place();
    let mut found = None;
    inner.each_point(&mut |point| {
        let from_center = (point - place.to_world(center)).as_vec3a();
        let point = pair.box_a.center + from_center;
        if found.is_none()
            && (pair.box_b.axes.transpose() * (point - pair.box_b.center)).abs().cmple(pair.box_b.half).all()
            && edge_polygon::encloses(&pair, point, workspace)
        {
            found = Some(point);
        }
    });
    found
}

/// Whether there is an answer to where two shapes meet.
pub(crate) fn is_known(a: Placed, b: Placed) -> bool {
    intersects(a, b, NarrowPhase::DEFAULT_TOLERANCE).is_some()
}

/// A shape in its place, relative to an origin, as something that can be asked; `None` for what parry knows no more of
/// than its name.
fn body<'a>(placed: Placed<'a>, origin: Vec3) -> Option<Body<'a>> {
    let at = Place::of(placed.transform, origin);
    let scale = Vec3::from(effective_scale(placed.shape, placed.transform));
    let convex = match placed.shape {
        Shape::Cuboid { half_size } => Convex::cuboid(*half_size * scale, at),
        Shape::Sphere { radius } => Convex::ball(radius * scale.x, at),
        Shape::Convex(mesh) => Convex::mesh(mesh, scale.as_dvec3(), at),
        Shape::Mesh(mesh) => {
            let parts = mesh.parry.0.get_or_init(|| convert(mesh)).as_deref()?;
            return Some(Body::Tree { parts, is_compound: false, scale: scale.as_dvec3(), at });
        }
        Shape::Rapier(shape) => return Body::of(&**shape, at),
    };
    Some(Body::Simple(Simple::Convex(convex)))
}

/// A mesh in triangles, with a tree, at its own size: scale is put on triangle by triangle.
fn convert(mesh: &PolygonMesh) -> Option<Arc<TriMesh>> {
    #[cfg(test)]
    CONVERSIONS.set(CONVERSIONS.get() + 1);
    let mut triangles = Vec::new();
    for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
        triangulate(mesh.vertices(), corners, *normal, |triangle| triangles.push(triangle));
    }
    TriMesh::new(mesh.vertices().to_vec(), triangles).ok().map(Arc::new)
}

#[cfg(test)]
thread_local! {
    /// How many meshes have been converted in this thread.
    pub(super) static CONVERSIONS: Cell<usize> = const { Cell::new(0) };
}
