//! What is told about whole bodies that come into contact and part.

use bevy::prelude::*;

use super::{
    bodies::{BodyCollision, BodyPair},
    list::Contacts,
    pair::{compare, other},
};

/// Two bodies have come into contact, by whichever of their parts: a message, and an event for
/// observers.
///
/// As a **message** it is written in the set [`Report`](crate::CollisionSystems::Report), once for
/// each two bodies, when the first of their parts touch, and not again until all of them have
/// parted; what [sensors](Self::is_sensor) see is told by itself. One of the two is a
/// [`CollisionBody`](crate::parts::CollisionBody); the other may be an entity that is part of none.
/// Messages come in the order of [time](Self::time), and at the same
/// time in that of the bodies.
///
/// As an **event** it is triggered for each of the two that has opted in by
/// [`CollisionEventsEnabled`](super::CollisionEventsEnabled), with that one first, after the events
/// about parts.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let ship = app.world_mut().spawn((CollisionBody::default(), CollisionEventsEnabled)).id();
/// app.world_mut().entity_mut(ship).observe(|event: On<BodyCollisionStarted>| {
///     println!("{} has met {}, by its part {}", event.a, event.b, event.parts[0]);
/// });
/// ```
#[derive(EntityEvent, Message, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Event, Message, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct BodyCollisionStarted {
    /// Of an event, the target. Of a message, the body with the lower index, unless it does not
    /// [hear](Self::hears) of the other.
    #[event_target]
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// Is it what a [`Sensor`](crate::filters::Sensor) among the parts sees? Else, two solid parts
    /// have met. Each of the two starts and ends by itself.
    pub is_sensor: bool,
    /// The parts of `a` and `b` that met first.
    pub parts: [Entity; 2],
    /// Whether `a` hears of it, which it does, and whether `b` does: see
    /// [`Detector`](crate::filters::Detector).
    pub hears: [bool; 2],
    /// The share of the tick after which the first two parts met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept).
    pub time: f32,
}

/// Tells that no parts of two bodies are in contact any longer, no solid ones or [none that are
/// sensors](Self::is_sensor), or one of the two is gone, or is no body any more.
///
/// Either may no longer exist. A message, and an event for observers, as [`BodyCollisionStarted`],
/// but in the order of the bodies. Every contact that started ends exactly once.
#[derive(EntityEvent, Message, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Event, Message, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct BodyCollisionEnded {
    /// Of an event, the target. Of a message, the body with the lower index, unless it does not
    /// [hear](Self::hears) of the other.
    #[event_target]
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// Is it what a [`Sensor`](crate::filters::Sensor) among the parts saw?
    pub is_sensor: bool,
    /// Parts of `a` and `b` that were in contact when the two last were; they may be gone.
    pub parts: [Entity; 2],
    /// Whether `a` heard of it, which it did, and whether `b` did.
    pub hears: [bool; 2],
}

impl BodyCollisionStarted {
    /// Returns the other of the two; `None` if the entity is neither.
    #[must_use]
    pub fn other(&self, body: Entity) -> Option<Entity> {
        other([self.a, self.b], body)
    }
}

impl BodyCollisionEnded {
    /// Returns the other of the two; `None` if the entity is neither.
    #[must_use]
    pub fn other(&self, body: Entity) -> Option<Entity> {
        other([self.a, self.b], body)
    }
}

impl From<BodyCollision> for BodyCollisionStarted {
    fn from(collision: BodyCollision) -> Self {
        let BodyCollision {
            a,
            b,
            is_sensor,
            parts,
            hears,
            time,
            ..
        } = collision;
        Self {
            a,
            b,
            is_sensor,
            parts,
            hears,
            time,
        }
    }
}

impl From<BodyCollision> for BodyCollisionEnded {
    fn from(collision: BodyCollision) -> Self {
        let BodyCollision {
            a,
            b,
            is_sensor,
            parts,
            hears,
            ..
        } = collision;
        Self {
            a,
            b,
            is_sensor,
            parts,
            hears,
        }
    }
}

/// Are parts of bodies in contact, or were they at the last report?
pub(super) fn some_bodies(contacts: Res<Contacts>) -> bool {
    contacts.some_bodies()
}

fn earlier(a: &BodyCollisionStarted, b: &BodyCollisionStarted) -> std::cmp::Ordering {
    a.time.total_cmp(&b.time)
}

/// Tells about bodies that are in contact since the last report, and about those that no longer are.
pub(super) fn write_body_messages(
    contacts: Res<Contacts>,
    mut in_time: Local<Vec<BodyCollisionStarted>>,
    mut started: MessageWriter<BodyCollisionStarted>,
    mut ended: MessageWriter<BodyCollisionEnded>,
) {
    let (before, now) = contacts.body_pairs_before_and_now();
    for (old, new) in compare(before, now, BodyPair::order) {
        let is_told = |pair: &&BodyPair| pair.is_told;
        match (old.filter(is_told), new.filter(is_told)) {
            (Some(old), None) => _ = ended.write(old.collision.heard().into()),
            (None, Some(new)) => in_time.push(new.collision.heard().into()),
            _ => {}
        }
    }
    in_time.sort_by(earlier);
    started.write_batch(in_time.drain(..));
}

/// Triggers the events about bodies, as those about parts are triggered.
pub(super) fn trigger_body_events(
    world: &mut World,
    mut ended: Local<Vec<BodyCollisionEnded>>,
    mut started: Local<Vec<BodyCollisionStarted>>,
) {
    let (before, now) = world.resource::<Contacts>().body_pairs_before_and_now();
    for (old, new) in compare(before, now, BodyPair::order) {
        for side in [0, 1] {
            let observed = |pair: &&BodyPair| pair.observed[side];
            match (old.filter(observed), new.filter(observed)) {
                (Some(old), None) => ended.push(old.collision.seen_from(side).into()),
                (None, Some(new)) => started.push(new.collision.seen_from(side).into()),
                _ => {}
            }
        }
    }
    started.sort_by(earlier);
    for event in ended.drain(..) {
        world.trigger(event);
        world.flush();
    }
    for event in started.drain(..) {
        world.trigger(event);
        world.flush();
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<BodyCollisionStarted>()
        .register_type::<BodyCollisionEnded>();
}
