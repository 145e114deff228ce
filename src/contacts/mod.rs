//! Contacts: the exact verdict on every candidate pair, how it changes from tick to tick, and who is told.

mod adjacency;
mod colliding_entities;
mod collisions;
mod events;
mod narrow;
mod report;
mod tracking;

use std::{cmp::Ordering, iter::Peekable, sync::OnceLock};

use bevy::prelude::*;

use crate::{
    broad_phase::{Pair, Proxies, ProxyId},
    collision_index::CollisionIndex,
    filters::CollisionLayers,
    narrow_phase::{Contact, TimedContact},
};
use adjacency::Adjacency;
use tracking::{TrackedContact, Tracking};

pub use colliding_entities::CollidingEntities;
pub use collisions::{Collision, Collisions};
pub use events::{CollisionEnded, CollisionEventSettings, CollisionEventsEnabled, CollisionStarted, EventScope};
pub use narrow::NarrowPhasePlugin;
pub use report::ReportPlugin;

/// Two entities in contact.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct ContactPair {
    /// Their handles in the [`CollisionIndex`].
    pub pair: Pair,
    /// The entity of `pair.a`.
    pub a: Entity,
    /// The entity of `pair.b`.
    pub b: Entity,
    /// The layers of `a`, and those of `b`.
    pub layers: [CollisionLayers; 2],
    /// The share of the tick after which they met: 1, its end, unless one of them is [swept](crate::swept::Swept).
    pub time: f32,
}

impl ContactPair {
    /// What tells a contact from others, and orders them. A handle alone does not: it may be another entity's by the next
    /// tick, if the index was brought up to date between the two.
    const fn key(&self) -> (Pair, Entity, Entity) {
        (self.pair, self.a, self.b)
    }
}

/// Two that met on the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptContact {
    pub(crate) pair: Pair,
    pub(crate) met: TimedContact,
}

/// All pairs of entities in contact, in the order of their handles.
///
/// After [`NarrowPhase`](crate::CollisionSystems::NarrowPhase), those of this tick. [`Collisions`] looks at them by
/// entity.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Debug, Default)]
pub struct Contacts {
    pairs: Vec<ContactPair>,
    /// Those of the last report, for comparison; and those of the last tick, if they were not reported.
    before: Vec<ContactPair>,
    unreported: Vec<ContactPair>,
    /// Is there anything to report that was not?
    has_news: bool,
    /// The search for pairs that `pairs` are the verdicts on, by its number in the index; and the one that `found` and
    /// `impacts` are from.
    search: u64,
    found_in: u64,
    /// Those that were found, rather than kept, in this tick.
    found: Vec<Pair>,
    /// May a pair have been found twice at the end of the tick?
    may_repeat: bool,
    /// Those of which more is known, in the order of `pairs`; of the last report; and of the last tick, unreported.
    #[reflect(ignore)]
    tracked: Vec<TrackedContact>,
    #[reflect(ignore)]
    tracked_before: Vec<TrackedContact>,
    #[reflect(ignore)]
    tracked_unreported: Vec<TrackedContact>,
    /// The geometry of those that were found, if it was asked for.
    #[reflect(ignore)]
    found_geometry: Vec<(Pair, Contact)>,
    #[reflect(ignore)]
    tracking: Tracking,
    /// When and how the pairs met of which one is swept, in the order of the pairs.
    #[reflect(ignore)]
    impacts: Vec<SweptContact>,
    /// Those who are elsewhere at the end of the tick than where they were found, by handle.
    #[reflect(ignore)]
    displaced: Vec<ProxyId>,
    /// Made when it is first asked for in a tick.
    #[reflect(ignore)]
    by_object: OnceLock<Adjacency>,
}

impl Contacts {
    /// All contacts, in the order of their pairs.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &ContactPair> {
        self.pairs.iter()
    }

    /// The number of contacts.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Is nothing in contact?
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Is this pair in contact? O(log n).
    #[must_use]
    pub fn contains(&self, pair: Pair) -> bool {
        self.find(pair).is_some()
    }

    /// Where the two of a pair meet, with the normal from `pair.a` to `pair.b`; `None` if they are not in contact, or
    /// nobody [asked](CollisionEventSettings::geometry). O(log n).
    #[must_use]
    pub fn geometry(&self, pair: Pair) -> Option<&Contact> {
        tracking::find(&self.tracked, pair).map(|tracked| &tracked.geometry)
    }

    /// The share of the tick after which a pair came into contact, of which one is [swept](crate::swept::Swept): 0 to 1;
    /// that of the first time, if there were several. `None` for other pairs: they are looked at where they are at the end
    /// of a tick. O(log n).
    #[must_use]
    pub fn time_of_impact(&self, pair: Pair) -> Option<f32> {
        time_of_impact(&self.impacts, pair)
    }

    /// Those that met on the way, in a tick whose verdicts have not been taken up yet.
    pub(crate) fn impacts(&self) -> &[SweptContact] {
        if self.has_verdicts() { &self.impacts } else { &[] }
    }

    /// Replaces them by others, in any order, a pair maybe several times. Whoever is `displaced` is elsewhere at the end of
    /// the tick than where it was looked at, and in contact with what it is found to touch there.
    pub(crate) fn set_impacts(
        &mut self,
        impacts: impl Iterator<Item = SweptContact>,
        displaced: impl Iterator<Item = ProxyId>,
        found: impl Iterator<Item = (Pair, Contact)>,
    ) {
        self.impacts.clear();
        self.impacts.extend(impacts);
        self.sort_impacts();
        self.displaced.extend(displaced);
        self.displaced.sort_unstable();
        if !self.displaced.is_empty() {
            let displaced = &self.displaced;
            self.found.retain(|pair| !is_displaced(displaced, *pair));
            self.found_geometry.retain(|(pair, _)| !is_displaced(displaced, *pair));
            for (pair, geometry) in found {
                self.found.push(pair);
                self.found_geometry.push((pair, geometry));
            }
        }
    }

    /// The first of each pair, in the order of pairs.
    fn sort_impacts(&mut self) {
        self.impacts.sort_by(|a, b| a.pair.cmp(&b.pair).then(a.met.time.total_cmp(&b.met.time)));
        self.impacts.dedup_by_key(|impact| impact.pair);
    }

    fn find(&self, pair: Pair) -> Option<&ContactPair> {
        self.pairs.binary_search_by_key(&pair, |contact| contact.pair).ok().map(|place| &self.pairs[place])
    }

    /// The contacts of an entity, in the order of their pairs. O(1) for each, and O(contacts + objects) for the first call
    /// in a tick.
    fn of(&self, entity: Entity, id: ProxyId) -> impl Iterator<Item = &ContactPair> {
        let adjacency = self.by_object.get_or_init(|| Adjacency::new(&self.pairs));
        let all = adjacency.of(id).iter().map(|place| &self.pairs[*place as usize]);
        // The handle may have been another's.
        all.filter(move |contact| contact.a == entity || contact.b == entity)
    }

    /// Are the contacts the verdicts on some other search than the last one of this index? If so, none of them can be kept:
    /// what moved since is not known.
    pub(crate) const fn are_out_of_step(&self, index: &CollisionIndex) -> bool {
        self.search != index.search()
    }

    /// Are there verdicts that have not been taken up?
    const fn has_verdicts(&self) -> bool {
        self.found_in != self.search
    }

    /// Forgets what the last tick found.
    fn clear_found(&mut self, search: u64, may_repeat: bool) {
        (self.found_in, self.may_repeat) = (search, may_repeat);
        self.found.clear();
        self.found_geometry.clear();
        self.impacts.clear();
        self.displaced.clear();
    }

    /// Takes up the verdicts of a tick: `self.found` are the pairs that were found to be in contact, `self.impacts` those
    /// that met on the way, and a pair may be in both, or twice in the first; of last tick's contacts, those between two
    /// resting objects stay.
    fn take_up(&mut self, index: &CollisionIndex) {
        let proxies = index.index().proxies();
        self.search = self.found_in;
        self.by_object.take();
        self.found.extend(self.impacts.iter().map(|impact| impact.pair));
        self.found.sort_unstable();
        if self.may_repeat || !self.impacts.is_empty() {
            self.found.dedup();
        }
        let displaced = &self.displaced;
        let last = turn(&mut self.pairs, &mut self.before, &mut self.unreported, self.has_news);
        let kept = last.iter();
        let sources = (&self.found[..], &self.impacts[..], index);
        // Nearly always, what was at rest still is.
        if index.is_as_searched() && displaced.is_empty() {
            merge(&mut self.pairs, sources, kept.filter(|contact| rest(contact.pair, proxies)));
        } else {
            let rested = |contact: &ContactPair| index.rested(contact.pair, [contact.a, contact.b]);
            let stays = |contact: &&ContactPair| rested(contact) && !is_displaced(displaced, contact.pair);
            merge(&mut self.pairs, sources, kept.filter(stays));
        }
    }
}

/// All contacts of a tick: those that are kept, and those that were found, both in the order of pairs.
fn merge<'a>(
    contacts: &mut Vec<ContactPair>,
    (found, impacts, index): (&[Pair], &[SweptContact], &CollisionIndex),
    kept: impl Iterator<Item = &'a ContactPair>,
) {
    let proxies = index.index().proxies();
    let contact = |pair: Pair| {
        let [a, b] = index.entities(pair);
        let layers = [pair.a, pair.b].map(|id| proxies.filter(id).into());
        ContactPair { pair, a, b, layers, time: time_of_impact(impacts, pair).unwrap_or(1.0) }
    };
    let mut found = found.iter().copied().peekable();
    for kept in kept {
        while let Some(pair) = found.next_if(|pair| *pair < kept.pair) {
            contacts.push(contact(pair));
        }
        contacts.push(*kept);
        // One of them rested until it was hit.
        found.next_if_eq(&kept.pair);
    }
    contacts.extend(found.map(contact));
}

/// Makes room in `now` for what is known in a new tick, and returns what was known in the last one: that is what the next
/// report compares with, unless one is still due, whose `before` then stays.
fn turn<'a, T>(now: &mut Vec<T>, before: &'a mut Vec<T>, unreported: &'a mut Vec<T>, has_news: bool) -> &'a [T] {
    let last = if has_news { unreported } else { before };
    std::mem::swap(now, last);
    now.clear();
    last
}

fn rest(pair: Pair, proxies: &Proxies) -> bool {
    proxies.is_resting(pair.a) && proxies.is_resting(pair.b)
}

fn time_of_impact(impacts: &[SweptContact], pair: Pair) -> Option<f32> {
    let place = impacts.binary_search_by_key(&pair, |impact| impact.pair).ok()?;
    Some(impacts[place].met.time)
}

fn is_displaced(displaced: &[ProxyId], pair: Pair) -> bool {
    [pair.a, pair.b].iter().any(|id| displaced.binary_search(id).is_ok())
}

/// Of a list in the order of pairs, what is about this one, if anything is. For pairs asked about in the same order, not all
/// of those in the list.
fn seek<'a, T: 'a>(
    list: &mut Peekable<impl Iterator<Item = &'a T>>,
    pair: Pair,
    key: impl Fn(&T) -> Pair,
) -> Option<&'a T> {
    while list.next_if(|other| key(other) < pair).is_some() {}
    list.next_if(|other| key(other) == pair)
}

/// Compares the contacts of two ticks, both in the order of their pairs: calls `visit` for each pair, with what is
/// known of it in the one and in the other.
fn compare<'a, T: 'a, K: Ord>(
    before: impl Iterator<Item = &'a T>,
    now: impl Iterator<Item = &'a T>,
    key: impl Fn(&T) -> K,
    mut visit: impl FnMut(Option<&'a T>, Option<&'a T>),
) {
    let (mut before, mut now) = (before.peekable(), now.peekable());
    loop {
        let order = match (before.peek(), now.peek()) {
            (Some(old), Some(new)) => key(old).cmp(&key(new)),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => return,
        };
        let old = if order.is_le() { before.next() } else { None };
        let new = if order.is_ge() { now.next() } else { None };
        visit(old, new);
    }
}
