//! Contacts by entity.

use bevy::{ecs::system::SystemParam, prelude::*};

use super::{ContactPair, Contacts};
use crate::{
    broad_phase::{Pair, ProxyId},
    components::BroadPhaseProxy,
    filters::CollisionLayers,
    narrow_phase::Contact,
};

/// Two entities in contact, as seen from the first.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct Collision {
    /// The entity that was asked about; of all contacts, the one with the lower handle.
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// Where they meet, with the normal from `a` to `b`; `None` if nobody
    /// [asked](super::CollisionEventSettings::geometry).
    pub contact: Option<Contact>,
    /// The layers of `a`, and those of `b`, as the broad phase saw them last.
    pub layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is [swept](crate::swept::Swept).
    pub time: f32,
}

impl Collision {
    /// As seen from the other one.
    #[must_use]
    pub fn reversed(self) -> Self {
        let [a, b] = self.layers;
        Self { a: self.b, b: self.a, contact: self.contact.map(Contact::reversed), layers: [b, a], ..self }
    }
}

impl ContactPair {
    /// The two, as seen from `a`.
    pub(super) fn collision(&self, contact: Option<Contact>) -> Collision {
        Collision { a: self.a, b: self.b, contact, layers: self.layers, time: self.time }
    }

    /// The other of the two.
    pub(super) fn other(&self, entity: Entity) -> Entity {
        if self.a == entity { self.b } else { self.a }
    }
}

/// Reads contacts by entity: after [`NarrowPhase`](crate::CollisionSystems::NarrowPhase) those of this tick, before it
/// those of the last. Entities that are gone since then have none.
///
/// Everything comes in the order of the [`Contacts`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_octree::prelude::*;
/// # #[derive(Component)]
/// # struct Player;
/// fn what_the_player_touches(player: Single<Entity, With<Player>>, collisions: Collisions) {
///     for other in collisions.colliding_with(*player) {
///         println!("{other}");
///     }
/// }
/// # bevy::ecs::system::assert_is_system(what_the_player_touches);
/// ```
#[derive(SystemParam, Debug)]
pub struct Collisions<'w, 's> {
    contacts: Res<'w, Contacts>,
    proxies: Query<'w, 's, &'static BroadPhaseProxy>,
}

impl Collisions<'_, '_> {
    /// All contacts. O(1) for each, and O(log n) for those with geometry.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Collision> {
        self.contacts.iter().map(|contact| self.collision(contact))
    }

    /// The contacts of an entity, seen from it. O(1) for each, O(log n) for those with geometry; and O(contacts +
    /// objects), once, for the first call of this or [`colliding_with`](Self::colliding_with) in a tick.
    pub fn of(&self, entity: Entity) -> impl Iterator<Item = Collision> {
        self.pairs_of(entity).map(move |contact| self.collision(contact).seen_from(entity))
    }

    /// The entities that an entity is in contact with. Costs as [`of`](Self::of), without geometry.
    pub fn colliding_with(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        self.pairs_of(entity).map(move |contact| contact.other(entity))
    }

    /// The contact of two entities, seen from the first, if they are in contact. O(log n).
    #[must_use]
    pub fn get(&self, a: Entity, b: Entity) -> Option<Collision> {
        Some(self.collision(self.find(a, b)?).seen_from(a))
    }

    /// Are these two entities in contact? O(log n).
    #[must_use]
    pub fn contains(&self, a: Entity, b: Entity) -> bool {
        self.find(a, b).is_some()
    }

    /// The number of contacts.
    #[must_use]
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Is nothing in contact?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    fn id(&self, entity: Entity) -> Option<ProxyId> {
        self.proxies.get(entity).ok()?.id()
    }

    fn find(&self, a: Entity, b: Entity) -> Option<&ContactPair> {
        let [id_a, id_b] = [self.id(a)?, self.id(b)?];
        let pair = (id_a != id_b).then(|| Pair::new(id_a, id_b))?;
        // Their handles may have been those of others.
        self.contacts.find(pair).filter(|contact| [contact.a, contact.b] == [a, b] || [contact.a, contact.b] == [b, a])
    }

    fn pairs_of(&self, entity: Entity) -> impl Iterator<Item = &ContactPair> {
        self.id(entity).map(|id| self.contacts.of(entity, id)).into_iter().flatten()
    }

    fn collision(&self, contact: &ContactPair) -> Collision {
        contact.collision(self.contacts.geometry(contact.pair).copied())
    }
}

impl Collision {
    fn seen_from(self, entity: Entity) -> Self {
        if self.a == entity { self } else { self.reversed() }
    }
}
