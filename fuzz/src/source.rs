//! What a target takes from its bytes: numbers, places, lists.

use std::f32::consts::FRAC_1_SQRT_2;

use arbitrary::Unstructured;
use bevy::prelude::*;

/// Numbers that are at an end of something.
const ENDS: [f32; 20] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1e38,
    1e20,
    -1e20,
    1e-20,
    1e9,
    -1e9,
    1e4,
    0.0,
    -0.0,
    1e-4,
    1e-5,
    -1.0,
];

/// Bytes, and how far they have been read. Where they end, zeros follow.
#[derive(Debug)]
pub struct Source<'a> {
    bytes: Unstructured<'a>,
    is_wild: bool,
}

impl<'a> Source<'a> {
    /// Returns a source whose numbers are tame.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes: Unstructured::new(bytes),
            is_wild: false,
        }
    }

    /// By the next byte, numbers may be anything from now on, or are of a size that is computed
    /// with to a millionth. Returns which.
    pub fn may_go_wild(&mut self) -> bool {
        self.is_wild = self.byte() & 3 == 1;
        self.is_wild
    }

    /// Returns `true` if all was read.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Returns all that was not read.
    #[must_use]
    pub fn rest(self) -> &'a [u8] {
        self.bytes.take_rest()
    }

    /// Returns a byte.
    pub fn byte(&mut self) -> u8 {
        self.bytes.arbitrary().unwrap_or_default()
    }

    /// Returns `true` or `false`.
    pub fn bit(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// Returns a number below another, which is not 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.bytes.int_in_range(0..=end - 1).unwrap_or_default()
    }

    /// Returns one of a list that is not empty.
    pub fn choose<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// Returns up to so many of something, fewer where the bytes end.
    pub fn list<T>(&mut self, most: usize, mut next: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let count = self.below(most + 1);
        let mut list = Vec::new();
        while list.len() < count && !self.is_empty() {
            list.push(next(self));
        }
        list
    }

    /// Returns any 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.bytes.arbitrary().unwrap_or_default()
    }

    /// Returns a number between -8 and 8, on a grid or not; if the source is wild, any number.
    pub fn number(&mut self) -> f32 {
        match self.byte() {
            0..144 => f32::from(self.byte().cast_signed()) / 16.0,
            144..160 => self.choose(&[0.0, 1.0, -1.0, 0.5, 2.0, FRAC_1_SQRT_2]),
            160..208 => self.fine(),
            208..240 if self.is_wild => self.choose(&ENDS),
            _ if self.is_wild => f32::from_bits(self.bits()),
            _ => self.fine(),
        }
    }

    fn fine(&mut self) -> f32 {
        let bits: i16 = self.bytes.arbitrary().unwrap_or_default();
        f32::from(bits) / 4096.0
    }

    /// Returns a number between 1/16 and 8; if the source is wild, any number.
    pub fn size(&mut self) -> f32 {
        let number = self.number();
        if self.is_wild {
            number
        } else {
            number.abs().max(0.0625)
        }
    }

    /// Returns three numbers.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Returns three sizes.
    pub fn sizes(&mut self) -> Vec3 {
        Vec3::new(self.size(), self.size(), self.size())
    }

    /// Returns a direction.
    pub fn direction(&mut self) -> Dir3 {
        let is_wild = std::mem::replace(&mut self.is_wild, false);
        let direction = Dir3::new(self.vector()).unwrap_or(Dir3::X);
        self.is_wild = is_wild;
        direction
    }

    /// Returns a turn; if the source is wild, four numbers.
    pub fn turn(&mut self) -> Quat {
        match self.byte() {
            0..64 => Quat::IDENTITY,
            64..96 => Quat::from_rotation_x(self.number()),
            96..128 => {
                let quarters = f32::from(self.byte() & 3);
                Quat::from_axis_angle(
                    self.choose(&[Vec3::X, Vec3::Y, Vec3::Z]),
                    quarters * std::f32::consts::FRAC_PI_2,
                )
            }
            _ if self.is_wild => Quat::from_vec4(self.vector().extend(self.number())),
            _ => Quat::from_scaled_axis(self.vector()),
        }
    }

    /// Returns a scale; if the source is wild, any.
    pub fn scale(&mut self) -> Vec3 {
        match self.byte() {
            0..128 => Vec3::ONE,
            128..192 => self.even_scale(),
            _ => {
                let mut scale = self.sizes();
                if !self.is_wild {
                    scale = scale.clamp(Vec3::splat(0.25), Vec3::splat(4.0));
                }
                scale
                    * if self.bit() {
                        -Vec3::X + Vec3::Y + Vec3::Z
                    } else {
                        Vec3::ONE
                    }
            }
        }
    }

    /// Returns a scale that is the same along all axes, perhaps mirrored along some.
    pub fn even_scale(&mut self) -> Vec3 {
        let scale = self.choose(&[1.0, 0.25, 0.5, 1.5, 2.0, 3.0]);
        let signs = self.byte();
        Vec3::from([0, 1, 2].map(|axis| {
            if signs >> axis & 1 == 1 {
                -scale
            } else {
                scale
            }
        }))
    }

    /// Returns where something is.
    pub fn pose(&mut self) -> Transform {
        Transform {
            translation: self.vector(),
            rotation: self.turn(),
            scale: self.scale(),
        }
    }
}
