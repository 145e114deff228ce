//! Running the engines on the frames of a scene.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use bevy::math::bounding::Aabb3d;

use super::{
    BLOCK,
    report::{Cell, Row},
};
use crate::{
    engines::{Engine, Entry, Pair, Role},
    measure::median,
};

/// The pairs of a frame in two numbers that do not depend on order: how many, and a sum of hashes.
type Digest = (usize, u64);

fn digest(pairs: &[Pair]) -> Digest {
    let hash = |&(a, b): &Pair| {
        let key = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
        let key = (key ^ key >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (key ^ key >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    };
    (
        pairs.len(),
        pairs.iter().map(hash).fold(0, u64::wrapping_add),
    )
}

/// An engine and what was measured of it.
struct Runner {
    entry: Entry,
    engine: Box<dyn Engine>,
    /// Update and search, of each counted frame.
    times: Vec<[Duration; 2]>,
    digests: Vec<Digest>,
    too_slow: bool,
}

impl Runner {
    fn run(&mut self, boxes: &[Aabb3d], pairs: &mut Vec<Pair>) -> [Duration; 2] {
        pairs.clear();
        let start = Instant::now();
        self.engine.update(boxes);
        let updated = Instant::now();
        self.engine.pairs(pairs);
        let found = Instant::now();
        self.digests.push(digest(pairs));
        [updated - start, found - updated]
    }

    fn row(&self, expected: &[Digest]) -> Row {
        let milliseconds = |of: fn(&[Duration; 2]) -> Duration| {
            median(self.times.iter().map(|time| of(time).as_secs_f64() * 1e3))
        };
        Row {
            engine: self.entry.name,
            role: self.entry.role,
            update_ms: milliseconds(|[update, _]| *update),
            pairs_ms: milliseconds(|[_, pairs]| *pairs),
            total_ms: milliseconds(|[update, pairs]| *update + *pairs),
            too_slow: self.too_slow,
            mismatch: self.entry.role != Role::Floor
                && self
                    .digests
                    .iter()
                    .zip(expected)
                    .any(|(found, expected)| found != expected),
        }
    }
}

/// Runs the engines on these frames, of which the first block is for warming up.
pub fn compare(scene: &str, frames: &[Vec<Aabb3d>], engines: &[Entry], limit: f64) -> Cell {
    let runner = |entry: &Entry| Runner {
        entry: *entry,
        engine: (entry.make)(),
        times: vec![],
        digests: vec![],
        too_slow: false,
    };
    let mut runners: Vec<_> = engines.iter().map(runner).collect();
    let mut pairs = vec![];
    for (number, block) in frames.chunks(BLOCK).enumerate() {
        let (late, early) = runners.split_at_mut(number % engines.len().max(1));
        for runner in early
            .iter_mut()
            .chain(late)
            .filter(|runner| !runner.too_slow)
        {
            for boxes in block {
                let time = runner.run(boxes, &mut pairs);
                if number > 0 {
                    runner.times.push(time);
                } else if runner.digests.len() > 1 && (time[0] + time[1]).as_secs_f64() > limit {
                    // Not the first frame, in which some build more than they will ever again.
                    runner.too_slow = true;
                    break;
                }
            }
        }
    }
    let expected = expected(&runners, frames.len());
    Cell {
        scene: scene.to_owned(),
        objects: frames.first().map_or(0, Vec::len),
        pairs: expected.last().map_or(0, |(pairs, _)| *pairs),
        rows: runners.iter().map(|runner| runner.row(&expected)).collect(),
    }
}

/// What brute force found in each frame, or else most of the engines.
fn expected(runners: &[Runner], frames: usize) -> Vec<Digest> {
    if let Some(brute) = runners
        .iter()
        .find(|runner| runner.entry.name == "brute" && !runner.too_slow)
    {
        return brute.digests.clone();
    }
    let voters: Vec<_> = runners
        .iter()
        .filter(|runner| runner.entry.role != Role::Floor)
        .collect();
    let winner = |frame: usize| {
        let mut votes = BTreeMap::<Digest, usize>::new();
        for digest in voters.iter().filter_map(|runner| runner.digests.get(frame)) {
            *votes.entry(*digest).or_default() += 1;
        }
        votes
            .into_iter()
            .max_by_key(|(_, votes)| *votes)
            .map(|(digest, _)| digest)
    };
    (0..frames).filter_map(winner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_tells_pairs_apart_but_not_their_order() {
        assert_eq!(digest(&[(1, 2), (7, 3)]), digest(&[(3, 7), (2, 1)]));
        assert_ne!(digest(&[(1, 2), (3, 7)]), digest(&[(1, 3), (2, 7)]));
        assert_ne!(digest(&[(1, 2)]), digest(&[(1, 2), (1, 2)]));
    }
}
