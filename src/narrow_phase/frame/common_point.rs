//! A point of two shapes that overlap.

use bevy::math::Vec3A;

use super::edge_polygon::{self, Touch};
use super::oriented_box::OrientedBox;
use super::placed::{Placed, PlacedPair};
use super::placing::Placing;
use super::workspace::Workspace;
use crate::narrow_phase::shape::Shape;

/// How often to go back and forth between two shapes in search of a point of both: twice is the
/// rule.
const MOST_STEPS: usize = 8;

/// A point of two boxes, found by going back and forth between them; `None` if that takes too long.
pub fn common_point(pair: &PlacedPair) -> Option<Vec3A> {
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

/// The mean of the points where edges of one shape meet polygons of the other. It is in both
/// shapes, to within the tolerance, if they are convex.
pub fn mean_touch(pair: &PlacedPair, workspace: &mut Workspace) -> Option<Vec3A> {
    let (mut count, mut points) = (0.0, Vec3A::ZERO);
    edge_polygon::touches(pair, workspace, |Touch { point, .. }| {
        count += 1.0;
        points += point;
    });
    (count > 0.0).then(|| points / count)
}

/// A point in the middle of a shape, in the frame: that of its box, or of a convex mesh, which may
/// not reach there, the mean of the ends of its edges. Linear in these.
pub fn middle(placed: Placed, bounds: &OrientedBox) -> Vec3A {
    let Shape::Convex(mesh) = placed.shape else {
        return bounds.center;
    };
    let placing = Placing::of((mesh, Vec3A::ONE), placed, bounds);
    let corners = mesh.edges().as_flattened();
    let sum: Vec3A = (corners.iter())
        .map(|corner| placing.place(mesh.vertices()[*corner as usize]) - bounds.center)
        .sum();
    bounds.center + sum / corners.len() as f32
}

/// How far a shape reaches from the centre of its box along a direction: as far as the box, or a
/// convex mesh by itself. Linear in its edges.
pub fn reach(placed: Placed, bounds: &OrientedBox, direction: Vec3A) -> f32 {
    let Shape::Convex(mesh) = placed.shape else {
        return bounds.extent(direction);
    };
    let placing = Placing::of((mesh, Vec3A::ONE), placed, bounds);
    (mesh.edges().as_flattened().iter())
        .map(|corner| placing.place(mesh.vertices()[*corner as usize]) - bounds.center)
        .map(|from_center| from_center.dot(direction))
        .fold(f32::NEG_INFINITY, f32::max)
}
