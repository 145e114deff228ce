//! Velocities, and what moves by them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::{step::MotionSettings, track::PositionTrack};

/// The velocity of an entity: how fast and where to it moves, in units per second, in the space of
/// its parent.
///
/// Contacts count with its velocity in the world, to which that of each ancestor adds: one that is
/// moved by other means than its velocity may have one beside [`MovedElsewhere`], which says how
/// fast it is.
///
/// The report gives each object a direction and a speed; this is their product. A velocity that is
/// not finite moves nothing, with a warning in the log.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect, Deref, DerefMut, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[require(Transform)]
#[doc(alias("linear velocity", "speed"))]
pub struct Velocity(pub Vec3);

/// Marks an entity whose [`Velocity`] says how it moves, but which something else moves: a system
/// of your own, a physics engine. Contacts change the velocity all the same.
#[doc(alias("kinematic", "kinematic body"))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
pub struct MovedElsewhere;

/// Beside a [`Velocity`].
type MovedByVelocity = (Without<PositionTrack>, Without<MovedElsewhere>);

/// Does [`move_by_velocity`] move this entity?
pub(crate) fn is_moved_by_velocity(entity: EntityRef) -> bool {
    entity.contains::<Velocity>()
        && !entity.contains::<PositionTrack>()
        && !entity.contains::<MovedElsewhere>()
}

pub(super) fn move_by_velocity(
    mut moving: Query<(Entity, &Velocity, &mut Transform), MovedByVelocity>,
    settings: Res<MotionSettings>,
    time: Option<Res<Time>>,
    mut warned: Local<bool>,
) {
    let Some(seconds) = settings.step.seconds(time.as_deref()) else {
        if !std::mem::replace(&mut *warned, true) {
            tracing::warn!(
                "nothing moves: the step is {:?}, expected seconds, finite and not negative",
                settings.step
            );
        }
        return;
    };
    *warned = false;
    for (entity, velocity, mut transform) in &mut moving {
        // What does not move must not count as changed.
        if velocity.0 == Vec3::ZERO || seconds == 0.0 {
            continue;
        }
        if velocity.0.is_finite() {
            transform.translation += velocity.0 * seconds;
        } else {
            tracing::warn!("{entity} does not move: its velocity is {}", velocity.0);
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<Velocity>()
        .register_type::<MovedElsewhere>();
}
