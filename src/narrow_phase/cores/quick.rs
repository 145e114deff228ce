//! Balls, capsules and cuboids in closed form, straight from where they are.
//!
//! These are what games have most, and what is told about two of them takes less than to put any two
//! shapes into a frame. Numbers that are so large, so small or so wrong that products of them are no
//! numbers any more are left to the tests for all shapes, and so are two cuboids. Two balls have a [type of
//! their own](super::balls).

use bevy::math::{Mat3A, Quat, Vec3A};

use super::balls::{FAIR, are_fair};
use super::nearest::{Closest, Nearest};
use super::segments::{Segment, segment_box, segments, way_out};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::placed::{Placed, ROUNDING},
    shape::Shape,
    stage::{Stage, StageCounters},
};

/// The least distance of two cores that tells a direction, as a share of the sizes.
const LEAST: f32 = 1e-4;
/// The same of a box and what is much smaller: where that is, is known to the last digit.
const LEAST_ASIDE: f32 = 1e-5;

/// How many times larger a box is of which the place of the other is computed in 64-bit floats.
const MUCH_LARGER: f32 = 8.0;

/// Two shapes, relative to the position of the first.
#[derive(Clone, Copy, Debug)]
pub struct QuickPair {
    kind: Kind,
    /// The sum of the greatest half extents.
    size: f32,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Rounds {
        segments: [Segment; 2],
        radii: [f32; 2],
    },
    WithBox {
        /// In the axes of the box, around its centre.
        segment: Segment,
        radius: f32,
        half: Vec3A,
        axes: Mat3A,
        /// Where the box is, and where the other one.
        center: Vec3A,
        other: Vec3A,
        is_box_first: bool,
    },
}

/// A turn of unit length, if it is one at all.
#[inline(always)]
fn turn(rotation: Quat) -> Option<Quat> {
    let squared = rotation.length_squared();
    FAIR.contains(&squared)
        .then(|| rotation * squared.sqrt().recip())
}

/// The half of the segment, and the radius around it, of a ball or a capsule.
#[inline(always)]
fn round(placed: Placed) -> Option<(Vec3A, f32)> {
    let scale = placed.transform.scale.abs();
    let rotation = placed.transform.rotation;
    match placed.shape {
        // It looks alike from all sides, if it is turned at all.
        Shape::Sphere { radius } => FAIR
            .contains(&rotation.length_squared())
            .then(|| (Vec3A::ZERO, radius.abs() * scale.max_element())),
        Shape::Capsule {
            radius,
            half_length,
        } => {
            let radius = radius.abs() * scale.x.max(scale.z);
            let length = half_length.abs() * scale.y;
            Some((turn(rotation)? * Vec3A::Y * length, radius))
        }
        _ => None,
    }
}

impl QuickPair {
    /// Two of which each is a ball, a capsule or a cuboid, but for two balls and two cuboids.
    #[inline(always)]
    pub fn of(a: Placed, b: Placed) -> Option<Self> {
        let offset = Vec3A::from(b.transform.translation - a.transform.translation);
        let pair = match (a.shape, b.shape) {
            (Shape::Cuboid { .. }, Shape::Sphere { .. } | Shape::Capsule { .. }) => {
                Self::with_box(a, b, offset, true)
            }
            (Shape::Sphere { .. } | Shape::Capsule { .. }, Shape::Cuboid { .. }) => {
                Self::with_box(b, a, -offset, false)
            }
            (Shape::Capsule { .. }, Shape::Sphere { .. } | Shape::Capsule { .. })
            | (Shape::Sphere { .. }, Shape::Capsule { .. }) => {
                let ((half_a, radius_a), (half_b, radius_b)) = (round(a)?, round(b)?);
                let center = Vec3A::ZERO;
                let lengths = half_a.abs().max_element() + half_b.abs().max_element();
                Some(Self {
                    kind: Kind::Rounds {
                        segments: [
                            Segment {
                                center,
                                half: half_a,
                            },
                            Segment {
                                center: offset,
                                half: half_b,
                            },
                        ],
                        radii: [radius_a, radius_b],
                    },
                    size: lengths + radius_a + radius_b,
                })
            }
            _ => None,
        }?;
        let is_fair = are_fair(pair.size, offset)
            && pair.is_finite()
            && a.transform.scale.is_finite()
            && b.transform.scale.is_finite();
        is_fair.then_some(pair)
    }

    /// A box, and what is round, by the way from the box to it.
    #[inline(always)]
    fn with_box(cuboid: Placed, other: Placed, offset: Vec3A, is_box_first: bool) -> Option<Self> {
        let Shape::Cuboid { half_size } = cuboid.shape else {
            return None;
        };
        let half = Vec3A::from((*half_size * cuboid.transform.scale).abs());
        let (way, radius) = round(other)?;
        let rotation = turn(cuboid.transform.rotation)?;
        let axes = Mat3A::from_quat(rotation);
        let back = axes.transpose();
        let reach = way.abs().max_element() + radius;
        // Beside what is much larger, where it is takes more digits than it has.
        let at = if half.max_element() > MUCH_LARGER * reach {
            let turn = rotation.as_dquat().normalize();
            let [from, to] = [cuboid, other].map(|placed| placed.transform.translation.as_dvec3());
            (turn.inverse() * (to - from)).as_vec3a()
        } else {
            back * offset
        };
        Some(Self {
            kind: Kind::WithBox {
                segment: Segment {
                    center: at,
                    half: back * way,
                },
                radius,
                half,
                axes,
                center: if is_box_first { Vec3A::ZERO } else { -offset },
                other: if is_box_first { offset } else { Vec3A::ZERO },
                is_box_first,
            },
            size: half.max_element() + reach,
        })
    }

    /// Is no extent lost in the greatest of them?
    #[inline(always)]
    fn is_finite(&self) -> bool {
        match &self.kind {
            Kind::Rounds { radii: [a, b], .. } => (a + b).is_finite(),
            Kind::WithBox { half, radius, .. } => (half.element_sum() + radius).is_finite(),
        }
    }

    /// Counts a verdict where the stages come to it: each looks at the pair as long as none before
    /// has parted it.
    #[inline]
    pub fn count(&self, tolerance: f32, verdict: bool, counters: &mut StageCounters) {
        let slack = 2.0 * self.tolerance(tolerance);
        let (apart, reach, radii) = match &self.kind {
            Kind::Rounds {
                segments: [a, b],
                radii,
            } => {
                let radii = radii[0] + radii[1];
                let halves = a.half.length() + b.half.length();
                (
                    b.center,
                    a.half.abs() + b.half.abs() + radii,
                    halves + radii,
                )
            }
            Kind::WithBox {
                segment,
                radius,
                half,
                axes,
                center,
                other,
                ..
            } => {
                let way = *axes * segment.half;
                let apart = *other - *center;
                let reach = axes.abs() * *half + way.abs() + *radius;
                (apart, reach, half.length() + way.length() + radius)
            }
        };
        let is_parted = !verdict && (apart.abs() - reach).max_element() > slack;
        if counters
            .count(Stage::Bounds, is_parted.then_some(false))
            .is_some()
        {
            return;
        }
        let is_parted = !verdict && apart.length() - radii > slack;
        if counters
            .count(Stage::Spheres, is_parted.then_some(false))
            .is_some()
        {
            return;
        }
        // A ball and a box are decided as boxes are.
        let is_ball = matches!(&self.kind, Kind::WithBox { segment, .. } if segment.is_point());
        if counters
            .count(Stage::Boxes, is_ball.then_some(verdict))
            .is_none()
        {
            counters.count(Stage::Complete, Some(verdict));
        }
    }

    /// At least what rounding leaves uncertain.
    #[inline(always)]
    fn tolerance(&self, tolerance: f32) -> f32 {
        tolerance.max(ROUNDING * self.size)
    }

    /// Where the two are closest, without their radii, and these.
    #[inline(always)]
    fn nearest(&self) -> Nearest {
        match self.kind {
            Kind::Rounds {
                segments: [a, b],
                radii,
            } => Nearest::between(segments(&a, &b), radii),
            Kind::WithBox {
                segment,
                radius,
                half,
                axes,
                center,
                other,
                is_box_first,
            } => {
                let [from, to] = segment_box(&segment, half);
                let on_box = center + axes * to;
                let on_other = if segment.is_point() {
                    other
                } else {
                    center + axes * from
                };
                let found = Nearest {
                    points: [on_other, on_box],
                    offset: axes * (to - from),
                    radii: [radius, 0.0],
                };
                if is_box_first {
                    found.reversed()
                } else {
                    found
                }
            }
        }
    }

    /// Whether the two are no further apart than the tolerance.
    #[inline]
    pub fn intersects(&self, tolerance: f32) -> bool {
        self.nearest().gap() <= self.tolerance(tolerance)
    }

    /// Where the two are closest to each other.
    #[inline]
    pub fn closest_points(&self) -> Closest {
        self.nearest().of_surfaces()
    }

    /// Where and how deep the two meet, if they do; the outer `None` where their cores do, and no
    /// closed form knows more.
    #[inline]
    pub fn contact(&self, tolerance: f32) -> Option<Option<LocalContact>> {
        let nearest = self.nearest();
        if nearest.gap() > self.tolerance(tolerance) {
            return Some(None);
        }
        if nearest.distance() > self.least() {
            return Some(Some(nearest.contact()));
        }
        let Kind::WithBox {
            segment,
            radius,
            half,
            axes,
            is_box_first,
            ..
        } = self.kind
        else {
            return None;
        };
        let (way, depth) = way_out(&segment, half);
        // The round one goes out that way, and so is where its normal comes from.
        let outwards = axes * way;
        Some(Some(LocalContact {
            normal: if is_box_first { outwards } else { -outwards },
            point: nearest.points[usize::from(is_box_first)],
            depth: (depth + radius).max(0.0),
        }))
    }

    /// The least distance of the two cores that tells a direction.
    #[inline]
    fn least(&self) -> f32 {
        let share = match &self.kind {
            Kind::Rounds { .. } => LEAST,
            Kind::WithBox { half, .. }
                if MUCH_LARGER * (self.size - half.max_element()) < half.max_element() =>
            {
                LEAST_ASIDE
            }
            Kind::WithBox { .. } => LEAST,
        };
        share * self.size
    }
}
