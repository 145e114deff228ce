//! Entities that are near each other: of two groups, or of one.

use bevy::prelude::*;

use super::{
    filter::SpatialQueryFilter,
    query::{SpatialQuery, flow},
    scratch,
};
use crate::{
    broad_phase::{Flow, Gap, ProxyId, with_gaps},
    collision_index::Body,
    narrow_phase::Proximity,
    parallel,
};

/// So many pairs of boxes are looked at by one job.
const PAIRS_PER_JOB: usize = 256;

/// Two entities near each other.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct PairHit {
    /// The first: of pairs of two groups, the one that the first filter lets pass.
    pub a: Entity,
    /// The second.
    pub b: Entity,
    /// How far their shapes are apart, in a straight line; 0 if they overlap.
    pub distance: f32,
    /// A point of the shape of `a` and one of that of `b` that are closest to each other.
    pub points: [Vec3; 2],
}

/// # Pairs of two groups
impl SpatialQuery<'_, '_> {
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
    #[doc(alias("spatial join", "distance join"))]
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
    #[doc(alias("spatial join", "distance join"))]
    pub fn pairs_within(
        &self,
        distance: f32,
        first: &SpatialQueryFilter,
        second: &SpatialQueryFilter,
        pairs: &mut Vec<PairHit>,
    ) {
        pairs.clear();
        self.for_each_pair_within(distance, first, second, |near| pairs.push(near));
        self.sort_pairs(pairs);
    }
}

/// # Pairs of one group
impl SpatialQuery<'_, '_> {
    /// Calls `found` with every pair of entities that the filter lets pass, whose shapes are no
    /// farther apart than `distance`; it may return a [`ControlFlow`](std::ops::ControlFlow) to
    /// stop. Exact: see [`NarrowPhase::closest_points`](crate::narrow_phase::NarrowPhase::closest_points).
    ///
    /// Each pair is told once, the entity with the lower index first, or that with the lower
    /// [`CollisionOrder`](crate::collision_order::CollisionOrder). Entities without an end
    /// make none. Layers and ignore lists are not asked: the filter is, once about each entity.
    ///
    /// In an order that depends on the history of the index alone. One join of the index with
    /// itself, and the exact test where boxes are within the distance, both side by side on all
    /// threads with the feature `multi_threaded`: this is the way to find the neighbours of
    /// thousands. A distance that is negative or NaN finds nothing.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_octree::prelude::*;
    /// # #[derive(Component)]
    /// # struct Unit;
    /// /// Units that stand close to each other step aside.
    /// fn keep_apart(mut units: Query<&mut Transform, With<Unit>>, spatial: SpatialQuery) {
    ///     spatial.for_each_pair_among(0.5, &SpatialQueryFilter::DEFAULT, |near| {
    ///         let Ok([mut a, mut b]) = units.get_many_mut([near.a, near.b]) else { return };
    ///         let aside = (b.translation - a.translation).normalize_or(Vec3::X) * (0.5 - near.distance);
    ///         a.translation -= aside * 0.1;
    ///         b.translation += aside * 0.1;
    ///     });
    /// }
    /// # bevy::ecs::system::assert_is_system(keep_apart);
    /// ```
    #[doc(alias(
        "neighbors",
        "boids",
        "flocking",
        "separation",
        "spatial hash",
        "self-join"
    ))]
    pub fn for_each_pair_among<F: Flow>(
        &self,
        distance: f32,
        filter: &SpatialQueryFilter,
        mut found: impl FnMut(PairHit) -> F,
    ) {
        with_gaps(|gaps| {
            let index = self.index.index();
            index.find_gaps(distance, |id| self.candidate(id, filter).is_some(), gaps);
            let near = |gap: &Gap| {
                let [a, b] = self.in_order([gap.a, gap.b]);
                self.near(a, b)
                    .filter(|near| near.distance <= distance)
            };
            if !parallel::is_on() || gaps.len() <= PAIRS_PER_JOB {
                let mut pairs = gaps.iter().filter_map(near);
                while pairs.next().is_some_and(|near| found(near).goes_on()) {}
                return;
            }
            let chunks = gaps.chunks(PAIRS_PER_JOB);
            let mut jobs = vec![Vec::new(); chunks.len()];
            parallel::for_each(chunks.zip(&mut jobs), |(gaps, pairs)| {
                pairs.extend(gaps.iter().filter_map(near));
            });
            let mut pairs = jobs.into_iter().flatten();
            while pairs.next().is_some_and(|near| found(near).goes_on()) {}
        });
    }

    /// Fills a vector as [`for_each_pair_among`](Self::for_each_pair_among) calls back: nearest
    /// first, those as near by ascending entities. They replace what is in `pairs`, which is yours
    /// to use again.
    #[doc(alias("neighbors", "spatial hash", "self-join", "boids"))]
    pub fn pairs_among(
        &self,
        distance: f32,
        filter: &SpatialQueryFilter,
        pairs: &mut Vec<PairHit>,
    ) {
        pairs.clear();
        self.for_each_pair_among(distance, filter, |near| pairs.push(near));
        self.sort_pairs(pairs);
    }
}

/// # Two entities
impl SpatialQuery<'_, '_> {
    /// Returns how far the shapes of two entities are apart, and where they are closest. `None` if
    /// one has no shape in the index, or of shapes of which no distance is known, such as two
    /// half-spaces. Exact: see
    /// [`NarrowPhase::closest_points`](crate::narrow_phase::NarrowPhase::closest_points).
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_octree::prelude::*;
    /// fn is_in_reach(hand: Entity, handle: Entity, spatial: &SpatialQuery) -> bool {
    ///     spatial.distance_between(hand, handle).is_some_and(|near| near.distance < 0.1)
    /// }
    /// ```
    #[doc(alias("closest points", "gap", "proximity"))]
    #[must_use]
    pub fn distance_between(&self, a: Entity, b: Entity) -> Option<PairHit> {
        self.proximity(self.entry_of(a)?, self.entry_of(b)?)
    }

    /// The two as they are told where either could come first.
    fn in_order(&self, [a, b]: [ProxyId; 2]) -> [ProxyId; 2] {
        if self.proxies().order(a) <= self.proxies().order(b) {
            [a, b]
        } else {
            [b, a]
        }
    }

    fn near(&self, a: ProxyId, b: ProxyId) -> Option<PairHit> {
        self.proximity(self.index.body(a)?, self.index.body(b)?)
    }

    fn proximity(&self, a: &Body, b: &Body) -> Option<PairHit> {
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

    /// Nearest first, those as near by ascending entities.
    fn sort_pairs(&self, pairs: &mut [PairHit]) {
        let order = |pair: &PairHit| (self.order_of(pair.a), self.order_of(pair.b));
        pairs.sort_unstable_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then_with(|| order(a).cmp(&order(b)))
        });
    }
}
