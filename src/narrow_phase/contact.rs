//! Where, which way and how deep two shapes meet.

use bevy::{
    math::{Vec3, Vec3A},
    reflect::Reflect,
};

use super::edge_polygon::{self, Hit};
use super::large::Smaller;
use super::pair::{Pair, in_order};
use super::separation::{Separation, sign};
use super::{BoundsError, NarrowPhase, Placed, Shape, Workspace, convex_contact};

/// How often to go back and forth between two shapes in search of a point of both: twice is the
/// rule.
pub(super) const MOST_STEPS: usize = 8;

/// The geometry of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct Contact {
    /// A unit vector from the first shape to the second: to part the two, push the second along it.
    pub normal: Vec3,
    /// A point where the two meet, in the world.
    pub point: Vec3,
    /// How far the shapes overlap along the normal, in world units. Zero if they touch, or are
    /// apart by no more than the tolerance.
    pub depth: f32,
}

impl Contact {
    /// The contact as the other shape sees it: with the normal turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, ..self }
    }
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
            None => super::parry::with_own(pair.a, pair.b, |a, b| self.contact(a, b, workspace)).flatten(),
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
            let own = super::parry::cuboids(pair, |pair| cuboids(pair, workspace));
            own.unwrap_or_else(|| super::parry::contact(pair.a, pair.b, pair.tolerance))
        }
        (Shape::Sphere { .. }, Shape::Sphere { .. }) => spheres(pair),
        (Shape::Sphere { .. }, _) => sphere_other(pair, workspace),
        (_, Shape::Sphere { .. }) => sphere_other(&pair.swapped(), workspace).map(LocalContact::reversed),
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

/// A point of two boxes, found by going back and forth between them; `None` if that takes too long.
pub(super) fn common_point(pair: &Pair) -> Option<Vec3A> {
    let (a, b) = (&pair.box_a, &pair.box_b);
    // From near the smaller one, the way is short.
    let ratio = b.radius / a.radius.max(f32::MIN_POSITIVE);
    let share = 1.0 / (1.0 + ratio * ratio);
    let mut on_a = a.center.lerp(b.center, share);
    (0..MOST_STEPS).find_map(|_| {
        let on_b = b.closest_point(on_a);
        on_a = a.closest_point(on_b);
        let close = on_a.distance_squared(on_b) <= pair.tolerance * pair.tolerance;
        close.then(|| on_a.midpoint(on_b))
    })
}

/// The mean of the places where edges of one shape meet polygons of the other. It is in both
/// shapes, to within the tolerance, if they are convex.
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
    super::parry::contact(a, b, tolerance).unwrap_or_else(|| straight(a, b))
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

#[cfg(test)]
mod tests {
    use super::super::tests::{at, box_of, mesh_of};
    use super::*;
    use bevy::math::Quat;
    use bevy::transform::components::Transform;

    fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Contact {
        let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
        let mut workspace = Workspace::default();
        let tests = NarrowPhase::default();
        let found = tests.contact(one, two, &mut workspace).unwrap();
        let back = tests.contact(two, one, &mut workspace).unwrap();
        let normal = -back.normal;
        assert_eq!(found, Contact { normal, ..back });
        found
    }

    fn assert_close(found: Contact, normal: Vec3, depth: f32) {
        let off = (found.normal - normal).length().max((found.depth - depth).abs());
        assert!(off < 1e-4, "{found:?}, expected {normal} {depth}");
    }

    #[test]
    fn every_kind_of_pair_pushes_the_second_away() {
        let (cube, ball) = (box_of(1.0, 1.0, 1.0), Shape::sphere(1.0).unwrap());
        let (mesh, here) = (mesh_of(Vec3::ONE), at(0.0, 0.0, 0.0));
        let convex = Shape::convex(
            mesh_vertices(&mesh).to_vec(),
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
        );
        let convex = convex.unwrap();
        for a in [&cube, &ball, &mesh, &convex] {
            for b in [&cube, &ball, &mesh, &convex] {
                let found = contact((a, here), (b, at(0.0, 1.75, 0.0)));
                assert_close(found, Vec3::Y, 0.25);
                assert!((found.point.y - 0.875).abs() < 0.126, "{found:?}");
                let touching = contact((a, at(1.0, 0.0, 0.0)), (b, at(-1.0, 0.0, 0.0)));
                assert_close(touching, Vec3::NEG_X, 0.0);
                let off = touching.point.abs();
                assert!(off.x < 1e-4 && off.y.max(off.z) < 0.2, "{touching:?}");
            }
        }
    }

    #[test]
    fn a_mirror_does_not_turn_a_mesh_inside_out() {
        let mesh = mesh_of(Vec3::ONE);
        let mirrored = at(0.0, 0.0, 0.0).with_scale(Vec3::new(-1.0, 1.0, 1.0));
        let found = contact((&mesh, mirrored), (&mesh, at(0.0, 1.75, 0.0)));
        assert_close(found, Vec3::Y, 0.25);
        let flattened = mirrored.with_scale(Vec3::new(-1.0, 0.0, 1.0));
        let found = contact((&mesh, flattened), (&mesh, at(0.0, 1.0, 0.0)));
        assert!(found.normal.is_normalized() && found.depth < 1e-4, "{found:?}");
    }

    fn mesh_vertices(shape: &Shape) -> &[Vec3] {
        match shape {
            Shape::Mesh(mesh) => mesh.vertices(),
            _ => unreachable!(),
        }
    }

    #[test]
    fn a_ball_inside_leaves_by_the_nearest_face() {
        let small = Shape::sphere(0.1).unwrap();
        let here = at(0.0, 0.0, 0.0);
        for solid in [box_of(1.0, 1.0, 1.0), mesh_of(Vec3::ONE)] {
            let found = contact((&solid, here), (&small, at(0.2, 0.0, -0.7)));
            assert_close(found, Vec3::NEG_Z, 0.4);
            // With its centre on the surface.
            let found = contact((&solid, here), (&small, at(0.2, 0.0, -1.0)));
            assert_close(found, Vec3::NEG_Z, 0.1);
        }
    }

    #[test]
    fn cuboids_at_an_edge_and_on_a_floor() {
        let cube = box_of(1.0, 1.0, 1.0);
        let turned = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
        let found = contact((&cube, at(0.0, 0.0, 0.0)), (&cube, at(2.3, 0.0, 0.0).with_rotation(turned)));
        assert_close(found, Vec3::X, 1.0 + 2f32.sqrt() - 2.3);
        let floor = box_of(100.0, 1.0, 100.0);
        let found = contact((&floor, at(0.0, 0.0, 0.0)), (&cube, at(40.0, 1.9, 7.0)));
        assert_close(found, Vec3::Y, 0.1);
        assert!(found.point.distance(Vec3::new(40.0, 0.95, 7.0)) < 0.1, "{found:?}");
    }

    #[test]
    fn one_mesh_inside_another_leaves_from_centre_to_centre() {
        let (large, small) = (mesh_of(Vec3::splat(2.0)), mesh_of(Vec3::splat(0.1)));
        let found = contact((&large, at(0.0, 0.0, 0.0)), (&small, at(0.0, 0.5, 0.0)));
        assert_close(found, Vec3::Y, 1.6);
        let here = at(1.0, 1.0, 1.0);
        let (one, two) = (Placed::new(&large, &here), Placed::new(&small, &here));
        let found = NarrowPhase::default().contact(one, two, &mut Workspace::default());
        assert_eq!(found.unwrap().normal.length(), 1.0);
    }
}
