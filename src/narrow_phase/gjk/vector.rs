//! Vectors of either precision, for what is computed alike in both.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use bevy::math::{DVec3, Vec3A};

/// A number of either precision.
pub trait Scalar:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;
    /// What may be left uncertain of a distance, as a share of it and of the sizes at hand.
    const PRECISION: Self;
    /// What counts as flat, or as nothing, as a share of the sizes at hand: more than rounding.
    const FLAT: Self;
    /// A share of a corner that may be none.
    const DOUBT: Self;

    fn sqrt(self) -> Self;
    fn greater(self, other: Self) -> Self;
    fn clamped(self, low: Self, high: Self) -> Self;
}

/// A vector of three such numbers.
pub trait Vector:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Self::Scalar, Output = Self>
    + Div<Self::Scalar, Output = Self>
{
    type Scalar: Scalar;
    const ZERO: Self;

    fn dot(self, other: Self) -> Self::Scalar;
    fn cross(self, other: Self) -> Self;
    fn midpoint(self, other: Self) -> Self;

    #[inline(always)]
    fn length_squared(self) -> Self::Scalar {
        self.dot(self)
    }

    #[inline(always)]
    fn length(self) -> Self::Scalar {
        self.length_squared().sqrt()
    }
}

macro_rules! precision {
    ($scalar:ty, $vector:ty, $precision:literal, $flat:literal) => {
        impl Scalar for $scalar {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const PRECISION: Self = $precision;
            const FLAT: Self = $flat;
            const DOUBT: Self = 1e-2;

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn greater(self, other: Self) -> Self {
                self.max(other)
            }

            #[inline(always)]
            fn clamped(self, low: Self, high: Self) -> Self {
                self.clamp(low, high)
            }
        }

        impl Vector for $vector {
            type Scalar = $scalar;
            const ZERO: Self = Self::ZERO;

            #[inline(always)]
            fn dot(self, other: Self) -> $scalar {
                self.dot(other)
            }

            #[inline(always)]
            fn cross(self, other: Self) -> Self {
                self.cross(other)
            }

            #[inline(always)]
            fn midpoint(self, other: Self) -> Self {
                self.midpoint(other)
            }
        }
    };
}

precision!(f32, Vec3A, 1e-6, 1e-6);
precision!(f64, DVec3, 1e-13, 1e-13);
