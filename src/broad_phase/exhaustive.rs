//! All pairs: the reference.

use super::{BroadPhase, BroadPhaseStats, EVERYWHERE, Pair, Proxies, ProxyId, Visitor, overlap};

/// Exhaustive search (Swan 1994, section 1.4): every moved box against every other.
///
/// Time per tick is O(m·n) for m moved objects among n, with a small constant; there is nothing to maintain. It is
/// the reference that the other implementations are checked against, and the fastest for a handful of objects.
#[derive(Clone, Debug, Default)]
pub struct Exhaustive;

impl BroadPhase for Exhaustive {
    fn name(&self) -> &'static str {
        "exhaustive"
    }

    fn maintain(&mut self, _: &Proxies) {}

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let boxes = proxies.boxes();
        for &id in proxies.moved() {
            let Some(aabb) = proxies.get(id) else { continue };
            for (index, other) in boxes.iter().enumerate() {
                if !overlap(aabb, other) {
                    continue;
                }
                let other = ProxyId::new(index as u32);
                // Of two moved objects, the higher one reports the pair.
                let mine = proxies.is_resting(other) || (other < id && proxies.is_moved(other));
                if mine && other != id {
                    pairs.push(Pair::new(id, other));
                }
            }
        }
        distinct_pairs(proxies)
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        for (id, aabb) in proxies.iter() {
            if visitor.enter(aabb) {
                visitor.object(id, aabb, &EVERYWHERE);
            }
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        BroadPhaseStats::default()
    }
}

/// The number of distinct pairs with an object that moved.
fn distinct_pairs(proxies: &Proxies) -> u64 {
    let all = proxies.len() as u64;
    let moved = proxies.moved().iter().filter(|id| proxies.contains(**id)).count() as u64;
    moved * (all - moved) + moved * moved.saturating_sub(1) / 2
}
