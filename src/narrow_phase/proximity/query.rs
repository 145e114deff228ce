//! Distances of placed shapes, from a point and from each other.

use std::ops::RangeInclusive;

use bevy::math::{Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::{boxes, polygons};
use crate::narrow_phase::{
    answer::Proximity,
    cores::{Balls, Bodies, Closest, QuickPair},
    error::BoundsError,
    frame::{
        case::Case,
        edge_polygon,
        placed::{Placed, PlacedPair, in_order},
        smaller::Smaller,
        workspace::Workspace,
    },
    settings::NarrowPhase,
    shape::{Kind, Shape},
    support,
};

impl NarrowPhase {
    /// Returns the point of a shape that is closest to `point`; `point` itself, if it is inside.
    ///
    /// Exact for every kind of shape. `None` if anything is not finite.
    ///
    /// Cuboids, spheres: O(1); meshes: O(log n) for each polygon that is about as near as the
    /// closest. Allocates nothing once the workspace is warm.
    ///
    /// ```
    /// use bevy::{math::Vec3, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// let (brick, at) = (Shape::cuboid(4.0, 2.0, 2.0), Transform::from_xyz(5.0, 0.0, 0.0));
    /// let brick = Placed::new(&brick, &at);
    /// let closest = NarrowPhase::default().closest_point(brick, Vec3::Y, &mut Workspace::default());
    /// assert_eq!(closest, Some(Vec3::new(3.0, 1.0, 0.0)));
    /// ```
    #[doc(alias = "project_point")]
    #[must_use]
    pub fn closest_point(
        &self,
        target: Placed,
        point: Vec3,
        workspace: &mut Workspace,
    ) -> Option<Vec3> {
        if target.shape.kind().is_by_support() {
            let is_finite =
                point.is_finite() && target.transform.is_finite() && target.shape.is_finite();
            let closest = is_finite
                .then(|| support::closest_point(target, point))
                .flatten();
            return closest.filter(|closest| closest.is_finite());
        }
        if let Some(closest) = closest_on_sphere(target, point) {
            let closest = point + Vec3::from(closest);
            return closest.is_finite().then_some(closest);
        }
        let (at_point, here) = (
            Shape::Sphere { radius: 0.0 },
            Transform::from_translation(point),
        );
        let at_point = Placed::new(&at_point, &here);
        let pair = PlacedPair::of_point(at_point, target, self.tolerance()).ok()?;
        if pair.is_wide()
            && let Some(smaller) = Smaller::of(&pair, self)
        {
            let [at_point, target] = smaller.placed(&pair);
            let closest =
                smaller
                    .tests
                    .closest_point(target, at_point.transform.translation, workspace)?;
            return Some(closest * smaller.factor).filter(|closest| closest.is_finite());
        }
        // The frame of the pair has its origin at the point.
        let closest = point + Vec3::from(closest_to_center(&pair, workspace)?);
        closest.is_finite().then_some(closest)
    }

    /// Returns how far two shapes are apart, and where they are closest to each other.
    ///
    /// Exact for every kind of shape, up to rounding. Shapes overlap as they do for
    /// [`intersects`](Self::intersects): one inside the other too, if that is closed. Those that
    /// are in contact by tolerance alone have a distance, which is no more than the tolerance.
    /// Swapping the two swaps the points and turns the offset around, unless they are equal in all
    /// things, position included. `None` if anything is not finite, and for pairs of which nothing
    /// is known, such as two half-spaces: see the [module](crate::narrow_phase).
    ///
    /// Two cuboids: O(1), in the order of 0.1 µs if turned alike, and 1 µs if not; two spheres, and
    /// a sphere and a cuboid: O(1); one of these and a mesh: O(log n) for each polygon that is about
    /// as near as the closest; two meshes: the same for each two polygons. Of meshes of a few
    /// polygons, all are looked at. Height fields and voxels: linear in the cells that are as near,
    /// in each direction, as what is closest. Allocates nothing once the workspace is warm.
    ///
    /// ```
    /// use bevy::{math::Vec3, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// let (brick, ball) = (Shape::cuboid(2.0, 2.0, 2.0), Shape::sphere(0.5));
    /// let (here, there) = (Transform::IDENTITY, Transform::from_xyz(4.0, 5.0, 0.0));
    /// let (brick, ball) = (Placed::new(&brick, &here), Placed::new(&ball, &there));
    /// let found = NarrowPhase::default().closest_points(brick, ball, &mut Workspace::default()).unwrap();
    /// assert_eq!(found.distance, 4.5);
    /// assert_eq!(found.points[0], Vec3::new(1.0, 1.0, 0.0));
    /// ```
    #[doc(alias = "distance")]
    #[must_use]
    pub fn closest_points(
        &self,
        a: Placed,
        b: Placed,
        workspace: &mut Workspace,
    ) -> Option<Proximity> {
        let (first, second, swapped) = in_order(a, b);
        if let Some(balls) = Balls::of(first, second) {
            return found(first, balls.nearest.of_surfaces(), swapped);
        }
        if let Some(pair) = QuickPair::of(first, second) {
            return found(first, pair.closest_points(), swapped);
        }
        if let Some(found) = support::with_own(a, b, |a, b| self.closest_points(a, b, workspace)) {
            return found;
        }
        let points = match PlacedPair::new(first, second, self.tolerance()) {
            Ok(pair) if pair.is_wide() => match Smaller::of(&pair, self) {
                Some(smaller) => {
                    let [a, b] = smaller.placed(&pair);
                    return larger(
                        smaller.tests.closest_points(a, b, workspace)?,
                        smaller.factor,
                        swapped,
                    );
                }
                None => local_points(&pair, workspace),
            },
            Ok(pair) => local_points(&pair, workspace),
            Err(BoundsError::Unbounded) => unbounded(first, second).map(Closest::from),
            Err(BoundsError::NonFinite) => None,
        };
        found(first, points?, swapped)
    }
}

/// What was found in the frame of the first, by the order in which it was asked for.
fn found(first: Placed, closest: impl Into<Closest>, swapped: bool) -> Option<Proximity> {
    let Closest {
        points: [mut from, mut to],
        mut offset,
        distance,
    } = closest.into();
    if swapped {
        std::mem::swap(&mut from, &mut to);
        offset = -offset;
    }
    let origin = first.transform.translation;
    let points = [from, to].map(|point| origin + Vec3::from(point));
    Proximity {
        distance,
        points,
        offset: offset.into(),
    }
    .if_finite()
}

/// Numbers with which spheres are quick to look at.
const FAIR: RangeInclusive<f32> = 1e-8..=1e8;

/// The radius of a sphere; `None` of another shape, or where a number is so large or so small, or so
/// wrong, that it had better be looked at as all others are.
#[inline]
fn fair_radius(placed: Placed) -> Option<f32> {
    let Shape::Sphere { radius } = placed.shape else {
        return None;
    };
    let Transform {
        rotation, scale, ..
    } = placed.transform;
    let radius = radius.abs() * scale.abs().max_element();
    let is_fair =
        FAIR.contains(&radius) && scale.is_finite() && FAIR.contains(&rotation.length_squared());
    is_fair.then_some(radius)
}

/// The point of a sphere that is closest to the origin, which is the same as
/// [`closest_to_center`] finds, to the last bit, in a fraction of the steps.
#[inline]
fn closest_on_sphere(sphere: Placed, origin: Vec3) -> Option<Vec3A> {
    let radius = fair_radius(sphere)?;
    let offset = Vec3A::from(sphere.transform.translation - origin);
    let is_fair = offset.is_finite() && offset.abs().max_element() <= *FAIR.end();
    is_fair.then(|| offset * (1.0 - (radius / offset.length()).min(1.0)))
}

/// What was found at a smaller scale, by the order in which it was asked for.
fn larger(found: Proximity, factor: f32, swapped: bool) -> Option<Proximity> {
    let Proximity {
        distance,
        points: [from, to],
        offset,
    } = found;
    let points = if swapped { [to, from] } else { [from, to] }.map(|point| point * factor);
    let offset = if swapped { -offset } else { offset } * factor;
    Proximity {
        distance: distance * factor,
        points,
        offset,
    }
    .if_finite()
}

/// The closest points of two shapes, in the frame of the pair.
pub fn local_points(pair: &PlacedPair, workspace: &mut Workspace) -> Option<Closest> {
    // Boxes turned alike have a closed form.
    let bodies = match pair.case() {
        Case::Cuboids if pair.box_a.axes != pair.box_b.axes => Bodies::of(pair),
        _ => Bodies::of_case(pair),
    };
    if let Some(closest) = bodies.and_then(|bodies| bodies.closest_points()) {
        return Some(closest);
    }
    let points = match pair.case() {
        Case::Spheres | Case::SphereFirst => sphere_other(pair, workspace),
        Case::SphereSecond => {
            sphere_other(&pair.swapped(), workspace).map(|[on_ball, on_other]| [on_other, on_ball])
        }
        Case::Cuboids => boxes::closest_points(pair, workspace),
        Case::Convex | Case::Polygons => polygons::closest_points(pair, workspace),
        Case::Parts | Case::Foreign => parts(pair, workspace),
    };
    points.map(Closest::from)
}

/// Two that the support functions are asked about.
fn parts(pair: &PlacedPair, workspace: &mut Workspace) -> Option<[Vec3A; 2]> {
    match support::enclosed(pair, workspace) {
        Some(point) => Some([point; 2]),
        None => support::closest_points(pair.a, pair.b),
    }
}

/// A sphere, the first of the pair, and any other shape.
fn sphere_other(pair: &PlacedPair, workspace: &mut Workspace) -> Option<[Vec3A; 2]> {
    let sphere = &pair.box_a;
    let closest = closest_to_center(pair, workspace)?;
    let offset = closest - sphere.center;
    let distance = offset.length();
    let on_sphere = if distance > sphere.radius {
        sphere.center + offset * (sphere.radius / distance)
    } else {
        closest
    };
    Some([on_sphere, closest])
}

/// The point of the second shape that is closest to the centre of the first.
fn closest_to_center(pair: &PlacedPair, workspace: &mut Workspace) -> Option<Vec3A> {
    let center = pair.box_a.center;
    match pair.b.shape.kind() {
        Kind::Cuboid => Some(pair.box_b.closest_point(center)),
        Kind::Sphere => {
            let offset = pair.box_b.center - center;
            Some(center + offset * (1.0 - (pair.box_b.radius / offset.length()).min(1.0)))
        }
        Kind::Convex | Kind::Mesh => match Bodies::of_case(pair) {
            // Which side of a thin solid a point is on, its nearest polygons alone do not tell.
            Some(bodies) => {
                let mote = Shape::Sphere { radius: 0.0 };
                let at_center = Placed::new(&mote, pair.a.transform);
                let found = (pair.box_a.radius == 0.0)
                    .then(|| bodies.closest_points())
                    .flatten()
                    .or_else(|| support::closest_points(at_center, pair.b).map(Closest::from))?;
                let apart = found.distance > 0.0;
                Some(center + if apart { found.offset } else { Vec3A::ZERO })
            }
            None => match edge_polygon::sphere_closest(pair, workspace)? {
                (_, true) => Some(center),
                (closest, false) => Some(closest.point),
            },
        },
        Kind::Curved | Kind::Parts | Kind::Foreign => None,
    }
}

/// The closest points of two shapes of which one has no bounds, relative to the position of the
/// first.
fn unbounded(a: Placed, b: Placed) -> Option<[Vec3A; 2]> {
    let is_finite = a.transform.is_finite() && b.transform.is_finite();
    is_finite.then(|| support::closest_points(a, b)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_as_near_as_any_two_shapes() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut vector = |reach: f32| {
            Vec3::from_array(std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * reach))
        };
        let mut workspace = Workspace::default();
        for round in 0..3000 {
            let size = 10_f32.powi(round % 30 - 15);
            let mut ball = || {
                let radius = [vector(size).x, size, 0.0][round as usize / 7 % 3];
                let turn = bevy::math::Quat::from_vec4(vector(1.0).extend(0.4));
                let at = Transform::from_translation(vector(3.0 * size)).with_rotation(turn);
                (Shape::Sphere { radius }, at.with_scale(vector(2.0)))
            };
            let ((a, at_a), (b, mut at_b)) = (ball(), ball());
            if round % 11 == 0 {
                at_b.translation = at_a.translation;
            }
            let (a, b) = (Placed::new(&a, &at_a), Placed::new(&b, &at_b));
            if let Some(balls) = Balls::of(a, b) {
                let pair = PlacedPair::new(a, b, 1e-6).unwrap();
                assert!(!pair.is_wide());
                let found = local_points(&pair, &mut workspace).unwrap().offset;
                let off = balls.nearest.of_surfaces().offset.distance(found);
                assert!(
                    off <= 1e-6 * (pair.size + found.length()),
                    "{off}: {a:?} {b:?}"
                );
            }
            let point = at_a.translation;
            if let Some(closest) = closest_on_sphere(b, point) {
                let (sphere, here) = (
                    Shape::Sphere { radius: 0.0 },
                    Transform::from_translation(point),
                );
                let at_point = Placed::new(&sphere, &here);
                let pair = PlacedPair::of_point(at_point, b, 1e-6).unwrap();
                assert_eq!(closest_to_center(&pair, &mut workspace), Some(closest));
            }
        }
    }
}
