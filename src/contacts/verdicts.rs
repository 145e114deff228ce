//! What the exact tests of a tick have found.

use bevy::prelude::*;

use super::{
    buckets::{Buckets, Found},
    order::Sorter,
    pair::{ContactKey, SweptContact},
    watched::Watch,
};
use crate::{broad_phase::ProxyId, narrow_phase::Contact};

/// The verdicts of a tick, on their way from the exact tests, which write them, by the response to
/// impacts, which may replace some, to the list of contacts, which [merges](super::Contacts::merge)
/// them. Nobody else looks at them.
#[derive(Resource, Debug, Default)]
pub(crate) struct Verdicts {
    /// The search for pairs that they are about, by its number in the index; `None` once they are
    /// merged.
    search: Option<u64>,
    /// Those in contact at the end of the tick, in any order.
    found: Vec<ContactKey>,
    /// Those that jobs have found, until they are put to the others.
    found_by_job: Vec<Found>,
    jobs: usize,
    buckets: Buckets,
    /// May one of them have been found twice?
    may_repeat: bool,
    /// Where they meet, of those that somebody asked about.
    geometry: Vec<(ContactKey, Contact)>,
    /// What is found to be in contact at the end of the tick after all, and where.
    found_later: Vec<(ContactKey, Contact)>,
    /// When and how the pairs met of which one is swept: the first time of each, in the order of
    /// keys.
    impacts: Vec<SweptContact>,
    /// Who is elsewhere at the end of the tick than where it was looked at, in the order of
    /// handles.
    displaced: Vec<ProxyId>,
    /// Who has asked about contacts.
    pub(super) watch: Watch,
    sorter: Sorter,
}

/// # Testing
impl Verdicts {
    /// Begins anew, with a search that has not been looked at. A pair may come up twice, if the
    /// candidates were changed.
    pub(super) fn begin(&mut self, search: u64, may_repeat: bool) {
        (self.search, self.may_repeat) = (Some(search), may_repeat);
        self.found.clear();
        self.jobs = 0;
        self.geometry.clear();
        self.found_later.clear();
        self.impacts.clear();
        self.displaced.clear();
    }

    /// Where so many jobs are to put those that are in contact, of which nobody asked where, each
    /// divided into these buckets.
    pub(super) fn begin_jobs(&mut self, jobs: usize, buckets: Buckets) -> (&Watch, &mut [Found]) {
        (self.jobs, self.buckets) = (jobs, buckets);
        if self.found_by_job.len() < jobs {
            self.found_by_job.resize_with(jobs, Found::default);
        }
        let found = &mut self.found_by_job[..jobs];
        found.iter_mut().for_each(Found::clear);
        (&self.watch, found)
    }

    /// These two are in contact, and somebody asked where.
    pub(super) fn touch(&mut self, key: ContactKey, geometry: Contact) {
        self.found.push(key);
        self.geometry.push((key, geometry));
    }

    /// These two met on the way.
    pub(super) fn meet(&mut self, impact: SweptContact) {
        self.impacts.push(impact);
    }

    /// The first of each pair, in the order of keys.
    pub(super) fn sort_impacts(&mut self) {
        self.impacts
            .sort_by(|a, b| a.key.cmp(&b.key).then(a.met.time.total_cmp(&b.met.time)));
        self.impacts.dedup_by_key(|impact| impact.key);
    }
}

/// # The response to impacts
impl Verdicts {
    /// Those that met on the way, as long as that is not merged.
    pub(crate) fn impacts(&self) -> &[SweptContact] {
        if self.search.is_some() {
            &self.impacts
        } else {
            &[]
        }
    }

    /// Replaces those that met on the way by others, in any order, a pair maybe several times.
    /// Whoever is `displaced` is elsewhere at the end of the tick than where it was looked at, and
    /// in contact with what it is found to touch there.
    pub(crate) fn replace_impacts(
        &mut self,
        impacts: impl Iterator<Item = SweptContact>,
        displaced: impl Iterator<Item = ProxyId>,
        found: impl Iterator<Item = (ContactKey, Contact)>,
    ) {
        self.impacts.clear();
        self.impacts.extend(impacts);
        self.sort_impacts();
        self.displaced.extend(displaced);
        self.displaced.sort_unstable();
        if self.displaced.is_empty() {
            return;
        }
        self.collect();
        let displaced = &self.displaced;
        self.found.retain(|key| !is_one_of(displaced, key.ids));
        self.geometry
            .retain(|(key, _)| !is_one_of(displaced, key.ids));
        self.found_later.extend(found);
    }
}

/// # Merging
impl Verdicts {
    /// The number of the search, if the verdicts on it are to be merged; once.
    pub(super) const fn take_search(&mut self) -> Option<u64> {
        self.search.take()
    }

    /// What jobs have found, in these buckets, if that is all there is.
    pub(super) fn by_job(&self) -> Option<(&[Found], Buckets)> {
        let no_others =
            self.found.is_empty() && self.impacts.is_empty() && self.found_later.is_empty();
        let is_all = self.jobs > 0 && !self.may_repeat && no_others;
        is_all.then(|| (&self.found_by_job[..self.jobs], self.buckets))
    }

    /// Puts what jobs have found to all else.
    fn collect(&mut self) {
        for found in &self.found_by_job[..self.jobs] {
            self.found.extend_from_slice(found.all());
        }
        self.jobs = 0;
    }

    /// Puts all in the order of keys: those in contact once each, those that met on the way among
    /// them. Returns these, the first time of each, which replace those of the last tick.
    pub(super) fn sort(&mut self, impacts: &mut Vec<SweptContact>) {
        self.collect();
        self.may_repeat |= !self.found_later.is_empty();
        self.found
            .extend(self.found_later.iter().map(|(key, _)| *key));
        self.geometry.append(&mut self.found_later);
        impacts.clear();
        impacts.append(&mut self.impacts);
        self.found.extend(impacts.iter().map(|impact| impact.key));
        self.sorter.sort(&mut self.found, 0);
        self.may_repeat |= !impacts.is_empty();
        if self.may_repeat {
            self.found.dedup();
        }
        debug_assert!(
            self.found.is_sorted_by(|a, b| a < b),
            "each pair is found once"
        );
        self.geometry.sort_by_key(|(key, _)| *key);
    }

    /// May two at rest be among those in contact? Only if others put them there.
    pub(super) const fn may_repeat(&self) -> bool {
        self.may_repeat
    }

    /// All pairs in contact.
    pub(super) fn found(&self) -> &[ContactKey] {
        &self.found
    }

    /// Where they meet at the end of the tick, a pair maybe several times.
    pub(super) fn geometry(&self) -> &[(ContactKey, Contact)] {
        &self.geometry
    }

    /// Is anybody elsewhere than where it was looked at?
    pub(super) const fn displaces(&self) -> bool {
        !self.displaced.is_empty()
    }

    /// Is one of the two elsewhere than where it was looked at?
    pub(super) fn is_displaced(&self, key: &ContactKey) -> bool {
        is_one_of(&self.displaced, key.ids)
    }
}

fn is_one_of(displaced: &[ProxyId], ids: [ProxyId; 2]) -> bool {
    ids.iter().any(|id| displaced.binary_search(id).is_ok())
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<Verdicts>();
}
