//! The broad phase: from boxes to pairs of overlapping boxes.
//!
//! A [`SpatialIndex`] holds the boxes of all objects behind stable handles ([`ProxyId`]) and a
//! [`BroadPhase`], the way in which it looks for overlaps. Boxes go in one by one; an
//! [`update`](SpatialIndex::update) brings the broad phase up to date with all that changed since
//! the last one; [`find_pairs`](SpatialIndex::find_pairs) gives every pair of overlapping boxes,
//! each once.
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{BroadPhaseMethod, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&BroadPhaseMethod::default());
//! let cube = |x: f32| Aabb3d::new(Vec3::new(x, 0.0, 0.0), Vec3::splat(0.5));
//! let a = index.insert(cube(0.0))?;
//! let b = index.insert(cube(0.75))?;
//! let c = index.insert(cube(9.0))?;
//! index.update();
//! assert_eq!(index.find_pairs().len(), 1); // a and b
//!
//! index.set(c, &cube(1.75))?; // touches b
//! index.update();
//! assert!(index.find_pairs().iter().all(|pair| pair.a == b || pair.b == b));
//! # Ok::<(), bevy_octree::broad_phase::BoxError>(())
//! ```
//!
//! # Ways to look
//!
//! The report compares an octree with exhaustive search, and mentions pointerless octrees; here
//! each is an implementation of [`BroadPhase`], chosen by a [`BroadPhaseMethod`] and exchanged at
//! any time ([`SpatialIndex::set_method`]):
//!
//! - [`Auto`], the default: exhaustive search for a handful of objects, the linear octree beyond.
//! - [`LinearOctree`]: the pointerless octree, by far the fastest for more than a handful.
//! - [`ObjectOctree`]: the report's N-objects octree, maintained as objects move; for its canonical
//!   shape, which tells where in space objects crowd, and for studies of the report.
//! - [`Exhaustive`]: every box against every other; the reference.
//!
//! All of them give the same pairs: exactly those whose boxes overlap, touching included. What each
//! takes is in the [guide](crate::guide::broad_phases).
//!
//! Unbounded objects, such as a ground plane, have no box: the index keeps them apart from the
//! broad phase ([`SpatialIndex::insert_unbounded`]).
//!
//! # A way of your own
//!
//! Implement [`BroadPhase`] for a type, and give it to [`SpatialIndex::with_engine`]. The trait has
//! one verb for each step of a tick; the boxes, the handles, the list of what changed and the pairs
//! of resting objects are kept for you.
//!
//! ```
//! use bevy_octree::broad_phase::*;
//!
//! /// Exhaustive search over a list sorted along x.
//! #[derive(Default)]
//! struct SweepAndPrune {
//!     order: Vec<ProxyId>,
//! }
//!
//! impl BroadPhase for SweepAndPrune {
//!     fn name(&self) -> &'static str {
//!         "sweep and prune"
//!     }
//!
//!     fn maintain(&mut self, proxies: &Proxies) {
//!         self.order.clear();
//!         self.order.extend(proxies.iter().map(|(id, _)| id));
//!         let low = |id: &ProxyId| proxies.boxes()[id.index()].min.x;
//!         self.order.sort_by(|a, b| low(a).total_cmp(&low(b)));
//!     }
//!
//!     fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
//!         let boxes = proxies.boxes();
//!         let mut compared = 0;
//!         for (i, &a) in self.order.iter().enumerate() {
//!             let reach = boxes[a.index()].max.x;
//!             for &b in self.order[i + 1..].iter().take_while(|b| boxes[b.index()].min.x <= reach) {
//!                 compared += 1;
//!                 let moved = proxies.is_moved(a) || proxies.is_moved(b);
//!                 if moved && overlap(&boxes[a.index()], &boxes[b.index()]) {
//!                     pairs.push(Pair::new(a, b));
//!                 }
//!             }
//!         }
//!         compared
//!     }
//!
//!     fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
//!         Exhaustive::default().traverse(proxies, visitor);
//!     }
//!
//!     fn stats(&self) -> BroadPhaseStats {
//!         BroadPhaseStats::default()
//!     }
//! }
//!
//! let index = SpatialIndex::with_engine(Box::new(SweepAndPrune::default()));
//! assert_eq!(index.engine().name(), "sweep and prune");
//! ```

mod auto;
mod block;
mod boxes;
#[cfg(test)]
mod checked;
mod engine;
mod exhaustive;
mod filter;
mod flags;
mod group;
mod halving;
mod index;
mod level;
pub mod linear_octree;
mod measure;
mod method;
pub mod object_octree;
mod pairs;
mod proxy;
mod query;
mod still_octree;
mod unbounded;

pub use auto::Auto;
pub(crate) use block::WIDTH as BLOCK_WIDTH;
pub(crate) use boxes::Gap;
pub use boxes::{BoxError, EVERYWHERE, ProxyId, check_box, overlap};
pub use engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor};
pub use exhaustive::Exhaustive;
pub use filter::{PairFilter, PairKinds};
pub use index::SpatialIndex;
#[cfg(test)]
pub(crate) use level::forced as levels;
pub use linear_octree::LinearOctree;
pub(crate) use linear_octree::query::Visit;
pub(crate) use measure::Measure;
pub use method::{BroadPhaseMethod, UnknownMethod};
pub use object_octree::{
    ObjectOctree, ObjectOctreeSettings, PairSearch, RootPolicy, SettingsError,
};
pub use pairs::{Pair, PairSet};
pub use proxy::Proxies;
pub(crate) use proxy::part::{ProxyPart, cut};
pub use query::{Cast, Flow, Hit, HitLists, Region};
pub(crate) use query::{Height, Overlap, ScaledDistance, Sweep, answer_each, with_gaps};
pub(crate) use still_octree::{JoinStack, StillOctree, TriangleBlock};
