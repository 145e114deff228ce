//! A point of two convex shapes that touch.

use super::vector::Vector;

/// So often does the search go from one shape to the other.
const MOST_WAYS: usize = 8;

/// A point of two, near another, by going back and forth between the two: each says which of its points
/// is closest to another. Two points that are no further apart than `same` count as one. `None` if
/// that takes too long.
pub fn common_point<V: Vector>(
    near: V,
    closest_of_a: impl Fn(V) -> V,
    closest_of_b: impl Fn(V) -> V,
    same: V::Scalar,
) -> Option<V> {
    let mut point = near;
    (0..MOST_WAYS).find_map(|_| {
        let on_a = closest_of_a(point);
        point = closest_of_b(on_a);
        ((on_a - point).length() <= same).then(|| on_a.midpoint(point))
    })
}
