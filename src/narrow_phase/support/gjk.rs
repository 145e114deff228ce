//! How far two convex shapes are apart, or how deep they are in each other, by their support
//! functions: the [search] for the closest points of their cores.

use bevy::math::DVec3;

use super::convex::Convex;
use super::gap::Gap;
use super::segment_triangle;
use crate::narrow_phase::gjk::{Found, Polytope, Simplex, Vertex, common_point, expand, search};

/// What is left uncertain of a depth, as a share of the sizes at hand: little enough for normals.
const UNCERTAIN: f64 = 1e-12;
/// Two points that are no further apart count as one, as a share of the sizes at hand.
const SAME: f64 = 1e-7;

/// The gap between two shapes; `None` if it is wider than `limit`. Where the depth is not asked
/// for, the distance of two that overlap is no more than negative.
pub fn gap(a: &Convex, b: &Convex, limit: f64, with_depth: bool) -> Option<Gap> {
    let radii = [a.radius, b.radius];
    let limit = limit + a.radius + b.radius;
    let in_closed_form = |a: &Convex, b: &Convex| {
        let (segment, triangle) = (a.core_segment()?, b.core_triangle()?);
        Some(segment_triangle::gap(segment, triangle, limit, with_depth))
    };
    if let Some(gap) = in_closed_form(a, b) {
        return Some(gap?.grown(radii));
    }
    if let Some(gap) = in_closed_form(b, a) {
        return Some(gap?.reversed().grown(radii));
    }
    by_steps(a, b, limit, with_depth).map(|gap| gap.grown(radii))
}

/// The gap between two cores, whatever they are.
pub fn by_steps(a: &Convex, b: &Convex, limit: f64, with_depth: bool) -> Option<Gap> {
    let difference = |direction: DVec3| Vertex::of([a.furthest(direction), b.furthest(-direction)]);
    let towards_b = (b.at.translation - a.at.translation)
        .try_normalize()
        .unwrap_or(DVec3::X);
    let (mut simplex, mut size) = (Simplex::empty(), 0.0);
    let limits = [limit, -1.0];
    match search(difference, towards_b, limits, &mut simplex, &mut size) {
        Found::Beyond => return None,
        Found::Apart | Found::Unsettled => {
            let nearest = simplex.nearest();
            let distance = nearest.length();
            return (distance <= limit).then(|| Gap {
                distance,
                normal: -nearest / distance,
                points: simplex.points(),
                between: DVec3::ZERO,
            });
        }
        Found::Overlap | Found::Enough => {}
    }
    let [on_a, on_b] = simplex.points();
    let between = on_a.midpoint(on_b);
    if !with_depth {
        return Some(Gap {
            distance: -f64::MIN_POSITIVE,
            normal: towards_b,
            points: [between; 2],
            between,
        });
    }
    let polytope = &mut Polytope::default();
    let deepest = expand(&simplex, difference, UNCERTAIN, towards_b, polytope);
    let middle = deepest.points[0].midpoint(deepest.points[1]);
    let (on_a, on_b) = (|point| closest(a, point), |point| closest(b, point));
    Some(Gap {
        distance: -deepest.depth.max(f64::MIN_POSITIVE),
        normal: deepest.normal,
        points: deepest.points,
        between: common_point(middle, on_a, on_b, SAME * size).unwrap_or(between),
    })
}

/// The point of a core that is closest to another; that one itself, if it is inside.
fn closest(core: &Convex, point: DVec3) -> DVec3 {
    let gap = by_steps(&Convex::point(point), core, f64::INFINITY, false);
    gap.filter(|gap| gap.distance > 0.0)
        .map_or(point, |gap| gap.points[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::narrow_phase::{Shape, support::convex::Isometry};
    use bevy::math::{DMat3, DQuat, Vec3};

    #[test]
    fn points_of_a_gap_are_of_the_two() {
        let mut random = fastrand::Rng::with_seed(4);
        let mut vector = || DVec3::from_array([0; 3].map(|_| random.f64() * 2.0 - 1.0));
        let mut worst = [0.0f64; 2];
        for _ in 0..300 {
            let points: Vec<Vec3> = (0..24).map(|_| vector().as_vec3()).collect();
            let Ok(Shape::Convex(hull)) = Shape::convex_hull(points) else {
                continue;
            };
            for _ in 0..30 {
                let turn = DMat3::from_quat(DQuat::from_scaled_axis(vector() * 3.0));
                let at = Isometry {
                    rotation: turn,
                    translation: vector() * 2.0,
                };
                let a = Convex::mesh(&hull, DVec3::ONE, at);
                let corners = [vector(), vector(), vector()];
                let b = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
                let gap = by_steps(&a, &b, f64::INFINITY, false).unwrap();
                if gap.distance < 0.0 {
                    continue;
                }
                let off = (gap.points[0].distance(gap.points[1]) - gap.distance).abs();
                let [p, q, r] = corners;
                let normal = (q - p).cross(r - p).normalize();
                let height = normal.dot(gap.points[1] - p).abs();
                worst = [worst[0].max(off), worst[1].max(height)];
                let certain = b.furthest(-gap.normal).dot(gap.normal)
                    - a.furthest(gap.normal).dot(gap.normal);
                assert!((certain - gap.distance).abs() < 1e-9, "{certain} {gap:?}");
            }
        }
        assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
    }
}
