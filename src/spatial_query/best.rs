//! The answers that a search ends with, so that no exact test is made twice.

use crate::broad_phase::{Hit, Proxies, ProxyId};

/// More than rounding makes of a distance, as a share of it, or of a unit.
const ROUNDING: f32 = 1e-4;

/// The nearest answer so far, kept while the index looks for the nearest object, by the index's own
/// rule: of several as far away, the one that comes first in the [order](Proxies::order).
pub(super) struct Best<'a, T> {
    proxies: &'a Proxies,
    /// Nothing beyond this is an answer.
    most: f32,
    limit: f32,
    found: Option<(ProxyId, T)>,
}

impl<'a, T> Best<'a, T> {
    /// Nothing yet, and nothing beyond `limit`.
    pub(super) const fn within(limit: f32, proxies: &'a Proxies) -> Self {
        Self {
            proxies,
            most: limit,
            limit,
            found: None,
        }
    }

    /// How far an exact test has to look for a better answer, or one as good: a little further than there, lest
    /// rounding lose what is as far away as the best. Which is asked about first would make a difference then.
    pub(super) fn limit(&self) -> f32 {
        if self.found.is_none() {
            return self.most;
        }
        (self.limit * (1.0 + ROUNDING) + ROUNDING).min(self.most)
    }

    /// Keeps an answer, if it is the best so far. Returns its distance then, for the index.
    pub(super) fn offer(&mut self, id: ProxyId, distance: f32, answer: T) -> Option<f32> {
        let comes_first =
            |(best, _): &(ProxyId, T)| self.proxies.order(id) < self.proxies.order(*best);
        let is_as_near = distance == self.limit && self.found.as_ref().is_none_or(comes_first);
        let is_better = distance < self.limit || is_as_near;
        if is_better {
            (self.limit, self.found) = (distance, Some((id, answer)));
        }
        is_better.then_some(distance)
    }

    /// The best answer, wherever it came from.
    pub(super) fn found(self) -> Option<T> {
        self.found.map(|(_, answer)| answer)
    }

    /// The answer about the object that the index has found to be nearest.
    pub(super) fn answer(self, nearest: Option<ProxyId>) -> Option<T> {
        debug_assert_eq!(
            nearest,
            self.found.as_ref().map(|(id, _)| *id),
            "the index goes by the same rule"
        );
        self.found.map(|(_, answer)| answer)
    }
}

/// The nearest few answers so far, nearest first, by the same rule.
pub(super) struct BestFew<'a, T> {
    proxies: &'a Proxies,
    /// At most so many, and at least one.
    k: usize,
    limit: f32,
    found: &'a mut Vec<(Hit, T)>,
}

impl<'a, T> BestFew<'a, T> {
    /// Nothing yet, and nothing beyond `limit`. They replace what is in `found`.
    pub(super) fn within(
        k: usize,
        limit: f32,
        proxies: &'a Proxies,
        found: &'a mut Vec<(Hit, T)>,
    ) -> Self {
        found.clear();
        Self {
            proxies,
            k,
            limit,
            found,
        }
    }

    /// Keeps an answer, if it is one of the best so far.
    pub(super) fn offer(&mut self, hit: Hit, answer: T) {
        if hit.distance <= self.limit {
            let proxies = self.proxies;
            let index = self
                .found
                .partition_point(|(other, _)| other.is_before(&hit, proxies));
            if index < self.k {
                self.found.truncate(self.k - 1);
                self.found.insert(index, (hit, answer));
            }
            if let Some((last, _)) = self.found.get(self.k - 1) {
                self.limit = last.distance;
            }
        }
    }
}
