//! Which pairs are wanted at all.

use bevy::prelude::Reflect;

/// What an object is, and what it may meet. Overlapping boxes of which one does not admit the other make no pair.
///
/// ```
/// use bevy::math::{Vec3, bounding::Aabb3d};
/// use bevy_octree::broad_phase::{PairFilter, SpatialIndex};
///
/// let mut index = SpatialIndex::default();
/// let bullets = PairFilter { memberships: 0b10, filters: 0b01, ..PairFilter::default() };
/// for _ in 0..3 {
///     let bullet = index.insert(Aabb3d::new(Vec3::ZERO, Vec3::ONE))?;
///     index.set_filter(bullet, bullets)?;
/// }
/// index.insert(Aabb3d::new(Vec3::ZERO, Vec3::ONE))?; // by default, on layer 0b01, and admits all layers
/// assert_eq!(index.find_pairs().len(), 3); // each bullet with the last, and with no other bullet
/// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
pub struct PairFilter {
    /// The layers that the object is on: a bit for each.
    pub memberships: u32,
    /// The layers that it may meet.
    pub filters: u32,
    /// Static objects do not meet each other.
    pub is_static: bool,
}

impl Default for PairFilter {
    /// On the first layer, and admits everything.
    fn default() -> Self {
        Self { memberships: 1, filters: u32::MAX, is_static: false }
    }
}

impl PairFilter {
    /// Do two objects admit each other? Each must be on a layer that the other may meet, and one must not be static.
    #[inline]
    #[must_use]
    pub const fn admits(&self, other: &Self) -> bool {
        self.memberships & other.filters != 0
            && other.memberships & self.filters != 0
            && !(self.is_static && other.is_static)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_must_admit_and_one_must_not_be_static() {
        let any = PairFilter::default();
        let on = |memberships, filters| PairFilter { memberships, filters, is_static: false };
        assert!(any.admits(&any));
        assert!(on(2, 4).admits(&on(4, 2)));
        assert!(!on(2, 4).admits(&on(4, 1)));
        assert!(!on(2, 1).admits(&on(4, 2)));
        assert!(!on(0, u32::MAX).admits(&any), "an object on no layer meets nothing");
        let fixed = PairFilter { is_static: true, ..any };
        assert!(fixed.admits(&any) && any.admits(&fixed) && !fixed.admits(&fixed));
    }
}
