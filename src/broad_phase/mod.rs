//! The broad phase: from boxes to pairs of overlapping boxes.
//!
//! A [`SpatialIndex`] holds the boxes of all objects behind stable handles ([`ProxyId`]) and a [`BroadPhase`], the
//! way in which it looks for overlaps. Boxes go in one by one; an [`update`](SpatialIndex::update) brings the broad
//! phase up to date with all that changed since the last one; [`find_pairs`](SpatialIndex::find_pairs) gives every
//! pair of overlapping boxes, each once.
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{Method, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&Method::default());
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
//! # Three ways to look
//!
//! The report compares an octree with exhaustive search, and mentions pointerless octrees; here each is an
//! implementation of [`BroadPhase`], chosen by a [`Method`] and exchanged at any time ([`SpatialIndex::set_method`]):
//!
//! - [`Auto`], the default: exhaustive search for a handful of objects, the linear octree beyond.
//! - [`LinearOctree`]: the pointerless octree, by far the fastest for more than a handful.
//! - [`ObjectOctree`]: the report's N-objects octree, maintained as objects move; for its canonical shape, which tells
//!   where in space objects crowd, and for studies of the report.
//! - [`Exhaustive`]: every box against every other; the reference.
//!
//! All of them give the same pairs: exactly those whose boxes overlap, touching included.
//!
//! Objects without an end, such as a ground plane, have no box: the index keeps them apart from the broad phase
//! ([`SpatialIndex::insert_endless`]).
//!
//! # A way of your own
//!
//! Implement [`BroadPhase`] for a type, and give it to [`SpatialIndex::with_engine`]. The trait has one verb for each
//! step of a tick; the boxes, the handles, the list of what changed and the pairs of resting objects are kept for you.
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
#[cfg(test)]
mod checked;
mod endless;
mod exhaustive;
mod filter;
mod group;
mod index;
pub mod linear_octree;
mod method;
pub mod object_octree;
mod pairs;
mod proxy;
mod query;

use std::any::Any;

use bevy::math::{Vec3A, bounding::Aabb3d};

pub use auto::Auto;
pub use exhaustive::Exhaustive;
pub use filter::{PairFilter, PairKinds};
pub use index::SpatialIndex;
pub use linear_octree::LinearOctree;
pub use method::{Method, UnknownMethod};
pub use object_octree::{ObjectOctree, ObjectOctreeSettings, RootPolicy, SettingsError};
pub use pairs::{Pair, PairSet};
pub use proxy::{BoxError, Proxies, ProxyId, check_box, overlap};
pub use query::{Cast, Flow, Hit, Region};

/// A way to find the overlapping pairs among moving boxes.
///
/// A [`SpatialIndex`] owns the boxes and calls these methods, always in this order: [`maintain`](Self::maintain) after
/// boxes changed, then any number of [`find_pairs`](Self::find_pairs) and [`traverse`](Self::traverse). An
/// implementation that has just been installed finds every object in [`Proxies::moved`].
///
/// What every implementation owes: the pairs are exact (each once, none missing, touching counts), their order
/// depends on the history of calls alone, memory is linear in the objects, and no input makes it panic.
pub trait BroadPhase: Any + Send + Sync {
    /// The name by which users know this way of searching.
    fn name(&self) -> &'static str;

    /// Takes up the changes listed in [`Proxies::moved`]: objects inserted, moved and removed.
    fn maintain(&mut self, proxies: &Proxies);

    /// Appends every pair of overlapping boxes of which at least one [moved](Proxies::is_moved), each once. The pairs
    /// of resting objects are kept by the caller and must not be given. Returns the number of pairs of boxes that it
    /// compared.
    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64;

    /// Does [`find_pairs`](Self::find_pairs) leave out pairs that do not [admit](Proxies::admits) each other? If not, as
    /// by default, the caller takes them out.
    fn asks_filters(&self) -> bool {
        false
    }

    /// Walks the index from coarse to fine: calls [`Visitor::enter`] with boxes that bound groups of objects, and
    /// [`Visitor::object`] with the objects of the groups that the visitor enters. Queries are written against this.
    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor);

    /// Calls `found` with every leaf of the tree, in no particular order: for a picture of it, or to know where objects
    /// crowd. By default, there is no tree, and no leaf.
    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        let _ = found;
    }

    /// The linear octree at work, if there is one: queries search its blocks directly, which is faster. An
    /// implementation that hands its work on to another should hand on this too.
    fn as_linear(&self) -> Option<&LinearOctree> {
        None
    }

    /// What the structure looks like now.
    fn stats(&self) -> BroadPhaseStats;
}

/// What walks through a [`BroadPhase`]: see [`BroadPhase::traverse`].
pub trait Visitor {
    /// Is anything inside `bounds` of interest? Objects may stick out of it; the parts that do are in other groups.
    fn enter(&mut self, bounds: &Aabb3d) -> bool;

    /// An object of an entered group, with its box. An object may come up once in each of several groups; `cell` is
    /// the part of space that this visit speaks for. Cells are half-open, disjoint and together all of space, so that
    /// a point of the object's box lies in the cell of exactly one of its visits.
    fn object(&mut self, id: ProxyId, aabb: &Aabb3d, cell: &Aabb3d);

    /// The place from which to look, maybe infinitely far away: the walk goes from near groups to far ones where it
    /// can. A hint that no result depends on.
    fn viewpoint(&self) -> Vec3A {
        Vec3A::NEG_INFINITY
    }
}

/// The cell of a broad phase that does not divide space.
pub const EVERYWHERE: Aabb3d = Aabb3d { min: Vec3A::NEG_INFINITY, max: Vec3A::INFINITY };

/// A leaf of a [`BroadPhase`]'s tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Its part of space. Of the N-objects octree, the cell, without the reach to infinity of the outermost ones; of the
    /// linear octree, the bounds of a block of skins.
    pub bounds: Aabb3d,
    /// Its generation; 0 for a lone root. All leaves of the linear octree have the same.
    pub generation: u32,
    /// How many objects it lists.
    pub objects: u32,
}

/// Figures about a [`BroadPhase`]; all zero where it has nothing of the kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BroadPhaseStats {
    /// Nodes of the tree, leaves included.
    pub nodes: usize,
    /// Leaves of the tree.
    pub leaves: usize,
    /// The largest generation of a node; 0 for a lone root.
    pub depth: u32,
    /// Entries in all leaves together: an object counts once for each leaf that lists it.
    pub entries: usize,
    /// Memory taken, in bytes, that of the [`Proxies`] not included.
    pub bytes: usize,
}

impl BroadPhaseStats {
    /// How full the leaves are: the mean number of entries per leaf; 0 where there are no leaves.
    #[must_use]
    pub fn fill(&self) -> f64 {
        self.entries as f64 / self.leaves.max(1) as f64
    }
}
