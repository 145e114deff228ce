//! Two in contact, and lists of them that are in the order of pairs.

use std::{
    cmp::Ordering,
    iter::{self, Peekable},
};

use bevy::prelude::*;

use crate::{
    broad_phase::Pair,
    filters::{self, CollisionLayers},
    narrow_phase::{Contact, TimedContact},
};

/// Two entities in contact, as the list of all has them.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub(crate) struct ContactPair {
    /// Their handles in the [`CollisionIndex`](crate::collision_index::CollisionIndex).
    pub(crate) pair: Pair,
    /// The entity of `pair.a`.
    pub(crate) a: Entity,
    /// The entity of `pair.b`.
    pub(crate) b: Entity,
    /// The layers of `a`, and those of `b`.
    pub(crate) layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is
    /// [swept](crate::swept::Swept).
    pub(crate) time: f32,
}

impl ContactPair {
    /// What tells a contact from others, and orders them. A handle alone does not: it may be
    /// another entity's by the next tick, if the index was brought up to date between the two.
    pub(super) const fn key(&self) -> (Pair, Entity, Entity) {
        (self.pair, self.a, self.b)
    }

    /// The two, as seen from `a`.
    pub(super) fn collision(&self, contact: Option<Contact>) -> Collision {
        Collision {
            a: self.a,
            b: self.b,
            contact,
            layers: self.layers,
            time: self.time,
        }
    }

    /// Is this entity one of the two?
    pub(super) fn is_of(&self, entity: Entity) -> bool {
        self.a == entity || self.b == entity
    }

    /// Which of the two hear of it.
    pub(crate) fn hears(&self) -> [bool; 2] {
        filters::hear(self.layers)
    }

    /// Is this entity one of the two, and hears of it?
    pub(super) fn is_heard_by(&self, entity: Entity) -> bool {
        let [a_hears, b_hears] = self.hears();
        (self.a == entity && a_hears) || (self.b == entity && b_hears)
    }

    /// The other of the two.
    pub(super) fn other(&self, entity: Entity) -> Entity {
        if self.a == entity { self.b } else { self.a }
    }
}

/// Two that met on the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptContact {
    pub(crate) pair: Pair,
    pub(crate) met: TimedContact,
}

/// Two entities in contact, as seen from the first.
#[doc(alias = "contact pair")]
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub struct Collision {
    /// The entity that was asked about; of all contacts, the one with the lower handle in the
    /// [`CollisionIndex`](crate::collision_index::CollisionIndex).
    pub a: Entity,
    /// The other one.
    pub b: Entity,
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
        let [a, b] = self.layers;
        Self {
            a: self.b,
            b: self.a,
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

/// Of a list in the order of pairs, what is about this one, if anything is. For pairs asked about
/// in the same order, not all of those in the list.
pub(super) fn seek<'a, T: 'a>(
    list: &mut Peekable<impl Iterator<Item = &'a T>>,
    pair: Pair,
    key: impl Fn(&T) -> Pair,
) -> Option<&'a T> {
    while list.next_if(|other| key(other) < pair).is_some() {}
    list.next_if(|other| key(other) == pair)
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
