//! Skins: where an object may go before the index has to know.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

/// How much larger than boxes skins may be, by volume. More makes skins last longer, and more of them overlap.
const GROWTH: f32 = 1.6;

/// The fewest ticks that skins are worth making for, and how much larger they may be for these.
const SHORTEST: f32 = 2.0;
const GROWTH_FOR_SHORTEST: f32 = 2.1;

/// The most ticks that skins are made for.
const LONGEST: f32 = 32.0;

/// Share of the way ahead that is added on all sides: rounding must not carry an object out of a skin along its way.
const MARGIN: f32 = 0.02;

/// The lower corner of an object's box when its skin was made, and the tick; 0 if there is none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Anchor {
    corner: Vec3,
    tick: u32,
}

impl Anchor {
    /// Makes the skin of a box for some ticks ahead: the box swept along its way. `None` if it has none.
    #[inline(always)]
    pub(super) fn renew(&mut self, tick: u32, aabb: &Aabb3d, horizon: f32) -> Option<Aabb3d> {
        let way = self.step(tick, aabb) * horizon;
        self.drop_at(tick, aabb);
        let margin = way.abs() * MARGIN;
        let min = aabb.min + way.min(Vec3A::ZERO) - margin;
        let max = aabb.max + way.max(Vec3A::ZERO) + margin;
        // A way that overflows is not worth a skin.
        (way != Vec3A::ZERO && min.is_finite() && max.is_finite()).then_some(Aabb3d { min, max })
    }

    /// Notes where a box is, the skin of which is the box itself.
    #[inline(always)]
    pub(super) fn drop_at(&mut self, tick: u32, aabb: &Aabb3d) {
        *self = Self { corner: aabb.min.into(), tick };
    }

    /// How an object moves in a tick: the mean since its skin was made.
    #[inline(always)]
    pub(super) fn step(&self, tick: u32, aabb: &Aabb3d) -> Vec3A {
        let age = tick.wrapping_sub(self.tick);
        if self.tick == 0 || age == 0 {
            return Vec3A::ZERO;
        }
        (aabb.min - Vec3A::from(self.corner)) / age as f32
    }
}

/// For how many ticks ahead skins should be made, given steps of a sample of objects and their boxes; 0 if that does
/// not pay.
///
/// The mean of the steps, in parts of the objects' sizes, says how fast skins would grow.
pub(super) fn horizon<'a>(sample: impl Iterator<Item = (Vec3A, &'a Aabb3d)>) -> f32 {
    let (mut sum, mut count) = (Vec3A::ZERO, 0.0);
    for (step, aabb) in sample {
        let step = step.abs();
        if step != Vec3A::ZERO {
            // The share is 1 at most, also for points.
            sum += step / (aabb.max - aabb.min).max(step).max(Vec3A::splat(f32::MIN_POSITIVE));
            count += 1.0;
        }
    }
    if count == 0.0 {
        return SHORTEST;
    }
    let share = sum / count;
    let growth = |ticks: f32| (Vec3A::ONE + share * ticks).to_array().into_iter().product::<f32>();
    if growth(SHORTEST) > GROWTH_FOR_SHORTEST {
        return 0.0;
    }
    let mut ticks = SHORTEST;
    while ticks < LONGEST && growth(ticks + 1.0) <= GROWTH {
        ticks += 1.0;
    }
    ticks
}
