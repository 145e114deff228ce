//! Contacts: the exact verdict on every candidate pair, and how it changes from tick to tick.

use std::cmp::Ordering;

use bevy::{ecs::schedule::InternedScheduleLabel, prelude::*};

use crate::{
    broad_phase::{Pair, Proxies},
    collision_index::{CandidatePairs, CollisionIndex},
    counters::CollisionCounters,
    narrow_phase::{Placed, Workspace},
    plugin::{CollisionSystems, NarrowPhaseSettings},
};

/// Two entities in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct ContactPair {
    /// Their handles in the [`CollisionIndex`].
    pub pair: Pair,
    /// The entity of `pair.a`.
    pub a: Entity,
    /// The entity of `pair.b`.
    pub b: Entity,
}

/// All pairs of entities in contact, in the order of their handles.
///
/// After [`NarrowPhase`](CollisionSystems::NarrowPhase), those of this tick.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Debug, Default)]
pub struct Contacts {
    pairs: Vec<ContactPair>,
    /// Those of the last tick, for comparison.
    before: Vec<ContactPair>,
    /// Those that were found, rather than kept, in this tick.
    found: Vec<Pair>,
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
        self.pairs.binary_search_by_key(&pair, |contact| contact.pair).is_ok()
    }

    /// Takes up the verdicts of a tick: `self.found` are the pairs that were found to be in contact; of last tick's
    /// contacts, those between two resting objects stay.
    fn take_up(&mut self, index: &CollisionIndex) {
        let proxies = index.index().proxies();
        std::mem::swap(&mut self.pairs, &mut self.before);
        self.pairs.clear();
        self.found.sort_unstable();
        let contact = |pair: Pair| {
            let [a, b] = index.entities(pair);
            ContactPair { pair, a, b }
        };
        let mut found = self.found.iter().copied().peekable();
        for kept in self.before.iter().filter(|contact| rests(contact.pair, proxies)) {
            while let Some(pair) = found.next_if(|pair| *pair < kept.pair) {
                self.pairs.push(contact(pair));
            }
            self.pairs.push(*kept);
        }
        self.pairs.extend(found.map(contact));
    }

    /// Compares with the last tick, in the order of the pairs: calls `ended` and `started` for the differences.
    fn compare(&self, mut ended: impl FnMut(&ContactPair), mut started: impl FnMut(&ContactPair)) {
        let (mut before, mut now) = (self.before.iter().peekable(), self.pairs.iter().peekable());
        loop {
            let order = match (before.peek(), now.peek()) {
                // A handle may be another entity's by now, if the index was brought up to date between two ticks.
                (Some(old), Some(new)) => (old.pair, old.a, old.b).cmp(&(new.pair, new.a, new.b)),
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (None, None) => return,
            };
            if order.is_le()
                && let Some(old) = before.next()
                && order.is_lt()
            {
                ended(old);
            }
            if order.is_ge()
                && let Some(new) = now.next()
                && order.is_gt()
            {
                started(new);
            }
        }
    }
}

fn rests(pair: Pair, proxies: &Proxies) -> bool {
    proxies.is_resting(pair.a) && proxies.is_resting(pair.b)
}

/// Two entities have come into contact. Written once for each contact, in the set
/// [`Report`](CollisionSystems::Report), in the order of the [`Contacts`].
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Debug, PartialEq)]
pub struct CollisionStarted {
    /// The entity with the lower handle in the [`CollisionIndex`].
    pub a: Entity,
    /// The other one.
    pub b: Entity,
}

/// Two entities are no longer in contact, or one of them is gone: it may no longer exist. Every contact that started
/// ends exactly once.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Debug, PartialEq)]
pub struct CollisionEnded {
    /// The entity with the lower handle in the [`CollisionIndex`].
    pub a: Entity,
    /// The other one.
    pub b: Entity,
}

/// The exact tests of all candidate pairs.
#[derive(Clone, Debug)]
pub struct NarrowPhasePlugin(pub(crate) InternedScheduleLabel);

impl Plugin for NarrowPhasePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(self.0, test_candidates.in_set(CollisionSystems::NarrowPhase));
    }
}

fn test_candidates(
    index: Res<CollisionIndex>,
    candidates: Res<CandidatePairs>,
    settings: Res<NarrowPhaseSettings>,
    mut contacts: ResMut<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    mut workspace: Local<Workspace>,
) {
    let contacts = &mut *contacts;
    let tests = settings.tests();
    contacts.found.clear();
    contacts.found.extend(candidates.iter().filter(|pair| {
        // Entities may have gone since the pairs were found.
        let [Some(a), Some(b)] = [pair.a, pair.b].map(|id| index.body(id)) else { return false };
        tests.intersects(Placed::new(&a.shape, &a.pose), Placed::new(&b.shape, &b.pose), &mut workspace)
    }));
    contacts.take_up(&index);
    counters.tick.stages = std::mem::take(&mut workspace.counters);
    counters.tick.contacts = contacts.len() as u64;
}

/// Messages about contacts that started and ended.
#[derive(Clone, Debug)]
pub struct ReportPlugin(pub(crate) InternedScheduleLabel);

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<CollisionStarted>()
            .add_message::<CollisionEnded>()
            .add_systems(self.0, report.in_set(CollisionSystems::Report));
    }
}

fn report(
    contacts: Res<Contacts>,
    mut counters: ResMut<CollisionCounters>,
    mut started: MessageWriter<CollisionStarted>,
    mut ended: MessageWriter<CollisionEnded>,
) {
    let counters = &mut counters.tick;
    contacts.compare(
        |&ContactPair { a, b, .. }| {
            ended.write(CollisionEnded { a, b });
            counters.ended += 1;
        },
        |&ContactPair { a, b, .. }| {
            started.write(CollisionStarted { a, b });
            counters.started += 1;
        },
    );
}
