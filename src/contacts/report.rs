//! Tells about contacts that started and ended.

use std::{cmp::Ordering, iter::Peekable, slice};

use bevy::prelude::*;

use super::{
    arrangement::place,
    bodies::BodyContacts,
    body_events::{
        BodyCollisionEnded, BodyCollisionStarted, some_bodies, trigger_body_events,
        write_body_messages,
    },
    colliding_entities::{follow_contacts, is_in_use},
    events::{CollisionEnded, CollisionStarted},
    list::Contacts,
    pair::{Collision, ContactPair, compare, seek},
    settings::{CollisionEventSettings, EventScope},
    watched::{self, WatchedContact},
};
use crate::{
    collision_index::CollisionIndex,
    counters::CollisionCounters,
    disabled::see_disabled,
    schedule::{CollisionSystems, add_to_tick},
};

/// The plugin for messages and events about contacts that started and ended, and for
/// [`CollidingEntities`](super::CollidingEntities).
#[derive(Clone, Copy, Debug, Default)]
pub struct ReportPlugin;

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<CollisionStarted>()
            .add_message::<CollisionEnded>()
            .add_message::<BodyCollisionStarted>()
            .add_message::<BodyCollisionEnded>();
        add_to_tick(app, |app, schedule| {
            let world = app.world_mut();
            let lists_are_in_use = see_disabled(world, is_in_use);
            let follow_contacts = see_disabled(world, follow_contacts);
            // Observers come last, so that they find everything else up to date, and see no change
            // but their own.
            let report = (
                write_messages,
                write_body_messages.run_if(some_bodies),
                follow_contacts.run_if(lists_are_in_use),
                trigger_events.run_if(anything_watched),
                trigger_body_events.run_if(some_bodies),
                note_bodies_reported.run_if(some_bodies),
            );
            // Each change is told once, though the exact tests or this may be skipped in a tick.
            let report = report
                .chain()
                .run_if(|contacts: Res<Contacts>| contacts.has_news());
            app.add_systems(schedule, report.in_set(CollisionSystems::Report));
        });
    }
}

/// What messages are about, put in order.
#[derive(Default)]
struct ToTell {
    started: Vec<ContactPair>,
    ended: Vec<ContactPair>,
    in_time: Vec<CollisionStarted>,
}

fn write_messages(
    mut contacts: ResMut<Contacts>,
    (settings, index): (Res<CollisionEventSettings>, Option<Res<CollisionIndex>>),
    mut to_tell: Local<ToTell>,
    mut counters: ResMut<CollisionCounters>,
    mut started: MessageWriter<CollisionStarted>,
    mut ended: MessageWriter<CollisionEnded>,
) {
    let ToTell {
        started: starts,
        ended: ends,
        in_time,
    } = &mut *to_tell;
    let scope = settings.messages;
    let before = contacts.bypass_change_detection().note_reported(scope);
    let ledger = contacts.ledger();
    let (watched_before, watched) = (contacts.watched_before(), contacts.watched());
    let (bodies_before, bodies) = contacts.bodies_before_and_now();
    let before_with = |old: &ContactPair| seen_with(old, watched_before, bodies_before);
    let now_with = |new: &ContactPair| seen_with(new, watched, bodies);
    let ordering = index.as_deref().filter(|index| index.is_ordered());
    // Counters are about contacts, whoever is told.
    counters.tick.ended += ledger.ended().len() as u64;
    counters.tick.started += ledger.started().len() as u64;
    let is_about_all = (before, scope) == (EventScope::All, EventScope::All);
    if is_about_all && ordering.is_none() {
        let ends = ledger.ended().iter();
        ended.write_batch(ends.map(|old| before_with(old).heard().into()));
        let starts = ledger.started();
        let messages = starts
            .iter()
            .map(|new| CollisionStarted::from(now_with(new).heard()));
        if starts.is_sorted_by(|a, b| a.time <= b.time) {
            started.write_batch(messages);
        } else {
            in_time.extend(messages);
        }
    } else {
        if is_about_all {
            ends.extend_from_slice(ledger.ended());
            starts.extend_from_slice(ledger.started());
        } else {
            let mut told_before = Told::of(before, watched_before);
            let mut told = Told::of(scope, watched);
            for (old, new) in ledger.compare() {
                match (
                    old.filter(|old| told_before.includes(old)),
                    new.filter(|new| told.includes(new)),
                ) {
                    (Some(old), None) => ends.push(*old),
                    (None, Some(new)) => starts.push(*new),
                    _ => {}
                }
            }
        }
        if let Some(index) = ordering {
            ends.sort_by_cached_key(|contact| place(&contact.key, index));
            starts.sort_by_cached_key(|contact| place(&contact.key, index));
        }
        ended.write_batch(ends.drain(..).map(|old| before_with(&old).heard().into()));
        let starts = starts.drain(..);
        in_time.extend(starts.map(|new| CollisionStarted::from(now_with(&new).heard())));
    }
    in_time.sort_by(earlier);
    started.write_batch(in_time.drain(..));
}

/// Those that start at the same time stay in the order of the contacts.
fn earlier(a: &CollisionStarted, b: &CollisionStarted) -> Ordering {
    a.time.total_cmp(&b.time)
}

/// The contacts that messages are about, for one question after the other, in the order of keys.
enum Told<'a> {
    All,
    /// Those that somebody enabled.
    Some(Peekable<slice::Iter<'a, WatchedContact>>),
}

impl<'a> Told<'a> {
    fn of(scope: EventScope, watched: &'a [WatchedContact]) -> Self {
        match scope {
            EventScope::All => Self::All,
            EventScope::Enabled => Self::Some(watched.iter().peekable()),
        }
    }

    fn includes(&mut self, contact: &ContactPair) -> bool {
        match self {
            Self::All => true,
            Self::Some(watched) => seek(watched, &contact.key, WatchedContact::key)
                .is_some_and(|watched| watched.enabled),
        }
    }
}

/// With what is known of it. O(log n).
fn seen_with(
    contact: &ContactPair,
    watched: &[WatchedContact],
    bodies: &BodyContacts,
) -> Collision {
    let watched = watched::find(watched, &contact.key);
    contact.collision(
        watched.map(|watched| watched.geometry),
        bodies.bodies(&contact.key),
    )
}

/// What comes next is compared with this.
fn note_bodies_reported(mut contacts: ResMut<Contacts>) {
    contacts.bypass_change_detection().note_bodies_reported();
}

fn anything_watched(contacts: Res<Contacts>) -> bool {
    !(contacts.watched_before().is_empty() && contacts.watched().is_empty())
}

/// Triggers events: first those of all contacts that ended, in the order of the contacts, then
/// those of all that started, in the order of time; and for each contact first that of `a`.
///
/// All are decided before the first is triggered: an observer that despawns an entity, or opts it
/// out, changes what is told in the next tick, and nothing in this one.
fn trigger_events(
    world: &mut World,
    mut ended: Local<Vec<([u64; 2], CollisionEnded)>>,
    mut started: Local<Vec<([u64; 2], CollisionStarted)>>,
) {
    let contacts = world.resource::<Contacts>();
    let index = world.get_resource::<CollisionIndex>();
    let place =
        |contact: &WatchedContact| index.map_or([0; 2], |index| place(&contact.key(), index));
    let (before, now) = (contacts.watched_before(), contacts.watched());
    let (bodies_before, bodies) = contacts.bodies_before_and_now();
    for (old, new) in compare(before, now, WatchedContact::key) {
        for side in [0, 1] {
            let observed = |watched: &&WatchedContact| watched.observed[side];
            match (old.filter(observed), new.filter(observed)) {
                // It goes on for others, perhaps: the latest that is known.
                (Some(old), None) => {
                    let (last, known) = new.map_or((old, bodies_before), |new| (new, bodies));
                    let event = last.seen_from(side, known.bodies(&last.key()));
                    ended.push((place(last), event.into()));
                }
                (None, Some(new)) => {
                    let event = new.seen_from(side, bodies.bodies(&new.key()));
                    started.push((place(new), event.into()));
                }
                _ => {}
            }
        }
    }
    // The two sides of a contact stay as they are.
    ended.sort_by_key(|(place, _)| *place);
    started.sort_by(|(place_a, a), (place_b, b)| earlier(a, b).then(place_a.cmp(place_b)));
    for (_, event) in ended.drain(..) {
        world.trigger(event);
        // What its observers asked for is done before those of the next.
        world.flush();
    }
    for (_, event) in started.drain(..) {
        world.trigger(event);
        world.flush();
    }
}
