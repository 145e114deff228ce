//! Contacts of which more is known than that they are: where, and who is told.

use bevy::prelude::*;

use super::{
    pair::{Collision, ContactKey, ContactPair},
    settings::{CollisionEventSettings, EventScope},
};
use crate::{broad_phase::ProxyId, narrow_phase::Contact};

/// A contact that somebody asked about.
#[derive(Clone, Copy, Debug)]
pub(super) struct WatchedContact {
    pub(super) contact: ContactPair,
    pub(super) geometry: Contact,
    /// Are the observers of `a`, and those of `b`, told?
    pub(super) observed: [bool; 2],
    /// Does one of the two carry the marker, and hears of it?
    pub(super) enabled: bool,
}

impl WatchedContact {
    pub(super) const fn key(&self) -> ContactKey {
        self.contact.key
    }

    /// From one of its two sides, of bodies in the order of the contact.
    pub(super) fn seen_from(&self, side: usize, bodies: [Entity; 2]) -> Collision {
        let collision = self.contact.collision(Some(self.geometry), bodies);
        if side == 0 {
            collision
        } else {
            collision.reversed()
        }
    }
}

/// What is known of two. O(log n).
pub(super) fn find<'a>(
    watched: &'a [WatchedContact],
    key: &ContactKey,
) -> Option<&'a WatchedContact> {
    watched
        .binary_search_by_key(key, WatchedContact::key)
        .ok()
        .map(|index| &watched[index])
}

/// Who has asked about contacts in this tick.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    all_observed: bool,
    all: bool,
    /// By handle: who carries the marker.
    enabled: Vec<bool>,
}

impl Watch {
    /// Asks the settings, and the objects that carry the marker. O(marked objects).
    pub(super) fn refresh(
        &mut self,
        settings: &CollisionEventSettings,
        enabled: impl Iterator<Item = ProxyId>,
    ) {
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

    /// Has somebody asked about the contact of these two?
    #[inline]
    pub(super) fn wants(&self, ids: [ProxyId; 2]) -> bool {
        self.all || self.enabled(ids).contains(&true)
    }

    /// The contact, with all that is to be known of it.
    pub(super) fn watched(&self, contact: ContactPair, geometry: Contact) -> WatchedContact {
        let hears = contact.hears();
        let asks = self.enabled(contact.key.ids);
        let enabled = [asks[0] && hears[0], asks[1] && hears[1]];
        let observed = if self.all_observed { hears } else { enabled };
        WatchedContact {
            contact,
            geometry,
            observed,
            enabled: enabled.contains(&true),
        }
    }

    #[inline]
    fn enabled(&self, ids: [ProxyId; 2]) -> [bool; 2] {
        ids.map(|id| self.enabled.get(id.index()).is_some_and(|enabled| *enabled))
    }
}
