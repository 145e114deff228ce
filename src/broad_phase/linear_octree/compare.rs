//! From near pairs to pairs: the boxes of this tick are compared.

use super::{
    levels::JOB,
    list::{Packed, unpack},
    octree::LinearOctree,
};
use crate::{
    broad_phase::{
        boxes::{ProxyId, overlap},
        pairs::Pair,
        proxy::Proxies,
    },
    parallel,
};

/// How many near pairs are compared at once.
const BATCH: usize = 256;

impl LinearOctree {
    /// Appends those of all near pairs whose boxes overlap and of which at least one moved.
    pub(super) fn compare_near(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) {
        let near = self.near.as_slice();
        let chunks = near.chunks(JOB);
        if !parallel::is_on() || chunks.len() <= 1 {
            near.chunks(BATCH)
                .for_each(|near| self.compare(near, proxies, pairs));
            return;
        }
        let mut jobs = std::mem::take(&mut self.pairs_by_job);
        jobs.resize_with(chunks.len(), Vec::new);
        parallel::for_each(chunks.zip(&mut jobs), |(near, found)| {
            found.clear();
            near.chunks(BATCH)
                .for_each(|near| self.compare(near, proxies, found));
        });
        jobs.iter().for_each(|found| pairs.extend_from_slice(found));
        self.pairs_by_job = jobs;
    }

    /// Appends those of a batch of near pairs whose boxes overlap and of which at least one moved.
    ///
    /// Without a branch on either verdict: these would be mispredicted often.
    fn compare(&self, near: &[Packed], proxies: &Proxies, pairs: &mut Vec<Pair>) {
        debug_assert!(near.len() <= BATCH);
        let mut hits = [0; BATCH];
        let hits = if self.exact {
            near
        } else {
            debug_assert!(
                self.boxes_are_gathered,
                "skins that are not boxes have boxes beside them"
            );
            let mut count = 0;
            for pair in near {
                let [a, b] = unpack(*pair).map(|slot| &self.boxes[slot as usize]);
                hits[count] = *pair;
                count += usize::from(overlap(a, b));
            }
            &hits[..count]
        };
        let pair = |hit: &Packed| {
            let [a, b] = unpack(*hit).map(|slot| ProxyId::new(self.owners[slot as usize]));
            Pair {
                a: a.min(b),
                b: a.max(b),
            }
        };
        if proxies.all_moved() {
            pairs.extend(hits.iter().map(pair));
        } else {
            let mut moving = [Pair {
                a: ProxyId::new(0),
                b: ProxyId::new(0),
            }; BATCH];
            let mut count = 0;
            for pair in hits.iter().map(pair) {
                moving[count] = pair;
                count += usize::from(proxies.is_moved(pair.a) | proxies.is_moved(pair.b));
            }
            pairs.extend_from_slice(&moving[..count]);
        }
    }
}
