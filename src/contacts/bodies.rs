//! Contacts of things made of parts: which bodies are in contact, by which of their parts.

use bevy::prelude::*;

use super::{
    arrangement::place,
    pair::{ContactKey, ContactPair, other},
};
use crate::{
    broad_phase::ProxyId,
    collision_index::{CollisionIndex, rank},
};

/// Two bodies in contact: one or more parts of one with one or more of the other. One of the two is
/// a [`CollisionBody`](crate::parts::CollisionBody); the other is one as well, or an entity that is
/// part of none. What their solid parts do and what [sensors](Self::is_sensor) see are two contacts.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[type_path = "bevy_octree"]
pub struct BodyCollision {
    /// The body with the lower index.
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// Is one of each two parts in contact a [`Sensor`](crate::filters::Sensor)? Contacts of solid
    /// parts of the same bodies are told by themselves.
    pub is_sensor: bool,
    /// The parts of the two that came into contact first; of those at the same time, the first in
    /// the order of the [`Contacts`](super::Contacts).
    pub parts: [Entity; 2],
    /// How many such contacts there are between parts of the two.
    pub contacts: u32,
    /// Whether `a` hears of one of these, and whether `b` does: see
    /// [`Detector`](crate::filters::Detector).
    pub hears: [bool; 2],
    /// The share of the tick after which the first two parts met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept). Of bodies that have been in contact longer, that of this tick.
    pub time: f32,
}

impl BodyCollision {
    /// Returns the same as seen from the other one.
    #[must_use]
    pub const fn reversed(self) -> Self {
        let ([part_a, part_b], [a_hears, b_hears]) = (self.parts, self.hears);
        Self {
            a: self.b,
            b: self.a,
            parts: [part_b, part_a],
            hears: [b_hears, a_hears],
            ..self
        }
    }

    /// Returns the other of the two; `None` if the entity is neither.
    #[must_use]
    pub fn other(&self, body: Entity) -> Option<Entity> {
        other([self.a, self.b], body)
    }

    /// As seen from one that hears of it.
    pub(super) const fn heard(self) -> Self {
        if self.hears[0] { self } else { self.reversed() }
    }

    /// From one of its two sides.
    pub(super) const fn seen_from(self, side: usize) -> Self {
        if side == 0 { self } else { self.reversed() }
    }
}

/// By handle: the body that an object is a part of.
#[derive(Clone, Debug, Default)]
pub(super) struct Owners(Vec<Option<Entity>>);

impl Owners {
    /// Takes note of all parts. O(parts and handles).
    pub(super) fn refresh(&mut self, parts: impl Iterator<Item = (ProxyId, Entity)>) {
        self.0.clear();
        for (id, body) in parts {
            if self.0.len() <= id.index() {
                self.0.resize(id.index() + 1, None);
            }
            self.0[id.index()] = Some(body);
        }
    }

    /// The bodies of the two in contact, if one of them is a part.
    fn bodies(&self, key: &ContactKey) -> Option<[Entity; 2]> {
        let [a, b] = key
            .ids
            .map(|id| self.0.get(id.index()).copied().unwrap_or_default());
        let is_of_bodies = a.is_some() || b.is_some();
        is_of_bodies.then(|| [a.unwrap_or(key.a), b.unwrap_or(key.b)])
    }
}

/// Who is to be told of the contacts of two bodies.
pub(super) struct Audience<'a> {
    /// Has it opted in to events?
    pub(super) is_enabled: &'a dyn Fn(Entity) -> bool,
    /// Are messages, and events, for all, or for those that have opted in?
    pub(super) messages_for_all: bool,
    pub(super) events_for_all: bool,
}

/// A contact of which one is a part of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartContact {
    pub(super) key: ContactKey,
    pub(super) bodies: [Entity; 2],
    /// Is one of the two a sensor?
    pub(super) is_sensor: bool,
}

/// Two bodies in contact, and who is told.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyPair {
    pub(super) collision: BodyCollision,
    /// Is there a message about it?
    pub(super) is_told: bool,
    /// Are the observers of `a`, and those of `b`, told?
    pub(super) observed: [bool; 2],
    /// What tells it from others, and orders all of them.
    order: Order,
    /// Where its contacts begin among those of all pairs.
    first: u32,
}

impl BodyPair {
    pub(super) const fn order(&self) -> Order {
        self.order
    }

    /// The places of its own that each of the two has in the order of all.
    pub(super) fn own_places(&self) -> [Option<u64>; 2] {
        let (bodies, _) = self.order;
        bodies.map(|(place, rank)| (place != rank).then_some(place))
    }

    /// One that was saved.
    pub(super) fn restored(
        collision: BodyCollision,
        is_told: bool,
        observed: [bool; 2],
        places: &Places,
    ) -> Self {
        let (order, side) = places.order([collision.a, collision.b], collision.is_sensor);
        Self {
            collision: collision.seen_from(side),
            is_told,
            observed: if side == 0 {
                observed
            } else {
                [observed[1], observed[0]]
            },
            order,
            first: 0,
        }
    }
}

/// Where a body stands among all, and, of several with the same place, its entity.
type Place = (u64, u64);

/// What tells contacts of bodies from each other: the two, and whether sensors see it. Those of solid
/// parts come first.
pub(super) type Order = ([Place; 2], bool);

/// Who has a place of its own in the order of all.
pub(crate) struct Places<'a> {
    /// That of a body, if it has one; `None` if it is gone.
    pub(crate) of_body: &'a dyn Fn(Entity) -> Option<Option<u64>>,
    /// For the places of parts.
    pub(crate) index: &'a CollisionIndex,
}

impl Places<'_> {
    fn of(&self, body: Entity) -> Place {
        let rank = rank(body);
        let own = (self.of_body)(body).unwrap_or_else(|| self.index.order_of_gone(body));
        (own.unwrap_or(rank), rank)
    }

    /// Where two stand among others, and from which of their sides they are seen.
    fn order(&self, bodies: [Entity; 2], is_sensor: bool) -> (Order, usize) {
        let [a, b] = bodies.map(|body| self.of(body));
        let in_order = a <= b;
        let bodies = if in_order { [a, b] } else { [b, a] };
        ((bodies, is_sensor), usize::from(!in_order))
    }
}

/// The contacts of parts at some moment. Empty where there are no bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyContacts {
    /// In the order of keys.
    contacts: Vec<PartContact>,
    /// In the order of their bodies.
    pairs: Vec<BodyPair>,
    /// The contacts of one pair after those of the other.
    by_pair: Vec<ContactKey>,
    /// Memory for the next time: the order of two bodies, the place and the number of the contact, and
    /// what is known of it.
    sorted: Vec<(Order, ([u64; 2], u32), BodyCollision)>,
}

impl BodyContacts {
    pub(super) const fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Those that were saved: contacts in the order of keys, and the pairs of bodies.
    pub(super) fn restored(
        contacts: Vec<PartContact>,
        pairs: impl Iterator<Item = BodyPair>,
        places: &Places,
    ) -> Self {
        let mut pairs: Vec<_> = pairs.collect();
        pairs.sort_unstable_by_key(BodyPair::order);
        // Two that were mapped to one are one.
        pairs.dedup_by_key(|pair| pair.order);
        let of_two = |contact: &&PartContact| contact.bodies[0] != contact.bodies[1];
        let order = |contact: &PartContact| {
            let (order, _) = places.order(contact.bodies, contact.is_sensor);
            (order, place(&contact.key, places.index), contact.key)
        };
        let mut sorted: Vec<_> = contacts.iter().filter(of_two).map(order).collect();
        sorted.sort_unstable();
        for pair in &mut pairs {
            let first = sorted.partition_point(|(order, ..)| *order < pair.order);
            let end = sorted.partition_point(|(order, ..)| *order <= pair.order);
            pair.first = first as u32;
            pair.collision.contacts = (end - first) as u32;
        }
        Self {
            by_pair: sorted.into_iter().map(|(.., key)| key).collect(),
            contacts,
            pairs,
            ..Self::default()
        }
    }

    /// Makes this a copy of another one.
    pub(super) fn copy(&mut self, other: &Self) {
        self.contacts.clone_from(&other.contacts);
        self.pairs.clone_from(&other.pairs);
    }

    /// Finds out which of all contacts are those of bodies. O(n log n) in those that are, and O(1) for
    /// each of all.
    pub(super) fn refresh<'a>(
        &mut self,
        all: impl Iterator<Item = &'a ContactPair>,
        owners: &Owners,
        is_sensor: impl Fn(Entity) -> bool,
        places: &Places,
        audience: &Audience,
    ) {
        self.contacts.clear();
        self.pairs.clear();
        self.by_pair.clear();
        self.sorted.clear();
        if owners.0.is_empty() {
            return;
        }
        for contact in all {
            let Some(bodies) = owners.bodies(&contact.key) else {
                continue;
            };
            let key = contact.key;
            let is_sensor = contact.entities().into_iter().any(&is_sensor);
            let number = self.contacts.len() as u32;
            self.contacts.push(PartContact {
                key,
                bodies,
                is_sensor,
            });
            let [a, b] = bodies;
            if a == b {
                continue;
            }
            let collision = BodyCollision {
                a,
                b,
                is_sensor,
                parts: contact.entities(),
                contacts: 1,
                hears: contact.hears(),
                time: contact.time,
            };
            let (order, side) = places.order(bodies, is_sensor);
            let collision = collision.seen_from(side);
            let place = place(&key, places.index);
            self.sorted.push((order, (place, number), collision));
        }
        self.sorted
            .sort_unstable_by_key(|(order, place, _)| (*order, *place));
        let contacts = &self.contacts;
        let keys = self.sorted.iter();
        self.by_pair
            .extend(keys.map(|(_, (_, number), _)| contacts[*number as usize].key));
        let mut first = 0;
        for of_pair in self.sorted.chunk_by(|a, b| a.0 == b.0) {
            let all = of_pair.iter().map(|(_, _, collision)| *collision);
            if let Some(collision) = all.reduce(join) {
                self.pairs
                    .push(audience.pair(collision, of_pair[0].0, first));
            }
            first += of_pair.len() as u32;
        }
    }

    /// The bodies of the two in contact, if one of them is a part; else, each is its own. O(log n).
    #[inline]
    pub(super) fn bodies(&self, key: &ContactKey) -> [Entity; 2] {
        if self.is_empty() {
            [key.a, key.b]
        } else {
            self.seek_bodies(key)
        }
    }

    #[inline(never)]
    fn seek_bodies(&self, key: &ContactKey) -> [Entity; 2] {
        self.part(key).map_or([key.a, key.b], |part| part.bodies)
    }

    /// What is known of a contact, if one of the two is a part. O(log n).
    pub(super) fn part(&self, key: &ContactKey) -> Option<&PartContact> {
        let place = self
            .contacts
            .binary_search_by_key(key, |contact| contact.key);
        Some(&self.contacts[place.ok()?])
    }

    /// The same, for one contact after the other in the order of keys.
    pub(super) fn walk(&self) -> impl FnMut(&ContactKey) -> [Entity; 2] {
        let mut rest = &self.contacts[..];
        move |key| {
            while rest.first().is_some_and(|contact| contact.key < *key) {
                rest = &rest[1..];
            }
            match rest.first() {
                Some(contact) if contact.key == *key => contact.bodies,
                _ => [key.a, key.b],
            }
        }
    }

    /// All pairs of bodies, in their order.
    pub(super) fn pairs(&self) -> &[BodyPair] {
        &self.pairs
    }

    /// The contacts between the parts of two bodies, those of solid parts first, each in the order of
    /// all. O(pairs of bodies).
    pub(super) fn between(&self, a: Entity, b: Entity) -> impl Iterator<Item = &ContactKey> {
        let own = self.pairs.iter();
        let own = own.filter(move |pair| pair.collision.other(a) == Some(b));
        own.flat_map(|pair| self.keys(pair))
    }

    /// The contacts of a pair of bodies.
    pub(super) fn keys(&self, pair: &BodyPair) -> &[ContactKey] {
        &self.by_pair[pair.first as usize..][..pair.collision.contacts as usize]
    }
}

impl Audience<'_> {
    fn pair(&self, collision: BodyCollision, order: Order, first: u32) -> BodyPair {
        let BodyCollision { a, b, hears, .. } = collision;
        let asks = [a, b].map(self.is_enabled);
        let enabled = [asks[0] && hears[0], asks[1] && hears[1]];
        BodyPair {
            collision,
            is_told: self.messages_for_all || enabled.contains(&true),
            observed: if self.events_for_all { hears } else { enabled },
            order,
            first,
        }
    }
}

/// What is known of two contacts between the same bodies, the earlier one in front.
fn join(one: BodyCollision, other: BodyCollision) -> BodyCollision {
    let first = if other.time < one.time { other } else { one };
    BodyCollision {
        contacts: one.contacts + other.contacts,
        hears: [
            one.hears[0] || other.hears[0],
            one.hears[1] || other.hears[1],
        ],
        ..first
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<BodyCollision>();
}
