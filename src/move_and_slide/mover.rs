//! What systems ask to move something.

use std::ops::Deref;

use bevy::{ecs::system::SystemParam, prelude::*};

use super::{
    hit::{AtHit, Depenetrated, MoveEnd, MoveHit, Moved},
    push_out::push_out,
    slide::{Plain, Slide},
    surroundings::Surroundings,
};
use crate::{
    narrow_phase::{Placed, Shape},
    spatial_query::{SpatialQuery, SpatialQueryFilter},
};

/// How a shape moves among others.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct MoveSettings {
    /// The distance that is kept to others, in world units: a hundredth of the shape's size, say. It is never less than
    /// four times the [tolerance](crate::narrow_phase::NarrowPhase::tolerance) of the exact tests, which is what a number
    /// that is negative or not finite comes to. What is kept off is not in
    /// [contact](crate::contacts::Contacts): who is touched is told by the move.
    #[doc(alias("skin width", "offset", "contact offset"))]
    pub skin: f32,
    /// How often the shape may change its way in one move. What is left of the way then is lost.
    #[doc(alias = "iterations")]
    pub max_slides: u32,
}

impl MoveSettings {
    /// The distance kept to others unless told otherwise, in world units.
    pub const DEFAULT_SKIN: f32 = 0.01;
    /// How often a shape may change its way in one move, unless told otherwise.
    pub const DEFAULT_MAX_SLIDES: u32 = 8;
}

impl Default for MoveSettings {
    fn default() -> Self {
        Self {
            skin: Self::DEFAULT_SKIN,
            max_slides: Self::DEFAULT_MAX_SLIDES,
        }
    }
}

/// Moves a shape from a pose by a velocity, for a time in seconds: it slides along what it meets, and goes through
/// nothing, however fast it is. Returns where it gets to, and the velocity that is left.
///
/// `on_hit` is told of each that is met, in order, and decides what becomes of it: see [`AtHit`]. The shape does not turn. It
/// keeps the [skin](MoveSettings::skin) as a distance to all that it meets; what it starts in, it is
/// [pushed out](depenetrate) of first. Both vectors are in the world.
///
/// | asked for | what becomes of it |
/// |---|---|
/// | no time, or no velocity | it is pushed out of what it is in, and that is all |
/// | a time that is negative, a pose, velocity or time that is not finite, a shape without an end | [`MoveEnd::Refused`]: nothing moves |
/// | no way out of what it starts in | [`MoveEnd::Stuck`]: it stays, unless its velocity leads out |
///
/// Costs a shape cast for each that is met, and one for the rest of the way; `O(log n)` each. Allocates nothing, once the
/// buffers of the thread are warm. The same on every machine thread: it depends on nothing but what it is given, and the
/// index.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{move_and_slide::move_and_slide, prelude::*};
///
/// fn roll(balls: Query<(Entity, &CollisionShape, &Transform)>, spatial: SpatialQuery) {
///     for (entity, shape, at) in &balls {
///         let filter = SpatialQueryFilter::DEFAULT.except(entity);
///         let moved = move_and_slide(&spatial, shape, at, Vec3::X, 0.1, &MoveSettings::default(), &filter, |hit| {
///             println!("{entity} meets {} at {}", hit.entity, hit.point);
///             AtHit::Slide
///         });
///         println!("{entity} gets to {}", moved.pose.translation);
///     }
/// }
/// # bevy::ecs::system::assert_is_system(roll);
/// ```
#[expect(
    clippy::too_many_arguments,
    reason = "each is a thing of its own, and a struct for them would be one more to learn"
)]
pub fn move_and_slide(
    spatial: &SpatialQuery,
    shape: &Shape,
    start: &Transform,
    velocity: Vec3,
    time: f32,
    settings: &MoveSettings,
    filter: &SpatialQueryFilter,
    on_hit: impl FnMut(&MoveHit) -> AtHit,
) -> Moved {
    let mut around = Surroundings::new(spatial, shape, filter, settings.skin);
    if !(velocity.is_finite() && time.is_finite() && time >= 0.0 && around.is_somewhere(start)) {
        return Moved {
            pose: *start,
            velocity: Vec3::ZERO,
            end: MoveEnd::Refused,
        };
    }
    let slide = Slide {
        start: *start,
        velocity,
        time,
        most_slides: settings.max_slides,
    };
    slide.along(&mut around, None, &mut Plain(on_hit))
}

/// Finds what a shape meets first as it moves from a pose by `way`, and how far it may go: such that the skin is left
/// between the two. The hit's time is the share of the way, 0 to 1; `None` if nothing is met. What the shape starts in
/// touch with, or in, is met only as far as it goes into it.
///
/// Nothing is met by a way or a pose that is not finite, nor by a shape without an end.
#[must_use]
pub fn cast_move(
    spatial: &SpatialQuery,
    moving: Placed,
    way: Vec3,
    settings: &MoveSettings,
    filter: &SpatialQueryFilter,
) -> Option<MoveHit> {
    let around = Surroundings::new(spatial, moving.shape, filter, settings.skin);
    let met = around.cast(moving.transform, way)?;
    Some(met.hit(met.share, way))
}

/// Pushes a shape out of all that it is in, by the shortest way out of all of them at once that it finds, and not through
/// what it is not in.
///
/// It goes by the normals and depths of its contacts: a [manifold](crate::narrow_phase::Manifold) has one normal for all its
/// points, of which the deepest is the contact. A second look, from where that leads, finds what else there is: the
/// other wall of a corner that is one mesh. Where there is no way, as between walls that close in, it stays where it is.
///
/// Allocates nothing for up to eight contacts at once. A pose that is not finite, or a shape without an end, is free.
#[must_use]
#[doc(alias("push out", "resolve penetration"))]
pub fn depenetrate(
    spatial: &SpatialQuery,
    placed: Placed,
    settings: &MoveSettings,
    filter: &SpatialQueryFilter,
) -> Depenetrated {
    let mut around = Surroundings::new(spatial, placed.shape, filter, settings.skin);
    if !around.is_somewhere(placed.transform) {
        return Depenetrated {
            pose: *placed.transform,
            is_free: true,
        };
    }
    push_out(&mut around, placed.transform, |_| true)
}

/// Moves shapes among others, as a parameter of systems: the functions of this [module](super), and all questions of
/// [`SpatialQuery`], which it derefs to.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// #[derive(Component)]
/// struct Ghost(Vec3);
///
/// fn fly(mut ghosts: Query<(Entity, &CollisionShape, &mut Transform, &Ghost)>, time: Res<Time>, mover: MoveAndSlide) {
///     for (entity, shape, mut at, ghost) in &mut ghosts {
///         let walls = SpatialQueryFilter::DEFAULT.except(entity).without_sensors();
///         let settings = MoveSettings::default();
///         *at = mover.move_and_slide(shape, &at, ghost.0, time.delta_secs(), &settings, &walls, |_| AtHit::Slide).pose;
///     }
/// }
/// # bevy::ecs::system::assert_is_system(fly);
/// ```
#[doc(alias("character controller", "move and slide", "collide and slide"))]
#[derive(SystemParam)]
pub struct MoveAndSlide<'w, 's> {
    /// What is asked.
    pub spatial: SpatialQuery<'w, 's>,
}

impl<'w, 's> Deref for MoveAndSlide<'w, 's> {
    type Target = SpatialQuery<'w, 's>;

    fn deref(&self) -> &Self::Target {
        &self.spatial
    }
}

impl MoveAndSlide<'_, '_> {
    /// As [`move_and_slide`].
    #[expect(clippy::too_many_arguments, reason = "as the function")]
    pub fn move_and_slide(
        &self,
        shape: &Shape,
        start: &Transform,
        velocity: Vec3,
        time: f32,
        settings: &MoveSettings,
        filter: &SpatialQueryFilter,
        on_hit: impl FnMut(&MoveHit) -> AtHit,
    ) -> Moved {
        move_and_slide(
            &self.spatial,
            shape,
            start,
            velocity,
            time,
            settings,
            filter,
            on_hit,
        )
    }

    /// As [`cast_move`].
    #[must_use]
    pub fn cast_move(
        &self,
        moving: Placed,
        way: Vec3,
        settings: &MoveSettings,
        filter: &SpatialQueryFilter,
    ) -> Option<MoveHit> {
        cast_move(&self.spatial, moving, way, settings, filter)
    }

    /// As [`depenetrate`].
    #[must_use]
    pub fn depenetrate(
        &self,
        placed: Placed,
        settings: &MoveSettings,
        filter: &SpatialQueryFilter,
    ) -> Depenetrated {
        depenetrate(&self.spatial, placed, settings, filter)
    }
}
