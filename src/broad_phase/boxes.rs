//! Boxes and their handles: what everything else in the broad phase is about.

use bevy::{
    math::{Vec3A, bounding::Aabb3d},
    prelude::Reflect,
};
use thiserror::Error;

/// The handle of one object's box in a [`SpatialIndex`](super::SpatialIndex).
///
/// Handles are dense, from 0 up. A handle stays the same until its object is removed; after that it
/// is not handed out again before two more updates have passed, so that whoever compares one tick
/// with the next never takes one object for another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[type_path = "bevy_octree"]
pub struct ProxyId(u32);

impl ProxyId {
    /// Returns the handle with this index.
    #[inline]
    #[must_use]
    pub const fn new(index: u32) -> Self {
        Self(index)
    }

    /// Returns the index in arrays that run parallel to the proxies.
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the index as the 32-bit number that it is stored as.
    #[inline]
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

/// Why a box cannot be indexed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BoxError {
    /// A corner is NaN or infinite.
    #[error("the box has a corner that is not finite: min {:?}, max {:?}", .0.min, .0.max)]
    NotFinite(Aabb3d),
    /// A minimum lies above its maximum.
    #[error("the box is inverted: min {:?}, max {:?}", .0.min, .0.max)]
    Inverted(Aabb3d),
    /// There is no such object, or no longer.
    #[error("no object has the handle {0:?}")]
    UnknownProxy(ProxyId),
    /// All of the 2³² − 1 handles are in use.
    #[error("the index is full: it holds {} objects", u32::MAX)]
    Full,
}

/// Two objects, the lower handle first, and how far their boxes are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    pub a: ProxyId,
    pub b: ProxyId,
    pub distance: f32,
}

/// Returns how far two boxes are from each other, in a straight line. In double precision, in which
/// no square overflows.
#[inline(always)]
pub fn distance(a: &Aabb3d, b: &Aabb3d) -> f32 {
    let gap = (a.min - b.max).max(b.min - a.max).max(Vec3A::ZERO);
    gap.as_dvec3().length() as f32
}

/// Refuses boxes that are not finite, or inverted. A box without extent (a point) is fine.
///
/// # Errors
/// [`BoxError::NotFinite`] and [`BoxError::Inverted`].
#[inline]
pub fn check_box(aabb: &Aabb3d) -> Result<(), BoxError> {
    if is_box(aabb) {
        return Ok(());
    }
    if aabb.min.is_finite() && aabb.max.is_finite() {
        Err(BoxError::Inverted(*aabb))
    } else {
        Err(BoxError::NotFinite(*aabb))
    }
}

/// Returns `true` if a box is finite and not inverted. A NaN fails every comparison.
#[inline]
pub(super) fn is_box(aabb: &Aabb3d) -> bool {
    let least = Vec3A::splat(f32::MIN);
    let most = Vec3A::splat(f32::MAX);
    (aabb.min.cmple(aabb.max) & aabb.min.cmpge(least) & aabb.max.cmple(most)).all()
}

/// Returns `true` if two boxes overlap. Touching counts, as in [`Aabb3d`]'s own `intersects`.
#[inline]
#[must_use]
#[doc(alias = "intersects")]
pub fn overlap(a: &Aabb3d, b: &Aabb3d) -> bool {
    (a.min.cmple(b.max) & a.max.cmpge(b.min)).all()
}

/// The cell of a broad phase that does not divide space.
pub const EVERYWHERE: Aabb3d = Aabb3d {
    min: Vec3A::NEG_INFINITY,
    max: Vec3A::INFINITY,
};

/// A box that overlaps nothing.
pub(super) const NOWHERE: Aabb3d = Aabb3d {
    min: Vec3A::INFINITY,
    max: Vec3A::NEG_INFINITY,
};
