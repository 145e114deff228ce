//! The list of all contacts, and what became of it since the last report.
//!
//! Contacts of two at rest are kept by themselves, and not looked at while these rest: a tick costs
//! what moves. What started and what ended follows from the contacts of what moved, in the last tick
//! and in this one.

use std::cmp::Ordering;

use bevy::prelude::*;

use super::{
    buckets::{Buckets, Found},
    order::Sorter,
    pair::{ContactKey, ContactPair, compare},
};
use crate::{broad_phase::ProxyId, filters::CollisionLayers, parallel};

/// All contacts, each once, in two lists, both in the order of keys.
#[derive(Clone, Debug, Default, Reflect)]
#[type_path = "bevy_octree"]
pub(super) struct Ledger {
    /// Of which one moved in the last tick that was entered, or was found to be in contact anew.
    moving: Vec<ContactPair>,
    /// Of two at rest.
    resting: Vec<ContactPair>,
    /// What began and what ended since the last report, in the order of keys. Of what did both,
    /// nothing.
    started: Vec<ContactPair>,
    ended: Vec<ContactPair>,
    /// May some of `moving` be of two that rested all the time?
    is_unsettled: bool,
    /// Is there anything to report that was not? An empty tick is news too.
    has_news: bool,
    #[reflect(ignore)]
    work: Work,
}

/// Lists that are worked with, kept for the next time.
#[derive(Clone, Debug, Default)]
struct Work {
    last: Vec<ContactPair>,
    split_off: Vec<ContactPair>,
    merged: Vec<ContactPair>,
    started: Vec<ContactPair>,
    ended: Vec<ContactPair>,
    /// By bucket.
    jobs: Vec<Job>,
}

/// The lists of a job.
#[derive(Clone, Debug, Default)]
struct Job {
    keys: Vec<ContactKey>,
    sorter: Sorter,
    started: Vec<ContactPair>,
    ended: Vec<ContactPair>,
}

/// Two that stand where no contact is written yet.
const NOBODY: ContactPair = ContactPair {
    key: ContactKey {
        a: Entity::PLACEHOLDER,
        b: Entity::PLACEHOLDER,
        ids: [ProxyId::new(0); 2],
    },
    layers: [CollisionLayers::ALL; 2],
    time: 1.0,
};

/// What may have become of those at rest since the last tick that was entered. Where it is certain
/// that nothing did, they are not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Changes {
    /// May one of two at rest have moved, or gone?
    pub(super) some_woke: bool,
    /// May two of which one moved rest by now?
    pub(super) some_slept: bool,
    /// May two at rest be found to be in contact anew?
    pub(super) some_found_at_rest: bool,
}

impl Changes {
    /// Nothing is certain.
    pub(super) const ANY: Self = Self {
        some_woke: true,
        some_slept: true,
        some_found_at_rest: true,
    };
}

impl Ledger {
    pub(super) const fn len(&self) -> usize {
        self.moving.len() + self.resting.len()
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All contacts, in the order of keys.
    pub(super) fn iter(&self) -> Merged<'_> {
        Merged {
            moving: &self.moving,
            resting: &self.resting,
        }
    }

    /// The contact of two. O(log n).
    pub(super) fn find(&self, entities: [Entity; 2]) -> Option<&ContactPair> {
        let [a, b] = entities;
        let find = |entities| {
            [&self.moving, &self.resting].into_iter().find_map(|list| {
                let index = list.binary_search_by(|contact| contact.key.cmp_entities(entities));
                Some(&list[index.ok()?])
            })
        };
        // Either may be the one that comes first.
        find([a, b]).or_else(|| find([b, a]))
    }

    /// All contacts with their numbers, by which they are [looked up](Self::at), in the order of
    /// keys.
    pub(super) fn numbered(&self) -> impl Iterator<Item = (u32, &ContactPair)> {
        let mut numbers = [0, self.moving.len() as u32];
        let mut merged = self.iter();
        std::iter::from_fn(move || {
            let of_resting = usize::from(merged.next_is_resting()?);
            let number = numbers[of_resting];
            numbers[of_resting] += 1;
            Some((number, merged.next()?))
        })
    }

    /// The contact of a number.
    pub(super) fn at(&self, number: u32) -> &ContactPair {
        let index = number as usize;
        self.moving
            .get(index)
            .unwrap_or_else(|| &self.resting[index - self.moving.len()])
    }

    /// All contacts, each with whether it was found in this tick, in the order of keys.
    pub(super) fn with_found(&self) -> impl Iterator<Item = (&ContactPair, bool)> {
        let first_at_rest = self.moving.len() as u32;
        self.numbered()
            .map(move |(number, contact)| (contact, number < first_at_rest))
    }

    /// Enters the contacts of a tick: those that were `found`, in the order of keys, and of those of
    /// the last tick all that rest.
    pub(super) fn enter(
        &mut self,
        found: &[ContactKey],
        contact: impl Fn(&ContactKey) -> ContactPair,
        rests: impl Fn(&ContactPair) -> bool,
        changes: Changes,
    ) {
        self.set_resting_apart(rests, changes);
        let Self {
            moving,
            resting,
            work,
            ..
        } = self;
        let is_kept = |key: &ContactKey| {
            // One of them rested until it was hit.
            let place = resting.binary_search_by_key(key, |resting| resting.key);
            changes.some_found_at_rest && place.is_ok()
        };
        moving.clear();
        moving.extend(found.iter().filter(|key| !is_kept(key)).map(contact));
        tell_apart(moving, &work.last, &mut work.started, &mut work.ended);
        self.is_unsettled = changes.some_found_at_rest;
        self.note_news();
    }

    /// Enters the contacts of a tick as [`enter`](Self::enter) does, bucket by bucket, side by side.
    /// None of them is found at rest, or twice.
    pub(super) fn enter_by_job(
        &mut self,
        (found, buckets): (&[Found], Buckets),
        contact: impl Fn(&ContactKey) -> ContactPair + Sync,
        rests: impl Fn(&ContactPair) -> bool,
        changes: Changes,
    ) {
        debug_assert!(!changes.some_found_at_rest);
        self.set_resting_apart(rests, changes);
        let Self { moving, work, .. } = self;
        let Work {
            last,
            jobs,
            started,
            ended,
            ..
        } = work;
        jobs.resize_with(buckets.count().max(jobs.len()), Job::default);
        let lengths = |bucket| found.iter().map(move |found| found.of(bucket).len());
        let total = (0..buckets.count()).flat_map(lengths).sum();
        moving.resize(total, NOBODY);
        let (mut last, mut free) = (&last[..], &mut moving[..]);
        let parts: Vec<_> = (0..buckets.count())
            .zip(&mut *jobs)
            .map(|(bucket, job)| {
                let end = last.partition_point(|contact| buckets.of(&contact.key) <= bucket);
                let last = last.split_off(..end).unwrap_or_default();
                let count = lengths(bucket).sum();
                let moving = free.split_off_mut(..count).unwrap_or_default();
                (bucket, job, last, moving)
            })
            .collect();
        parallel::for_each(parts.into_iter(), |(bucket, job, last, moving)| {
            job.keys.clear();
            let keys = found.iter().flat_map(|found| found.of(bucket));
            job.keys.extend(keys);
            job.sorter.sort(&mut job.keys, buckets.first_entity(bucket));
            for (key, moving) in job.keys.iter().zip(&mut *moving) {
                *moving = contact(key);
            }
            tell_apart(moving, last, &mut job.started, &mut job.ended);
        });
        started.clear();
        ended.clear();
        for job in &mut jobs[..buckets.count()] {
            started.append(&mut job.started);
            ended.append(&mut job.ended);
        }
        self.is_unsettled = false;
        self.note_news();
    }

    /// Brings those at rest up to date, and puts those of the last tick that do not rest into
    /// `work.last`.
    fn set_resting_apart(&mut self, rests: impl Fn(&ContactPair) -> bool, changes: Changes) {
        let Self {
            moving,
            resting,
            is_unsettled,
            work,
            ..
        } = self;
        std::mem::swap(moving, &mut work.last);
        if changes.some_woke {
            split_off(resting, &rests, &mut work.split_off);
            merge_into(&mut work.last, &mut work.split_off, &mut work.merged);
        }
        if changes.some_slept || *is_unsettled {
            let moves = |contact: &ContactPair| !rests(contact);
            split_off(&mut work.last, moves, &mut work.split_off);
            merge_into(resting, &mut work.split_off, &mut work.merged);
        }
    }

    /// Has the contacts be those of another time, in the order of keys, after a report of those before; another report may
    /// be due.
    pub(super) fn replace(
        &mut self,
        reported: &[ContactPair],
        now: Vec<ContactPair>,
        has_news: bool,
    ) {
        tell_apart(&now, reported, &mut self.started, &mut self.ended);
        self.has_news = has_news;
        self.moving = now;
        self.resting.clear();
        // Some of them rest.
        self.is_unsettled = true;
    }

    /// Adds what began and ended in this tick to what is not reported yet.
    fn note_news(&mut self) {
        debug_assert!(
            self.iter().is_sorted_by(|a, b| a.key < b.key),
            "each pair is one contact"
        );
        let Self {
            started,
            ended,
            work,
            ..
        } = self;
        if std::mem::replace(&mut self.has_news, true) {
            // Of what ended and began again nothing is told, nor of what began and ended.
            cancel(&mut work.started, ended);
            cancel(&mut work.ended, started);
            merge_into(started, &mut work.started, &mut work.merged);
            merge_into(ended, &mut work.ended, &mut work.merged);
        } else {
            std::mem::swap(started, &mut work.started);
            std::mem::swap(ended, &mut work.ended);
        }
    }

    pub(super) const fn has_news(&self) -> bool {
        self.has_news
    }

    /// All that happened until now was told.
    pub(super) const fn note_reported(&mut self) {
        self.has_news = false;
    }

    /// What began since the last report, in the order of keys.
    pub(super) fn started(&self) -> &[ContactPair] {
        &self.started
    }

    /// What ended since the last report, in the order of keys.
    pub(super) fn ended(&self) -> &[ContactPair] {
        &self.ended
    }

    /// What was in contact at the last report, and what is now, side by side, in the order of keys.
    /// Of what was and is, as it is now.
    pub(super) fn compare(
        &self,
    ) -> impl Iterator<Item = (Option<&ContactPair>, Option<&ContactPair>)> {
        let mut started = self.started.iter().peekable();
        let mut ended = self.ended.iter().peekable();
        let mut now = self.iter().peekable();
        std::iter::from_fn(move || {
            let order = match (ended.peek(), now.peek()) {
                (Some(ended), Some(now)) => ended.key.cmp(&now.key),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => return None,
            };
            if order.is_lt() {
                return Some((ended.next(), None));
            }
            let now = now.next()?;
            let is_new = started.next_if(|started| started.key == now.key).is_some();
            Some(((!is_new).then_some(now), Some(now)))
        })
    }
}

/// Contacts in the order of keys, out of two lists.
#[derive(Clone, Debug)]
pub(super) struct Merged<'a> {
    moving: &'a [ContactPair],
    resting: &'a [ContactPair],
}

impl Merged<'_> {
    /// Is the next one of two at rest?
    #[inline]
    fn next_is_resting(&self) -> Option<bool> {
        match (self.moving.first(), self.resting.first()) {
            (Some(moving), Some(resting)) => Some(resting.key < moving.key),
            (Some(_), None) => Some(false),
            (None, Some(_)) => Some(true),
            (None, None) => None,
        }
    }
}

impl<'a> Iterator for Merged<'a> {
    type Item = &'a ContactPair;

    #[inline]
    fn next(&mut self) -> Option<&'a ContactPair> {
        if self.next_is_resting()? {
            self.resting.split_off_first()
        } else {
            self.moving.split_off_first()
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let len = self.moving.len() + self.resting.len();
        (len, Some(len))
    }
}

impl ExactSizeIterator for Merged<'_> {}

/// Lists what is in one list of contacts and was not in the last, and the other way round.
fn tell_apart(
    now: &[ContactPair],
    last: &[ContactPair],
    started: &mut Vec<ContactPair>,
    ended: &mut Vec<ContactPair>,
) {
    started.clear();
    ended.clear();
    let mut last = last.iter().peekable();
    for contact in now {
        while let Some(old) = last.next_if(|old| old.key < contact.key) {
            ended.push(*old);
        }
        if last.next_if(|old| old.key == contact.key).is_none() {
            started.push(*contact);
        }
    }
    ended.extend(last.copied());
}

/// Moves those that do not stay to another list, which was empty, and keeps the order of both.
fn split_off(
    list: &mut Vec<ContactPair>,
    stays: impl Fn(&ContactPair) -> bool,
    others: &mut Vec<ContactPair>,
) {
    debug_assert!(others.is_empty());
    list.retain(|contact| {
        let stays = stays(contact);
        if !stays {
            others.push(*contact);
        }
        stays
    });
}

/// Moves all of one list into another; both are in the order of keys, and have no key in common.
fn merge_into(
    list: &mut Vec<ContactPair>,
    others: &mut Vec<ContactPair>,
    merged: &mut Vec<ContactPair>,
) {
    if others.is_empty() {
        return;
    }
    merged.clear();
    let both = compare(list, others, |contact| contact.key);
    merged.extend(both.filter_map(|(one, other)| one.or(other)));
    std::mem::swap(list, merged);
    others.clear();
}

/// Takes what two lists have in common out of both.
fn cancel(list: &mut Vec<ContactPair>, others: &mut Vec<ContactPair>) {
    let has = |list: &[ContactPair], key: &ContactKey| {
        list.binary_search_by_key(key, |contact| contact.key)
            .is_ok()
    };
    let before = list.clone();
    list.retain(|contact| !has(others, &contact.key));
    others.retain(|contact| !has(&before, &contact.key));
}

#[cfg(test)]
mod tests;
