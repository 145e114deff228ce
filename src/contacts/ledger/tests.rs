use std::collections::BTreeSet;

use fastrand::Rng;

use super::*;
use crate::broad_phase::ProxyId;

fn contact(key: &ContactKey) -> ContactPair {
    ContactPair {
        key: *key,
        layers: Default::default(),
        time: 1.0,
    }
}

/// Entities that move and rest at random, and touch at random whenever one of them moves.
struct History {
    rng: Rng,
    entities: Vec<Entity>,
    moved: Vec<bool>,
    touching: BTreeSet<ContactKey>,
    reported: BTreeSet<ContactKey>,
}

impl History {
    fn new(seed: u64, count: usize) -> Self {
        let mut world = World::new();
        Self {
            rng: Rng::with_seed(seed),
            // In several buckets.
            entities: (0..count)
                .flat_map(|_| (0..600).map(|_| world.spawn_empty().id()).last())
                .collect(),
            moved: vec![false; count],
            touching: BTreeSet::new(),
            reported: BTreeSet::new(),
        }
    }

    fn keys(&self) -> impl Iterator<Item = ContactKey> {
        let count = self.entities.len();
        let pairs = (0..count).flat_map(move |a| (a + 1..count).map(move |b| [a, b]));
        pairs.map(|ids| ContactKey {
            a: self.entities[ids[0]],
            b: self.entities[ids[1]],
            ids: ids.map(|id| ProxyId::new(id as u32)),
        })
    }

    fn tick(&mut self, ledger: &mut Ledger) {
        let most = self.rng.usize(0..4);
        let moved: Vec<bool> = self
            .entities
            .iter()
            .map(|_| self.rng.usize(0..3) < most)
            .collect();
        let mut rng = self.rng.fork();
        let moves = |key: &ContactKey| key.ids.iter().any(|id| moved[id.index()]);
        let found: Vec<_> = self
            .keys()
            .filter(|key| moves(key) && rng.usize(0..4) == 0)
            .collect();
        self.touching.retain(|key| !moves(key));
        self.touching.extend(&found);
        let (woke, slept) = self
            .moved
            .iter()
            .zip(&moved)
            .fold((false, false), |(woke, slept), (before, now)| {
                (woke | (!before & now), slept | (before & !now))
            });
        let changes = if self.rng.bool() {
            Changes::ANY
        } else {
            Changes {
                some_woke: woke,
                some_slept: slept,
                some_found_at_rest: false,
            }
        };
        let rests = |contact: &ContactPair| !moves(&contact.key);
        if changes.some_found_at_rest || self.rng.bool() {
            ledger.enter(&found, contact, rests, changes);
        } else {
            // In no order, and by several jobs.
            let buckets = Buckets::up_to(self.rng.u32(0..5000));
            let mut jobs = vec![Found::default(); 3];
            let mut found = found;
            self.rng.shuffle(&mut found);
            for key in found {
                jobs[self.rng.usize(0..3)].extend(std::iter::once(key));
            }
            jobs.iter_mut().for_each(|found| found.divide(buckets));
            ledger.enter_by_job((&jobs, buckets), contact, rests, changes);
        }
        self.moved = moved;
    }

    fn check(&mut self, ledger: &mut Ledger) {
        let all: Vec<_> = self.touching.iter().copied().collect();
        assert_eq!(ledger.iter().len(), all.len());
        assert_eq!(keys(ledger.iter()), all);
        for (number, contact) in ledger.numbered() {
            assert_eq!(ledger.at(number), contact);
        }
        for key in self.keys() {
            let found = ledger.find([key.b, key.a]).map(|contact| contact.key);
            assert_eq!(found, self.touching.get(&key).copied());
        }
        assert!(ledger.has_news());
        let began = self.touching.difference(&self.reported);
        assert_eq!(keys(ledger.started()), began.copied().collect::<Vec<_>>());
        let ended = self.reported.difference(&self.touching);
        assert_eq!(keys(ledger.ended()), ended.copied().collect::<Vec<_>>());
        let both = self.reported.union(&self.touching).map(|key| {
            let one_of = |list: &BTreeSet<ContactKey>| list.get(key).copied();
            (one_of(&self.reported), one_of(&self.touching))
        });
        let compared = ledger.compare().map(|(old, new)| {
            let key = |contact: &ContactPair| contact.key;
            (old.map(key), new.map(key))
        });
        assert!(compared.eq(both));
        if self.rng.bool() {
            ledger.note_reported();
            self.reported = self.touching.clone();
        }
    }
}

fn keys<'a>(contacts: impl IntoIterator<Item = &'a ContactPair>) -> Vec<ContactKey> {
    contacts.into_iter().map(|contact| contact.key).collect()
}

#[test]
fn all_contacts_are_known_and_told_once_whoever_moves() {
    for seed in 0..60 {
        let count = 3 + seed as usize % 10;
        let (mut history, mut ledger) = (History::new(seed, count), Ledger::default());
        for _ in 0..80 {
            history.tick(&mut ledger);
            history.check(&mut ledger);
        }
    }
}

/// Two at rest may be found to touch by who adds to the candidates.
#[test]
fn what_is_found_at_rest_stays() {
    let history = History::new(0, 2);
    let key = history.keys().next().unwrap();
    let mut ledger = Ledger::default();
    let nothing = Changes {
        some_woke: false,
        some_slept: false,
        some_found_at_rest: false,
    };
    let found = Changes {
        some_found_at_rest: true,
        ..nothing
    };
    ledger.enter(&[key], contact, |_| true, found);
    ledger.enter(&[], contact, |_| true, nothing);
    ledger.enter(&[key], contact, |_| true, found);
    assert_eq!(keys(ledger.iter()), [key]);
    assert_eq!(keys(ledger.started()), [key]);
    assert!(ledger.ended().is_empty());
}

/// Who was out of the index in between, and has another handle, is another.
#[test]
fn another_handle_makes_another_contact() {
    let history = History::new(0, 3);
    let [first, second] = [0, 1].map(|index| history.keys().nth(index).unwrap());
    let other = ContactKey {
        ids: second.ids,
        ..first
    };
    let mut ledger = Ledger::default();
    ledger.enter(&[first], contact, |_| false, Changes::ANY);
    ledger.note_reported();
    ledger.enter(&[other], contact, |_| false, Changes::ANY);
    assert_eq!(keys(ledger.started()), [other]);
    assert_eq!(keys(ledger.ended()), [first]);
}
