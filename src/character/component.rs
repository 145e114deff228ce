//! Characters as components.

use bevy::{ecs::entity::MapEntities, prelude::*};

use super::{gone::Gone, ground::Ground, settings::WalkSettings};
use crate::{
    components::CollisionShape,
    move_and_slide::{MoveEnd, MoveHit},
};

/// Has an entity walk in each tick: by its velocity, along the ground, and through nothing.
///
/// What gives it its velocity is up to the game: keys, gravity, jumps. Whatever it runs against takes its share away. It walks in
/// the set [`CharacterSystems`](super::CharacterSystems); see the [module's documentation](super) for what it meets there.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// fn steer(mut characters: Query<&mut KinematicCharacter>, time: Res<Time>, input: Res<Wish>) {
///     for mut character in &mut characters {
///         let fall = character.velocity.y - 9.8 * time.delta_secs();
///         let jumps = input.jump && character.is_on_ground();
///         character.velocity = input.way * 5.0 + Vec3::Y * if jumps { 4.0 } else { fall };
///     }
/// }
/// # #[derive(Resource)]
/// # struct Wish { way: Vec3, jump: bool }
/// # bevy::ecs::system::assert_is_system(steer);
/// ```
///
/// It is not to have a [`Velocity`](crate::motion::Velocity), by which it would be moved once more, nor to be
/// [`Swept`](crate::swept::Swept): it passes through nothing as it is.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect, MapEntities)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[require(Transform, CollisionShape, Gone)]
#[doc(alias(
    "CharacterBody3D",
    "KinematicCharacterController",
    "character controller"
))]
pub struct KinematicCharacter {
    /// How fast it is to go, in the world and apart from the ground; and, after a tick, what is left of that.
    pub velocity: Vec3,
    /// How it walks.
    pub settings: WalkSettings,
    /// What it stood on at the end of the last tick.
    #[entities]
    pub ground: Option<Ground>,
    /// How its last move ended.
    pub end: MoveEnd,
}

impl KinematicCharacter {
    /// Makes a character that walks by these settings.
    #[must_use]
    pub fn new(settings: WalkSettings) -> Self {
        Self {
            settings,
            ..Self::default()
        }
    }

    /// Returns `true` if it stood on the ground at the end of the last tick.
    #[must_use]
    #[doc(alias("grounded", "is_on_floor"))]
    pub const fn is_on_ground(&self) -> bool {
        self.ground.is_some()
    }
}

/// Lists what a [`KinematicCharacter`] has met in the last tick, in order: for those that have this component.
///
/// The ground that it stands on is among them, each tick anew.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect, Deref, MapEntities)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CharacterHits(#[entities] pub Vec<MoveHit>);
