//! Contacts as they are saved and restored: by entity, and not by handle.

use bevy::{
    ecs::entity::{EntityMapper, MapEntities},
    prelude::*,
};

use super::{
    bodies::{BodyCollision, BodyContacts, BodyPair, PartContact, Places},
    list::{Contacts, Known},
    pair::{ContactKey, ContactPair, GONE},
    settings::EventScope,
    watched::{self, WatchedContact},
};
use crate::{
    broad_phase::{Pair, ProxyId},
    collision_index::CollisionIndex,
    filters::CollisionLayers,
    narrow_phase::Contact,
};

/// All that has to be known of the contacts of a tick, so that the next one starts and ends those that
/// it should.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[type_path = "bevy_octree"]
pub(crate) struct SavedContacts {
    /// Those of the tick.
    now: SavedState,
    /// Those of the last report, if that of the tick is still due.
    reported: Option<SavedState>,
    /// Whom messages were for at the last report.
    scope: Option<EventScope>,
}

/// All contacts at some moment.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedState {
    contacts: Vec<SavedContact>,
    bodies: Vec<SavedBodies>,
}

/// A contact of two, by entity.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedContact {
    entities: [Entity; 2],
    /// Their own places in the order of all, for an index that does not know of those who are gone.
    orders: [Option<u64>; 2],
    /// If one of the two is a part of a body.
    parts: Option<SavedParts>,
    layers: [CollisionLayers; 2],
    time: f32,
    /// If somebody asked about it.
    watched: Option<SavedWatch>,
}

/// What two are parts of.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedParts {
    bodies: [Entity; 2],
    is_sensor: bool,
}

/// What is known of a contact that somebody asked about.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedWatch {
    geometry: Contact,
    observed: [bool; 2],
    enabled: bool,
}

/// A contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedBodies {
    collision: BodyCollision,
    orders: [Option<u64>; 2],
    is_told: bool,
    observed: [bool; 2],
}

impl SavedContact {
    fn of(
        contact: &ContactPair,
        watched: &[WatchedContact],
        bodies: &BodyContacts,
        index: Option<&CollisionIndex>,
    ) -> Self {
        let watched = watched::find(watched, &contact.key).map(|watched| SavedWatch {
            geometry: watched.geometry,
            observed: watched.observed,
            enabled: watched.enabled,
        });
        let parts = bodies.part(&contact.key).map(|part| SavedParts {
            bodies: part.bodies,
            is_sensor: part.is_sensor,
        });
        let ContactKey { a, b, ids } = contact.key;
        let orders = [(ids[0], a), (ids[1], b)];
        Self {
            entities: [a, b],
            orders: orders.map(|(id, entity)| index?.own_order_of(id, entity)),
            parts,
            layers: contact.layers,
            time: contact.time,
            watched,
        }
    }

    /// As seen from the other one.
    fn reversed(self) -> Self {
        let reverse = |[a, b]: [Entity; 2]| [b, a];
        let watched = self.watched.map(|watched| SavedWatch {
            geometry: watched.geometry.reversed(),
            observed: [watched.observed[1], watched.observed[0]],
            ..watched
        });
        let parts = self.parts.map(|parts| SavedParts {
            bodies: reverse(parts.bodies),
            ..parts
        });
        Self {
            entities: reverse(self.entities),
            orders: [self.orders[1], self.orders[0]],
            parts,
            layers: [self.layers[1], self.layers[0]],
            watched,
            ..self
        }
    }

    fn pair(&self, key: ContactKey) -> ContactPair {
        ContactPair {
            key,
            layers: self.layers,
            time: self.time,
        }
    }
}

impl SavedBodies {
    fn of(pair: &BodyPair) -> Self {
        Self {
            collision: pair.collision,
            orders: pair.own_places(),
            is_told: pair.is_told,
            observed: pair.observed,
        }
    }
}

impl SavedState {
    /// Replaces what was saved by these, in their order.
    fn save<'a>(
        &mut self,
        contacts: impl Iterator<Item = &'a ContactPair>,
        watched: &[WatchedContact],
        bodies: &BodyContacts,
        index: Option<&CollisionIndex>,
    ) {
        self.contacts.clear();
        self.contacts
            .extend(contacts.map(|contact| SavedContact::of(contact, watched, bodies, index)));
        self.bodies.clear();
        self.bodies
            .extend(bodies.pairs().iter().map(SavedBodies::of));
    }
}

impl SavedContacts {
    fn states(&self) -> impl Iterator<Item = &SavedState> {
        std::iter::once(&self.now).chain(&self.reported)
    }

    /// All that are or were in contact, each with its own place in the order of all.
    pub(crate) fn entities(&self) -> impl Iterator<Item = (Entity, Option<u64>)> {
        let contacts = self.states().flat_map(|state| &state.contacts);
        contacts.flat_map(|contact| contact.entities.into_iter().zip(contact.orders))
    }

    /// The same of bodies.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = (Entity, Option<u64>)> {
        let pairs = self.states().flat_map(|state| &state.bodies);
        pairs.flat_map(|pair| {
            let bodies = [pair.collision.a, pair.collision.b];
            bodies.into_iter().zip(pair.orders)
        })
    }

    /// The number of contacts.
    pub(crate) const fn len(&self) -> usize {
        self.now.contacts.len()
    }
}

impl MapEntities for SavedContacts {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let mut map = |entities: &mut [Entity; 2]| {
            entities
                .iter_mut()
                .for_each(|entity| *entity = mapper.get_mapped(*entity));
        };
        for SavedState { contacts, bodies } in
            std::iter::once(&mut self.now).chain(&mut self.reported)
        {
            for contact in contacts {
                map(&mut contact.entities);
                if let Some(parts) = &mut contact.parts {
                    map(&mut parts.bodies);
                }
            }
            for SavedBodies { collision, .. } in bodies {
                let mut bodies = [collision.a, collision.b];
                map(&mut bodies);
                [collision.a, collision.b] = bodies;
                map(&mut collision.parts);
            }
        }
    }
}

impl SavedState {
    /// The same contacts under the handles of now, those of who is gone included.
    fn restored(&self, places: &Places, id_of: &impl Fn(Entity) -> Option<ProxyId>) -> Known {
        let find = |contact: &SavedContact| {
            let [a, b] = contact.entities;
            let (key, contact) = match contact.entities.map(id_of) {
                // Mapped to one and the same.
                [Some(id_a), Some(id_b)] if id_a == id_b => return None,
                [Some(id_a), Some(id_b)] => {
                    let key = ContactKey::of(Pair::new(id_a, id_b), places.index);
                    let is_as_saved = key.a == a;
                    let contact = if is_as_saved {
                        *contact
                    } else {
                        contact.reversed()
                    };
                    (key, contact)
                }
                ids => {
                    let ids = ids.map(|id| id.unwrap_or(GONE));
                    (ContactKey { a, b, ids }, *contact)
                }
            };
            Some((key, contact))
        };
        let mut found: Vec<_> = self.contacts.iter().filter_map(find).collect();
        found.sort_unstable_by_key(|(key, _)| *key);
        // Two that were mapped to one are one.
        found.dedup_by_key(|(key, _)| *key);
        let part = |(key, contact): &(ContactKey, SavedContact)| {
            let SavedParts { bodies, is_sensor } = contact.parts?;
            Some(PartContact {
                key: *key,
                bodies,
                is_sensor,
            })
        };
        let watched = |(key, contact): &(ContactKey, SavedContact)| {
            let watched = contact.watched?;
            Some(WatchedContact {
                contact: contact.pair(*key),
                geometry: watched.geometry,
                observed: watched.observed,
                enabled: watched.enabled,
            })
        };
        let pair = |saved: &SavedBodies| {
            BodyPair::restored(saved.collision, saved.is_told, saved.observed, places)
        };
        let parts = found.iter().filter_map(part).collect();
        let pairs = self.bodies.iter().map(pair);
        Known {
            bodies: BodyContacts::restored(parts, pairs, places),
            watched: found.iter().filter_map(watched).collect(),
            contacts: found
                .iter()
                .map(|(key, contact)| contact.pair(*key))
                .collect(),
        }
    }
}

/// # Saved and restored
impl Contacts {
    /// Saves what the next tick has to know.
    pub(crate) fn save(&self, saved: &mut SavedContacts, index: Option<&CollisionIndex>) {
        let (bodies_before, bodies) = self.bodies_before_and_now();
        let (watched_before, watched) = (self.watched_before(), self.watched());
        saved.now.save(self.pairs(), watched, bodies, index);
        saved.reported = self.has_news().then(|| {
            let mut reported = SavedState::default();
            let before = self.ledger().compare().filter_map(|(old, _)| old);
            reported.save(before, watched_before, bodies_before, index);
            reported
        });
        saved.scope = self.scope_reported();
    }

    /// Has the contacts be those that were saved. What is in the index no longer stays until it is found to be in contact
    /// no longer, by the exact tests: as what goes while nobody goes back.
    pub(crate) fn restore(
        &mut self,
        saved: &SavedContacts,
        id_of: impl Fn(Entity) -> Option<ProxyId>,
        places: &Places,
    ) {
        let now = saved.now.restored(places, &id_of);
        let reported = saved.reported.as_ref();
        let reported = reported.map(|reported| reported.restored(places, &id_of));
        self.replace(reported, now, saved.scope, places.index);
    }
}
