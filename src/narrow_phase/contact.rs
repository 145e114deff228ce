//! Where, which way and how deep two shapes meet.

use bevy::math::{Vec3, Vec3A};

use super::edge_polygon::{self, Hit};
use super::pair::{Pair, in_order};
use super::separation::{Separation, sign};
use super::{NarrowPhase, Placed, Shape, Workspace, convex_contact};

/// How often to go back and forth between two cuboids in search of a point of both: twice is the rule.
const MOST_STEPS: usize = 8;

/// The geometry of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// A unit vector from the first shape to the second: to part the two, push the second along it.
    pub normal: Vec3,
    /// A point where the two meet, in the world.
    pub point: Vec3,
    /// How far the shapes overlap along the normal, in world units. Zero if they touch, or are apart by
    /// no more than the tolerance.
    pub depth: f32,
}

/// A contact in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalContact {
    pub normal: Vec3A,
    pub point: Vec3A,
    pub depth: f32,
}

impl LocalContact {
    /// That of the pair with its two shapes swapped.
    fn reversed(self) -> Self {
        let normal = -self.normal;
        Self { normal, ..self }
    }
}

impl NarrowPhase {
    /// The contact of two shapes: some if and only if they [intersect](Self::intersects), which counts
    /// the stages once.
    ///
    /// Swapping the two turns the normal around exactly and changes nothing else, unless they are equal
    /// in all things, place included. The normal is
    ///
    /// * for two cuboids or convex meshes, the axis along which they overlap least; normals of faces are
    ///   preferred to products of edges that are hardly better (and only they are tried if the two
    ///   meshes have more than 1 024 pairs of edges), those of one shape to those of the other;
    /// * for a sphere, the direction of the closest point of the other shape;
    /// * for other meshes, an approximation: the mean normal of the polygons that are crossed. The depth
    ///   is then how far the crossing reaches along it;
    /// * for Rapier shapes, what parry finds;
    /// * where all that fails (a mesh inside another, without crossing), the direction from centre to
    ///   centre, and +Y if these coincide. The depth is then the overlap of the two boxes that way.
    #[must_use]
    pub fn contact(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Contact> {
        if !self.intersects(a, b, workspace) {
            return None;
        }
        let (first, second, swapped) = in_order(a, b);
        let origin = Vec3A::from(first.transform.translation);
        let found = match Pair::new(first, second, self.tolerance()) {
            Ok(pair) => local_contact(&pair, workspace),
            Err(_) => unbounded_contact(first, second, self.tolerance()),
        };
        let found = if swapped { found.reversed() } else { found };
        Some(Contact {
            normal: found.normal.into(),
            point: (origin + found.point).into(),
            depth: found.depth,
        })
    }
}

fn local_contact(pair: &Pair, workspace: &mut Workspace) -> LocalContact {
    let found = match (pair.a.shape, pair.b.shape) {
        #[cfg(feature = "rapier")]
        (Shape::Rapier(_), _) | (_, Shape::Rapier(_)) => {
            super::parry::contact(pair.a, pair.b, pair.tolerance)
        }
        (Shape::Sphere { .. }, Shape::Sphere { .. }) => spheres(pair),
        (Shape::Sphere { .. }, _) => sphere_other(pair, workspace),
        (_, Shape::Sphere { .. }) => {
            sphere_other(&pair.swapped(), workspace).map(LocalContact::reversed)
        }
        (Shape::Cuboid { .. }, Shape::Cuboid { .. }) => cuboids(pair, workspace),
        (Shape::Cuboid { .. } | Shape::Convex(_), Shape::Cuboid { .. } | Shape::Convex(_)) => {
            convex_contact::contact(pair, workspace)
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
    // From the sphere to the other: the way to the surface, or back from it if the centre is inside.
    let towards = offset.try_normalize().filter(|_| distance > pair.tolerance);
    let (normal, depth) = match (towards, inside) {
        (Some(towards), false) => (towards, radius - distance),
        (Some(towards), true) => (-towards, radius + distance),
        (None, _) => (-outwards, radius),
    };
    Some(LocalContact {
        normal: normal.try_normalize()?,
        point,
        depth: depth.max(0.0),
    })
}

/// The point on a cuboid closest to the centre of a sphere, its normal, and whether the centre is inside.
fn sphere_cuboid(pair: &Pair) -> (Vec3A, Vec3A, bool) {
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

fn cuboids(pair: &Pair, workspace: &mut Workspace) -> Option<LocalContact> {
    let found = Separation::of(&pair.box_a, &pair.box_b, f32::INFINITY)?;
    let point = common_point(pair).or_else(|| mean_hit(pair, workspace));
    Some(LocalContact {
        normal: found.axis,
        point: point?,
        depth: (-found.along).max(0.0),
    })
}

/// A point of two boxes, found by going back and forth between them; `None` if that takes too long.
fn common_point(pair: &Pair) -> Option<Vec3A> {
    let (a, b) = (&pair.box_a, &pair.box_b);
    // From near the smaller one, the way is short.
    let share = a.radius / (a.radius + b.radius).max(f32::MIN_POSITIVE);
    let mut on_a = a.center.lerp(b.center, share);
    (0..MOST_STEPS).find_map(|_| {
        let on_b = b.closest_point(on_a);
        on_a = a.closest_point(on_b);
        let close = on_a.distance_squared(on_b) <= pair.tolerance * pair.tolerance;
        close.then(|| on_a.midpoint(on_b))
    })
}

/// The mean of the places where edges of one shape meet polygons of the other. It is in both shapes, to
/// within the tolerance, if they are convex.
pub(super) fn mean_hit(pair: &Pair, workspace: &mut Workspace) -> Option<Vec3A> {
    let (mut count, mut points) = (0.0, Vec3A::ZERO);
    edge_polygon::hits(pair, workspace, |Hit { point, .. }| {
        count += 1.0;
        points += point;
    });
    (count > 0.0).then(|| points / count)
}

/// Meshes of any form: the mean of all crossings.
fn meshes(pair: &Pair, workspace: &mut Workspace) -> Option<LocalContact> {
    let (mut count, mut points, mut normals) = (0.0, Vec3A::ZERO, Vec3A::ZERO);
    edge_polygon::hits(pair, workspace, |Hit { point, normal }| {
        count += 1.0;
        points += point;
        normals += normal;
    });
    // Normals that cancel out leave rounding behind, and no direction.
    let normal = normals
        .try_normalize()
        .filter(|_| normals.length() > 1e-3 * count);
    let normal = normal.unwrap_or_else(|| center_direction(pair));
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    edge_polygon::hits(pair, workspace, |hit| {
        low = low.min(hit.point.dot(normal));
        high = high.max(hit.point.dot(normal));
    });
    (count > 0.0).then(|| LocalContact {
        normal,
        point: points / count,
        depth: high - low,
    })
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
    LocalContact {
        normal,
        point: smaller.center,
        depth: (extents - (b.center - a.center).dot(normal)).max(0.0),
    }
}

#[cfg(feature = "rapier")]
fn unbounded_contact(a: Placed, b: Placed, tolerance: f32) -> LocalContact {
    super::parry::contact(a, b, tolerance).unwrap_or_else(|| straight(a, b))
}

#[cfg(not(feature = "rapier"))]
fn unbounded_contact(a: Placed, b: Placed, _tolerance: f32) -> LocalContact {
    straight(a, b)
}

/// From place to place, for want of bounds.
fn straight(a: Placed, b: Placed) -> LocalContact {
    let offset = Vec3A::from(b.transform.translation - a.transform.translation);
    LocalContact {
        normal: offset.try_normalize().unwrap_or(Vec3A::Y),
        point: offset * 0.5,
        depth: 0.0,
    }
}
