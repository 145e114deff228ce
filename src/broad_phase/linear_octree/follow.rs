//! Following the objects from tick to tick: who came, who went, and who left its skin.

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{Simd, dispatch};

use super::{
    levels::JOB,
    list::List,
    octree::{LinearOctree, NONE},
    skin::{self, REFRESH_SHARE},
};
use crate::{
    broad_phase::{
        block::{ALL, Block, WIDTH},
        boxes::{NOWHERE, ProxyId},
        proxy::Proxies,
    },
    parallel,
};

/// How many boxes are gathered from memory before they are worked on.
const GATHERED: usize = 256;

impl LinearOctree {
    /// Lets go of objects that are gone, and gives places to new ones; unless these are so many that all objects had
    /// better be put in order.
    pub(super) fn let_go_and_take_in(&mut self, proxies: &Proxies) {
        self.slot_of.resize(proxies.capacity(), NONE);
        let mut new = 0;
        for &id in proxies.moved() {
            if !proxies.contains(id) {
                self.let_go(id);
            } else if self.slot_of[id.index()] == NONE {
                new += 1;
            }
        }
        if new * REFRESH_SHARE < proxies.len() {
            for &id in proxies.moved() {
                if proxies.contains(id) && self.slot_of[id.index()] == NONE {
                    self.take_in(id);
                }
            }
        }
    }

    fn let_go(&mut self, id: ProxyId) {
        let slot = std::mem::replace(&mut self.slot_of[id.index()], NONE);
        if slot != NONE {
            let place = slot as usize;
            self.owners[place] = NONE;
            self.owned -= 1;
            self.tree.set(place, &NOWHERE);
            if let Some(aabb) = self.boxes.get_mut(place) {
                *aabb = NOWHERE;
            }
            self.near.renew(slot);
            self.order.note_change();
            self.changes += 1;
        }
    }

    /// Gives an object a place at the end. It has no skin yet, and will be found to have left it.
    fn take_in(&mut self, id: ProxyId) {
        let place = self.owners.len();
        self.slot_of[id.index()] = place as u32;
        self.owners.push(id.get());
        self.owned += 1;
        self.anchors.push(skin::Anchor::default());
        if self.boxes_are_gathered {
            self.boxes.push(NOWHERE);
        }
        self.tree.push(place);
        self.near.push_slot();
        self.order.note_change();
    }

    /// Gathers the boxes of this tick, and lists the slots of objects that left their skins.
    pub(super) fn follow(&mut self, proxies: &Proxies) {
        let all = proxies.most_moved();
        if all || !self.boxes_are_gathered {
            self.follow_all(proxies);
        } else {
            self.follow_moved(proxies);
        }
        if all {
            self.near.watch_all();
        } else {
            self.near.watch_moved(proxies, &self.slot_of);
            for id in proxies.moved().iter().filter(|id| proxies.contains(**id)) {
                self.near.watch(self.slot_of[id.index()]);
            }
        }
    }

    fn follow_all(&mut self, proxies: &Proxies) {
        self.boxes.resize(self.owners.len(), NOWHERE);
        self.boxes_are_gathered = true;
        let jobs = self.owners.len().div_ceil(JOB);
        self.escaped_by_job.resize_with(jobs, List::default);
        let (level, blocks) = (self.level, &self.tree.as_slice()[0][..]);
        let chunks = self.owners.chunks(JOB).zip(self.boxes.chunks_mut(JOB)).zip(blocks.chunks(JOB / WIDTH));
        parallel::for_each(
            chunks.zip(&mut self.escaped_by_job).enumerate(),
            |(job, (((owners, boxes), blocks), escaped))| {
                gather(proxies.boxes(), owners, boxes);
                dispatch!(level, simd => find_escaped(simd, job * JOB, boxes, blocks, escaped));
            },
        );
        for escaped in &self.escaped_by_job {
            self.escaped.extend(escaped.as_slice().iter().map(|slot| *slot as u32));
        }
    }

    fn follow_moved(&mut self, proxies: &Proxies) {
        let boxes = proxies.boxes();
        for id in proxies.moved().iter().filter(|id| proxies.contains(**id)) {
            let slot = self.slot_of[id.index()] as usize;
            let aabb = &boxes[id.index()];
            self.boxes[slot] = *aabb;
            if !self.tree.as_slice()[0][slot / WIDTH].holds(slot % WIDTH, aabb) {
                self.escaped.push(slot as u32);
            }
        }
    }

    /// For how many ticks ahead to make all skins; 0 if they had better be boxes.
    pub(super) fn horizon(&self, proxies: &Proxies) -> f32 {
        // What has no skin is renewed each tick. If so many are fast, all would be renewed before the shortest of skins
        // had served its time.
        const MOST_FAST: f32 = 1.0 / (skin::SHORTEST * REFRESH_SHARE as f32);
        skin::horizon(self.sample(0..self.owners.len(), proxies), MOST_FAST)
    }

    /// For how many ticks ahead to make skins of objects that left theirs. Those that are fast say nothing about the
    /// others.
    pub(super) fn horizon_of_escaped(&self, proxies: &Proxies) -> f32 {
        let escaped = self.escaped.iter().map(|slot| *slot as usize);
        skin::horizon(self.sample(escaped, proxies), 1.0).max(skin::SHORTEST)
    }

    /// Steps of some of the objects in slots, and their boxes.
    fn sample<'a>(
        &'a self,
        slots: impl ExactSizeIterator<Item = usize>,
        proxies: &'a Proxies,
    ) -> impl Iterator<Item = (Vec3A, &'a Aabb3d)> {
        const SAMPLE: usize = 512;
        let step = slots.len() / SAMPLE + 1;
        slots.step_by(step).filter_map(move |slot| {
            let aabb = proxies.boxes().get(*self.owners.get(slot)? as usize)?;
            Some((self.anchors[slot].step(self.tick, aabb), aabb))
        })
    }

    /// Makes the skins of all objects for so many ticks ahead. True if each is the box itself.
    pub(super) fn make_all_skins(&mut self, proxies: &Proxies, horizon: f32) -> bool {
        let (tick, gathered) = (self.tick, self.boxes_are_gathered);
        let keep_boxes = gathered || horizon > 0.0;
        self.boxes_are_gathered = keep_boxes;
        self.boxes.resize(if keep_boxes { self.owners.len() } else { 0 }, NOWHERE);
        let mut all_boxes = self.boxes.chunks_mut(JOB);
        let chunks = self.owners.chunks(JOB).zip(self.anchors.chunks_mut(JOB));
        let chunks = chunks.zip(self.tree.boxes_mut().chunks_mut(JOB / WIDTH));
        let some_skin = AtomicBool::new(false);
        // Without skins, the boxes are not kept beside the tree.
        let chunks = chunks.map(|chunk| (chunk, all_boxes.next()));
        parallel::for_each(chunks, |(((owners, anchors), blocks), kept)| {
            let mut passing = [NOWHERE; GATHERED];
            let mut has_skin = false;
            let mut kept = kept.unwrap_or_default();
            let parts = owners.chunks(GATHERED).zip(anchors.chunks_mut(GATHERED));
            for ((owners, anchors), blocks) in parts.zip(blocks.chunks_mut(GATHERED / WIDTH)) {
                let boxes = if keep_boxes {
                    kept.split_off_mut(..owners.len()).unwrap_or_default()
                } else {
                    &mut passing[..owners.len()]
                };
                if !gathered {
                    gather(proxies.boxes(), owners, boxes);
                }
                for ((boxes, anchors), block) in boxes.chunks(WIDTH).zip(anchors.chunks_mut(WIDTH)).zip(blocks) {
                    for (lane, (aabb, anchor)) in boxes.iter().zip(anchors).enumerate() {
                        if horizon > 0.0 {
                            let skin = anchor.renew(tick, aabb, horizon);
                            has_skin |= skin.is_some();
                            block.set(lane, &skin.unwrap_or(*aabb));
                        } else {
                            block.set(lane, aabb);
                            anchor.drop_at(tick, aabb);
                        }
                    }
                }
            }
            some_skin.fetch_or(has_skin, Ordering::Relaxed);
        });
        !some_skin.into_inner()
    }
}

/// Copies the boxes of some objects. In a loop that does nothing else, so that the processor runs ahead and waits for
/// many boxes at once.
fn gather(boxes: &[Aabb3d], owners: &[u32], gathered: &mut [Aabb3d]) {
    for (owner, aabb) in owners.iter().zip(gathered) {
        *aabb = *boxes.get(*owner as usize).unwrap_or(&NOWHERE);
    }
}

/// Lists the slots, from `start` on, whose boxes are not within the ones in the blocks.
#[inline(always)]
fn find_escaped<S: Simd>(simd: S, start: usize, boxes: &[Aabb3d], blocks: &[Block], escaped: &mut List) {
    escaped.clear();
    escaped.reserve(blocks.len());
    for (place, (eight, block)) in boxes.chunks(WIDTH).zip(blocks).enumerate() {
        let mut inner = Block::EMPTY;
        for (lane, aabb) in eight.iter().enumerate() {
            inner.set(lane, aabb);
        }
        escaped.push_lanes(!block.holds_all(simd, &inner) & ALL, (start + place * WIDTH) as u64, 1);
    }
}
