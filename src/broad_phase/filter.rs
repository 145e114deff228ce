//! Which pairs are wanted at all.

use bevy::prelude::Reflect;

/// What an object is, and what it may meet. Overlapping boxes of which one does not admit the other
/// make no pair, unless one is a [detector](Self::is_detector).
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
#[type_path = "bevy_octree"]
#[doc(alias = "layer mask")]
#[doc(alias = "collision groups")]
pub struct PairFilter {
    /// The layers that the object is on: a bit for each.
    pub memberships: u32,
    /// The layers that it may meet.
    pub filters: u32,
    /// Which of the [`PairKinds`] the object's pairs are. By default, static objects do not meet
    /// each other.
    pub is_static: bool,
    /// Does it make pairs with all that it may meet, though that may not meet it?
    pub is_detector: bool,
    /// The number of the world that the object is in. Objects of different worlds do not meet.
    pub world: u32,
    /// The number of the body that the object is a part of. Parts of one body do not meet each
    /// other; what has [no body](Self::NO_BODY) meets all.
    pub body: u32,
}

impl Default for PairFilter {
    /// On the first layer of the default world, and admits everything.
    fn default() -> Self {
        Self {
            memberships: 1,
            filters: u32::MAX,
            is_static: false,
            is_detector: false,
            world: Self::DEFAULT_WORLD,
            body: Self::NO_BODY,
        }
    }
}

impl PairFilter {
    /// The world of all objects that were given no other.
    pub const DEFAULT_WORLD: u32 = u32::MAX;
    /// The body of all objects that are parts of none.
    pub const NO_BODY: u32 = u32::MAX;

    /// Returns `true` if two objects admit each other. They must be in the same world, not parts of
    /// one body, and each on a layer that the other may meet; what may meet a
    /// [detector](Self::is_detector) is up to that alone.
    #[inline]
    #[must_use]
    pub const fn admits(&self, other: &Self) -> bool {
        self.world == other.world
            && !self.is_of_one_body(other)
            && if self.filters & other.memberships != 0 {
                other.filters & self.memberships != 0 || self.is_detector
            } else {
                other.is_detector && other.filters & self.memberships != 0
            }
    }

    #[inline]
    const fn is_of_one_body(&self, other: &Self) -> bool {
        self.body == other.body && self.body != Self::NO_BODY
    }
}

/// Which kinds of pairs are sought at all: by default, all but those of two static objects.
///
/// ```
/// use bevy::math::{Vec3, bounding::Aabb3d};
/// use bevy_octree::broad_phase::{PairFilter, PairKinds, SpatialIndex};
///
/// let mut index = SpatialIndex::default();
/// for is_static in [true, true, false, false] {
///     let object = index.insert(Aabb3d::new(Vec3::ZERO, Vec3::ONE))?;
///     index.set_filter(object, PairFilter { is_static, ..PairFilter::default() })?;
/// }
/// assert_eq!(index.find_pairs().len(), 5);
/// index.set_pair_kinds(PairKinds { moving_moving: false, ..PairKinds::default() });
/// assert_eq!(index.find_pairs().len(), 4); // each moving one with each static one
/// # Ok::<(), bevy_octree::broad_phase::BoxError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[type_path = "bevy_octree"]
pub struct PairKinds {
    /// Pairs of which neither is [static](PairFilter::is_static).
    pub moving_moving: bool,
    /// Pairs of which one is static.
    pub moving_static: bool,
    /// Pairs of which both are static.
    pub static_static: bool,
}

impl Default for PairKinds {
    fn default() -> Self {
        Self {
            moving_moving: true,
            moving_static: true,
            static_static: false,
        }
    }
}

impl PairKinds {
    /// Returns `true` if pairs of two such objects are sought.
    #[inline]
    #[must_use]
    pub const fn include(self, a: &PairFilter, b: &PairFilter) -> bool {
        let by_static = [self.moving_moving, self.moving_static, self.static_static];
        by_static[a.is_static as usize + b.is_static as usize]
    }
}

#[cfg(test)]
mod tests;
