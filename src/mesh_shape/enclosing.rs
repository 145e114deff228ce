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
/// [`ShapeError::Empty`], and those of [`ball`].
pub(super) fn sphere(points: &[Vec3]) -> Result<Shape, ShapeError> {
    let middle = Extent::of(points)?.middle();
    let squared = (points
        .iter()
        .map(|point| point.as_dvec3().distance_squared(middle)))
    .fold(0.0, f64::max);
    ball(middle, squared.sqrt())
}

/// The capsule around the points, along the longest axis of their box, the first of those that are
/// as long. Its radius is how far the farthest point is from that axis; its ends are no further out
/// than points require.
///
/// # Errors
/// [`ShapeError::Empty`], and those of [`capsule_between`].
pub(super) fn capsule(points: &[Vec3]) -> Result<Shape, ShapeError> {
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
    // Each point has to be within the cap, or between the two.
    let [back, front] =
        points
            .iter()
            .map(split)
            .fold([0.0_f64; 2], |[back, front], (along, off)| {
                let cap = (squared - off).max(0.0).sqrt();
                [back.min(along + cap), front.max(along - cap)]
            });
    capsule_between(middle + axis * back, middle + axis * front, squared.sqrt())
}

/// A ball.
///
/// # Errors
/// [`ShapeError::NotOfMeshes`] for one that is not around the origin, which is no shape by itself.
fn ball(middle: DVec3, radius: f64) -> Result<Shape, ShapeError> {
    if middle.length() <= f64::from(CENTRED) * radius {
        Shape::try_sphere(radius as f32)
    } else {
        Err(ShapeError::NotOfMeshes(
            "ball that is not around the origin",
        ))
    }
}

/// A capsule.
///
/// # Errors
/// [`ShapeError::NotOfMeshes`], unless it is a ball around the origin.
fn capsule_between(back: DVec3, front: DVec3, radius: f64) -> Result<Shape, ShapeError> {
    if back.distance(front) <= f64::from(CENTRED) * radius {
        ball((back + front) * 0.5, radius)
    } else {
        Err(ShapeError::NotOfMeshes("capsule"))
    }
}
