//! Where, which way and how deep two shapes meet.

use bevy::math::Vec3A;

use super::convex;
#[cfg(feature = "rapier")]
use crate::narrow_phase::parry::{own, query};
use crate::narrow_phase::{
    answer::{Contact, LocalContact},
    error::BoundsError,
    frame::{
        common_point::{common_point, mean_hit},
        edge_polygon::{self, Hit},
        large::Smaller,
        placed::{Pair, Placed, in_order},
        separation::{Separation, sign},
        workspace::Workspace,
    },
    settings::NarrowPhase,
    shape::Shape,
};

impl NarrowPhase {
    /// The contact of two shapes: some if and only if they [intersect](Self::intersects), which
    /// counts the stages once.
    ///
    /// Swapping the two turns the normal around exactly and changes nothing else, unless they are
    /// equal in all things, place included. The normal is
    ///
    /// * for two cuboids or convex meshes, the axis along which they overlap least; normals of
    ///   faces are preferred to products of edges that are hardly better (and only they are tried
    ///   if the two meshes have more than 1 024 pairs of edges), those of one shape to those of the
    ///   other;
    /// * for a sphere, the direction of the closest point of the other shape;
    /// * for other meshes, an approximation: the mean normal of the polygons that are crossed. The
    ///   depth is then how far the crossing reaches along it;
    /// * for Rapier shapes, that along which they overlap least; of shapes that consist of parts, that of the two that are
    ///   deepest in each other;
    /// * where all that fails (a mesh inside another, without crossing), the direction from centre
    ///   to centre, and +Y if these coincide. The depth is then the overlap of the two boxes that
    ///   way.
    #[must_use]
    pub fn contact(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Contact> {
        if !self.intersects(a, b, workspace) {
            return None;
        }
        let (first, second, swapped) = in_order(a, b);
        let origin = Vec3A::from(first.transform.translation);
        let found = match Pair::new(first, second, self.tolerance()) {
            Ok(pair) if pair.is_large() => {
                let found =
                    self.large_contact(&pair, workspace).map(|found| if swapped { found.reversed() } else { found });
                if found.is_some() {
                    return found;
                }
                local_contact(&pair, workspace)
            }
            Ok(pair) => local_contact(&pair, workspace),
            Err(BoundsError::Unbounded) => unbounded_contact(first, second, self.tolerance()),
            // So large that squares are beyond all numbers.
            Err(BoundsError::NonFinite) => straight(first, second),
        };
        let found = if swapped { found.reversed() } else { found };
        Some(Contact { normal: found.normal.into(), point: (origin + found.point).into(), depth: found.depth })
    }
}

/// # Of what is large
impl NarrowPhase {
    /// That of two shapes of ours at a smaller scale, in the order in which pairs are computed.
    #[cold]
    fn large_contact(&self, pair: &Pair, workspace: &mut Workspace) -> Option<Contact> {
        // The stages have been counted.
        let counters = workspace.counters;
        let found = match Smaller::of(pair, self) {
            Some(smaller) => {
                let [a, b] = smaller.placed(pair);
                let found = smaller.tests.contact(a, b, workspace);
                let larger = |found: Contact| Contact {
                    point: found.point * smaller.factor,
                    depth: (found.depth * smaller.factor).min(f32::MAX),
                    ..found
                };
                found.map(larger)
            }
            #[cfg(feature = "rapier")]
            None => own::with_own(pair.a, pair.b, |a, b| self.contact(a, b, workspace)).flatten(),
            #[cfg(not(feature = "rapier"))]
            None => None,
        };
        workspace.counters = counters;
        found
    }
}

fn local_contact(pair: &Pair, workspace: &mut Workspace) -> LocalContact {
    let found = match (pair.a.shape, pair.b.shape) {
        #[cfg(feature = "rapier")]
        (Shape::Rapier(_), _) | (_, Shape::Rapier(_)) => {
            let own = own::cuboids(pair, |pair| cuboids(pair, workspace));
            own.unwrap_or_else(|| query::contact(pair.a, pair.b, pair.tolerance))
        }
        (Shape::Sphere { .. }, Shape::Sphere { .. }) => spheres(pair),
        (Shape::Sphere { .. }, _) => sphere_other(pair, workspace),
        (_, Shape::Sphere { .. }) => sphere_other(&pair.swapped(), workspace).map(LocalContact::reversed),
        (Shape::Cuboid { .. }, Shape::Cuboid { .. }) => cuboids(pair, workspace),
        (Shape::Cuboid { .. } | Shape::Convex(_), Shape::Cuboid { .. } | Shape::Convex(_)) => {
            convex::contact(pair, workspace)
        }
        _ => meshes(pair, workspace),
    };
    found.unwrap_or_else(|| from_centers(pair))
}

fn spheres(pair: &Pair) -> Option<LocalContact> {
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

/// A sphere, the first of the pair, and a shape which is none.
fn sphere_other(pair: &Pair, workspace: &mut Workspace) -> Option<LocalContact> {
    let center = pair.box_a.center;
    let radius = pair.box_a.radius;
    let (point, outwards, inside) = match pair.b.shape {
        Shape::Cuboid { .. } => sphere_cuboid(pair),
        _ => {
            let (closest, inside) = edge_polygon::sphere_closest(pair, workspace)?;
            (closest.point, closest.normal, inside)
        }
    };
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
    Some(LocalContact { normal: normal.try_normalize()?, point, depth: depth.max(0.0) })
}

/// The point on a cuboid closest to the centre of a sphere, its normal, and whether the centre is
/// inside.
fn sphere_cuboid(pair: &Pair) -> (Vec3A, Vec3A, bool) {
    let (center, cuboid) = (pair.box_a.center, &pair.box_b);
    let local = cuboid.axes.transpose() * (center - cuboid.center);
    let axis = (local.abs() - cuboid.half).max_position();
    let outwards = cuboid.axes.col(axis) * sign(local[axis]);
    let inside = local.abs().cmple(cuboid.half).all();
    let point =
        if inside { center + outwards * (cuboid.half[axis] - local[axis].abs()) } else { cuboid.closest_point(center) };
    (point, outwards, inside)
}

fn cuboids(pair: &Pair, workspace: &mut Workspace) -> Option<LocalContact> {
    let found = Separation::of(&pair.box_a, &pair.box_b, f32::INFINITY)?;
    let point = common_point(pair).or_else(|| mean_hit(pair, workspace));
    Some(LocalContact { normal: found.axis, point: point?, depth: (-found.along).max(0.0) })
}

/// Meshes of any form: the mean of all crossings.
fn meshes(pair: &Pair, workspace: &mut Workspace) -> Option<LocalContact> {
    let (mut count, mut points, mut normals) = (0.0, Vec3A::ZERO, Vec3A::ZERO);
    edge_polygon::hits(pair, workspace, |Hit { point, normal, .. }| {
        count += 1.0;
        points += point;
        normals += normal;
    });
    // Normals that cancel out leave rounding behind, and no direction.
    let normal = normals.try_normalize().filter(|_| normals.length() > 1e-3 * count);
    let normal = normal.unwrap_or_else(|| center_direction(pair));
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    edge_polygon::hits(pair, workspace, |hit| {
        low = low.min(hit.point.dot(normal));
        high = high.max(hit.point.dot(normal));
    });
    (count > 0.0).then(|| LocalContact { normal, point: points / count, depth: high - low })
}

fn center_direction(pair: &Pair) -> Vec3A {
    let offset = pair.box_b.center - pair.box_a.center;
    offset.try_normalize().unwrap_or(Vec3A::Y)
}

/// The last resort: the boxes, from centre to centre.
fn from_centers(pair: &Pair) -> LocalContact {
    let (a, b) = (&pair.box_a, &pair.box_b);
    let normal = center_direction(pair);
    let extents = a.extent(normal) + b.extent(normal);
    let smaller = if b.radius < a.radius { b } else { a };
    LocalContact { normal, point: smaller.center, depth: (extents - (b.center - a.center).dot(normal)).max(0.0) }
}

#[cfg(feature = "rapier")]
fn unbounded_contact(a: Placed, b: Placed, tolerance: f32) -> LocalContact {
    query::contact(a, b, tolerance).unwrap_or_else(|| straight(a, b))
}

#[cfg(not(feature = "rapier"))]
fn unbounded_contact(a: Placed, b: Placed, _tolerance: f32) -> LocalContact {
    straight(a, b)
}

/// From place to place, for want of bounds.
fn straight(a: Placed, b: Placed) -> LocalContact {
    let offset = Vec3A::from(b.transform.translation - a.transform.translation);
    LocalContact { normal: offset.try_normalize().unwrap_or(Vec3A::Y), point: offset * 0.5, depth: 0.0 }
}
