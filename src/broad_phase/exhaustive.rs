//! All pairs: the reference.

use bevy::math::Vec3A;
use fearless_simd::{Level, dispatch};

use super::{
    boxes::EVERYWHERE,
    engine::{BroadPhase, BroadPhaseStats, Visitor},
    group::Group,
    level,
    pairs::Pair,
    proxy::Proxies,
};

/// Exhaustive search (Swan 1994, section 1.4): every moved box against every other.
///
/// Time per tick is O(m·n) for m moved objects among n, with a small constant; there is nothing to
/// maintain. It is the reference that the other implementations are checked against, and the
/// fastest for a handful of objects.
#[derive(Clone, Debug)]
pub struct Exhaustive {
    /// The vector instructions that this machine has.
    level: Level,
    group: Group,
}

impl Default for Exhaustive {
    fn default() -> Self {
        Self {
            level: level::best(),
            group: Group::default(),
        }
    }
}

impl BroadPhase for Exhaustive {
    fn name(&self) -> &'static str {
        "exhaustive"
    }

    fn maintain(&mut self, _: &Proxies) {}

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        if proxies.moved().is_empty() {
            return 0;
        }
        self.group.gather(
            proxies.iter().map(|(id, _)| id),
            Vec3A::NEG_INFINITY,
            proxies,
        );
        dispatch!(self.level, simd => self.group.overlaps(simd, pairs))
    }

    fn asks_filters(&self) -> bool {
        true
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        if visitor.enter(&EVERYWHERE) {
            for (id, aabb) in proxies.iter() {
                visitor.object(id, aabb, &EVERYWHERE);
            }
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        BroadPhaseStats {
            bytes: self.group.memory_bytes(),
            ..BroadPhaseStats::default()
        }
    }
}
