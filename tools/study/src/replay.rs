//! Replays a recorded trace through a broad phase, and measures it.
//!
//! `cargo run --release -p study -- replay --help` explains the arguments; `record` writes traces.

use std::{num::NonZero, path::PathBuf, time::Instant};

use bevy::math::bounding::Aabb3d;
use bevy_octree::{
    broad_phase::{BroadPhaseMethod, PairSearch, ProxyId, SpatialIndex},
    trace::TraceReader,
};
use clap::Args;

use crate::{
    brute_force::{compare, overlapping_pairs},
    outcome::Outcome,
    progress::Progress,
    quantile::quantile,
    threads::use_threads,
};

/// Replays a trace in Broadmark's .aabbs format through a broad phase: in each frame every object's
/// box is set, the index is brought up to date, and all overlapping pairs are searched for,
/// touching ones included.
///
/// Prints one line. Times are medians per frame, in milliseconds: `update_ms` for setting the boxes
/// and bringing the index up to date, `pairs_ms` for the search, `total_ms` for both. The initial
/// boxes of the file count as a frame. `pairs_last` is the number of pairs in the last frame,
/// `pairs_total` the sum over all frames.
#[derive(Args)]
pub struct Arguments {
    /// The trace.
    file: PathBuf,
    /// The broad phase: `object` for the report's N-objects octree, `exhaustive`, or any other that
    /// the library knows. The library's default if not given.
    #[arg(long)]
    engine: Option<BroadPhaseMethod>,
    /// How many threads work.
    #[arg(long, default_value_t = NonZero::<usize>::MIN, allow_negative_numbers = true)]
    threads: NonZero<usize>,
    /// Stop after so many frames.
    #[arg(long, allow_negative_numbers = true)]
    frames: Option<u64>,
    /// N: how many objects a leaf of the N-objects octree may list before it splits.
    #[arg(long, allow_negative_numbers = true)]
    max_objects: Option<u32>,
    /// The N-objects octree searches its leaves, as in the report.
    #[arg(long)]
    leaves: bool,
    /// Compare the pairs of each frame with brute force, and fail on the first difference. Times
    /// are as without.
    #[arg(long)]
    check: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let method = chosen_method(arguments)?;
    use_threads(arguments.threads)?;
    let mut reader = TraceReader::open(&arguments.file)?;
    let objects = reader.header().objects;
    let frames = reader
        .header()
        .box_sets()
        .min(arguments.frames.unwrap_or(u64::MAX));
    let mut replay = Replay::new(&method);
    let mut progress = Progress::new(frames);
    for frame in 0..frames {
        progress.begin(format!("{} pairs", replay.pairs_last));
        let Some(boxes) = reader.next_frame()? else {
            break;
        };
        replay.frame(boxes)?;
        if arguments.check {
            replay
                .check(boxes)
                .map_err(|difference| format!("frame {frame}: {difference}"))?;
        }
    }
    drop(progress);
    let name = arguments.file.file_name().unwrap_or_default().display();
    let bytes = replay.index.memory_bytes() as f64 / f64::from(objects.max(1));
    println!(
        "trace={name} objects={objects} frames={frames} pairs_last={} pairs_total={} update_ms={:.4} pairs_ms={:.4} total_ms={:.4} bytes_per_object={bytes:.1}",
        replay.pairs_last,
        replay.pairs_total,
        quantile(&replay.update_ms, 0.5),
        quantile(&replay.pairs_ms, 0.5),
        quantile(&replay.total_ms, 0.5),
    );
    Ok(())
}

fn chosen_method(arguments: &Arguments) -> Outcome<BroadPhaseMethod> {
    let mut method = arguments.engine.clone().unwrap_or_default();
    if let BroadPhaseMethod::ObjectOctree(settings) = &mut method {
        if let Some(max_objects) = arguments.max_objects {
            settings.max_objects = max_objects;
        }
        if arguments.leaves {
            settings.search = PairSearch::Leaves;
        }
    } else if arguments.max_objects.is_some() || arguments.leaves {
        return Err(format!(
            "--max-objects and --leaves are for the engine `object`, not for `{method}`"
        )
        .into());
    }
    method.check()?;
    Ok(method)
}

/// An index that follows a trace, and what was measured.
struct Replay {
    index: SpatialIndex,
    objects: Vec<ProxyId>,
    pairs_last: u64,
    pairs_total: u64,
    update_ms: Vec<f64>,
    pairs_ms: Vec<f64>,
    total_ms: Vec<f64>,
}

impl Replay {
    fn new(method: &BroadPhaseMethod) -> Self {
        Self {
            index: SpatialIndex::new(method),
            objects: Vec::new(),
            pairs_last: 0,
            pairs_total: 0,
            update_ms: Vec::new(),
            pairs_ms: Vec::new(),
            total_ms: Vec::new(),
        }
    }

    /// What a game does in a frame. Not inlined, so that profilers can tell it from the reading of
    /// the trace.
    #[inline(never)]
    fn frame(&mut self, boxes: &[Aabb3d]) -> Outcome {
        let start = Instant::now();
        for (object, aabb) in self.objects.iter().zip(boxes) {
            self.index.set(*object, aabb)?;
        }
        // All of them, in the first frame.
        for aabb in &boxes[self.objects.len()..] {
            self.objects.push(self.index.insert(*aabb)?);
        }
        self.index.update();
        let updated = Instant::now();
        self.pairs_last = self.index.find_pairs().len() as u64;
        let end = Instant::now();

        self.pairs_total += self.pairs_last;
        self.update_ms.push((updated - start).as_secs_f64() * 1e3);
        self.pairs_ms.push((end - updated).as_secs_f64() * 1e3);
        self.total_ms.push((end - start).as_secs_f64() * 1e3);
        Ok(())
    }

    /// Compares the pairs of the last frame with those of brute force; fails with a description of
    /// the first difference.
    fn check(&self, boxes: &[Aabb3d]) -> Result<(), String> {
        // Handles are given out from 0 up: they are the indices of the objects.
        let mut found: Vec<_> = self
            .index
            .pairs()
            .iter()
            .map(|pair| [pair.a.get(), pair.b.get()])
            .collect();
        found.sort_unstable();
        compare(&found, &overlapping_pairs(boxes))
    }
}
