//! Entities of two groups that are near each other.

use bevy::prelude::*;

use super::{
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
    scratch,
};
use crate::{
    broad_phase::{Flow, ProxyId},
    narrow_phase::Proximity,
};

/// Two entities near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairHit {
    /// The one that the first filter lets pass.
    pub a: Entity,
    /// The one that the second filter lets pass.
    pub b: Entity,
    /// How far their shapes are apart, in a straight line; 0 if they overlap.
    pub distance: f32,
    /// A point of the shape of `a` and one of that of `b` that are closest to each other.
    pub points: [Vec3; 2],
}

/// # Pairs of two groups
impl SpatialQuery<'_> {
    /// Calls `found` with every pair of an entity that the first filter lets pass, and one that the
    /// second does, whose shapes are no farther apart than `distance`; it may return a
    /// [`ControlFlow`](std::ops::ControlFlow) to stop. Exact: see
    /// [`NarrowPhase::closest_points`](crate::narrow_phase::NarrowPhase::closest_points).
    ///
    /// The two groups may share members. No entity makes a pair with itself, and a pair that could
    /// be told in either order is told once, by its lower handle in the
    /// [`CollisionIndex`](crate::collision_index::CollisionIndex) first. Layers and ignore lists
    /// are not asked: filters are.
    ///
    /// In the order of the handles of the first group; the partners of one as the broad phase comes
    /// upon them, which depends on the history of the index alone. One search for each member of
    /// the first group, which had better be the smaller one; the exact test where boxes are within
    /// the distance. A distance that is negative or NaN finds nothing.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_octree::prelude::*;
    /// # #[derive(Component)]
    /// # struct Wolf;
    /// # #[derive(Component)]
    /// # struct Sheep;
    /// fn scent(wolves: Query<(), With<Wolf>>, sheep: Query<(), With<Sheep>>, spatial: SpatialQuery) {
    ///     let (is_wolf, is_sheep) = (|entity| wolves.contains(entity), |entity| sheep.contains(entity));
    ///     let all = SpatialQueryFilter::DEFAULT;
    ///     spatial.for_each_pair_within(20.0, &all.only(&is_wolf), &all.only(&is_sheep), |near| {
    ///         println!("{} smells {} from {} away", near.a, near.b, near.distance);
    ///     });
    /// }
    /// # bevy::ecs::system::assert_is_system(scent);
    /// ```
    #[doc(alias = "spatial join")]
    pub fn for_each_pair_within<F: Flow>(
        &self,
        distance: f32,
        first: &SpatialQueryFilter,
        second: &SpatialQueryFilter,
        mut found: impl FnMut(PairHit) -> F,
    ) {
        let passes = |filter| move |id: ProxyId| self.candidate(id, filter).is_some();
        self.index.index().for_each_pair_within(
            distance,
            passes(first),
            passes(second),
            |a, b, _| {
                let near = self.near(a, b).filter(|near| near.distance <= distance);
                flow(near.is_none_or(|near| found(near).goes_on()))
            },
        );
    }

    /// Fills a vector as [`for_each_pair_within`](Self::for_each_pair_within) calls back: nearest
    /// first, those as near by ascending entities. They replace what is in `pairs`, which is yours
    /// to use again.
    pub fn pairs_within(
        &self,
        distance: f32,
        first: &SpatialQueryFilter,
        second: &SpatialQueryFilter,
        pairs: &mut Vec<PairHit>,
    ) {
        pairs.clear();
        self.for_each_pair_within(distance, first, second, |near| pairs.push(near));
        pairs.sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then((a.a, a.b).cmp(&(b.a, b.b)))
        });
    }

    fn near(&self, a: ProxyId, b: ProxyId) -> Option<PairHit> {
        let (a, b) = (self.index.body(a)?, self.index.body(b)?);
        let closest = |scratch: &mut scratch::Scratch| {
            self.tests()
                .closest_points(a.placed(), b.placed(), &mut scratch.workspace)
        };
        let Proximity {
            distance, points, ..
        } = scratch::with(closest)?;
        Some(PairHit {
            a: a.entity,
            b: b.entity,
            distance,
            points,
        })
    }
}
