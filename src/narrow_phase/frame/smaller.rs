//! Pairs too large for products of their lengths to be held by 32-bit floats: what is asked about
//! them is asked at a smaller scale, by a power of two, which changes nothing but the exponents.

use bevy::{math::Vec3, transform::components::Transform};

use super::case::Case;
use super::placed::{Placed, PlacedPair};
use crate::narrow_phase::settings::NarrowPhase;

/// The greatest length whose fourth power 32-bit floats hold, with room to spare.
const LARGE: f32 = 1e9;

/// A unit vector that was found at a smaller scale, where what is short has few digits left.
pub fn unit(normal: Vec3) -> Vec3 {
    normal.try_normalize().unwrap_or(normal)
}

/// A pair of shapes of ours at a smaller scale.
pub struct Smaller {
    pub tests: NarrowPhase,
    pub transforms: [Transform; 2],
    /// How much smaller it is: lengths times this are those of the pair.
    pub factor: f32,
}

impl PlacedPair<'_> {
    /// Returns `true` if the two shapes themselves are so large.
    #[inline]
    pub fn is_large(&self) -> bool {
        self.size > LARGE
    }

    /// Returns `true` if they are so large, or so far from each other.
    pub fn is_wide(&self) -> bool {
        self.extent() > LARGE
    }

    fn extent(&self) -> f32 {
        // The first is at the origin, but for the centre of its mesh.
        let far = self
            .box_a
            .center
            .abs()
            .max(self.box_b.center.abs())
            .max_element();
        self.size.max(far)
    }
}

impl Smaller {
    /// `None` if one of the two is known by its support function: these are looked at in 64-bit
    /// floats.
    pub fn of(pair: &PlacedPair, tests: &NarrowPhase) -> Option<Self> {
        if matches!(pair.case(), Case::Parts | Case::Foreign) {
            return None;
        }
        // The power of two that is next below: its exponent alone.
        let factor = f32::from_bits(pair.extent().to_bits() & f32::INFINITY.to_bits());
        let smaller = |placed: &Placed<'_>| {
            let Transform {
                translation,
                rotation,
                scale,
            } = *placed.transform;
            Transform {
                translation: translation / factor,
                rotation,
                scale: scale / factor,
            }
        };
        let transforms = [smaller(&pair.a), smaller(&pair.b)];
        Some(Self {
            tests: tests.with_tolerance(tests.tolerance() / factor),
            transforms,
            factor,
        })
    }

    /// The two, in their places.
    pub fn placed<'a>(&'a self, pair: &PlacedPair<'a>) -> [Placed<'a>; 2] {
        let [at_a, at_b] = &self.transforms;
        [
            Placed::new(pair.a.shape, at_a),
            Placed::new(pair.b.shape, at_b),
        ]
    }
}
