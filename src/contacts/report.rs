//! Tells about contacts that started and ended.

use std::{cmp::Ordering, iter::Peekable, slice};

use bevy::prelude::*;

use super::{
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
    counters::CollisionCounters,
    hierarchy::see_disabled,
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

fn write_messages(
    mut contacts: ResMut<Contacts>,
    settings: Res<CollisionEventSettings>,
    (mut scope_before, mut in_time): (Local<Option<EventScope>>, Local<Vec<CollisionStarted>>),
    mut counters: ResMut<CollisionCounters>,
    mut started: MessageWriter<CollisionStarted>,
    mut ended: MessageWriter<CollisionEnded>,
) {
    contacts.bypass_change_detection().note_reported();
    let ledger = contacts.ledger();
    let (watched_before, watched) = (contacts.watched_before(), contacts.watched());
    let (bodies_before, bodies) = contacts.bodies_before_and_now();
    let before_with = |old: &ContactPair| seen_with(old, watched_before, bodies_before);
    let now_with = |new: &ContactPair| seen_with(new, watched, bodies);
    // Counters are about contacts, whoever is told.
    counters.tick.ended += ledger.ended().len() as u64;
    counters.tick.started += ledger.started().len() as u64;
    let scope = settings.messages;
    let before = scope_before.replace(scope).unwrap_or(scope);
    if (before, scope) == (EventScope::All, EventScope::All) {
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
        let mut told_before = Told::of(before, watched_before);
        let mut told = Told::of(scope, watched);
        for (old, new) in ledger.compare() {
            match (
                old.filter(|old| told_before.includes(old)),
                new.filter(|new| told.includes(new)),
            ) {
                (Some(old), None) => _ = ended.write(before_with(old).heard().into()),
                (None, Some(new)) => in_time.push(now_with(new).heard().into()),
                _ => {}
            }
        }
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
    mut ended: Local<Vec<CollisionEnded>>,
    mut started: Local<Vec<CollisionStarted>>,
) {
    let contacts = world.resource::<Contacts>();
    let (before, now) = (contacts.watched_before(), contacts.watched());
    let (bodies_before, bodies) = contacts.bodies_before_and_now();
    for (old, new) in compare(before, now, WatchedContact::key) {
        for side in [0, 1] {
            let observed = |watched: &&WatchedContact| watched.observed[side];
            match (old.filter(observed), new.filter(observed)) {
                // It goes on for others, perhaps: the latest that is known.
                (Some(old), None) => {
                    let (last, known) = new.map_or((old, bodies_before), |new| (new, bodies));
                    ended.push(last.seen_from(side, known.bodies(&last.key())).into());
                }
                (None, Some(new)) => {
                    started.push(new.seen_from(side, bodies.bodies(&new.key())).into());
                }
                _ => {}
            }
        }
    }
    started.sort_by(earlier);
    for event in ended.drain(..) {
        world.trigger(event);
        // What its observers asked for is done before those of the next.
        world.flush();
    }
    for event in started.drain(..) {
        world.trigger(event);
        world.flush();
    }
}
