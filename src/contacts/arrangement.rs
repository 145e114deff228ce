//! Contacts in the order of what they are between, where that is not the order of keys.

use std::slice;

use super::{
    ledger::{Ledger, Merged},
    pair::{ContactKey, ContactPair},
};
use crate::collision_index::CollisionIndex;

/// The numbers of all contacts, in the order in which they are told: none, if that is the order of
/// keys, as it is unless entities have a [`CollisionOrder`](crate::collision_order::CollisionOrder).
#[derive(Clone, Debug, Default)]
pub(super) struct Arrangement {
    numbers: Vec<u32>,
    sorted: Vec<([u64; 2], ContactKey, u32)>,
}

impl Arrangement {
    /// Brings it up to date. O(n log n), if there is such an order.
    pub(super) fn renew(&mut self, contacts: &Ledger, index: &CollisionIndex) {
        self.numbers.clear();
        if !index.is_ordered() {
            return;
        }
        self.sorted.clear();
        let places = contacts
            .numbered()
            .map(|(number, contact)| (place(&contact.key, index), contact.key, number));
        self.sorted.extend(places);
        self.sorted.sort_unstable();
        let numbers = self.sorted.iter().map(|(.., number)| *number);
        self.numbers.extend(numbers);
    }

    /// Is it another order than that of keys?
    pub(super) const fn is_own(&self) -> bool {
        !self.numbers.is_empty()
    }

    /// All contacts in this order.
    pub(super) fn iter<'a>(&'a self, contacts: &'a Ledger) -> InOrder<'a> {
        if self.is_own() {
            InOrder::Arranged(self.numbers.iter(), contacts)
        } else {
            InOrder::ByKey(contacts.iter())
        }
    }

    /// The same, with their numbers.
    pub(super) fn numbered<'a>(
        &'a self,
        contacts: &'a Ledger,
    ) -> impl Iterator<Item = (u32, &'a ContactPair)> {
        let own = self
            .numbers
            .iter()
            .map(|number| (*number, contacts.at(*number)));
        let by_key = (!self.is_own()).then(|| contacts.numbered());
        own.chain(by_key.into_iter().flatten())
    }
}

/// Where a contact stands among others, if entities have places of their own.
pub(super) fn place(key: &ContactKey, index: &CollisionIndex) -> [u64; 2] {
    let ContactKey { a, b, ids } = *key;
    if index.is_ordered() {
        [index.order_of(ids[0], a), index.order_of(ids[1], b)]
    } else {
        [0; 2]
    }
}

/// All contacts in the order in which they are told.
#[derive(Clone, Debug)]
pub(super) enum InOrder<'a> {
    ByKey(Merged<'a>),
    Arranged(slice::Iter<'a, u32>, &'a Ledger),
}

impl<'a> Iterator for InOrder<'a> {
    type Item = &'a ContactPair;

    #[inline]
    fn next(&mut self) -> Option<&'a ContactPair> {
        match self {
            Self::ByKey(contacts) => contacts.next(),
            Self::Arranged(numbers, contacts) => Some(contacts.at(*numbers.next()?)),
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        match self {
            Self::ByKey(contacts) => contacts.size_hint(),
            Self::Arranged(numbers, _) => numbers.size_hint(),
        }
    }
}

impl ExactSizeIterator for InOrder<'_> {}
