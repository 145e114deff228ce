//! Two balls: the pair that takes least, and of which games have most.

use std::ops::RangeInclusive;

use bevy::math::Vec3A;

use super::nearest::Nearest;
use crate::narrow_phase::{
    frame::placed::{Placed, ROUNDING},
    shape::Shape,
    stage::{Stage, StageCounters},
};

/// Numbers whose squares are numbers, and not nothing.
pub const FAIR: RangeInclusive<f32> = 1e-8..=1e8;

/// Are the sizes of two and the way between them such numbers?
#[inline(always)]
pub fn are_fair(size: f32, offset: Vec3A) -> bool {
    FAIR.contains(&size) && offset.is_finite() && offset.abs().max_element() <= *FAIR.end()
}

/// Two balls, relative to the position of the first.
#[derive(Clone, Copy, Debug)]
pub struct Balls {
    pub nearest: Nearest,
}

/// The radius of a ball. However it is turned, if that is a turn at all.
#[inline(always)]
fn radius(placed: Placed) -> Option<f32> {
    let Shape::Sphere { radius } = placed.shape else {
        return None;
    };
    let radius = radius.abs() * placed.transform.scale.abs().max_element();
    let is_turn = FAIR.contains(&placed.transform.rotation.length_squared());
    (is_turn && placed.transform.scale.is_finite()).then_some(radius)
}

impl Balls {
    /// Two balls; `None` of others, and where products of the numbers would be none.
    #[inline(always)]
    pub fn of(a: Placed, b: Placed) -> Option<Self> {
        let radii = [radius(a)?, radius(b)?];
        let offset = Vec3A::from(b.transform.translation - a.transform.translation);
        are_fair(radii[0] + radii[1], offset).then_some(Self {
            nearest: Nearest {
                points: [Vec3A::ZERO, offset],
                offset,
                radii,
            },
        })
    }

    #[inline(always)]
    fn size(&self) -> f32 {
        self.nearest.radii[0] + self.nearest.radii[1]
    }

    /// Whether the two are no further apart than the tolerance. Counts it where the stages come to
    /// it.
    #[inline(always)]
    pub fn intersects(&self, tolerance: f32, counters: &mut StageCounters) -> bool {
        let size = self.size();
        let tolerance = tolerance.max(ROUNDING * size);
        let verdict = self.nearest.gap() <= tolerance;
        let aside = self.nearest.offset.abs().max_element() - size;
        let is_parted = !verdict && aside > 2.0 * tolerance;
        if counters
            .count(Stage::Bounds, is_parted.then_some(false))
            .is_none()
        {
            counters.count(Stage::Spheres, Some(verdict));
        }
        verdict
    }

    /// Do their centres tell a direction?
    #[inline(always)]
    pub fn have_normal(&self) -> bool {
        self.nearest.offset.length_squared() > f32::MIN_POSITIVE
    }
}
