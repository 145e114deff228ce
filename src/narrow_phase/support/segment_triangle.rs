//! Segments and points against triangles, in closed form: what balls and capsules meet a mesh by.

use bevy::math::DVec3;

use super::gap::Gap;

/// How small a distance tells no direction any more, as a share of the lengths at hand.
const NOTHING: f64 = 1e-14;

/// The gap between a segment, of which both ends may be the same, and a triangle; `None` if it is
/// wider than `limit`. Where the depth is not asked for, the distance of two that overlap is no more
/// than negative.
///
/// Two that are apart are closest to each other at an end of the segment and within the triangle,
/// or at the border of this. To part two that cross each other is to push an end of the segment
/// through the triangle, or a side of this past the segment.
pub fn gap(segment: [DVec3; 2], corners: [DVec3; 3], limit: f64, with_depth: bool) -> Option<Gap> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let heights = segment.map(|end| normal.dot(end - a));
    let squared = normal.length_squared();
    if squared > 0.0 {
        let [low, high] = [heights[0].min(heights[1]), heights[0].max(heights[1])];
        let is_inside = |point: DVec3| {
            let left_of = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal);
            left_of(a, b) >= 0.0 && left_of(b, c) >= 0.0 && left_of(c, a) >= 0.0
        };
        if low > 0.0 || high < 0.0 || low == high {
            let nearer = usize::from(heights[1].abs() < heights[0].abs());
            let (end, height) = (segment[nearer], heights[nearer]);
            let length = squared.sqrt();
            if height.abs() > limit * length {
                return None;
            }
            if is_inside(end) {
                let (up, height) = (normal / length, height / length);
                let on_triangle = end - up * height;
                return Some(Gap {
                    distance: height.abs(),
                    // What is on the triangle counts as on its front.
                    normal: if height < 0.0 { up } else { -up },
                    points: [end, on_triangle],
                    between: end.midpoint(on_triangle),
                });
            }
        } else {
            let crossing = segment[0].lerp(segment[1], heights[0] / (heights[0] - heights[1]));
            if is_inside(crossing) {
                let up = normal / squared.sqrt();
                return Some(if with_depth {
                    overlap(segment, corners, up, crossing)
                } else {
                    crossed(f64::MIN_POSITIVE, -up, [crossing; 2], crossing)
                });
            }
        }
    }
    let sides = [[a, b], [b, c], [c, a]];
    let [mut on_segment, mut on_side] = closest(segment, sides[0]);
    let mut least = on_segment.distance_squared(on_side);
    for side in &sides[1..] {
        let [one, other] = closest(segment, *side);
        let found = one.distance_squared(other);
        if found < least {
            (least, on_segment, on_side) = (found, one, other);
        }
    }
    let distance = least.sqrt();
    if distance > limit {
        return None;
    }
    let size = (segment[1] - segment[0]).abs().max_element()
        + (b - a).abs().max((c - a).abs()).max_element();
    let normal = if distance > NOTHING * size {
        (on_side - on_segment) / distance
    } else {
        // Beside the side they touch at, if not in front of or behind the triangle.
        let side = normal
            * if heights[0] + heights[1] < 0.0 {
                1.0
            } else {
                -1.0
            };
        side.try_normalize()
            .unwrap_or_else(|| (b - a).normalize_or(DVec3::X).any_orthonormal_vector())
    };
    Some(Gap {
        distance,
        normal,
        points: [on_segment, on_side],
        between: on_segment.midpoint(on_side),
    })
}

/// A segment and a triangle that cross each other, and how to part the two by the least way.
fn overlap(segment: [DVec3; 2], [a, b, c]: [DVec3; 3], up: DVec3, crossing: DVec3) -> Gap {
    let heights = segment.map(|end| up.dot(end - a));
    let lower = usize::from(heights[1] < heights[0]);
    let of_end = |end: usize, outwards: DVec3| {
        let depth = heights[end].abs();
        let points = [segment[end], segment[end] + outwards * depth];
        crossed(depth, -outwards, points, crossing)
    };
    let mut least = of_end(lower, up);
    if heights[1 - lower] < -heights[lower] {
        least = of_end(1 - lower, -up);
    }
    let along = segment[1] - segment[0];
    for [from, to, third] in [[a, b, c], [b, c, a], [c, a, b]] {
        let Some(across) = along.cross(to - from).try_normalize() else {
            continue;
        };
        let outwards = if across.dot(third - from) > 0.0 {
            -across
        } else {
            across
        };
        let depth = outwards.dot(from - crossing).max(0.0);
        if depth < -least.distance {
            let on_side = closest(segment.map(|end| end + outwards * depth), [from, to])[1];
            let points = [on_side - outwards * depth, on_side];
            least = crossed(depth, -outwards, points, crossing);
        }
    }
    least
}

fn crossed(depth: f64, normal: DVec3, points: [DVec3; 2], between: DVec3) -> Gap {
    Gap {
        distance: -depth.max(f64::MIN_POSITIVE),
        normal,
        points,
        between,
    }
}

/// The points of two segments that are closest to each other: Ericson, *Real-Time Collision
/// Detection*, 2005, section 5.1.9.
fn closest([p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> [DVec3; 2] {
    let (along, side, between) = (q - p, b - a, p - a);
    let [length, width] = [along.length_squared(), side.length_squared()];
    let share = |value: f64, of: f64| {
        if of > 0.0 {
            (value / of).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let (cosine, on_side) = (along.dot(side), side.dot(between));
    let back = along.dot(between);
    let whole = length * width - cosine * cosine;
    let mut s = share(cosine * on_side - back * width, whole);
    let t = cosine * s + on_side;
    let t = if t <= 0.0 || width == 0.0 {
        s = share(-back, length);
        0.0
    } else if t >= width {
        s = share(cosine - back, length);
        1.0
    } else {
        t / width
    };
    [p + along * s, a + side * t]
}

#[cfg(all(test, feature = "rapier"))]
mod tests;
