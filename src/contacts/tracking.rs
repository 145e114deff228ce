//! Contacts of which more is known than that they are: where, and who is told.

use super::{CollisionEventSettings, ContactPair, Contacts, EventScope, seek, turn};
use crate::{
    broad_phase::{Pair, ProxyId},
    narrow_phase::Contact,
};

/// A contact that somebody asked about.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrackedContact {
    pub(super) contact: ContactPair,
    pub(super) geometry: Contact,
    /// Are the observers of `a`, and those of `b`, told?
    pub(super) observed: [bool; 2],
    /// Does one of the two carry the marker?
    pub(super) enabled: bool,
}

/// Who has asked, in this tick.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracking {
    all_observed: bool,
    all: bool,
    /// By handle.
    enabled: Vec<bool>,
}

impl Tracking {
    /// Takes up the settings, and the objects that carry the marker. O(marked objects).
    pub(super) fn refresh(&mut self, settings: &CollisionEventSettings, enabled: impl Iterator<Item = ProxyId>) {
        self.all_observed = settings.observers == EventScope::All;
        self.all = self.all_observed || settings.geometry == EventScope::All;
        self.enabled.clear();
        for id in enabled {
            if self.enabled.len() <= id.index() {
                self.enabled.resize(id.index() + 1, false);
            }
            self.enabled[id.index()] = true;
        }
    }

    /// Has nobody asked about anything?
    pub(super) fn is_idle(&self) -> bool {
        !self.all && self.enabled.is_empty()
    }

    /// Has somebody asked about the contact of this pair?
    #[inline]
    pub(super) fn wants(&self, pair: Pair) -> bool {
        self.all || self.enabled(pair).contains(&true)
    }

    #[inline]
    fn enabled(&self, pair: Pair) -> [bool; 2] {
        [pair.a, pair.b].map(|id| self.enabled.get(id.index()).is_some_and(|enabled| *enabled))
    }
}

/// What is known of a pair. O(log n).
pub(super) fn find(tracked: &[TrackedContact], pair: Pair) -> Option<&TrackedContact> {
    tracked.binary_search_by_key(&pair, |tracked| tracked.contact.pair).ok().map(|place| &tracked[place])
}

impl Contacts {
    /// Brings the tracked contacts up to date with all contacts. The geometry of a contact that was kept is kept too,
    /// or has to be computed, by `geometry`, if it was not asked for before.
    ///
    /// Of a pair that was found both on the way and at the end of the tick, the geometry is that of the way.
    pub(super) fn track(&mut self, mut geometry: impl FnMut(Pair) -> Option<Contact>) {
        let (tracked, before) = (&mut self.tracked, &mut self.tracked_before);
        let last = turn(tracked, before, &mut self.tracked_unreported, self.has_news);
        let tracking = &self.tracking;
        if tracking.is_idle() {
            return;
        }
        self.found_geometry.sort_unstable_by_key(|(pair, _)| *pair);
        let mut found = self.found_geometry.iter().peekable();
        let mut impacts = self.impacts.iter().peekable();
        let mut last = last.iter().peekable();
        for contact in self.pairs.iter().filter(|contact| tracking.wants(contact.pair)) {
            let pair = contact.pair;
            let on_the_way = seek(&mut impacts, pair, |impact| impact.pair).map(|impact| impact.met.contact);
            let at_the_end = seek(&mut found, pair, |(found, _)| *found).map(|(_, geometry)| *geometry);
            let kept = seek(&mut last, pair, |kept| kept.contact.pair)
                .filter(|kept| kept.contact.key() == contact.key())
                .map(|kept| kept.geometry);
            let known = on_the_way.or(at_the_end).or(kept);
            let Some(geometry) = known.or_else(|| geometry(pair)) else { continue };
            let enabled = tracking.enabled(pair);
            let observed = if tracking.all_observed { [true; 2] } else { enabled };
            self.tracked.push(TrackedContact {
                contact: *contact,
                geometry,
                observed,
                enabled: enabled.contains(&true),
            });
        }
    }
}
