//! Contacts by entity, for systems.

use bevy::{ecs::system::SystemParam, prelude::*};

use super::{
    bodies::BodyCollision,
    list::Contacts,
    pair::{Collision, ContactKey, ContactPair},
};
use crate::{broad_phase::ProxyId, components::BroadPhaseProxy, narrow_phase::Manifold};

/// Reads contacts by entity: after [`NarrowPhase`](crate::CollisionSystems::NarrowPhase) those of
/// this tick, before it those of the last. Entities that are gone since then have none, though they
/// are among those of others until the next tick.
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
    /// Returns all contacts, each as seen from the entity with the lower index. O(1) for each.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Collision> {
        self.contacts.iter()
    }

    /// Returns the contacts of an entity, as seen from it; not those with a
    /// [detector](crate::filters::Detector) that it does not hear of. O(1) for each, O(log n) for
    /// those with geometry; and O(contacts + objects), once, for the first call of this or
    /// [`colliding_with`](Self::colliding_with) in a tick.
    pub fn of(&self, entity: Entity) -> impl Iterator<Item = Collision> {
        self.pairs_of(entity)
            .map(move |contact| self.contacts.collision(contact).seen_from(entity))
    }

    /// Returns the entities that an entity is in contact with. Costs as [`of`](Self::of), without
    /// geometry.
    pub fn colliding_with(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        self.pairs_of(entity)
            .map(move |contact| contact.other(entity))
    }

    /// Returns the contact of two entities, as seen from the first, if they are in contact. O(log
    /// n).
    #[must_use]
    pub fn between(&self, a: Entity, b: Entity) -> Option<Collision> {
        Some(self.contacts.collision(self.find(a, b)?).seen_from(a))
    }

    /// Returns the points at which two entities lie on each other, with the normal from the first to
    /// the second, if somebody asked: see [`Contacts::manifold`]. O(log n).
    #[must_use]
    pub fn manifold(&self, a: Entity, b: Entity) -> Option<Manifold> {
        self.contacts.manifold_of(self.find(a, b)?, a)
    }

    /// Returns all pairs of [bodies](crate::parts) in contact, as [`Contacts::body_pairs`].
    #[must_use]
    pub fn body_pairs(&self) -> impl ExactSizeIterator<Item = BodyCollision> {
        self.contacts.body_pairs()
    }

    /// Returns the contacts between the parts of two bodies, as [`Contacts::between_bodies`].
    pub fn between_bodies(&self, a: Entity, b: Entity) -> impl Iterator<Item = Collision> {
        self.contacts.between_bodies(a, b)
    }

    /// Returns the contacts of all parts of a body with what is not part of it, as
    /// [`Contacts::of_body`].
    pub fn of_body(&self, body: Entity) -> impl Iterator<Item = Collision> {
        self.contacts.of_body(body)
    }

    /// Returns `true` if two entities are in contact. O(log n).
    #[must_use]
    pub fn contains(&self, a: Entity, b: Entity) -> bool {
        self.find(a, b).is_some()
    }

    /// Returns the number of contacts.
    #[must_use]
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Returns `true` if nothing is in contact.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    fn id(&self, entity: Entity) -> Option<ProxyId> {
        self.proxies.get(entity).ok()?.id()
    }

    fn find(&self, a: Entity, b: Entity) -> Option<&ContactPair> {
        let found = self.contacts.find([a, b])?;
        // It may be out of the index by now.
        let ContactKey { a, b, ids } = found.key;
        let are_there = self.id(a) == Some(ids[0]) && self.id(b) == Some(ids[1]);
        are_there.then_some(found)
    }

    fn pairs_of(&self, entity: Entity) -> impl Iterator<Item = &ContactPair> {
        self.id(entity)
            .map(|id| self.contacts.of_handle(entity, id))
            .into_iter()
            .flatten()
    }
}
