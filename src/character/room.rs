//! Room to stand, crouch and turn.

use bevy::prelude::*;

use super::settings::WalkSettings;
use crate::{
    move_and_slide::{MoveSettings, Surroundings},
    narrow_phase::{NarrowPhase, Placed, Shape},
    spatial_query::{SpatialQuery, SpatialQueryFilter},
};

/// How deep in something counts as no room, in skins.
const DEEP: f32 = 0.1;

/// Returns `true` if a shape at a pose is in nothing, by more than a tenth of its skin. One without an end, or at a place that
/// is not finite, has no room.
#[must_use]
pub fn has_room(
    spatial: &SpatialQuery,
    placed: Placed,
    settings: &MoveSettings,
    filter: &SpatialQueryFilter,
) -> bool {
    let around = Surroundings::new(spatial, placed.shape, filter, settings.skin);
    let mut deepest = 0.0_f32;
    around.for_each_touch(placed.transform, |touch| deepest = deepest.max(touch.depth));
    around.is_somewhere(placed.transform) && deepest <= DEEP * around.skin
}

/// Returns where a character is that takes another shape, its feet where they are: to crouch, and to stand up again. `None` if
/// there is no room.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{character::change_shape, prelude::*};
///
/// fn crouch(characters: Query<(Entity, &mut CollisionShape, &mut Transform)>, keys: Res<Keys>, spatial: SpatialQuery) {
///     for (entity, mut shape, mut at) in characters {
///         let wanted = if keys.crouch { Shape::capsule(0.3, 0.3) } else { Shape::capsule(0.3, 1.2) };
///         let filter = spatial.filter_of(entity);
///         if let Some(there) = change_shape(&spatial, &shape, &wanted, &at, &WalkSettings::default(), &filter) {
///             (shape.0, *at) = (wanted, there);
///         }
///     }
/// }
/// # #[derive(Resource)]
/// # struct Keys { crouch: bool }
/// # bevy::ecs::system::assert_is_system(crouch);
/// ```
#[must_use]
#[doc(alias("crouch", "stand up"))]
pub fn change_shape(
    spatial: &SpatialQuery,
    from: &Shape,
    to: &Shape,
    at: &Transform,
    settings: &WalkSettings,
    filter: &SpatialQueryFilter,
) -> Option<Transform> {
    let up = settings.upwards();
    let feet = |shape: &Shape| lowest(spatial.tests(), shape, at, up);
    let rise = feet(from)? - feet(to)?;
    let there = at.with_translation(at.translation + up * rise);
    has_room(spatial, Placed::new(to, &there), &settings.moves, filter).then_some(there)
}

/// How far below its origin a shape ends.
fn lowest(tests: &NarrowPhase, shape: &Shape, at: &Transform, up: Vec3) -> Option<f32> {
    let upright = Transform {
        translation: Vec3::ZERO,
        rotation: Quat::from_rotation_arc(up, Vec3::Y) * at.rotation,
        ..*at
    };
    let aabb = tests.world_aabb(Placed::new(shape, &upright)).ok()?;
    Some(aabb.min.y)
}
