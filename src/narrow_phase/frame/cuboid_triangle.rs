//! A cuboid and a triangle, in the axes of the cuboid and around its centre.
//!
//! Two convex shapes are apart exactly if they are so along one of the axes that could part them:
//! here the three of the cuboid, the normal of the triangle, and the nine products of their edges
//! (Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001). The products of the three axes
//! with an edge are computed side by side: what a corner reaches along them is the cross product of
//! edge and corner.

use bevy::math::{DVec3, Vec3A, Vec3Swizzles};

/// The square of the sine of the angle below which edges count as parallel, and their product as no
/// axis: for 32-bit floats, and for 64.
const PARALLEL: f32 = 1e-4;
const PARALLEL_64: f64 = 1e-16;
/// How much later the way along a product of edges has to be free than that along a normal to be
/// preferred, as a share of the size.
const BIAS: f64 = 1e-7;

/// How far a triangle is from a cuboid along the axes that could part them.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// The widest; negative if the two overlap along all of them. They are no nearer than that.
    pub widest: f32,
    /// How far they may still be apart if all gaps are negative, because axes were left out.
    pub doubt: f32,
}

/// The gap between a cuboid and a triangle; `None` if it is wider than `limit`, or not a number.
#[inline]
pub fn gap(half: Vec3A, [a, b, c]: [Vec3A; 3], limit: f32) -> Option<Gap> {
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let faces = (min - half).max(-max - half);
    let mut widest = faces.max_element();
    if widest.is_nan() || widest > limit {
        return None;
    }
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    let length = normal.length();
    if length > 0.0 {
        widest = widest.max((a.dot(normal).abs() - normal.abs().dot(half)) / length);
    }
    let mut left_out = 0f32;
    for (edge, [on, off]) in edges.into_iter().zip([[a, c], [b, a], [c, b]]) {
        let (one, other) = (edge.cross(on), edge.cross(off));
        let reach = reach(half, edge);
        let gaps = (one.min(other) - reach).max(-one.max(other) - reach);
        let squares = edge * edge;
        let lengths = squares.yzx() + squares.zxy();
        let is_axis = lengths.cmpgt(Vec3A::splat(PARALLEL * edge.length_squared()));
        let gaps = Vec3A::select(is_axis, gaps / lengths.map(f32::sqrt), Vec3A::MIN);
        widest = widest.max(gaps.max_element());
        let out = Vec3A::select(is_axis, Vec3A::ZERO, lengths).max_element();
        left_out = left_out.max(out);
    }
    (widest <= limit).then(|| Gap {
        widest,
        doubt: if left_out > 0.0 {
            let size = half.length() + (max - min).length();
            4.0 * size * PARALLEL.sqrt()
        } else {
            0.0
        },
    })
}

/// How far a cuboid reaches along the products of its three axes and an edge.
#[inline]
fn reach(half: Vec3A, edge: Vec3A) -> Vec3A {
    let abs = edge.abs();
    half.yzx() * abs.zxy() + half.zxy() * abs.yzx()
}

/// Where a cuboid on its way meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// How far the cuboid goes.
    pub distance: f64,
    /// Along which axis they then touch: of any length, either way.
    pub normal: DVec3,
}

/// From when to when a cuboid on its way overlaps a triangle, along all axes so far.
struct Passage {
    enter: f64,
    leave: f64,
    normal: DVec3,
}

impl Passage {
    /// Takes up an axis along which the triangle is between `low` and `high` from where the cuboid
    /// begins and ends, and along which this moves with `speed`. `None` if the two do not meet.
    fn clip(&mut self, axis: DVec3, low: f64, high: f64, speed: f64, bias: f64) -> Option<()> {
        if speed == 0.0 {
            return (low <= 0.0 && high >= 0.0).then_some(());
        }
        let (one, other) = (low / speed, high / speed);
        let (enter, leave) = (one.min(other), one.max(other));
        if enter > self.enter + bias {
            (self.enter, self.normal) = (enter, axis);
        }
        self.leave = self.leave.min(leave);
        (self.enter <= self.leave).then_some(())
    }
}

/// How far a cuboid goes in a direction, which is of length 1, until it meets a triangle; `None` if
/// that is beyond `limit`, or behind.
///
/// The axes that could part the two at any time are the sides of a solid, the one swept by the
/// other, through which the way is a line (Cameron, *A Study of the Clash Detection Problem in
/// Robotics*, 1985).
pub fn sweep(half: DVec3, [a, b, c]: [DVec3; 3], direction: DVec3, limit: f64) -> Option<Met> {
    let mut pass = Passage {
        enter: f64::NEG_INFINITY,
        leave: limit,
        normal: DVec3::ZERO,
    };
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    for axis in 0..3 {
        let (low, high) = (min[axis] - half[axis], max[axis] + half[axis]);
        pass.clip(DVec3::AXES[axis], low, high, direction[axis], 0.0)?;
    }
    if pass.leave < 0.0 {
        return None;
    }
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    let (height, reach) = (a.dot(normal), normal.abs().dot(half));
    let speed = normal.dot(direction);
    // A triangle along the way is met at its edges.
    if speed != 0.0 || height.abs() > reach {
        pass.clip(normal, height - reach, height + reach, speed, 0.0)?;
    }
    let bias = BIAS * (half + max - min).max_element();
    for (edge, [on, off]) in edges.into_iter().zip([[a, c], [b, a], [c, b]]) {
        let (one, other) = (edge.cross(on), edge.cross(off));
        let abs = edge.abs();
        let least = PARALLEL_64 * edge.length_squared();
        let speeds = edge.cross(direction);
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            if edge[next] * edge[next] + edge[last] * edge[last] <= least {
                continue;
            }
            let reach = half[next] * abs[last] + half[last] * abs[next];
            let low = one[axis].min(other[axis]) - reach;
            let high = one[axis].max(other[axis]) + reach;
            let across = DVec3::AXES[axis].cross(edge);
            pass.clip(across, low, high, speeds[axis], bias)?;
        }
    }
    (pass.leave >= 0.0 && pass.enter <= limit).then_some(Met {
        distance: pass.enter.max(0.0),
        normal: pass.normal,
    })
}

/// The closest points of a cuboid and of a triangle, if they are nearer to each other than the root
/// of `limit`; the square of their distance comes last. Twice the same point if the two overlap.
///
/// Where neither is inside the other, a side of the triangle is closest to the cuboid, or its
/// inside to a corner.
pub fn closest(half: Vec3A, triangle: [Vec3A; 3], limit: f32) -> Option<([Vec3A; 2], f32)> {
    let [a, b, c] = triangle;
    if gap_squared(half, a.min(b).min(c), a.max(b).max(c)) >= limit {
        return None;
    }
    let mut best: Option<([Vec3A; 2], f32)> = None;
    let mut least = limit;
    let normal = (b - a).cross(c - a);
    let height = a.dot(normal);
    // The corner that comes closest to the plane, or furthest beyond it.
    let towards = if height < 0.0 { -normal } else { normal };
    let corner = Vec3A::select(towards.cmplt(Vec3A::ZERO), -half, half);
    let squared = normal.length_squared();
    if squared > 0.0 {
        let left = height - corner.dot(normal);
        let crosses = left * height <= 0.0;
        let on_plane = if crosses {
            // On the way from the centre to the corner.
            let whole = corner.dot(normal);
            corner * if whole == 0.0 { 0.0 } else { height / whole }
        } else {
            corner + normal * (left / squared)
        };
        if is_over([a, b, c], normal, on_plane) {
            let points = [if crosses { on_plane } else { corner }, on_plane];
            let squared = points[0].distance_squared(points[1]);
            return (squared < limit).then_some((points, squared));
        }
    }
    for [from, to] in [[a, b], [b, c], [c, a]] {
        if gap_squared(half, from.min(to), from.max(to)) >= least {
            continue;
        }
        let on_side = from + (to - from) * nearest_of_segment(half, from, to - from);
        let on_cuboid = on_side.clamp(-half, half);
        let squared = on_cuboid.distance_squared(on_side);
        if squared < least {
            least = squared;
            best = Some(([on_cuboid, on_side], squared));
        }
    }
    best
}

/// How far a box is from a cuboid, squared.
#[inline]
fn gap_squared(half: Vec3A, min: Vec3A, max: Vec3A) -> f32 {
    let gap = (min - half).max(-max - half).max(Vec3A::ZERO);
    gap.length_squared()
}

/// A point where a cuboid and a triangle touch, which do: the middle of what is in both.
pub fn meeting(half: Vec3A, triangle: [Vec3A; 3], tolerance: f32) -> Vec3A {
    // Cut at each side of the cuboid, a triangle has nine corners at most.
    let mut corners = [Vec3A::ZERO; 9];
    corners[..3].copy_from_slice(&triangle);
    let mut count = 3;
    let reach = half + 2.0 * tolerance;
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        let beyond = |corner: Vec3A| corner[axis] * sign - reach[axis];
        let (before, all) = (corners, count);
        count = 0;
        for i in 0..all {
            let (from, to) = (before[i], before[(i + 1) % all]);
            let (out, next_out) = (beyond(from), beyond(to));
            if out <= 0.0 && count < corners.len() {
                corners[count] = from;
                count += 1;
            }
            if (out > 0.0) != (next_out > 0.0) && count < corners.len() {
                corners[count] = from.lerp(to, out / (out - next_out));
                count += 1;
            }
        }
        if count == 0 {
            // Rounding has them apart.
            let found = closest(half, triangle, f32::INFINITY);
            return found.map_or(triangle[0], |([on_cuboid, _], _)| on_cuboid);
        }
    }
    let sum: Vec3A = corners[..count].iter().sum();
    (sum / count as f32).clamp(-half, half)
}

/// Whether a point in the plane of a triangle is in it.
fn is_over([a, b, c]: [Vec3A; 3], normal: Vec3A, point: Vec3A) -> bool {
    let beside = |from: Vec3A, to: Vec3A| normal.dot((to - from).cross(point - from)) >= 0.0;
    beside(a, b) && beside(b, c) && beside(c, a)
}

/// Where along a segment, from 0 at its start to 1 at its end, it is closest to a cuboid.
///
/// The square of the distance is a convex function, made of at most seven parabolas: the slope of
/// it goes up along straight lines. Newton's method finds its zero, kept between where it is known
/// to be.
fn nearest_of_segment(half: Vec3A, start: Vec3A, way: Vec3A) -> f32 {
    let slope = |share: f32| {
        let at = start + way * share;
        let beyond = at - at.clamp(-half, half);
        let counts = Vec3A::select(beyond.cmpeq(Vec3A::ZERO), Vec3A::ZERO, way);
        (beyond.dot(way), counts.length_squared())
    };
    let (mut low, mut high) = (0.0, 1.0);
    // From the point that is closest to the centre.
    let squared = way.length_squared();
    let mut share = if squared > 0.0 {
        (-start.dot(way) / squared).clamp(0.0, 1.0)
    } else {
        return 0.0;
    };
    for _ in 0..MOST_STEPS {
        let (rise, steepness) = slope(share);
        if rise == 0.0 {
            break;
        }
        if rise > 0.0 {
            high = share;
        } else {
            low = share;
        }
        let next = share - rise / steepness;
        let next = if next > low && next < high {
            next
        } else if (next <= low && low == 0.0 && rise > 0.0) || (next >= high && high == 1.0) {
            // The end itself, if it is not yet known to be beyond.
            let end = if rise > 0.0 { 0.0 } else { 1.0 };
            let (rise_at_end, _) = slope(end);
            if (end == 0.0) == (rise_at_end >= 0.0) || rise_at_end == 0.0 {
                return end;
            }
            (low + high) * 0.5
        } else {
            (low + high) * 0.5
        };
        if (next - share).abs() <= f32::EPSILON * 2.0 {
            share = next;
            break;
        }
        share = next;
    }
    share
}

/// So many steps lead to the zero of a slope that has seven parts, and more than so many seldom.
const MOST_STEPS: usize = 24;

#[cfg(test)]
mod tests;
