//! Where entities stand in the order of all, those who are gone included.

use bevy::prelude::*;

use super::{CollisionIndex, rank};
use crate::broad_phase::ProxyId;

/// For how many ticks at least the places of who is gone are known: for longer than anybody goes back.
const TICKS_REMEMBERED: u64 = 512;

impl CollisionIndex {
    /// Where the entity behind a handle stands in the order of all.
    #[inline]
    pub(crate) fn order(&self, id: ProxyId) -> u64 {
        self.index.proxies().order(id).0
    }

    /// The same, of an entity that had that handle; it may be another's by now.
    pub(crate) fn order_of(&self, id: ProxyId, entity: Entity) -> u64 {
        if self.is_entry_of(id, entity) {
            self.order(id)
        } else {
            self.order_of_gone(entity).unwrap_or(rank(entity))
        }
    }

    /// Its own place in the order of all, if it has one.
    pub(crate) fn own_order_of(&self, id: ProxyId, entity: Entity) -> Option<u64> {
        let order = self.is_ordered.then(|| self.order_of(id, entity));
        order.filter(|order| *order != rank(entity))
    }

    /// Takes note of the place of an entity that was in another index.
    pub(crate) fn restore_order(&mut self, entity: Entity, order: u64) {
        self.is_ordered = true;
        self.remember_order(entity, order);
    }

    /// Takes note of the place of an entity that may be gone soon.
    pub(crate) fn remember_order(&mut self, entity: Entity, order: u64) {
        self.gone[0].insert(entity, order);
    }

    /// The place of its own that an entity had which is gone, unless that is long ago.
    pub(crate) fn order_of_gone(&self, entity: Entity) -> Option<u64> {
        let mut gone = self.gone.iter();
        gone.find_map(|gone| gone.get(&entity).copied())
    }

    /// Its place in the order of all, if entities have places of their own.
    pub(crate) fn order_given(&self, id: ProxyId) -> Option<u64> {
        self.is_ordered.then(|| self.order(id))
    }

    /// Where two stand in the order of all, if any have places of their own.
    #[inline]
    pub(crate) fn places(&self, ids: [ProxyId; 2]) -> [u64; 2] {
        if self.is_ordered {
            ids.map(|id| self.order(id))
        } else {
            [0; 2]
        }
    }

    /// Does the first of two come before the other, in the order of all?
    #[inline]
    pub(crate) fn is_in_order(&self, ids: [ProxyId; 2]) -> bool {
        let ranks = ids.map(|id| rank(self.entities[id.index()]));
        if self.is_ordered {
            let orders = ids.map(|id| self.order(id));
            (orders[0], ranks[0]) <= (orders[1], ranks[1])
        } else {
            ranks[0] <= ranks[1]
        }
    }

    /// Has one of all ever had a place of its own in their order? Else that is the order of entities.
    #[inline]
    pub(crate) const fn is_ordered(&self) -> bool {
        self.is_ordered
    }

    /// Takes note of the place of who is about to go, if it is one of its own.
    pub(super) fn remember_order_of(&mut self, id: ProxyId) {
        if self.is_ordered {
            let (entity, order) = (self.entities[id.index()], self.order(id));
            if order != rank(entity) {
                self.remember_order(entity, order);
            }
        }
    }

    /// Forgets those who went long ago, now and then.
    pub(super) fn forget_orders(&mut self) {
        if self.search.is_multiple_of(TICKS_REMEMBERED) {
            self.gone.swap(0, 1);
            self.gone[0].clear();
        }
    }
}
