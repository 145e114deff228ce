//! The search for the point of a difference that is closest to the origin.

use super::simplex::{Simplex, Step, Vertex};
use super::vector::{Scalar, Vector};

/// Where a search for the distance ends that finds no end by itself: it is exact long before.
const MOST_STEPS: usize = 64;

/// How two convex shapes are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// They are apart: their closest points are the [points](Simplex::points) of the simplex.
    Apart,
    /// They are apart by more than was asked about.
    Beyond,
    /// They are no further apart than what was to be enough; how far, is not known.
    Enough,
    /// They overlap: the origin is in the hull of the simplex, or as near to it as numbers tell.
    Overlap,
    /// They are apart, but the numbers are too coarse for more.
    Unsettled,
}

/// Looks for the closest points of two shapes by the support function of their difference, beginning
/// along a unit vector from the first to the second. Nothing is said of what is apart by more than
/// `limit`, and no more than that of what is no further apart than `enough`, if that is not negative.
/// What the search ends with is left in the simplex, the length of the longest vector met in `size`.
#[inline]
pub fn search<V: Vector>(
    difference: impl Fn(V) -> Vertex<V>,
    towards: V,
    [limit, enough]: [V::Scalar; 2],
    simplex: &mut Simplex<V>,
    size: &mut V::Scalar,
) -> Found {
    *simplex = Simplex::new(difference(towards));
    let mut nearest = simplex.nearest();
    let mut distance = nearest.length();
    *size = distance;
    for _ in 0..MOST_STEPS {
        if distance <= enough {
            return Found::Enough;
        }
        if distance <= V::Scalar::FLAT * *size {
            return Found::Overlap;
        }
        let vertex = difference(-nearest / distance);
        *size = size.greater(vertex.point.length());
        // All of the difference is as far from the origin, this way.
        let certain = vertex.point.dot(nearest) / distance;
        if certain > limit {
            return Found::Beyond;
        }
        if distance - certain <= V::Scalar::PRECISION * (distance + *size) {
            return Found::Apart;
        }
        match simplex.add(&vertex, distance) {
            Step::Nearer {
                nearest: next,
                distance: next_distance,
            } => (nearest, distance) = (next, next_distance),
            Step::None => break,
            Step::Inside => return Found::Overlap,
        }
    }
    Found::Unsettled
}
