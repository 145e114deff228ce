//! The answer that a search ends with.

use crate::broad_phase::ProxyId;

/// The nearest answer so far, kept while the index looks for the nearest object, by the index's own rule: of several as far
/// away, that of the lowest handle.
pub(super) struct Best<T> {
    limit: f32,
    found: Option<(ProxyId, T)>,
}

impl<T> Best<T> {
    /// Nothing yet, and nothing beyond `limit`.
    pub(super) const fn within(limit: f32) -> Self {
        Self { limit, found: None }
    }

    /// How far away a better answer is at most.
    pub(super) const fn limit(&self) -> f32 {
        self.limit
    }

    /// Keeps an answer, if it is the best so far. Returns its distance then, for the index.
    pub(super) fn offer(&mut self, id: ProxyId, distance: f32, answer: T) -> Option<f32> {
        let is_as_near = distance == self.limit && self.found.as_ref().is_none_or(|(best, _)| id < *best);
        let is_better = distance < self.limit || is_as_near;
        if is_better {
            (self.limit, self.found) = (distance, Some((id, answer)));
        }
        is_better.then_some(distance)
    }

    /// The answer about the object that the index has found to be nearest.
    pub(super) fn answer(self, nearest: Option<ProxyId>) -> Option<T> {
        debug_assert_eq!(nearest, self.found.as_ref().map(|(id, _)| *id), "the index goes by the same rule");
        self.found.map(|(_, answer)| answer)
    }
}
