//! Upkeep from tick to tick: what to do about skins that objects have left, and about an order that
//! has become a bad one.

use super::{
    list::unpack,
    octree::{LinearOctree, NONE},
    order::Detail,
    skin::REFRESH_SHARE,
};
use crate::broad_phase::proxy::Proxies;

/// A tree that has become looser than this is not searched as a whole.
pub(super) const TOO_LOOSE: f64 = 3.0;

/// Few objects move, if no more than one in so many does.
const MOVERS_SHARE: usize = 8;

/// How far the upkeep of a tick has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// Objects that went have no slot any more, and those that came have one, unless they are too
    /// many.
    Counted,
    /// The boxes of this tick are gathered, and it is known who left its skin.
    Followed,
    /// Those that left their skins have new ones.
    Renewed,
}

/// What there is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    /// To see who left its skin.
    Follow,
    /// To make new skins for those that left theirs.
    Renew,
    /// To make new skins for all; in a new order, if the old one is to be forgotten.
    Refresh { forget_order: bool },
    /// All is done.
    Nothing,
}

impl LinearOctree {
    /// Takes up the changes of a tick.
    pub(super) fn keep_up(&mut self, proxies: &Proxies) {
        // 0 is kept for anchors that are none.
        self.tick = self.tick.checked_add(1).unwrap_or(1);
        self.exact &= proxies.moved().is_empty();
        self.escaped.clear();
        if proxies.population_changed() {
            self.let_go_and_take_in(proxies);
        }
        for id in proxies.changed_filters() {
            if let Some(slot) = self.slot_of.get(id.index()).filter(|slot| **slot != NONE) {
                self.near.renew(*slot);
            }
        }
        let mut progress = Progress::Counted;
        loop {
            progress = match self.decide(proxies, progress) {
                Work::Follow => {
                    self.follow(proxies);
                    self.changes += self.escaped.len();
                    Progress::Followed
                }
                Work::Renew => {
                    self.renew_escaped(proxies);
                    Progress::Renewed
                }
                Work::Refresh { forget_order } => {
                    // Only who follows gathers the boxes of a tick.
                    self.boxes_are_gathered &= progress != Progress::Counted;
                    if forget_order {
                        self.order.forget();
                    }
                    return self.refresh(proxies);
                }
                Work::Nothing => return,
            };
        }
    }

    /// Decides what to do next. The first condition that holds counts.
    ///
    /// | progress | if | then |
    /// |---|---|---|
    /// | counted | objects have no slot: so many came that all had better be put in order | refresh, in a new order |
    /// | | there are no skins, and many moved, all of which will have left theirs | refresh |
    /// | | | follow |
    /// | followed | searches for single slots have cost more than a new order would | refresh, in a new order |
    /// | | many came, went or left their skins since all skins were made | refresh |
    /// | | some left their skins | renew |
    /// | renewed | those that jumped have made blocks so large that searching for them costs as much as a new order would | refresh, in a new order |
    /// | | the next search is one of the whole tree, which has become too loose for it | refresh, in a new order |
    /// | | | nothing |
    ///
    /// Many are more than one in [`REFRESH_SHARE`].
    fn decide(&self, proxies: &Proxies, progress: Progress) -> Work {
        let are_many = |count: usize| count * REFRESH_SHARE > proxies.len();
        match progress {
            Progress::Counted if self.owned != proxies.len() => {
                Work::Refresh { forget_order: true }
            }
            Progress::Counted if self.tight && are_many(proxies.moved().len()) => Work::Refresh {
                forget_order: false,
            },
            Progress::Counted => Work::Follow,
            Progress::Followed if self.near.searches_are_slow() => {
                Work::Refresh { forget_order: true }
            }
            Progress::Followed if are_many(self.changes) => Work::Refresh {
                forget_order: false,
            },
            Progress::Followed if !self.escaped.is_empty() => Work::Renew,
            Progress::Renewed if self.searches_would_be_dear(proxies) => {
                Work::Refresh { forget_order: true }
            }
            Progress::Followed | Progress::Renewed => Work::Nothing,
        }
    }

    /// Returns `true` if the tree has become so loose that what will be searched in it costs more
    /// than a new order.
    fn searches_would_be_dear(&self, proxies: &Proxies) -> bool {
        let looseness = self.tree.looseness();
        let for_single_slots = looseness * self.escaped.len() as f64 > proxies.len() as f64;
        for_single_slots || (looseness > TOO_LOOSE && self.near.are_all_wanted())
    }

    /// Gives all objects new skins, in a new order if the old one has become a bad one.
    pub(super) fn refresh(&mut self, proxies: &Proxies) {
        let horizon = self.horizon(proxies);
        let has_skins = horizon > 0.0;
        if self.order.is_stale(self.owners.len(), has_skins) {
            self.sort(proxies, has_skins);
        }
        self.exact = self.make_all_skins(proxies, horizon);
        self.tree.refit();
        if self.tree.looseness() > TOO_LOOSE {
            self.sort(proxies, has_skins);
            self.exact = self.make_all_skins(proxies, horizon);
            self.tree.refit();
        }
        self.order.note_looseness(self.tree.looseness());
        self.changes = 0;
        self.tight = !has_skins;
        self.near.start_over(self.owners.len());
        if !proxies.most_moved() {
            self.near.watch_moved(proxies, &self.slot_of);
        }
    }

    /// With how much care the objects are put in order. The first condition that holds counts.
    ///
    /// | if | then | for |
    /// |---|---|---|
    /// | few of those that were there move, and many came or went since the last order but one, or the last is old | the boxes are halved | the order lasts, and costs each that comes or goes about as much as to spawn it |
    /// | they move within skins | the blocks are halved | it lasts for some ticks |
    /// | | along the curve alone | it will be looser in a few ticks |
    fn detail(&mut self, proxies: &Proxies, for_skins: bool) -> Detail {
        let all = proxies.len();
        let new = all.saturating_sub(self.owned);
        let movers = proxies.moved().len().saturating_sub(new);
        let is_worth_care = self.order.is_worth_care(new, all, self.tick);
        self.order.note_sort(new, all, self.tick);
        if is_worth_care && movers * MOVERS_SHARE <= all {
            Detail::Boxes
        } else if for_skins {
            Detail::Blocks
        } else {
            Detail::Curve
        }
    }

    /// Puts all objects in order.
    fn sort(&mut self, proxies: &Proxies, for_skins: bool) {
        let detail = self.detail(proxies, for_skins);
        self.slot_of.resize(proxies.capacity(), NONE);
        let mut old_anchors = std::mem::take(&mut self.order.spare_anchors);
        std::mem::swap(&mut self.anchors, &mut old_anchors);
        self.anchors.clear();
        self.owners.clear();
        for (slot, item) in (0..).zip(self.order.sort(self.level, proxies, for_skins, detail)) {
            let [_, id] = unpack(*item);
            let old = std::mem::replace(&mut self.slot_of[id as usize], slot);
            self.anchors
                .push(old_anchors.get(old as usize).copied().unwrap_or_default());
            self.owners.push(id);
        }
        self.order.spare_anchors = old_anchors;
        self.owned = self.owners.len();
        self.sorted = self.owners.len();
        debug_assert_eq!(self.owned, proxies.len(), "every object has a slot");
        self.tree.resize(self.owners.len());
        self.boxes_are_gathered = false;
    }

    /// Gives the objects that left their skins new ones, in their old slots.
    fn renew_escaped(&mut self, proxies: &Proxies) {
        let horizon = self.horizon_of_escaped(proxies);
        self.set_fast_apart(proxies);
        let one_by_one = self.escaped.len() * 32 < self.owners.len();
        for &slot in &self.escaped {
            let index = slot as usize;
            debug_assert_ne!(
                self.owners[index], NONE,
                "nothing is in an empty slot to leave it"
            );
            // As it was gathered, near those of the slots around.
            let aabb = self.boxes[index];
            let skin = self.anchors[index].renew(self.tick, &aabb, horizon);
            self.tree.set(index, &skin.unwrap_or(aabb));
            if one_by_one {
                self.tree.refit_above(index);
            }
            self.near.renew(slot);
        }
        if !one_by_one {
            self.tree.refit();
        }
    }
}
