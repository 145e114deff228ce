//! How far two oriented boxes are apart, by the 15 separating axes of Gottschalk, Lin and Manocha
//! (1996), three at a time.

use bevy::math::{Vec3A, Vec3Swizzles};

use super::oriented_box::OrientedBox;

/// The sine of the angle below which two edges count as parallel, and their cross product as no
/// axis.
const PARALLEL: f32 = 1e-2;
/// How much deeper an axis across two edges must part the boxes to be preferred to that of a face.
const FACE_BIAS: f32 = 1e-3;

/// The axis along which two boxes are furthest apart, or overlap least.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// The distance of the boxes along the axis; negative if they overlap. The distance in space is
    /// never less, and may be more if it runs from corner to corner.
    pub gap: f32,
    /// How far the boxes may still be apart if all gaps are negative, because axes were left out.
    pub doubt: f32,
    /// A unit vector pointing from the first box to the second, along which they overlap least, or
    /// nearly so: axes of faces are preferred, and those of the first box to those of the second.
    pub axis: Vec3A,
    /// The distance along `axis`.
    pub along: f32,
}

impl Separation {
    /// Finds the separation; gives up with `None` when a gap is wider than `limit` or not a number.
    #[inline]
    pub fn of(a: &OrientedBox, b: &OrientedBox, limit: f32) -> Option<Self> {
        // In the frame of a: columns are the axes of b.
        let to_a = a.axes.transpose();
        let axes = to_a * b.axes;
        let offset = b.center - a.center;
        let t = to_a * offset;
        let abs = axes.abs();

        let gaps_a = t.abs() - (a.half + abs * b.half);
        let t_b = b.axes.transpose() * offset;
        let gaps_b = t_b.abs() - (b.half + abs.transpose() * a.half);
        let (index_a, gap_a) = greatest(gaps_a);
        let (index_b, gap_b) = greatest(gaps_b);
        if !(gap_a <= limit && gap_b <= limit) {
            return None;
        }

        let bias = FACE_BIAS * (a.radius + b.radius);
        let (mut along, mut axis) = if gap_b > gap_a + bias {
            (gap_b, b.axes.col(index_b) * sign(t_b[index_b]))
        } else {
            (gap_a, a.axes.col(index_a) * sign(t[index_a]))
        };
        let mut widest = gap_a.max(gap_b);
        let mut to_beat = along + bias;

        let mut left_out = 0.0f32;
        for j in 0..3 {
            // The axes are the columns e0×c, e1×c and e2×c, with one lane for each.
            let c = axes.col(j);
            let c_abs = abs.col(j);
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let lengths = (c.yzx() * c.yzx() + c.zxy() * c.zxy()).map(f32::sqrt);
            let projected = c.cross(t);
            let reach_a = a.half.yzx() * c_abs.zxy() + a.half.zxy() * c_abs.yzx();
            let reach_b = abs.col(j2) * b.half[j1] + abs.col(j1) * b.half[j2];
            let gaps = (projected.abs() - reach_a - reach_b) / lengths;
            for i in 0..3 {
                if lengths[i] < PARALLEL {
                    left_out = left_out.max(lengths[i]);
                } else if gaps[i] > limit {
                    return None;
                } else {
                    widest = widest.max(gaps[i]);
                    if gaps[i] > to_beat {
                        to_beat = gaps[i];
                        along = gaps[i];
                        let cross = a.axes.col(i).cross(b.axes.col(j)) / lengths[i];
                        axis = cross * sign(cross.dot(offset));
                    }
                }
            }
        }
        Some(Self {
            gap: widest,
            doubt: left_out * 4.0 * (a.radius + b.radius),
            axis,
            along,
        })
    }
}

#[inline]
fn greatest(v: Vec3A) -> (usize, f32) {
    let index = v.max_position();
    (index, v[index])
}

/// −1 for negative numbers (−0 is not one), 1 otherwise.
#[inline]
pub fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}
