//! What becomes of bodies that met something on the way, kept from the exact tests to the response.

use bevy::prelude::*;

use super::course::Track;
use crate::{
    collision_index::CollisionIndex, components::BroadPhaseProxy, counters::CollisionCounters, motion::Velocity,
    settings::NarrowPhaseSettings,
};

/// What becomes of bodies that met something on the way.
#[derive(Resource, Debug, Default)]
pub(super) struct Outcomes {
    /// In the order of their entities.
    pub(super) bodies: Vec<Outcome>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) entity: Entity,
    /// In its own space.
    velocity: Option<Vec3>,
    bounces: u64,
    /// Where it is at the end of the tick, if it changed course.
    pub(super) place: Option<Place>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    in_world: Vec3,
    /// In its own space, if it goes there by itself, and not with what it hangs on.
    pub(super) own: Option<Vec3>,
}

impl Outcome {
    /// What has become of a body whose space is reached from the world by `to_own`.
    pub(super) fn of(track: &Track, to_own: impl FnOnce(Vec3) -> Option<Vec3>) -> Self {
        let in_world = (track.version > 0).then(|| track.place(1.0));
        let place = in_world.and_then(|in_world| {
            let own = if track.has_turned { Some(to_own(in_world)?) } else { None };
            Some(Place { in_world, own })
        });
        Self { entity: track.entity, velocity: track.own_velocity(), bounces: track.bounces, place }
    }
}

impl Outcomes {
    pub(super) const fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Has the velocity of this entity answered to an impact in this tick?
    pub(super) fn has_bounced(&self, entity: Entity) -> bool {
        self.bodies.binary_search_by_key(&entity, |body| body.entity).is_ok_and(|place| self.bodies[place].bounces > 0)
    }
}

/// Velocities and places become what the impacts have made of them.
pub(super) fn apply_outcomes(
    outcomes: Res<Outcomes>,
    mut bodies: Query<(Option<&mut Velocity>, &mut Transform, &mut BroadPhaseProxy)>,
    settings: Res<NarrowPhaseSettings>,
    mut index: ResMut<CollisionIndex>,
    mut counters: ResMut<CollisionCounters>,
) {
    for outcome in &outcomes.bodies {
        // It may be gone.
        let Ok((velocity, mut transform, mut proxy)) = bodies.get_mut(outcome.entity) else { continue };
        if outcome.bounces > 0
            && let (Some(mut velocity), Some(answer)) = (velocity, outcome.velocity)
        {
            velocity.0 = answer;
            counters.tick.bounces += outcome.bounces;
        }
        if let Some(place) = outcome.place
            && let Some(id) = proxy.id()
        {
            if let Some(own) = place.own {
                transform.translation = own;
            }
            let pose = proxy.pose().with_translation(place.in_world);
            BroadPhaseProxy::note_pose(&mut proxy, pose);
            index.put(id, &pose, settings.tests());
        }
    }
    if outcomes.bodies.iter().any(|outcome| outcome.place.is_some()) {
        index.settle();
    }
}

/// Each outcome is applied once.
pub(super) fn clear_outcomes(mut outcomes: ResMut<Outcomes>) {
    outcomes.bodies.clear();
}
