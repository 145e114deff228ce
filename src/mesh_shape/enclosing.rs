//! What encloses a list of points: boxes, balls and capsules.

use bevy::math::{DVec3, Vec3};

use crate::narrow_phase::{Shape, ShapeError};

/// As near to the origin as this share of the half extents, a middle is the origin: exporters and
/// the sines of full turns leave so much.
const CENTRED: f32 = 4e-6;

/// The box around points along the axes.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    fn of(points: &[Vec3]) -> Result<Self, ShapeError> {
        let (first, rest) = points.split_first().ok_or(ShapeError::Empty)?;
        let start = Self {
            low: *first,
            high: *first,
        };
        Ok(rest.iter().fold(start, |extent, point| Self {
            low: extent.low.min(*point),
            high: extent.high.max(*point),
        }))
    }

    fn half(&self) -> DVec3 {
        (self.high.as_dvec3() - self.low.as_dvec3()) * 0.5
    }

    /// The middle: zero along an axis where it is as good as that.
    fn middle(&self) -> DVec3 {
        let middle = (self.high.as_dvec3() + self.low.as_dvec3()) * 0.5;
        let nothing = f64::from(CENTRED) * self.half().max_element();
        DVec3::select(
            middle.abs().cmple(DVec3::splat(nothing)),
            DVec3::ZERO,
            middle,
        )
    }
}

/// The box around points, along the axes. Around another middle than the origin it is a convex mesh
/// of six rectangles, and without a height there one rectangle, which is met from both sides.
///
/// # Errors
/// [`ShapeError::Empty`]; and [`ShapeError::Flat`] for a box around another middle that is no more
/// than a segment or a point.
pub(super) fn cuboid(points: &[Vec3]) -> Result<Shape, ShapeError> {
    let extent = Extent::of(points)?;
    if extent.middle() == DVec3::ZERO {
        return Shape::try_from_half_size(extent.high.abs().max(extent.low.abs()));
    }
    let Extent { low, high } = extent;
    let corner = |bits: u32| {
        let at = |axis: usize| [low, high][(bits >> axis & 1) as usize][axis];
        Vec3::new(at(0), at(1), at(2))
    };
    let flat: Vec<usize> = (0..3).filter(|axis| low[*axis] == high[*axis]).collect();
    match *flat {
        [] => {
            let corners: Vec<Vec3> = (0..8).map(corner).collect();
            let sides = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            Shape::convex(corners, sides)
        }
        [axis] => {
            let (next, last) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let corners = [0, next, next | last, last].map(corner);
            Shape::mesh(corners, [[0, 1, 2, 3]])
        }
        _ => Err(ShapeError::Flat),
    }
}

/// The ball around the middle of the points' box, as large as the farthest of them is away.
///
/// # Errors
/// [`ShapeError::Empty`], and those of [`Shape::capsule_between`].
pub(super) fn sphere(points: &[Vec3]) -> Result<Shape, ShapeError> {
    let middle = Extent::of(points)?.middle();
    let squared = (points.iter())
        .map(|point| point.as_dvec3().distance_squared(middle))
        .fold(0.0, f64::max);
    ball(middle, squared.sqrt())
}

/// The capsule around the points, along the longest axis of their box, the first of those that are
/// as long. Its radius is how far the farthest point is from that axis; its ends are no further out
/// than points require.
///
/// # Errors
/// [`ShapeError::Empty`], and those of [`Shape::capsule_between`].
pub(super) fn capsule(points: &[Vec3]) -> Result<Shape, ShapeError> {
    let ([back, front], radius) = capsule_around(points)?;
    capsule_between(back, front, radius)
}

/// The ends of its segment, and its radius.
fn capsule_around(points: &[Vec3]) -> Result<([DVec3; 2], f64), ShapeError> {
    let extent = Extent::of(points)?;
    let (half, middle) = (extent.half(), extent.middle());
    let axis = if half.x >= half.y && half.x >= half.z {
        DVec3::X
    } else if half.y >= half.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let split = |point: &Vec3| {
        let from_middle = point.as_dvec3() - middle;
        let along = from_middle.dot(axis);
        (along, (from_middle - axis * along).length_squared())
    };
    let squared = (points.iter().map(|point| split(point).1)).fold(0.0, f64::max);
    // Each point has to be in the cap of an end, or between the two.
    let ends = (points.iter().map(split)).fold([0.0_f64; 2], |[back, front], (along, off)| {
        let cap = (squared - off).max(0.0).sqrt();
        [back.min(along + cap), front.max(along - cap)]
    });
    Ok((ends.map(|end| middle + axis * end), squared.sqrt()))
}

/// A ball. One that is not around the origin is what is around a segment from a point to itself.
fn ball(middle: DVec3, radius: f64) -> Result<Shape, ShapeError> {
    if middle.length() <= f64::from(CENTRED) * radius {
        Shape::try_sphere(radius as f32)
    } else {
        let middle = middle.as_vec3();
        Shape::capsule_between(middle, middle, radius as f32)
    }
}

/// A capsule, or the ball that it is.
fn capsule_between(back: DVec3, front: DVec3, radius: f64) -> Result<Shape, ShapeError> {
    if back.distance(front) <= f64::from(CENTRED) * radius {
        ball((back + front) * 0.5, radius)
    } else {
        Shape::capsule_between(back.as_vec3(), front.as_vec3(), radius as f32)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points() -> impl Strategy<Value = Vec<Vec3>> {
        let point = prop::array::uniform3(-10.0_f32..10.0).prop_map(Vec3::from);
        prop::collection::vec(point, 1..40)
    }

    proptest! {
        #[test]
        fn a_capsule_has_all_points_and_no_more_than_it_needs(points in points()) {
            let ([back, front], radius) = capsule_around(&points).unwrap();
            let axis = (front - back).normalize_or_zero();
            let middle = Extent::of(&points).unwrap().middle();
            let off = |point: &Vec3| {
                let point = point.as_dvec3();
                let along = (point - back).dot(axis).clamp(0.0, back.distance(front));
                point.distance(back + axis * along)
            };
            let farthest = points.iter().map(off).fold(0.0, f64::max);
            prop_assert!((farthest - radius).abs() < 1e-9);
            // Neither end can be drawn in.
            for (end, way) in [(front, axis), (back, -axis)] {
                let touches = |point: &&Vec3| {
                    let from_end = point.as_dvec3() - end;
                    from_end.dot(way) >= -1e-6 && (from_end.length() - radius).abs() < 1e-6
                };
                let is_as_short = end.distance(middle) < 1e-9;
                prop_assert!(is_as_short || points.iter().any(|point| touches(&point)));
            }
        }

        #[test]
        fn a_box_has_all_points(points in points()) {
            let shape = cuboid(&points);
            if points.len() > 3 {
                let Ok(Shape::Convex(mesh)) = shape else { panic!("{shape:?}") };
                let low = points.iter().copied().reduce(Vec3::min).unwrap();
                let high = points.iter().copied().reduce(Vec3::max).unwrap();
                let corners = mesh.vertices();
                prop_assert_eq!(corners.iter().copied().reduce(Vec3::min), Some(low));
                prop_assert_eq!(corners.iter().copied().reduce(Vec3::max), Some(high));
            }
        }
    }

    #[test]
    fn what_is_around_the_origin_is_simple() {
        let corners = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, -2.0, -3.0000005)];
        let Ok(Shape::Cuboid { half_size }) = cuboid(&corners) else {
            panic!("a cuboid")
        };
        assert_eq!(half_size, Vec3::new(1.0, 2.0, 3.0000005));
        let flat = [Vec3::new(1.0, 0.0, 3.0), Vec3::new(-1.0, 0.0, -3.0)];
        assert!(matches!(cuboid(&flat), Ok(Shape::Cuboid { .. })));
        let Ok(Shape::Sphere { radius }) = sphere(&corners) else {
            panic!("a ball")
        };
        assert!((radius - 14.0_f32.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn what_is_elsewhere_and_flat_is_a_rectangle_or_nothing() {
        for axis in 0..3 {
            let mut size = Vec3::new(1.0, 2.0, 3.0);
            size[axis] = 0.0;
            let Ok(Shape::Mesh(mesh)) = cuboid(&[Vec3::splat(5.0), Vec3::splat(5.0) + size]) else {
                panic!("a rectangle")
            };
            assert_eq!(mesh.polygon_count(), 1);
            assert_eq!(mesh.vertices().len(), 4);
        }
        assert!(matches!(
            cuboid(&[Vec3::ONE, Vec3::new(1.0, 1.0, 2.0)]),
            Err(ShapeError::Flat)
        ));
        assert!(matches!(cuboid(&[]), Err(ShapeError::Empty)));
    }
}
