//! The interface of a broad phase, and what it tells of itself.

use std::any::Any;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{boxes::ProxyId, pairs::Pair, proxy::Proxies};

/// A way to find the overlapping pairs among moving boxes.
///
/// A [`SpatialIndex`](super::SpatialIndex) owns the boxes and calls these methods, always in this
/// order: [`maintain`](Self::maintain) after boxes changed, then any number of
/// [`find_pairs`](Self::find_pairs) and [`traverse`](Self::traverse). An implementation that has
/// just been installed finds every object in [`Proxies::moved`].
///
/// What every implementation owes: the pairs are exact (each once, none missing, touching counts),
/// their order depends on the history of calls alone, memory is linear in the objects, and no input
/// makes it panic.
#[doc(alias = "sweep and prune")]
pub trait BroadPhase: Any + Send + Sync {
    /// Returns the name by which users know this way of searching.
    fn name(&self) -> &'static str;

    /// Takes up the changes listed in [`Proxies::moved`]: objects inserted, moved and removed.
    fn maintain(&mut self, proxies: &Proxies);

    /// Appends every pair of overlapping boxes of which at least one [moved](Proxies::is_moved),
    /// each once. The pairs of resting objects are kept by the caller and must not be given.
    /// Returns the number of pairs of boxes that it compared.
    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64;

    /// Returns `true` if [`find_pairs`](Self::find_pairs) leaves out pairs that do not
    /// [admit](Proxies::admits) each other. If not, as by default, the caller takes them out.
    fn asks_filters(&self) -> bool {
        false
    }

    /// Walks the index from coarse to fine: calls [`Visitor::enter`] with boxes that bound groups
    /// of objects, and [`Visitor::object`] with the objects of the groups that the visitor enters.
    /// Queries are written against this.
    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor);

    /// Calls `found` with every leaf of the tree, in no particular order: for a picture of it, or
    /// to know where objects crowd. By default, there is no tree, and no leaf.
    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        let _ = found;
    }

    /// Returns the broad phase that does the work, where this one hands it on to another: queries
    /// search the blocks of a [`LinearOctree`](super::LinearOctree) directly, which is faster. By
    /// default, this one works itself.
    fn inner(&self) -> Option<&dyn BroadPhase> {
        None
    }

    /// Returns what the structure looks like now.
    fn stats(&self) -> BroadPhaseStats;
}

/// What walks through a [`BroadPhase`]: see [`BroadPhase::traverse`].
pub trait Visitor {
    /// Returns `true` if anything inside `bounds` may be of interest. Objects may stick out of it;
    /// the parts that do are in other groups.
    fn enter(&mut self, bounds: &Aabb3d) -> bool;

    /// An object of an entered group, with its box. An object may come up once in each of several
    /// groups; `cell` is the part of space that this visit speaks for. Cells are half-open,
    /// disjoint and together all of space, so that a point of the object's box lies in the cell of
    /// exactly one of its visits.
    fn object(&mut self, id: ProxyId, aabb: &Aabb3d, cell: &Aabb3d);

    /// Returns the point from which to look, maybe infinitely far away: the walk goes from near
    /// groups to far ones where it can. A hint that no result depends on.
    fn viewpoint(&self) -> Vec3A {
        Vec3A::NEG_INFINITY
    }
}

/// A leaf of a [`BroadPhase`]'s tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Its part of space. Of the N-objects octree, the cell, without the reach to infinity of the
    /// outermost ones; of the linear octree, the bounds of a block of
    /// [skins](super::linear_octree#what-makes-it-fast).
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
    /// Returns how full the leaves are: the mean number of entries per leaf; 0 where there are no
    /// leaves.
    #[must_use]
    pub fn fill(&self) -> f64 {
        self.entries as f64 / self.leaves.max(1) as f64
    }
}
