//! What is told about contacts that start and end, and to whom.

use bevy::prelude::*;

use super::pair::{Collision, other};
use crate::{
    filters::{self, CollisionLayers},
    narrow_phase::Contact,
};

/// Two entities have come into contact: a message, and an event for observers.
///
/// As a **message** it is written once for each contact, in the set
/// [`Report`](crate::CollisionSystems::Report), in the order of [time](Self::time): what a
/// [swept](crate::swept::Swept) entity meets on its way comes in the order in which it meets it,
/// and before all that is met at the end of the tick. At the same time, the order is that of the
/// [`Contacts`](super::Contacts).
///
/// So the first message about a swept entity tells what it meets first. What it meets after that
/// follows in the same tick, unless it [stops](crate::swept::AtSolid::Stop): see [what ends at its
/// first hit](crate::swept#what-ends-at-its-first-hit).
///
/// As an **event** it is triggered right after, in the same order, for each of the two entities
/// that has opted in by [`CollisionEventsEnabled`](super::CollisionEventsEnabled), with that entity
/// first. All events of a tick are decided before the first is triggered: an observer that despawns
/// an entity silences the observers of that entity, not those of others that it met in this tick,
/// which are told of one that is gone.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// app.world_mut().spawn((CollisionShape::default(), CollisionEventsEnabled)).observe(|event: On<CollisionStarted>| {
///     println!("{} is touched by {}, at {:?}", event.a, event.b, event.contact.unwrap().point);
/// });
/// ```
#[doc(alias(
    "collision enter",
    "OnCollisionEnter",
    "OnTriggerEnter",
    "body_entered",
    "collision event"
))]
#[derive(EntityEvent, Message, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Event, Message, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionStarted {
    /// Of an event, the target. Of a message, the entity with the lower index, unless it does not
    /// [hear](Self::hears) of the other.
    #[event_target]
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// The [bodies](crate::parts) that `a` and `b` are parts of; what is part of none is its own.
    pub bodies: [Entity; 2],
    /// Where they meet, with the normal from `a` to `b`. `Some` in every event; in a message, if
    /// somebody [asked](super::CollisionEventSettings::geometry).
    pub contact: Option<Contact>,
    /// The layers of `a`, and those of `b`: the default ones, where no [`CollisionLayers`] were
    /// given.
    pub layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept).
    pub time: f32,
}

/// Tells that two entities are no longer in contact, or one of them is gone.
///
/// Either may no longer exist. A message, and an event for observers, as [`CollisionStarted`], but
/// in the order of the [`Contacts`](super::Contacts). Events of what ends come before those of what
/// starts.
///
/// Every contact that started ends exactly once, and whoever was told of the start is told of the
/// end.
#[doc(alias("collision exit", "OnCollisionExit", "OnTriggerExit", "body_exited"))]
#[derive(EntityEvent, Message, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Event, Message, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionEnded {
    /// Of an event, the target. Of a message, the entity with the lower index, unless it does not
    /// [hear](Self::hears) of the other.
    #[event_target]
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// The [bodies](crate::parts) that `a` and `b` were parts of, when they were last found in
    /// contact; what is part of none is its own.
    pub bodies: [Entity; 2],
    /// Where they met when they were last found in contact, with the normal from `a` to `b`. `Some`
    /// in every event; in a message, if somebody had
    /// [asked](super::CollisionEventSettings::geometry) by then.
    pub contact: Option<Contact>,
    /// The layers of `a`, and those of `b`, when they were last found in contact: also of an entity
    /// that is gone, or has other layers now.
    pub layers: [CollisionLayers; 2],
}

impl CollisionStarted {
    /// Returns the same as seen from the other one: with the two, their layers and the normal
    /// turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        let ([a, b], [body_a, body_b]) = (self.layers, self.bodies);
        Self {
            a: self.b,
            b: self.a,
            bodies: [body_b, body_a],
            contact: self.contact.map(Contact::reversed),
            layers: [b, a],
            ..self
        }
    }

    /// Returns the other of the two; `None` if the entity is neither.
    #[must_use]
    pub fn other(&self, entity: Entity) -> Option<Entity> {
        other([self.a, self.b], entity)
    }

    /// Returns whether `a` hears of the contact, which it does, and whether `b` does: not if `a` is
    /// a [detector](crate::filters::Detector) that `b` may not meet.
    #[must_use]
    pub fn hears(&self) -> [bool; 2] {
        filters::hear(self.layers)
    }
}

impl CollisionEnded {
    /// Returns the same as seen from the other one: with the two, their layers and the normal
    /// turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        let ([a, b], [body_a, body_b]) = (self.layers, self.bodies);
        Self {
            a: self.b,
            b: self.a,
            bodies: [body_b, body_a],
            contact: self.contact.map(Contact::reversed),
            layers: [b, a],
        }
    }

    /// Returns the other of the two; `None` if the entity is neither.
    #[must_use]
    pub fn other(&self, entity: Entity) -> Option<Entity> {
        other([self.a, self.b], entity)
    }

    /// Returns whether `a` heard of the contact, which it did, and whether `b` did: see
    /// [`CollisionStarted::hears`].
    #[must_use]
    pub fn hears(&self) -> [bool; 2] {
        filters::hear(self.layers)
    }
}

impl From<Collision> for CollisionStarted {
    fn from(
        Collision {
            a,
            b,
            bodies,
            contact,
            layers,
            time,
        }: Collision,
    ) -> Self {
        Self {
            a,
            b,
            bodies,
            contact,
            layers,
            time,
        }
    }
}

impl From<Collision> for CollisionEnded {
    fn from(
        Collision {
            a,
            b,
            bodies,
            contact,
            layers,
            ..
        }: Collision,
    ) -> Self {
        Self {
            a,
            b,
            bodies,
            contact,
            layers,
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<CollisionStarted>()
        .register_type::<CollisionEnded>();
}
