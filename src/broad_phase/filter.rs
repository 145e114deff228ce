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
    /// Which of the [`PairKinds`] the object's pairs are. By default, static objects do not meet each other.
    pub is_static: bool,
    /// The number of the world that the object is in. Objects of different worlds do not meet.
    pub world: u32,
}

impl Default for PairFilter {
    /// On the first layer of the default world, and admits everything.
    fn default() -> Self {
        Self { memberships: 1, filters: u32::MAX, is_static: false, world: Self::DEFAULT_WORLD }
    }
}

impl PairFilter {
    /// The world of all objects that were given no other.
    pub const DEFAULT_WORLD: u32 = u32::MAX;

    /// Do two objects admit each other? They must be in the same world, and each on a layer that the other may meet.
    #[inline]
    #[must_use]
    pub const fn admits(&self, other: &Self) -> bool {
        self.world == other.world && self.memberships & other.filters != 0 && other.memberships & self.filters != 0
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
        Self { moving_moving: true, moving_static: true, static_static: false }
    }
}

impl PairKinds {
    /// Are pairs of two such objects sought?
    #[inline]
    #[must_use]
    pub const fn include(self, a: &PairFilter, b: &PairFilter) -> bool {
        let by_static = [self.moving_moving, self.moving_static, self.static_static];
        by_static[a.is_static as usize + b.is_static as usize]
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Vec3A, bounding::Aabb3d};

    use super::*;
    use crate::broad_phase::{
        BroadPhase, BroadPhaseStats, Exhaustive, Pair, Proxies, SpatialIndex, Visitor, checked::Checked, overlap,
    };

    /// A broad phase that knows nothing of filters.
    struct Unfiltered;

    impl BroadPhase for Unfiltered {
        fn name(&self) -> &'static str {
            "unfiltered"
        }

        fn maintain(&mut self, _: &Proxies) {}

        fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
            for (a, box_a) in proxies.iter() {
                let after = proxies.iter().filter(|(b, box_b)| *b > a && overlap(box_a, box_b));
                let moving = after.filter(|(b, _)| proxies.is_moved(a) || proxies.is_moved(*b));
                pairs.extend(moving.map(|(b, _)| Pair::new(a, b)));
            }
            0
        }

        fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
            Exhaustive::default().traverse(proxies, visitor);
        }

        fn stats(&self) -> BroadPhaseStats {
            BroadPhaseStats::default()
        }
    }

    #[test]
    fn a_broad_phase_need_not_ask_filters() {
        let mut rng = fastrand::Rng::with_seed(4);
        let mut index = SpatialIndex::with_engine(Box::new(Unfiltered));
        for _ in 0..60 {
            let min = Vec3A::from_array(std::array::from_fn(|_| rng.f32() * 4.0));
            let id = index.insert(Aabb3d { min, max: min + 1.0 }).unwrap();
            let (memberships, filters) = (1 << rng.u32(0..3), rng.u32(0..8));
            let filter = PairFilter { memberships, filters, is_static: rng.bool(), world: rng.u32(0..2) };
            index.set_filter(id, filter).unwrap();
        }
        let mut checked = Checked { index };
        checked.step();
        assert!(!checked.index.pairs().is_empty());
    }

    #[test]
    fn both_must_admit() {
        let any = PairFilter::default();
        let on = |memberships, filters| PairFilter { memberships, filters, ..any };
        assert!(any.admits(&any));
        assert!(on(2, 4).admits(&on(4, 2)));
        assert!(!on(2, 4).admits(&on(4, 1)));
        assert!(!on(2, 1).admits(&on(4, 2)));
        assert!(!on(0, u32::MAX).admits(&any), "an object on no layer meets nothing");
        let elsewhere = PairFilter { world: 7, ..any };
        assert!(elsewhere.admits(&elsewhere) && !elsewhere.admits(&any) && !any.admits(&elsewhere));
    }

    #[test]
    fn each_kind_can_be_had_alone() {
        let moving = PairFilter::default();
        let fixed = PairFilter { is_static: true, ..moving };
        let included = |kinds: PairKinds| {
            [(moving, moving), (moving, fixed), (fixed, moving), (fixed, fixed)].map(|(a, b)| kinds.include(&a, &b))
        };
        assert_eq!(included(PairKinds::default()), [true, true, true, false]);
        let none = PairKinds { moving_moving: false, moving_static: false, static_static: false };
        assert_eq!(included(none), [false; 4]);
        assert_eq!(included(PairKinds { moving_moving: true, ..none }), [true, false, false, false]);
        assert_eq!(included(PairKinds { moving_static: true, ..none }), [false, true, true, false]);
        assert_eq!(included(PairKinds { static_static: true, ..none }), [false, false, false, true]);
    }
}
