//! Parts of the proxies, for jobs side by side.

use std::ops::Range;

use bevy::math::bounding::Aabb3d;

use super::Proxies;
use crate::broad_phase::{
    boxes::{ProxyId, is_box},
    flags::Flags,
};

/// The boxes behind handles that follow each other, for one job to renew.
///
/// What it renews it lists; the lists of all jobs then go to [`Proxies::note_moved`].
#[derive(Debug)]
pub(crate) struct ProxyPart<'a> {
    first: usize,
    boxes: &'a mut [Aabb3d],
    flags: &'a mut [Flags],
}

impl ProxyPart<'_> {
    /// The place of a handle in this part, if it is one of its own.
    #[inline]
    pub(crate) fn place(&self, id: ProxyId) -> Option<usize> {
        let place = id.index().wrapping_sub(self.first);
        (place < self.boxes.len()).then_some(place)
    }

    /// Gives an object its box of this tick, and counts it as moved though its box may stay. Returns
    /// `false`, and changes nothing, if it is not of this part, has no box, or is to have one that
    /// is none.
    #[inline]
    pub(crate) fn renew(&mut self, id: ProxyId, aabb: &Aabb3d, moved: &mut Vec<ProxyId>) -> bool {
        let Some(place) = self.place(id) else {
            return false;
        };
        let flags = &mut self.flags[place];
        let is_taken = flags.has_box() && is_box(aabb);
        if is_taken {
            self.boxes[place] = *aabb;
            if !flags.has(Flags::PENDING) {
                flags.set(Flags::PENDING);
                moved.push(id);
            }
        }
        is_taken
    }
}

impl Proxies {
    /// The parts behind some ranges of handles, which ascend and do not overlap.
    pub(in crate::broad_phase) fn parts<'a>(
        &'a mut self,
        ranges: impl Iterator<Item = Range<usize>> + 'a,
    ) -> impl Iterator<Item = ProxyPart<'a>> {
        let (mut boxes, mut flags) = (&mut self.boxes[..], &mut self.flags[..]);
        let mut start = 0;
        ranges.map(move |range| {
            let part = ProxyPart {
                first: range.start,
                boxes: cut(&mut boxes, start, &range),
                flags: cut(&mut flags, start, &range),
            };
            start = range.end;
            part
        })
    }

    /// Takes note of what the jobs have renewed.
    pub(in crate::broad_phase) fn note_moved(&mut self, moved: &[ProxyId]) {
        debug_assert!(
            moved
                .iter()
                .all(|id| self.flags[id.index()].has(Flags::PENDING))
        );
        self.moved.pending.extend_from_slice(moved);
    }
}

/// Cuts a range out of a list that begins at some place, and leaves what is behind it. What is
/// beyond the end is left out.
pub(crate) fn cut<'a, T>(
    list: &mut &'a mut [T],
    start: usize,
    range: &Range<usize>,
) -> &'a mut [T] {
    debug_assert!(start <= range.start, "ranges ascend and do not overlap");
    let rest = std::mem::take(list);
    let (_, rest) = rest.split_at_mut((range.start - start).min(rest.len()));
    let (part, rest) = rest.split_at_mut(range.len().min(rest.len()));
    *list = rest;
    part
}
