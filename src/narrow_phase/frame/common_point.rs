//! A point of two shapes that overlap.

use bevy::math::Vec3A;

use super::edge_polygon::{self, Touch};
use super::placed::PlacedPair;
use super::workspace::Workspace;

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
