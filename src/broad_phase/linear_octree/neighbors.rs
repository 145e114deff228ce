//! Pairs of boxes within a distance of each other, by one join of the tree with itself.

use bevy::math::Vec3A;

use super::{
    join::{JoinBuffers, Within},
    levels::JOB,
    list::{List, Packed, unpack},
    octree::LinearOctree,
    query::Skins,
};
use crate::{
    broad_phase::{
        boxes::{Gap, ProxyId, distance},
        proxy::Proxies,
    },
    parallel,
};

/// Lists that are worked with, kept for the next time.
#[derive(Debug, Default)]
pub struct NeighborBuffers {
    work: JoinBuffers,
    candidates: List,
    jobs: Vec<Vec<Gap>>,
}

impl LinearOctree {
    /// Distances of the tree's boxes beyond this are infinite in all that is computed here.
    pub(in crate::broad_phase) const FARTHEST: f32 = 1e30;

    /// Appends every pair of members whose boxes are no farther apart than `limit`, which is to be
    /// less than [`FARTHEST`](Self::FARTHEST); the lower handle first. Members are told by handle.
    pub(in crate::broad_phase) fn find_neighbors(
        &self,
        proxies: &Proxies,
        limit: f32,
        is_member: &(impl Fn(ProxyId) -> bool + Sync),
        buffers: &mut NeighborBuffers,
        found: &mut Vec<Gap>,
    ) {
        debug_assert!(limit < Self::FARTHEST);
        let NeighborBuffers {
            work,
            candidates,
            jobs,
        } = buffers;
        let id = |slot: u32| ProxyId::new(self.owners[slot as usize]);
        let keep = |a: u32, b: u32| is_member(id(a)) & is_member(id(b));
        candidates.clear();
        self.tree
            .self_join(self.level, &Within(limit), work, candidates, Some(&keep));
        let chunks = candidates.as_slice().chunks(JOB);
        if !parallel::is_on() || chunks.len() <= 1 {
            chunks.for_each(|chunk| self.measure(proxies, limit, chunk, found));
            return;
        }
        jobs.resize_with(jobs.len().max(chunks.len()), Vec::new);
        let jobs = &mut jobs[..chunks.len()];
        parallel::for_each(chunks.zip(&mut *jobs), |(chunk, found)| {
            found.clear();
            self.measure(proxies, limit, chunk, found);
        });
        jobs.iter().for_each(|job| found.extend_from_slice(job));
    }

    /// Appends those of some pairs of slots whose boxes are no farther apart than `limit`.
    fn measure(&self, proxies: &Proxies, limit: f32, candidates: &[Packed], found: &mut Vec<Gap>) {
        let skins = Skins::of(self, proxies);
        // A quick look first. Rounding, and squares that are too large or too small, pass it.
        let bound = limit * limit * (1.0 + 8.0 * f32::EPSILON) + f32::MIN_POSITIVE;
        for pair in candidates {
            let [a, b] = unpack(*pair);
            let (Some(box_a), Some(box_b)) = (skins.box_in(a), skins.box_in(b)) else {
                continue;
            };
            let gap = (box_a.min - box_b.max)
                .max(box_b.min - box_a.max)
                .max(Vec3A::ZERO);
            if gap.length_squared() > bound {
                continue;
            }
            let distance = distance(&box_a, &box_b);
            if distance <= limit {
                let [a, b] = [a, b].map(|slot| ProxyId::new(self.owners[slot as usize]));
                found.push(Gap {
                    a: a.min(b),
                    b: a.max(b),
                    distance,
                });
            }
        }
    }
}
