//! Two in contact, and lists of them that are in the order of pairs.

use std::{
    cmp::Ordering,
    iter::{self, Peekable},
};

use bevy::prelude::*;

use crate::{
    broad_phase::{Pair, ProxyId},
    collision_index::{CollisionIndex, rank},
    filters::{self, CollisionLayers},
    narrow_phase::{Contact, TimedContact},
};

/// What tells a contact from others, and orders all of them: the two entities, and their handles in
/// the index.
///
/// Contacts are ordered by their entities, and not by handles: these depend on who else came and went.
/// Which of the two is `a` is up to the order of [all](CollisionIndex::is_in_order). That the handles are part of it makes a contact a new one when one of
/// the two was out of the index in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[type_path = "bevy_octree"]
pub(crate) struct ContactKey {
    /// The entity that comes first.
    pub(crate) a: Entity,
    /// The other one.
    pub(crate) b: Entity,
    /// The handle of `a`, and that of `b`.
    pub(crate) ids: [ProxyId; 2],
}

/// The handle of who is not in the index any more.
pub(super) const GONE: ProxyId = ProxyId::new(u32::MAX);

impl ContactKey {
    /// That of the two of a pair, in the order of all.
    ///
    /// # Panics
    /// If the pair is not of this index.
    #[inline]
    pub(crate) fn of(pair: Pair, index: &CollisionIndex) -> Self {
        let [a, b] = index.entities(pair);
        let ids = [pair.a, pair.b];
        if index.is_in_order(ids) {
            Self { a, b, ids }
        } else {
            Self {
                a: b,
                b: a,
                ids: [ids[1], ids[0]],
            }
        }
    }

    /// The two handles, as the broad phase has them.
    pub(crate) fn pair(&self) -> Pair {
        Pair::new(self.ids[0], self.ids[1])
    }

    /// Where it stands to the contact of two entities, of which the first is its `a`.
    pub(super) fn cmp_entities(&self, [a, b]: [Entity; 2]) -> Ordering {
        (rank(self.a), rank(self.b)).cmp(&(rank(a), rank(b)))
    }
}

impl PartialOrd for ContactKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for ContactKey {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        let by_entities = (rank(self.a), rank(self.b)).cmp(&(rank(other.a), rank(other.b)));
        by_entities.then_with(|| self.ids.cmp(&other.ids))
    }
}

/// Two entities in contact, as the list of all has them.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub(crate) struct ContactPair {
    /// Who they are.
    pub(crate) key: ContactKey,
    /// The layers of the first, and those of the second.
    pub(crate) layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept).
    pub(crate) time: f32,
}

impl ContactPair {
    /// The two entities.
    pub(crate) const fn entities(&self) -> [Entity; 2] {
        [self.key.a, self.key.b]
    }

    /// The two, as seen from `a`.
    pub(super) const fn collision(
        &self,
        contact: Option<Contact>,
        bodies: [Entity; 2],
    ) -> Collision {
        Collision {
            a: self.key.a,
            b: self.key.b,
            bodies,
            contact,
            layers: self.layers,
            time: self.time,
        }
    }

    /// Which of the two hear of it.
    pub(crate) fn hears(&self) -> [bool; 2] {
        filters::hear(self.layers)
    }

    /// Is this entity one of the two, and hears of it?
    pub(super) fn is_heard_by(&self, entity: Entity) -> bool {
        let [a_hears, b_hears] = self.hears();
        (self.key.a == entity && a_hears) || (self.key.b == entity && b_hears)
    }

    /// The other of the two.
    pub(super) fn other(&self, entity: Entity) -> Entity {
        let ContactKey { a, b, .. } = self.key;
        if a == entity { b } else { a }
    }
}

/// Two that met on the way, in the order of their entities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptContact {
    pub(crate) key: ContactKey,
    pub(crate) met: TimedContact,
}

/// Two entities in contact, as seen from the first.
#[doc(alias = "contact pair")]
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub struct Collision {
    /// The entity that was asked about; of all contacts, the one with the lower index, or the lower
    /// [`CollisionOrder`](crate::collision_order::CollisionOrder).
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    /// The [bodies](crate::parts) that `a` and `b` are parts of; what is part of none is its own.
    pub bodies: [Entity; 2],
    /// Where they meet, with the normal from `a` to `b`; `None` if nobody asked, by
    /// [`CollisionEventsEnabled`](super::CollisionEventsEnabled) on one of them, or for all by
    /// [`CollisionEventSettings::geometry`](super::CollisionEventSettings::geometry).
    /// [`ManifoldsEnabled`](super::ManifoldsEnabled) asks for something else.
    pub contact: Option<Contact>,
    /// The layers of `a`, and those of `b`, as the broad phase saw them last.
    pub layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept).
    pub time: f32,
}

impl Collision {
    /// Returns the same contact as seen from the other one.
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

    /// Returns whether `a` hears of the contact, and whether `b` does: one of the two does not, if
    /// the other is a [detector](crate::filters::Detector).
    #[must_use]
    pub fn hears(&self) -> [bool; 2] {
        filters::hear(self.layers)
    }

    /// As seen from one that hears of it.
    pub(super) fn heard(self) -> Self {
        if self.hears()[0] {
            self
        } else {
            self.reversed()
        }
    }

    /// As seen from this one of the two.
    pub(super) fn seen_from(self, entity: Entity) -> Self {
        if self.a == entity {
            self
        } else {
            self.reversed()
        }
    }
}

/// Of two, the one that an entity is not, if it is one of them.
pub(super) fn other([a, b]: [Entity; 2], entity: Entity) -> Option<Entity> {
    if a == entity {
        Some(b)
    } else if b == entity {
        Some(a)
    } else {
        None
    }
}

/// Of a list in the order of keys, what is about this one, if anything is. For keys asked about in
/// the same order, not all of those in the list.
pub(super) fn seek<'a, T: 'a>(
    list: &mut Peekable<impl Iterator<Item = &'a T>>,
    key: &ContactKey,
    key_of: impl Fn(&T) -> ContactKey,
) -> Option<&'a T> {
    while list.next_if(|other| key_of(other) < *key).is_some() {}
    list.next_if(|other| key_of(other) == *key)
}

/// Two lists in the order of a key, side by side: what each has of a key, for all keys that one of
/// them has.
#[inline]
pub(super) fn compare<'a, T, K: Ord>(
    mut before: &'a [T],
    mut now: &'a [T],
    key: impl Fn(&T) -> K,
) -> impl Iterator<Item = (Option<&'a T>, Option<&'a T>)> {
    iter::from_fn(move || {
        let order = match (before.first(), now.first()) {
            (Some(old), Some(new)) => key(old).cmp(&key(new)),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => return None,
        };
        let old = if order.is_le() {
            before.split_off_first()
        } else {
            None
        };
        let new = if order.is_ge() {
            now.split_off_first()
        } else {
            None
        };
        Some((old, new))
    })
}
