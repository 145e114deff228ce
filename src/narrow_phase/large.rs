//! Pairs too large for products of their lengths to be held by 32-bit floats: what is asked about them is asked at a
//! smaller scale, by a power of two, which changes nothing but the exponents.

use bevy::math::{Dir3, Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::pair::Pair;
use super::{NarrowPhase, Placed};

/// The greatest length whose fourth power 32-bit floats hold, with room to spare.
const LARGE: f32 = 1e9;

/// A pair of shapes of ours at a smaller scale.
pub(super) struct Smaller {
    pub tests: NarrowPhase,
    pub transforms: [Transform; 2],
    /// How much smaller it is: lengths times this are those of the pair.
    pub factor: f32,
}

impl Pair<'_> {
    /// Are the two shapes themselves so large?
    #[inline]
    pub fn is_large(&self) -> bool {
        self.size > LARGE
    }

    /// Are they so large, or so far from each other?
    pub fn is_wide(&self) -> bool {
        self.extent() > LARGE
    }

    fn extent(&self) -> f32 {
        // The first is at the origin, but for the centre of its mesh.
        let far = self.box_a.center.abs().max(self.box_b.center.abs()).max_element();
        self.size.max(far)
    }
}

impl Smaller {
    /// `None` if one of the two is a shape of Rapier's: these have no scale, and are looked at in 64-bit floats.
    pub fn of(pair: &Pair, tests: &NarrowPhase) -> Option<Self> {
        #[cfg(feature = "rapier")]
        if [pair.a, pair.b].iter().any(|placed| matches!(placed.shape, super::Shape::Rapier(_))) {
            return None;
        }
        // The power of two that is next below: its exponent alone.
        let factor = f32::from_bits(pair.extent().to_bits() & f32::INFINITY.to_bits());
        let smaller = |placed: &Placed<'_>| {
            let Transform { translation, rotation, scale } = *placed.transform;
            Transform { translation: translation / factor, rotation, scale: scale / factor }
        };
        let transforms = [smaller(&pair.a), smaller(&pair.b)];
        Some(Self { tests: tests.with_tolerance(tests.tolerance() / factor), transforms, factor })
    }

    /// The two, in their places.
    pub fn placed<'a>(&'a self, pair: &Pair<'a>) -> [Placed<'a>; 2] {
        let [at_a, at_b] = &self.transforms;
        [Placed::new(pair.a.shape, at_a), Placed::new(pair.b.shape, at_b)]
    }
}

/// The length of a vector whose squares may overflow.
#[inline]
pub(super) fn length(v: Vec3A) -> f32 {
    let length = v.length();
    if length.is_finite() { length } else { safe_length(v) }
}

/// The direction and length of a vector whose squares may overflow.
pub(super) fn direction_and_length(v: Vec3) -> Option<(Dir3, f32)> {
    let length = length(v.into());
    Some((Dir3::new(v / length).ok()?, length))
}

/// The direction of a vector whose squares may overflow, or underflow; zero for zero.
#[inline]
pub(super) fn unit(v: Vec3A) -> Vec3A {
    let unit = v.normalize_or_zero();
    if unit == Vec3A::ZERO { safe_unit(v) } else { unit }
}

#[cold]
fn safe_unit(v: Vec3A) -> Vec3A {
    (v / v.abs().max_element()).normalize_or_zero()
}

#[cold]
fn safe_length(v: Vec3A) -> f32 {
    let greatest = v.abs().max_element();
    (v / greatest).length() * greatest
}
