//! Where segments are closest to each other and to boxes, in closed form. A segment may be a point.

use bevy::math::{Vec3A, Vec4};

use crate::narrow_phase::frame::closest;

/// The cosine, less than one by so little, of segments that run alongside each other.
const ALONGSIDE: f32 = 1e-5;
/// Faces are preferred to edges that are better by no more than this share of the sizes.
const HARDLY: f32 = 1e-4;

/// A segment, by its middle and its half.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub center: Vec3A,
    pub half: Vec3A,
}

impl Segment {
    /// Is it no more than a point?
    #[inline]
    pub fn is_point(&self) -> bool {
        self.half == Vec3A::ZERO
    }

    #[inline]
    fn at(&self, share: f32) -> Vec3A {
        self.center + self.half * share
    }

    #[inline]
    fn ends(&self) -> [Vec3A; 2] {
        [self.center - self.half, self.center + self.half]
    }
}

/// The points of two segments that are closest to each other: of those that run alongside, in the
/// middle of what they share.
#[inline(always)]
pub fn segments(a: &Segment, b: &Segment) -> [Vec3A; 2] {
    let (length_a, length_b) = (a.half.length_squared(), b.half.length_squared());
    if length_a == 0.0 {
        return [a.center, closest_to(b, a.center, length_b)];
    }
    if length_b == 0.0 {
        return [closest_to(a, b.center, length_a), b.center];
    }
    let cosine = a.half.dot(b.half);
    if cosine * cosine >= (1.0 - ALONGSIDE) * length_a * length_b {
        // As shares of the first: from where to where the other runs beside it.
        let offset = (b.center - a.center).dot(a.half) / length_a;
        let reach = (cosine / length_a).abs();
        let (low, high) = ((offset - reach).max(-1.0), (offset + reach).min(1.0));
        if low < high && cosine * cosine >= (1.0 - ALONGSIDE * ALONGSIDE) * length_a * length_b {
            let on_a = a.at((low + high) * 0.5);
            return [on_a, closest_to(b, on_a, length_b)];
        }
    }
    let (on_a, on_b) = closest::segments(a.ends(), b.ends());
    [on_a, on_b]
}

/// The point of a segment, whose half has a squared length, that is closest to another point.
#[inline]
fn closest_to(segment: &Segment, point: Vec3A, squared: f32) -> Vec3A {
    if squared == 0.0 {
        return segment.center;
    }
    let share = (point - segment.center).dot(segment.half) / squared;
    segment.at(share.clamp(-1.0, 1.0))
}

/// The points of a segment and of an upright box around the origin that are closest to each other;
/// of those that are equally so, in their middle.
///
/// The distance is a convex function of the way along the segment, and the square of it consists of
/// parabolas that join where the segment passes the plane of a side: the slope is linear between
/// two of six places.
#[inline]
pub fn segment_box(segment: &Segment, half: Vec3A) -> [Vec3A; 2] {
    let way = segment.half;
    if way == Vec3A::ZERO {
        let point = segment.center;
        return [point, point.clamp(-half, half)];
    }
    let to = |plane: Vec3A| {
        ((plane - segment.center) / way)
            .max(-Vec3A::ONE)
            .min(Vec3A::ONE)
    };
    let (low, high) = (to(-half), to(half));
    let places = [
        Vec4::new(-1.0, 1.0, low.x, high.x),
        Vec4::new(low.y, high.y, low.z, high.z),
    ];
    let slopes = places.map(|place| {
        let mut slope = Vec4::ZERO;
        for axis in 0..3 {
            let at = Vec4::splat(segment.center[axis]) + place * way[axis];
            let beyond = at - at.clamp(Vec4::splat(-half[axis]), Vec4::splat(half[axis]));
            slope += beyond * way[axis];
        }
        slope
    });
    // Where it last comes nearer, and where it first goes away.
    let (mut near, mut far) = ((-1.0, f32::NEG_INFINITY), (1.0, f32::INFINITY));
    for (place, slope) in places.into_iter().zip(slopes) {
        for lane in 0..4 {
            let (place, slope) = (place[lane], slope[lane]);
            if slope <= 0.0 && (place > near.0 || near.1 == f32::NEG_INFINITY) {
                near = (place, slope);
            }
            if slope >= 0.0 && (place < far.0 || far.1 == f32::INFINITY) {
                far = (place, slope);
            }
        }
    }
    let share = match (near.1.is_finite(), far.1.is_finite()) {
        // All along, it goes away, or comes nearer.
        (false, _) => -1.0,
        (_, false) => 1.0,
        // Along a side, or inside.
        _ if near.0 >= far.0 => (near.0 + far.0) * 0.5,
        _ => near.0 + (far.0 - near.0) * (-near.1 / (far.1 - near.1)),
    };
    let point = segment.at(share);
    [point, point.clamp(-half, half)]
}

/// The shortest way out of an upright box around the origin, for a segment that is partly inside, or
/// hardly outside: a unit vector, and how far, which is less than nothing outside. The difference of the two is bounded by planes along the sides of the
/// box, and by those that the segment spans with its edges.
pub fn way_out(segment: &Segment, half: Vec3A) -> (Vec3A, f32) {
    let Segment { center, half: way } = *segment;
    let depths = half + way.abs() - center.abs();
    let axis = depths.min_position();
    let mut best = (Vec3A::ZERO, depths[axis]);
    best.0[axis] = 1f32.copysign(center[axis]);
    let hardly = HARDLY * half.max_element();
    for edge in Vec3A::AXES {
        let Some(normal) = edge.cross(way).try_normalize() else {
            continue;
        };
        let height = center.dot(normal);
        let depth = half.dot(normal.abs()) - height.abs();
        if depth < best.1 - hardly {
            best = (normal * 1f32.copysign(height), depth);
        }
    }
    best
}
