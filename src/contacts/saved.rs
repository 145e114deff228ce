//! Contacts as they are saved and restored: by entity, and not by handle.

use bevy::{
    ecs::entity::{EntityMapper, MapEntities},
    prelude::*,
};

use super::{
    bodies::{BodyCollision, BodyContacts, BodyPair, Places},
    list::Contacts,
    pair::{ContactKey, ContactPair},
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
    now: Vec<SavedContact>,
    /// Those of the last report, if they are others.
    reported: Option<Vec<SavedContact>>,
    /// The pairs of bodies of the last report.
    bodies: Vec<SavedBodies>,
    /// Whom messages were for at the last report.
    scope: Option<EventScope>,
}

/// A contact of two, by entity.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedContact {
    entities: [Entity; 2],
    bodies: [Entity; 2],
    layers: [CollisionLayers; 2],
    time: f32,
    /// If somebody asked about it.
    known: Option<Known>,
}

/// What is known of a contact that somebody asked about.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct Known {
    geometry: Contact,
    observed: [bool; 2],
    enabled: bool,
}

/// A contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedBodies {
    collision: BodyCollision,
    is_told: bool,
    observed: [bool; 2],
}

impl SavedContact {
    fn of(contact: &ContactPair, watched: &[WatchedContact], bodies: &BodyContacts) -> Self {
        let known = watched::find(watched, &contact.key).map(|watched| Known {
            geometry: watched.geometry,
            observed: watched.observed,
            enabled: watched.enabled,
        });
        Self {
            entities: contact.entities(),
            bodies: bodies.bodies(&contact.key),
            layers: contact.layers,
            time: contact.time,
            known,
        }
    }

    /// As seen from the other one.
    fn reversed(self) -> Self {
        let reverse = |[a, b]: [Entity; 2]| [b, a];
        let known = self.known.map(|known| Known {
            geometry: known.geometry.reversed(),
            observed: [known.observed[1], known.observed[0]],
            ..known
        });
        Self {
            entities: reverse(self.entities),
            bodies: reverse(self.bodies),
            layers: [self.layers[1], self.layers[0]],
            known,
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
            is_told: pair.is_told,
            observed: pair.observed,
        }
    }
}

impl SavedContacts {
    /// All that are or were in contact.
    pub(crate) fn entities(&self) -> impl Iterator<Item = Entity> {
        let reported = self.reported.iter().flatten();
        let all = self.now.iter().chain(reported);
        all.flat_map(|contact| contact.entities)
    }

    /// The number of contacts.
    pub(crate) const fn len(&self) -> usize {
        self.now.len()
    }
}

impl MapEntities for SavedContacts {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let mut map = |entities: &mut [Entity; 2]| {
            entities
                .iter_mut()
                .for_each(|entity| *entity = mapper.get_mapped(*entity));
        };
        let reported = self.reported.iter_mut().flatten();
        for contact in self.now.iter_mut().chain(reported) {
            map(&mut contact.entities);
            map(&mut contact.bodies);
        }
        for SavedBodies { collision, .. } in &mut self.bodies {
            let mut bodies = [collision.a, collision.b];
            map(&mut bodies);
            [collision.a, collision.b] = bodies;
            map(&mut collision.parts);
        }
    }
}

/// The handle of who is not in the index any more.
const GONE: ProxyId = ProxyId::new(u32::MAX);

/// Contacts under the handles of now, in the order of keys.
#[derive(Default)]
struct Restored {
    pairs: Vec<ContactPair>,
    watched: Vec<WatchedContact>,
    /// The bodies of those that are of parts.
    bodies: Vec<(ContactKey, [Entity; 2])>,
}

impl Restored {
    /// Finds the handles. Those who are gone are left out, or kept as such.
    fn new(
        saved: &[SavedContact],
        index: &CollisionIndex,
        id_of: &impl Fn(Entity) -> Option<ProxyId>,
        keeps_gone: bool,
    ) -> Self {
        let find = |contact: &SavedContact| {
            let [a, b] = contact.entities;
            let (key, contact) = match contact.entities.map(id_of) {
                // Mapped to one and the same.
                [Some(id_a), Some(id_b)] if id_a == id_b => return None,
                [Some(id_a), Some(id_b)] => {
                    let key = ContactKey::of(Pair::new(id_a, id_b), index);
                    let is_as_saved = key.a == a;
                    let contact = if is_as_saved {
                        *contact
                    } else {
                        contact.reversed()
                    };
                    (key, contact)
                }
                ids if keeps_gone => {
                    let ids = ids.map(|id| id.unwrap_or(GONE));
                    (ContactKey { a, b, ids }, *contact)
                }
                _ => return None,
            };
            Some((key, contact))
        };
        let mut found: Vec<_> = saved.iter().filter_map(find).collect();
        found.sort_unstable_by_key(|(key, _)| *key);
        // Two that were mapped to one are one.
        found.dedup_by_key(|(key, _)| *key);
        let mut restored = Self::default();
        for (key, contact) in found {
            let pair = contact.pair(key);
            restored.pairs.push(pair);
            if contact.bodies != contact.entities {
                restored.bodies.push((key, contact.bodies));
            }
            if let Some(known) = contact.known {
                restored.watched.push(WatchedContact {
                    contact: pair,
                    geometry: known.geometry,
                    observed: known.observed,
                    enabled: known.enabled,
                });
            }
        }
        restored
    }
}

/// # Saved and restored
impl Contacts {
    /// Saves what the next tick has to know.
    pub(crate) fn save(&self, saved: &mut SavedContacts) {
        let (bodies_before, bodies) = self.bodies_before_and_now();
        let now = self.pairs();
        saved.now.clear();
        saved
            .now
            .extend(now.map(|contact| SavedContact::of(contact, self.watched(), bodies)));
        saved.reported = self.has_news().then(|| {
            let before = self.ledger().compare().filter_map(|(old, _)| old);
            before
                .map(|contact| SavedContact::of(contact, self.watched_before(), bodies_before))
                .collect()
        });
        saved.bodies.clear();
        let pairs = bodies_before.pairs().iter();
        saved.bodies.extend(pairs.map(SavedBodies::of));
        saved.scope = self.scope_reported();
    }

    /// Has the contacts be those that were saved. What is in the index no longer, is in contact no
    /// longer: that ends with the next report.
    pub(crate) fn restore(
        &mut self,
        saved: &SavedContacts,
        index: &CollisionIndex,
        id_of: impl Fn(Entity) -> Option<ProxyId>,
        places: &Places,
    ) {
        let before = saved.reported.as_ref().unwrap_or(&saved.now);
        let before = Restored::new(before, index, &id_of, true);
        let now = Restored::new(&saved.now, index, &id_of, false);
        let pairs = saved.bodies.iter().map(
            |&SavedBodies {
                 collision,
                 is_told,
                 observed,
             }| BodyPair::restored(collision, is_told, observed, places),
        );
        let bodies_before = BodyContacts::restored(before.bodies, pairs);
        let bodies = BodyContacts::restored(now.bodies, std::iter::empty());
        self.replace(
            (before.pairs, now.pairs),
            (before.watched, now.watched),
            (bodies_before, bodies),
            saved.scope,
        );
    }
}
