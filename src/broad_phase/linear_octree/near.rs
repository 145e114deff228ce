//! Near pairs: those whose skins overlap.

use fearless_simd::Level;

use super::{
    join::{JoinBuffers, Touching},
    levels::Levels,
    list::{List, Packed},
    skin::REFRESH_SHARE,
};
use crate::broad_phase::{block::WIDTH, proxy::Proxies};

/// The near pairs of a slot are not known any more. Set when its skin changes, and when it begins
/// to be watched; cleared when they are found.
const FRESH: u8 = 1;
/// The near pairs of a slot are kept. Set when its object moves; cleared, for all at once, when
/// many more are watched than move.
const WATCHED: u8 = 2;

/// Pairs of slots whose skins overlap, kept for as long as the skins are. Of objects that rest,
/// none are kept: what rests costs nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct NearPairs {
    /// As of before the skins in `fresh` changed.
    pairs: List,
    /// Are they known at all?
    are_known: bool,
    /// By slot.
    flags: Vec<u8>,
    /// Slots whose skin changed since the pairs were found, each once.
    fresh: Vec<u32>,
    /// Slots that moved: each pair has one of these. All slots, if `all_are_watched`.
    watched: Vec<u32>,
    all_are_watched: bool,
    /// How many blocks were looked at in searches for single slots.
    blocks_searched: usize,
    work: JoinBuffers,
}

impl NearPairs {
    /// The pairs, the lower slot first, as of the last [`find`](Self::find).
    pub(super) fn as_slice(&self) -> &[Packed] {
        self.pairs.as_slice()
    }

    /// Forgets everything: there are so many slots now, and all have new skins.
    pub(super) fn start_over(&mut self, slots: usize) {
        self.are_known = false;
        self.pairs.clear();
        self.all_are_watched = true;
        self.watched.clear();
        self.fresh.clear();
        self.flags.clear();
        self.flags.resize(slots, 0);
        self.blocks_searched = 0;
    }

    /// Adds a slot at the end, with no pairs.
    pub(super) fn push_slot(&mut self) {
        self.flags.push(0);
    }

    /// Notes that the near pairs of a slot are not known any more.
    pub(super) fn renew(&mut self, slot: u32) {
        let flags = &mut self.flags[slot as usize];
        if self.are_known && *flags & FRESH == 0 {
            *flags |= FRESH;
            self.fresh.push(slot);
        }
    }

    /// Watches a slot, if it is not watched yet.
    #[inline]
    pub(super) fn watch(&mut self, slot: u32) {
        if !self.all_are_watched && self.flags[slot as usize] & WATCHED == 0 {
            self.flags[slot as usize] |= WATCHED;
            self.watched.push(slot);
            self.renew(slot);
        }
    }

    /// Watches all slots.
    pub(super) fn watch_all(&mut self) {
        if !self.all_are_watched {
            self.all_are_watched = true;
            self.forget();
        }
    }

    /// Watches the objects that moved and no others, if many more are watched.
    pub(super) fn watch_moved(&mut self, proxies: &Proxies, slot_of: &[u32]) {
        debug_assert!(
            self.all_are_watched || self.watched.len() <= self.flags.len(),
            "each slot is listed once"
        );
        let watched = if self.all_are_watched {
            self.flags.len()
        } else {
            self.watched.len()
        };
        if watched < 64 + 8 * proxies.moved().len() {
            return;
        }
        if self.all_are_watched {
            self.flags.iter_mut().for_each(|flags| *flags &= !WATCHED);
        }
        self.all_are_watched = false;
        for slot in self.watched.drain(..) {
            self.flags[slot as usize] &= !WATCHED;
        }
        for slot in proxies
            .moved()
            .iter()
            .filter(|id| proxies.contains(**id))
            .map(|id| slot_of[id.index()])
        {
            self.flags[slot as usize] |= WATCHED;
            self.watched.push(slot);
        }
        self.drop_unwatched();
    }

    fn drop_unwatched(&mut self) {
        let flags = &self.flags;
        self.pairs.retain_from(0, |a, b| {
            (flags[a as usize] | flags[b as usize]) & WATCHED != 0
        });
    }

    fn forget(&mut self) {
        self.are_known = false;
        self.pairs.clear();
        for slot in self.fresh.drain(..) {
            self.flags[slot as usize] &= !FRESH;
        }
    }

    /// Returns `true` if searches for single slots have cost more than putting all in order would.
    pub(super) fn searches_are_slow(&self) -> bool {
        self.blocks_searched > 4 * self.flags.len()
    }

    /// Returns `true` if the next [`find`](Self::find) will search the tree as a whole.
    pub(super) fn are_all_wanted(&self) -> bool {
        !self.are_known || self.fresh.len() * REFRESH_SHARE > self.flags.len()
    }

    /// Brings the pairs up to date. Pairs of slots that do not admit each other are left out,
    /// before the list grows.
    pub(super) fn find(
        &mut self,
        level: Level,
        tree: &Levels,
        admits: Option<impl Fn(u32, u32) -> bool + Sync>,
    ) {
        if self.are_all_wanted() {
            self.find_all(level, tree, admits);
        } else {
            self.renew_fresh(level, tree, admits);
        }
    }

    /// Finds all pairs anew.
    fn find_all(
        &mut self,
        level: Level,
        tree: &Levels,
        admits: Option<impl Fn(u32, u32) -> bool + Sync>,
    ) {
        self.forget();
        self.are_known = true;
        debug_assert_eq!(
            self.flags.len().div_ceil(WIDTH).max(1),
            tree.leaves(),
            "the slots are those of the tree"
        );
        let Self {
            pairs,
            flags,
            all_are_watched,
            work,
            ..
        } = self;
        let is_watched = |a: u32, b: u32| {
            *all_are_watched || (flags[a as usize] | flags[b as usize]) & WATCHED != 0
        };
        match admits {
            Some(admits) => tree.self_join(
                level,
                &Touching,
                work,
                pairs,
                Some(&|a, b| is_watched(a, b) && admits(a, b)),
            ),
            None => tree.self_join(
                level,
                &Touching,
                work,
                pairs,
                (!*all_are_watched).then_some(&is_watched),
            ),
        }
    }

    /// Brings the pairs of fresh slots up to date.
    fn renew_fresh(
        &mut self,
        level: Level,
        tree: &Levels,
        admits: Option<impl Fn(u32, u32) -> bool + Sync>,
    ) {
        if self.fresh.is_empty() {
            return;
        }
        let Self {
            pairs,
            flags,
            fresh,
            all_are_watched,
            work,
            ..
        } = self;
        pairs.retain_from(0, |a, b| {
            (flags[a as usize] | flags[b as usize]) & FRESH == 0
        });
        // In the order of space, one search finds in the cache what the last one has read.
        fresh.sort_unstable();
        // Of two fresh ones, the lower finds the pair.
        let is_wanted = |a: u32, b: u32| {
            let (of_a, of_b) = (flags[a as usize], flags[b as usize]);
            let is_first = (a < b) | (of_b & FRESH == 0);
            is_first & (*all_are_watched | ((of_a | of_b) & WATCHED != 0))
        };
        self.blocks_searched += match admits {
            Some(admits) => tree.search(level, fresh, work, pairs, &|a, b| {
                is_wanted(a, b) && admits(a, b)
            }),
            None => tree.search(level, fresh, work, pairs, &is_wanted),
        };
        for slot in fresh.drain(..) {
            flags[slot as usize] &= !FRESH;
        }
    }

    /// Checks that every slot is there, and every fresh one listed. For tests.
    pub(super) fn assert_well_formed(&self, slots: usize) {
        let count = |flag| {
            self.flags
                .iter()
                .filter(|flags| **flags & flag != 0)
                .count()
        };
        assert_eq!(self.flags.len(), slots);
        assert_eq!(
            count(FRESH),
            self.fresh.len(),
            "each fresh slot is listed once"
        );
        assert!(
            self.all_are_watched || count(WATCHED) == self.watched.len(),
            "each watched slot is listed once"
        );
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.flags.capacity()
            + (self.fresh.capacity() + self.watched.capacity()) * size_of::<u32>()
            + self.pairs.memory_bytes()
            + self.work.memory_bytes()
    }
}
