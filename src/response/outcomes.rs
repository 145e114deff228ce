//! What becomes of bodies that met something on the way, kept from the exact tests to the response.

use bevy::{platform::collections::HashMap, prelude::*};

use super::course::Course;
use crate::{
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    counters::CollisionCounters,
    frame::{Ancestor, Frame},
    motion::Velocity,
    narrow_phase::NarrowPhase,
};

/// What becomes of bodies that met something on the way.
#[derive(Resource, Debug, Default)]
pub(super) struct Outcomes {
    /// In the order of their entities.
    bodies: Vec<Outcome>,
}

#[derive(Clone, Copy, Debug)]
struct Outcome {
    entity: Entity,
    /// In its own space.
    velocity: Option<Vec3>,
    bounces: u64,
    /// Where it is at the end of the tick, if it changed course.
    position: Option<Position>,
}

#[derive(Clone, Copy, Debug)]
struct Position {
    in_world: Vec3,
    /// In its own space, if it goes there by itself, and not with what it hangs on.
    own: Option<Vec3>,
}

impl Outcome {
    /// What has become of a body whose space is reached from the world by `to_own`.
    fn of(course: &Course, to_own: impl FnOnce(Vec3) -> Option<Vec3>) -> Self {
        let in_world = course.is_moved().then(|| course.position(1.0));
        let position = in_world.and_then(|in_world| {
            let own = if course.has_turned {
                Some(to_own(in_world)?)
            } else {
                None
            };
            Some(Position { in_world, own })
        });
        Self {
            entity: course.entity,
            velocity: course.own_velocity(),
            bounces: course.bounces,
            position,
        }
    }
}

impl Outcomes {
    pub(super) const fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Has the velocity of this entity answered to an impact in this tick?
    pub(super) fn has_bounced(&self, entity: Entity) -> bool {
        self.bodies
            .binary_search_by_key(&entity, |body| body.entity)
            .is_ok_and(|index| self.bodies[index].bounces > 0)
    }

    /// Takes note of what has become of all who met something.
    pub(super) fn note<'a>(&mut self, courses: impl Iterator<Item = &'a Course>, world: &World) {
        self.bodies.clear();
        let changed = courses.filter(|course| course.bounces > 0 || course.is_moved());
        let (mut children, mut positions) = (Vec::new(), HashMap::<Entity, Vec3>::default());
        for course in changed {
            match course.frame {
                None => self.bodies.push(Outcome::of(course, Some)),
                Some(frame) => children.push((frame.depth(), course)),
            }
        }
        if !children.is_empty() {
            // Who hangs on another that was put elsewhere has its own position by that.
            let put = |outcome: &Outcome| Some((outcome.entity, outcome.position?.own?));
            positions.extend(self.bodies.iter().filter_map(put));
            children.sort_unstable_by_key(|(depth, course)| (*depth, course.entity));
        }
        for (_, course) in children {
            let outcome = Outcome::of(course, |in_world| {
                let parent = world.get::<ChildOf>(course.entity)?.parent();
                let look = |entity| {
                    let mut ancestor = Ancestor::of(entity, world)?;
                    ancestor.transform.translation = positions
                        .get(&entity)
                        .copied()
                        .unwrap_or(ancestor.transform.translation);
                    Some(ancestor)
                };
                Frame::of(parent, look).own_position(in_world)
            });
            positions.extend(
                outcome
                    .position
                    .and_then(|position| Some((course.entity, position.own?))),
            );
            self.bodies.push(outcome);
        }
        self.bodies.sort_unstable_by_key(|body| body.entity);
    }
}

/// Velocities and positions become what the impacts have made of them.
pub(super) fn apply_outcomes(
    outcomes: Res<Outcomes>,
    mut bodies: Query<(
        Option<&mut Velocity>,
        &mut Transform,
        Option<&mut BroadPhaseProxy>,
    )>,
    tests: Res<NarrowPhase>,
    mut index: ResMut<CollisionIndex>,
    mut counters: ResMut<CollisionCounters>,
) {
    for outcome in &outcomes.bodies {
        // It may be gone.
        let Ok((velocity, mut transform, proxy)) = bodies.get_mut(outcome.entity) else {
            continue;
        };
        if outcome.bounces > 0
            && let (Some(mut velocity), Some(answer)) = (velocity, outcome.velocity)
        {
            velocity.0 = answer;
            counters.tick.bounces += outcome.bounces;
        }
        let Some(position) = outcome.position else {
            continue;
        };
        let Some(mut proxy) = proxy else {
            // A body made of parts, without a shape of its own.
            transform.translation = position.own.unwrap_or(transform.translation);
            continue;
        };
        if let Some(id) = proxy.id() {
            if let Some(own) = position.own {
                transform.translation = own;
            }
            let pose = proxy.pose().with_translation(position.in_world);
            BroadPhaseProxy::note_pose(&mut proxy, pose);
            index.put(id, &pose, &tests);
        }
    }
    if outcomes
        .bodies
        .iter()
        .any(|outcome| outcome.position.is_some())
    {
        index.settle();
    }
}

/// Each outcome is applied once.
pub(super) fn clear_outcomes(mut outcomes: ResMut<Outcomes>) {
    outcomes.bodies.clear();
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<Outcomes>();
}
