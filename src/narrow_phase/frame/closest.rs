//! Closest points of points and segments. No input is degenerate: a segment may be a point.

use bevy::math::{Vec3A, Vec4, Vec4Swizzles};

/// The square of the sine of the angle below which segments count as parallel.
pub const PARALLEL: f32 = 1e-12;

/// The point of the segment from `a` to `b` that is closest to `point`.
#[inline]
pub fn point_segment(point: Vec3A, a: Vec3A, b: Vec3A) -> Vec3A {
    a + (b - a) * parameter(point, a, b)
}

/// Where along the segment, from 0 at `a` to 1 at `b`, it is closest to `point`.
#[inline]
fn parameter(point: Vec3A, a: Vec3A, b: Vec3A) -> f32 {
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared > 0.0 {
        ((point - a).dot(along) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The point of a triangle that is closest to `point`: by the region of its plane, of a corner, a
/// side or the inside, that the point is over (Ericson, *Real-Time Collision Detection*, 2005,
/// section 5.1.5).
#[inline]
pub fn point_triangle(point: Vec3A, [a, b, c]: [Vec3A; 3]) -> Vec3A {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let normal = ab.cross(ac);
    // The areas beside the sides: the same as of the products above, but exact where these are
    // large and nearly cancel out.
    let beside = |from: Vec3A, along: Vec3A| normal.dot(along.cross(point - from));
    let (over_ab, over_bc, over_ca) = (beside(a, ab), beside(b, c - b), beside(c, a - c));
    if over_ab > 0.0 && over_bc > 0.0 && over_ca > 0.0 {
        let height = ap.dot(normal) / normal.length_squared();
        return point - normal * height;
    }
    let mut best = point_segment(point, a, b);
    let mut squared = best.distance_squared(point);
    for closest in [point_segment(point, b, c), point_segment(point, c, a)] {
        let distance = closest.distance_squared(point);
        if distance < squared {
            (best, squared) = (closest, distance);
        }
    }
    best
}

/// The square of the distance of a triangle from `point`, without a branch for each of its parts:
/// the three sides are looked at side by side. Of two triangles with a common corner that is closest,
/// it is the same.
#[inline(always)]
pub fn point_triangle_squared(point: Vec3A, corners: [Vec3A; 3]) -> f32 {
    let [a, b, c] = corners;
    // The sides from each corner to the next, and one from the first to itself.
    let corners = [
        Vec4::new(a.x, b.x, c.x, a.x),
        Vec4::new(a.y, b.y, c.y, a.y),
        Vec4::new(a.z, b.z, c.z, a.z),
    ];
    let along = corners.map(|corners| corners.yzxw() - corners);
    let from = [0, 1, 2].map(|axis| corners[axis] - Vec4::splat(point[axis]));
    let squares = dot(along, along);
    let share = (-dot(from, along) / squares.max(Vec4::splat(f32::MIN_POSITIVE))).max(Vec4::ZERO);
    let closest = [0, 1, 2].map(|axis| from[axis] + along[axis] * share);
    // What is beyond the end of a side is nearer to the next one.
    let to_sides = Vec4::select(
        share.cmplt(Vec4::ONE),
        dot(closest, closest),
        Vec4::splat(f32::INFINITY),
    );
    let normal = cross(along.map(Vec4Swizzles::zxyw), along).map(Vec4Swizzles::xxxx);
    // The areas beside the sides, seen along the normal.
    let beside = dot(normal, cross(along, from));
    if beside.cmplt(Vec4::ZERO).bitmask() & 0b111 == 0b111 {
        let height = dot(normal, from);
        return (height * (height / dot(normal, normal))).x;
    }
    to_sides.min_element()
}

/// The products of vectors, four side by side.
#[inline(always)]
fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [Vec4; 3], b: [Vec4; 3]) -> [Vec4; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The points of two segments that are closest to each other.
///
/// The crossing of the two lines comes from the cross product of their directions, which stays
/// exact for lines that are nearly parallel where the common formula in dot products does not.
#[inline]
pub fn segments(a: [Vec3A; 2], b: [Vec3A; 2]) -> (Vec3A, Vec3A) {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
    let normal = u.cross(v);
    let normal_squared = normal.length_squared();
    let s = if normal_squared > PARALLEL * u.length_squared() * v.length_squared() {
        (w.cross(v).dot(normal) / normal_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    // With one parameter clamped, the other follows; once more, in case that was clamped as well.
    let on_b = point_segment(a[0] + u * s, b[0], b[1]);
    let on_a = point_segment(on_b, a[0], a[1]);
    (on_a, point_segment(on_a, b[0], b[1]))
}

#[cfg(test)]
mod tests;
