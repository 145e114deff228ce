//! Where a sphere meets another shape.

use bevy::math::Vec3A;

use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        edge_polygon, placed::PlacedPair, separation::sign, surface::ClosestPoint,
        workspace::Workspace,
    },
    shape::{Kind, Shape},
};

/// Two spheres.
pub fn spheres(pair: &PlacedPair) -> Option<LocalContact> {
    let (a, b) = (&pair.box_a, &pair.box_b);
    let offset = b.center - a.center;
    let normal = offset.try_normalize()?;
    let gap = offset.length() - (a.radius + b.radius);
    Some(LocalContact {
        normal,
        // Halfway between the two surfaces.
        point: a.center + normal * (a.radius + 0.5 * gap),
        depth: (-gap).max(0.0),
    })
}

/// A sphere, the first of the pair, and a shape made of polygons.
pub fn sphere_other(pair: &PlacedPair, workspace: &mut Workspace) -> Option<LocalContact> {
    let met = match pair.b.shape.kind() {
        Kind::Cuboid => sphere_cuboid(pair),
        _ => on_mesh(pair, edge_polygon::sphere_closest(pair, workspace)?),
    };
    from_point(pair, met)
}

/// A sphere, the first of the pair, and a mesh, of which it is not known whether they are in
/// contact: `None` if not. The contact is none if there is no direction for it.
pub fn sphere_mesh(pair: &PlacedPair, workspace: &mut Workspace) -> Option<Option<LocalContact>> {
    let found = edge_polygon::sphere_touching(pair, workspace)?;
    Some(from_point(pair, on_mesh(pair, found)))
}

/// The point of a mesh closest to the centre of a sphere, the way out there, and whether the centre
/// is inside.
fn on_mesh(pair: &PlacedPair, (closest, inside): (ClosestPoint, bool)) -> (Vec3A, Vec3A, bool) {
    let side = side(pair, &closest);
    (closest.point, closest.normal * side, inside)
}

/// The contact of a sphere with a surface of which the closest point is known.
fn from_point(
    pair: &PlacedPair,
    (point, outwards, inside): (Vec3A, Vec3A, bool),
) -> Option<LocalContact> {
    let center = pair.box_a.center;
    let radius = pair.box_a.radius;
    let offset = point - center;
    let distance = offset.length();
    // From the sphere to the other: the way to the surface, or back from it if the centre is
    // inside.
    let towards = offset.try_normalize().filter(|_| distance > pair.tolerance);
    let (normal, depth) = match (towards, inside) {
        (Some(towards), false) => (towards, radius - distance),
        (Some(towards), true) => (-towards, radius + distance),
        (None, _) => (-outwards, radius),
    };
    // Further inside than it is large, the sphere does not reach the surface.
    let point = match towards {
        Some(towards) if inside && distance > radius => center + towards * radius,
        _ => point,
    };
    Some(LocalContact {
        normal: normal.try_normalize()?,
        point,
        depth: depth.max(0.0),
    })
}

/// Which way a sphere leaves a mesh, the second of the pair, whose surface its centre is on: 1 along
/// the normal of the polygon there, -1 against it. Outwards, off a solid; off a surface, to the side
/// that the centre is on.
fn side(pair: &PlacedPair, closest: &ClosestPoint) -> f32 {
    let bounds_solid = match pair.b.shape {
        Shape::Mesh(mesh) => mesh.bounds_solid(closest.polygon as usize),
        _ => true,
    };
    let height = (pair.box_a.center - closest.point).dot(closest.normal);
    if bounds_solid || height >= 0.0 {
        1.0
    } else {
        -1.0
    }
}

/// The point on a cuboid closest to the centre of a sphere, its normal, and whether the centre is
/// inside.
fn sphere_cuboid(pair: &PlacedPair) -> (Vec3A, Vec3A, bool) {
    let (center, cuboid) = (pair.box_a.center, &pair.box_b);
    let local = cuboid.axes.transpose() * (center - cuboid.center);
    let axis = (local.abs() - cuboid.half).max_position();
    let outwards = cuboid.axes.col(axis) * sign(local[axis]);
    let inside = local.abs().cmple(cuboid.half).all();
    let point = if inside {
        center + outwards * (cuboid.half[axis] - local[axis].abs())
    } else {
        cuboid.closest_point(center)
    };
    (point, outwards, inside)
}
