//! Boxes along the axes of the frame of a pair.

use bevy::math::Vec3A;

/// A box along the axes of the frame of a pair, by its corners. May be empty.
#[derive(Clone, Copy, Debug)]
pub struct LocalAabb {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl LocalAabb {
    pub const EVERYWHERE: Self = Self {
        min: Vec3A::NEG_INFINITY,
        max: Vec3A::INFINITY,
    };
    pub const NOWHERE: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// Returns `true` if nothing is outside.
    pub fn is_everywhere(&self) -> bool {
        self.min == Self::EVERYWHERE.min && self.max == Self::EVERYWHERE.max
    }

    /// What two boxes share, given by centre and half extents, grown by `margin`. May be empty.
    pub fn shared(a: (Vec3A, Vec3A), b: (Vec3A, Vec3A), margin: f32) -> Self {
        Self {
            min: (a.0 - a.1).max(b.0 - b.1) - margin,
            max: (a.0 + a.1).min(b.0 + b.1) + margin,
        }
    }

    /// The smallest box around points, grown by `margin`.
    #[inline]
    pub fn around(points: impl Iterator<Item = Vec3A>, margin: f32) -> Self {
        let (mut min, mut max) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for point in points {
            min = min.min(point);
            max = max.max(point);
        }
        let (min, max) = (min - margin, max + margin);
        Self { min, max }
    }

    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The square of the distance of the two.
    #[inline]
    pub fn gap_squared(&self, other: &Self) -> f32 {
        (self.min - other.max)
            .max(other.min - self.max)
            .max(Vec3A::ZERO)
            .length_squared()
    }
}
