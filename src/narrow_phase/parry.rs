//! Shapes of `bevy_rapier3d`, decided by parry.

use std::cell::Cell;
use std::sync::{Once, OnceLock};

use bevy::math::{Dir3, Vec3, Vec3A, primitives::HalfSpace};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::partitioning::BvhNode;
use bevy_rapier3d::parry::query::{self, ClosestPoints, ShapeCastOptions, Unsupported};
use bevy_rapier3d::parry::shape::{self, SharedShape, TriMesh};

use super::contact::{LocalContact, MOST_STEPS};
use super::edge_polygon;
use super::oriented_box::effective_scale;
use super::pair::{Pair, ROUNDING};
use super::ray;
use super::triangulate::triangulate;
use super::{BoundsError, Impact, Placed, PolygonMesh, Shape, Workspace};

/// Half extents beyond this stand for infinity: parry gives endless shapes boxes of this order.
const ENDLESS: f32 = f32::MAX / 8.0;

/// A mesh as parry knows it, made when it first meets a Rapier shape; `None` if parry refuses it.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache(OnceLock<Option<SharedShape>>);

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
    Ok((min * 0.5 + max * 0.5, half, half.length()))
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

/// Whether parry finds the two to overlap, or no further apart than the tolerance.
pub(super) fn intersects(a: Placed, b: Placed, tolerance: f32) -> bool {
    let decide = |a: &dyn shape::Shape, at_a: &Pose, b: &dyn shape::Shape, at_b: &Pose| {
        Ok(query::intersection_test(at_a, a, at_b, b)? || query::distance(at_a, a, at_b, b)? <= tolerance)
    };
    ask(a, b, decide).unwrap_or(false)
}

/// The contact that parry finds.
pub(super) fn contact(a: Placed, b: Placed, tolerance: f32) -> Option<LocalContact> {
    let origin = a.transform.translation;
    let of_half_space = half_space_contact(a, b, origin)
        .or_else(|| half_space_contact(b, a, origin).map(|found| LocalContact { normal: -found.normal, ..found }));
    if of_half_space.is_some() {
        return of_half_space;
    }
    let contact = ask(a, b, |a, at_a, b, at_b| query::contact(at_a, a, at_b, b, tolerance))??;
    Some(LocalContact {
        normal: Vec3A::from(contact.normal1).try_normalize()?,
        point: contact.point1.midpoint(contact.point2).into(),
        depth: (-contact.dist).max(0.0),
    })
}

/// The contact of a half-space and another shape. Parry's own takes the place of the one for that of the other if the
/// half-space is the second, or the other consists of parts.
fn half_space_contact(side: Placed, other: Placed, origin: Vec3) -> Option<LocalContact> {
    let Shape::Rapier(shape) = side.shape else { return None };
    let normal = side.transform.rotation.normalize() * shape.as_halfspace()?.normal;
    let from_side = other.transform.translation - side.transform.translation;
    let at = Pose::from_parts(from_side, other.transform.rotation.normalize());
    let deepest = with_shape(other, |other| deepest(other, &at, normal))??;
    let depth = -deepest.dot(normal);
    let point = side.transform.translation - origin + deepest + normal * (depth * 0.5);
    Some(LocalContact { normal: normal.into(), point: point.into(), depth: depth.max(0.0) })
}

/// The point of a shape that is farthest against a direction.
fn deepest(shape: &dyn shape::Shape, at: &Pose, up: Vec3) -> Option<Vec3> {
    if let Some(convex) = shape.as_support_map() {
        return Some(convex.support_point(at, -up));
    }
    let parts = shape.as_composite_shape()?;
    let own_up = at.rotation.inverse() * up;
    let lowest = Cell::new(f32::INFINITY);
    let may_be_lower = |node: &BvhNode| {
        let low = Vec3::select(own_up.cmpge(Vec3::ZERO), node.mins(), node.maxs());
        low.dot(own_up) + at.translation.dot(up) <= lowest.get()
    };
    let mut found = None;
    for part in parts.bvh().leaves(may_be_lower) {
        parts.map_part_at(part, &mut |part_at, part, _| {
            let at = part_at.map_or(*at, |part_at| *at * *part_at);
            if let Some(point) = deepest(part, &at, up).filter(|point| point.dot(up) < lowest.get()) {
                lowest.set(point.dot(up));
                found = Some(point);
            }
        });
    }
    found
}

/// Where a ray meets a shape. Solids are solid.
pub(super) fn cast_ray(
    shape: &SharedShape,
    at: &Transform,
    origin: Vec3,
    direction: Dir3,
    max_distance: f32,
) -> Option<Impact> {
    // Relative to the shape, so that a place far from the world's origin costs no exactness.
    let pose = Pose::from_parts(Vec3::ZERO, at.rotation.normalize());
    let ray = query::Ray::new(origin - at.translation, *direction);
    let met = shape.cast_ray_and_get_normal(&pose, &ray, max_distance.min(f32::MAX), true)?;
    let distance = met.time_of_impact;
    // No normal inside.
    let normal = met.normal.try_normalize().filter(|_| distance > 0.0).unwrap_or(-*direction);
    let normal = ray::against(normal, direction);
    let is_within = distance >= 0.0 && distance <= max_distance;
    is_within.then(|| Impact { distance, point: origin + direction * distance, normal })
}

/// The point of a shape that is closest to another; that one itself, if it is inside.
pub(super) fn closest_point(shape: &SharedShape, at: &Transform, point: Vec3) -> Vec3 {
    let pose = Pose::from_parts(Vec3::ZERO, at.rotation.normalize());
    at.translation + shape.project_point(&pose, point - at.translation, true).point
}

/// Where a shape on its way meets another that it does not touch at the start.
pub(super) fn sweep(moving: Placed, direction: Dir3, max_distance: f32, target: Placed) -> Option<Impact> {
    let options = ShapeCastOptions::with_max_time_of_impact(max_distance.min(f32::MAX));
    let hit =
        ask(moving, target, |a, at_a, b, at_b| query::cast_shapes(at_a, *direction, a, at_b, Vec3::ZERO, b, options))??;
    let distance = hit.time_of_impact;
    // The second witness is in the target's own coordinates.
    let rotation = target.transform.rotation.normalize();
    let point = target.transform.translation + rotation * hit.witness2;
    let normal = rotation * hit.normal2;
    let normal = normal.try_normalize().unwrap_or(-*direction);
    let normal = ray::against(normal, direction);
    Some(Impact { distance, point, normal })
}

/// Calls `f` with two shapes, of which one or both are Rapier's cuboids or balls, as ours. `None` if neither is, or one is
/// another shape of Rapier's.
pub(super) fn with_own<T>(a: Placed, b: Placed, f: impl FnOnce(Placed, Placed) -> T) -> Option<T> {
    let is_rapier = |placed: Placed| matches!(placed.shape, Shape::Rapier(_));
    let own = |placed: Placed| match placed.shape {
        Shape::Rapier(shape) => {
            let cuboid = shape.as_cuboid().map(|cuboid| Shape::Cuboid { half_size: cuboid.half_extents });
            let own = cuboid.or_else(|| shape.as_ball().map(|ball| Shape::Sphere { radius: ball.radius }))?;
            Some((own, placed.transform.with_scale(Vec3::ONE)))
        }
        shape => Some((shape.clone(), *placed.transform)),
    };
    if !is_rapier(a) && !is_rapier(b) {
        return None;
    }
    let ((a, at_a), (b, at_b)) = (own(a)?, own(b)?);
    Some(f(Placed::new(&a, &at_a), Placed::new(&b, &at_b)))
}

/// The closest points that parry finds, relative to the place of the first shape: the same one twice, if the two overlap.
pub(super) fn closest_points(a: Placed, b: Placed) -> Option<[Vec3A; 2]> {
    let closest = |a: &dyn shape::Shape, at_a: &Pose, b: &dyn shape::Shape, at_b: &Pose| {
        query::closest_points(at_a, a, at_b, b, f32::MAX)
    };
    match ask(a, b, closest)? {
        ClosestPoints::WithinMargin(on_a, on_b) => Some([on_a.into(), on_b.into()]),
        ClosestPoints::Intersecting => common_point(a, b).map(|point| [point; 2]),
        ClosestPoints::Disjoint => None,
    }
}

/// A point of two shapes that overlap, found by going back and forth between them.
fn common_point(a: Placed, b: Placed) -> Option<Vec3A> {
    let meet = |a: &dyn shape::Shape, at_a: &Pose, b: &dyn shape::Shape, at_b: &Pose| {
        let start = query::contact(at_a, a, at_b, b, 0.0)?.map_or(at_b.translation, |contact| contact.point1);
        let step = |point, _| a.project_point(at_a, b.project_point(at_b, point, true).point, true).point;
        Ok((0..MOST_STEPS).fold(start, step))
    };
    ask(a, b, meet).map(Vec3A::from)
}

/// A point of a Rapier shape, if a closed mesh is around it: parry knows meshes as surfaces without
/// an inside.
///
/// One point of the Rapier shape decides, given that the surfaces do not meet.
pub(super) fn enclosed(pair: &Pair, workspace: &mut Workspace) -> Option<Vec3A> {
    // The Rapier shape first.
    let (pair, inner) = match (pair.a.shape, pair.b.shape) {
        (Shape::Rapier(inner), _) => (*pair, inner),
        (_, Shape::Rapier(inner)) => (pair.swapped(), inner),
        _ => return None,
    };
    let beside = Vec3::from(pair.box_a.half) * 2.0 + Vec3::ONE;
    let on_surface = inner.project_local_point(beside, false).point;
    // In the frame of the pair, by way of the centre of the box.
    let from_center = Vec3A::from(on_surface - inner.compute_local_aabb().center());
    let point = pair.box_a.center + pair.box_a.axes * from_center;
    edge_polygon::encloses(&pair, point, workspace).then_some(point)
}

/// Puts a question about two shapes to parry. `None` without an answer, of which a warning tells
/// once.
fn ask<T>(
    a: Placed,
    b: Placed,
    question: impl FnOnce(&dyn shape::Shape, &Pose, &dyn shape::Shape, &Pose) -> Result<T, Unsupported>,
) -> Option<T> {
    let origin = a.transform.translation;
    let pose = |at: &Transform| Pose::from_parts(at.translation - origin, at.rotation.normalize());
    let (at_a, at_b) = (pose(a.transform), pose(b.transform));
    let answer = with_shape(a, |a| with_shape(b, |b| question(a, &at_a, b, &at_b).ok()));
    let answer = answer.flatten().flatten();
    if answer.is_none() {
        static WARNED: Once = Once::new();
        WARNED.call_once(|| {
            tracing::warn!(
                "parry cannot decide whether {:?} and {:?} are in contact: they count as apart",
                a.shape,
                b.shape
            );
        });
    }
    answer
}

/// Calls `f` with the shape as parry knows it, if it can.
fn with_shape<T>(placed: Placed, f: impl FnOnce(&dyn shape::Shape) -> T) -> Option<T> {
    let scale = Vec3::from(effective_scale(placed.shape, placed.transform));
    match placed.shape {
        Shape::Cuboid { half_size } => Some(f(&shape::Cuboid::new((half_size * scale).abs()))),
        Shape::Sphere { radius } => Some(f(&shape::Ball::new(radius.abs() * scale.x))),
        Shape::Convex(mesh) => with_mesh(mesh, scale, f),
        Shape::Mesh(mesh) => with_mesh(mesh, scale, f),
        Shape::Rapier(shape) => Some(f(&**shape)),
    }
}

/// A mesh at its own size is converted once; at another, each time.
fn with_mesh<T>(mesh: &PolygonMesh, scale: Vec3, f: impl FnOnce(&dyn shape::Shape) -> T) -> Option<T> {
    if scale == Vec3::ONE {
        let shared = mesh.parry.0.get_or_init(|| convert(mesh, scale).map(SharedShape::new));
        shared.as_deref().map(f)
    } else {
        convert(mesh, scale).map(|mesh| f(&mesh))
    }
}

fn convert(mesh: &PolygonMesh, scale: Vec3) -> Option<TriMesh> {
    let vertices = mesh.vertices().iter().map(|vertex| vertex * scale).collect();
    let mut triangles = Vec::new();
    for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
        triangulate(mesh.vertices(), corners, *normal, |triangle| triangles.push(triangle));
    }
    TriMesh::new(vertices, triangles).ok()
}
