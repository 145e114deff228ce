//! Skins: where an object may go before the index has to know.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

/// All objects get new skins when more than one in so many has left its skin since the last time.
pub(super) const REFRESH_SHARE: usize = 6;

/// How much larger than boxes skins may be, by volume. More makes skins last longer, and more of
/// them overlap.
const GROWTH: f32 = 1.6;

/// The fewest ticks that skins are worth making for, and how much larger they may be for these.
pub(super) const SHORTEST: f32 = 2.0;
const GROWTH_FOR_SHORTEST: f32 = 2.1;

/// The skin of a single object may be nearly so much larger than its box: as if it moved by its own
/// size in each of the fewest ticks, along one axis. What is faster has no skin, and does not count
/// where the time ahead is chosen for all.
const GROWTH_OF_ONE: f32 = 1.0 + SHORTEST;

/// A skin that is longer than its box by no more than this share along each axis is no larger than
/// that.
const SHORT: f32 = 0.44;

/// The most ticks that skins are made for.
const LONGEST: f32 = 32.0;

/// Share of the way ahead that is added on all sides: rounding must not carry an object out of a
/// skin along its way.
const MARGIN: f32 = 0.02;

/// The lower corner of an object's box when its skin was made, and the tick; 0 if there is none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Anchor {
    corner: Vec3,
    tick: u32,
}

impl Anchor {
    /// Makes the skin of a box for some ticks ahead, or fewer if it is fast: the box swept along
    /// its way. `None` if it has none.
    #[inline(always)]
    pub(super) fn renew(&mut self, tick: u32, aabb: &Aabb3d, horizon: f32) -> Option<Aabb3d> {
        let step = self.step(tick, aabb);
        self.drop_at(tick, aabb);
        if step == Vec3A::ZERO {
            return None;
        }
        let skin = swept(aabb, step * horizon);
        let size = aabb.max - aabb.min;
        // A skin that overflows is no shorter than the largest number.
        let short = (size * (1.0 + SHORT)).min(Vec3A::MAX);
        if (skin.max - skin.min).cmple(short).all() {
            Some(skin)
        } else {
            shorter(aabb, step, horizon)
        }
    }

    /// Returns `true` if an object is too fast for a skin.
    pub(super) fn is_fast(&self, tick: u32, aabb: &Aabb3d) -> bool {
        is_fast(share(self.step(tick, aabb), aabb))
    }

    /// Notes where a box is, the skin of which is the box itself.
    #[inline(always)]
    pub(super) fn drop_at(&mut self, tick: u32, aabb: &Aabb3d) {
        *self = Self {
            corner: aabb.min.into(),
            tick,
        };
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

/// A step in parts of the box's size; 1 at most, also for points.
fn share(step: Vec3A, aabb: &Aabb3d) -> Vec3A {
    let step = step.abs();
    step / (aabb.max - aabb.min)
        .max(step)
        .max(Vec3A::splat(f32::MIN_POSITIVE))
}

/// Returns `true` if steps of such a share of the size are too fast for a skin.
#[inline(always)]
fn is_fast(share: Vec3A) -> bool {
    let is_slow = (share * SHORTEST).cmple(Vec3A::splat(SHORT)).all();
    !is_slow && growth(share, SHORTEST) >= GROWTH_OF_ONE
}

/// How many times as large as a box its skin for so many ticks is.
fn growth(share: Vec3A, ticks: f32) -> f32 {
    (Vec3A::ONE + share * ticks)
        .to_array()
        .into_iter()
        .product()
}

/// A box swept along its way.
#[inline(always)]
fn swept(aabb: &Aabb3d, way: Vec3A) -> Aabb3d {
    let (ahead, behind) = (way * (1.0 + MARGIN), way * -MARGIN);
    Aabb3d {
        min: aabb.min + ahead.min(behind),
        max: aabb.max + ahead.max(behind),
    }
}

/// The skin of a box that may be too large for so many ticks. `None` if it is fast, or its way
/// overflows.
#[cold]
fn shorter(aabb: &Aabb3d, step: Vec3A, horizon: f32) -> Option<Aabb3d> {
    let share = share(step, aabb);
    let mut ticks = horizon;
    while growth(share, ticks) >= GROWTH_OF_ONE {
        if ticks <= SHORTEST {
            return None;
        }
        ticks = (0.5 * ticks).max(SHORTEST);
    }
    let skin = swept(aabb, step * ticks);
    (skin.min.is_finite() && skin.max.is_finite()).then_some(skin)
}

/// For how many ticks ahead skins should be made, given steps of a sample of objects and their
/// boxes; 0 if that does not pay, or if more than a share of the sample is too fast for it.
///
/// The mean of the steps of all others, in parts of the objects' sizes, says how fast skins would
/// grow.
pub(super) fn horizon<'a>(
    sample: impl Iterator<Item = (Vec3A, &'a Aabb3d)>,
    most_fast: f32,
) -> f32 {
    let (mut sum, mut slow, mut fast, mut all) = (Vec3A::ZERO, 0.0, 0.0, 0.0);
    for (step, aabb) in sample {
        all += 1.0;
        if step != Vec3A::ZERO {
            let share = share(step, aabb);
            if is_fast(share) {
                fast += 1.0;
            } else {
                sum += share;
                slow += 1.0;
            }
        }
    }
    if fast > all * most_fast {
        return 0.0;
    }
    if slow == 0.0 {
        return SHORTEST;
    }
    let mean = sum / slow;
    if growth(mean, SHORTEST) > GROWTH_FOR_SHORTEST {
        return 0.0;
    }
    let mut ticks = SHORTEST;
    while ticks < LONGEST && growth(mean, ticks + 1.0) <= GROWTH {
        ticks += 1.0;
    }
    ticks
}
