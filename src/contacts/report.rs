//! Tells about contacts that started and ended.

use std::cmp::Ordering;

use bevy::prelude::*;

use super::{
    Collision, CollisionEnded, CollisionEventSettings, CollisionStarted, ContactPair, Contacts, EventScope,
    colliding_entities::{follow_contacts, is_in_use},
    compare,
    tracking::{self, TrackedContact},
};
use crate::{
    counters::CollisionCounters,
    schedule::{CollisionSystems, add_to_tick},
};

/// Messages and events about contacts that started and ended, and [`CollidingEntities`](super::CollidingEntities).
#[derive(Clone, Copy, Debug, Default)]
pub struct ReportPlugin;

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<CollisionStarted>().add_message::<CollisionEnded>();
        add_to_tick(app, |app, schedule| {
            // Observers come last, so that they find everything else up to date, and see no change but their own.
            let report = (write_messages, follow_contacts.run_if(is_in_use), trigger_events.run_if(anything_tracked));
            // Each change is told once, though the exact tests or this may be skipped in a tick.
            let report = report.chain().run_if(|contacts: Res<Contacts>| contacts.has_news);
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
    contacts.bypass_change_detection().has_news = false;
    let contacts = &*contacts;
    let counters = &mut counters.tick;
    let scopes = [scope_before.replace(settings.messages).unwrap_or(settings.messages), settings.messages];
    // Where nothing was met on the way, the order of contacts is that of time.
    let is_in_time = scopes == [EventScope::All; 2] && contacts.impacts.is_empty();
    let mut written = [0, 0];
    let write = |old: Option<&ContactPair>, new: Option<&ContactPair>| match (old, new) {
        (Some(old), None) => {
            ended.write(old.seen_with(&contacts.tracked_before).into());
            written[0] += 1;
        }
        (None, Some(new)) => {
            let start = new.seen_with(&contacts.tracked).into();
            if is_in_time {
                started.write(start);
            } else {
                in_time.push(start);
            }
            written[1] += 1;
        }
        _ => {}
    };
    let (before, now) = (&contacts.before[..], &contacts.pairs[..]);
    let key = ContactPair::key;
    if scopes == [EventScope::All; 2] {
        compare(before.iter(), now.iter(), key, write);
        [counters.ended, counters.started] = written;
    } else {
        let before_in_scope = in_scope(scopes[0], before, &contacts.tracked_before);
        compare(before_in_scope, in_scope(scopes[1], now, &contacts.tracked), key, write);
        // The counters are about contacts, whoever is told.
        compare(before.iter(), now.iter(), key, |old, new| {
            counters.started += u64::from(old.is_none());
            counters.ended += u64::from(new.is_none());
        });
    }
    in_time.sort_by(earlier);
    started.write_batch(in_time.drain(..));
}

/// Those that start at the same time stay in the order of the contacts.
fn earlier(a: &CollisionStarted, b: &CollisionStarted) -> Ordering {
    a.time.total_cmp(&b.time)
}

/// The contacts that messages are about.
fn in_scope<'a>(
    scope: EventScope,
    all: &'a [ContactPair],
    tracked: &'a [TrackedContact],
) -> impl Iterator<Item = &'a ContactPair> {
    let (all, tracked) = match scope {
        EventScope::All => (all, &[][..]),
        EventScope::Enabled => (&[][..], tracked),
    };
    all.iter().chain(tracked.iter().filter(|tracked| tracked.enabled).map(|tracked| &tracked.contact))
}

impl ContactPair {
    /// With what is known of it.
    fn seen_with(&self, tracked: &[TrackedContact]) -> Collision {
        let contact = tracking::find(tracked, self.pair).map(|tracked| tracked.geometry);
        self.collision(contact)
    }
}

impl TrackedContact {
    /// From one of its two sides.
    fn seen_from(&self, side: usize) -> Collision {
        let collision = self.contact.collision(Some(self.geometry));
        if side == 0 { collision } else { collision.reversed() }
    }
}

fn anything_tracked(contacts: Res<Contacts>) -> bool {
    !(contacts.tracked.is_empty() && contacts.tracked_before.is_empty())
}

/// Triggers events: first those of all contacts that ended, in the order of the contacts, then those of all that started,
/// in the order of time; and for each contact first that of `a`.
///
/// All are decided before the first is triggered: an observer that despawns an entity, or opts it out, changes what is
/// told in the next tick, and nothing in this one.
fn trigger_events(world: &mut World, mut ended: Local<Vec<CollisionEnded>>, mut started: Local<Vec<CollisionStarted>>) {
    let contacts = world.resource::<Contacts>();
    let collect = |old: Option<&TrackedContact>, new: Option<&TrackedContact>| {
        for side in [0, 1] {
            let observed = |tracked: &&TrackedContact| tracked.observed[side];
            match (old.filter(observed), new.filter(observed)) {
                // It goes on for others, perhaps: the latest that is known.
                (Some(old), None) => ended.push(new.unwrap_or(old).seen_from(side).into()),
                (None, Some(new)) => started.push(new.seen_from(side).into()),
                _ => {}
            }
        }
    };
    compare(contacts.tracked_before.iter(), contacts.tracked.iter(), |tracked| tracked.contact.key(), collect);
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
