//! The report's N-objects octree, over moving boxes.
//!
//! A cube of space, the *root*, is divided into eight, and each part again, until no leaf lists more than N objects
//! (Swan 1994, section 2.2, after Shaffer and Herb). An object is listed in every leaf that its box overlaps, so that
//! two boxes overlap only if a leaf lists both. As objects move, they leave leaves and enter others; leaves that come
//! to list more than N objects split, and eight that list no more than N between them merge (section 2.4).
//!
//! ```
//! use bevy::math::{Vec3, bounding::Aabb3d};
//! use bevy_octree::broad_phase::{Method, ObjectOctreeSettings, SpatialIndex};
//!
//! let mut index = SpatialIndex::new(&Method::Octree(ObjectOctreeSettings::with_max_objects(2)));
//! for x in [-4.0, -2.0, 3.0] {
//!     index.insert(Aabb3d::new(Vec3::new(x, 1.0, 1.0), Vec3::splat(0.5)))?;
//! }
//! index.update();
//! assert_eq!(index.stats().nodes, 9); // three objects are more than two: the root has split
//! # Ok::<(), bevy_octree::broad_phase::BoxError>(())
//! ```
//!
//! # What holds
//!
//! 1. **Tiling.** Leaves tile space. A cell holds its lower borders and not its upper ones; the outermost cells reach
//!    to infinity, so that no box is ever outside, and an object is listed in exactly the leaves that its box overlaps.
//! 2. **N objects.** A leaf lists at most N objects unless it is at the depth limit. The limit is a
//!    [generation](ObjectOctreeSettings::max_depth), and the objects' own size: a cell is at its limit for an object
//!    that is larger than the cell (by its longest side), for splitting it would only list that object again in most of
//!    its children. Such objects are listed, and not counted. Without this rule, N + 1 boxes in one spot would split
//!    every cell along their borders down to the last generation, and memory would not be linear.
//! 3. **Canonical shape.** After an update the tree equals, node for node, the tree built from scratch over the same
//!    boxes and root (with a [merge slack](ObjectOctreeSettings::merge_slack) of 0): a node is split if, and only if,
//!    it is above the depth limit and more than N objects that fit in it overlap it.
//! 4. **The root.** It starts as 150 % of the bounding box of all objects and doubles toward an object that leaves it. When
//!    searches and maintenance have cost far more than a look at all objects, it is seen whether it still fits: where it is
//!    four times as large as the objects need or more, or may not double any more and leaves out more than one in eight,
//!    it is laid anew. So neither does an excursion spoil it for good, nor is it laid anew at each step across its border.
//!
//! [`ObjectOctree::assert_well_formed`] checks the first three.
//!
//! # Cost
//!
//! An update looks at the objects that moved and at no others. One comparison of a box with its *stay region*, the
//! region within which its list of leaves cannot change, spares most of them any further work. Those that are left
//! visit their leaves, and whatever is below the lowest node that holds all of the box. A node is looked at for a merge
//! only when so many objects have left its leaves that it may have to. Pairs are searched for in leaves that list an
//! object that moved; its box is compared with eight others at a time.
//!
//! A leaf lists at most N objects that fit in it, and beside them every larger one that overlaps it, or all that share a
//! cell at the depth limit: rods side by side, plates upon plates, and scenes of which the root is more than
//! 2^[`max_depth`](ObjectOctreeSettings::max_depth) times as large as what is in them are not told apart by cells. Where 512
//! objects or more that move share a leaf, they are therefore put in order before they are compared, as in the linear
//! octree: a leaf of n objects takes O(n log n) and its pairs, not n². Lists take memory for each leaf that an object
//! overlaps: at most eight for one that is smaller than the leaves around it; a large one is listed in each of the small
//! leaves that smaller objects have brought about within it. Pairs that filters rule out take none.
//!
//! # When to use it
//!
//! For its shape: leaves tile space, and how deep they lie says where objects crowd, whatever the history; with
//! [`tree`](ObjectOctree::tree) and [`leaves_of`](ObjectOctree::leaves_of) that is a map to build on. For speed, prefer
//! the [linear octree](super::LinearOctree): on scenes in which all objects move this one takes about twice its time at
//! 8 000 objects and three to four times at 64 000, for it reads boxes and leaves in no order of memory. Where one object in ten moves,
//! both execute as many instructions, and this one still takes about twice the time.

mod cell;
mod maintain;
mod pairs;
mod restructure;
mod root;
mod settings;
mod stay;
mod validate;

#[cfg(test)]
mod tests;

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;
use smallvec::SmallVec;

use super::{BroadPhase, BroadPhaseStats, Leaf, Pair, Proxies, ProxyId, Visitor, group::Group};
use crate::octree::{NodeId, Octree, Vertex};
pub use cell::Cell;
use root::RootCell;
pub use settings::{ObjectOctreeSettings, RootPolicy, SettingsError};
use stay::StayRegion;

/// The report's N-objects octree. See the [module's documentation](self).
#[derive(Debug)]
pub struct ObjectOctree {
    settings: ObjectOctreeSettings,
    tree: Octree<Cell>,
    /// Laid when the first objects come, forgotten when the last one goes.
    root: Option<RootCell>,
    /// By proxy index.
    entries: Vec<Entry>,
    /// By proxy index: the last count of distinct objects that saw it.
    seen: Vec<u64>,
    /// Counts the objects' turns in maintenance and other walks; marks on cells and objects that equal it were made
    /// in the current one.
    turn: u64,
    /// Leaves that came to list more than N objects, and nodes of which a child lost one: each at most once.
    overfull: Vec<NodeId>,
    shrunk: Vec<NodeId>,
    /// Objects whose list of leaves changed.
    unsettled: Vec<u32>,
    /// Emptied lists, for reuse.
    spare: Vec<Vec<u32>>,
    /// How much work there has been since it was last seen whether the root fits.
    work: u64,
    /// The vector instructions that this machine has.
    level: Level,
    /// The objects of the leaf that is searched.
    group: Group,
}

/// What the octree knows of one object.
#[derive(Clone, Debug)]
struct Entry {
    /// The box at the last update.
    aabb: Aabb3d,
    /// Where the box may go without a change of `leaves`.
    stay: StayRegion,
    /// The leaves that the box overlaps; none for an object that is not in the tree.
    leaves: SmallVec<[NodeId; 8]>,
    /// The number of generations, from the root down, whose cells the object fits in.
    levels: u32,
    /// Is it in [`ObjectOctree::unsettled`]?
    unsettled: bool,
}

impl Entry {
    const ABSENT: Self = Self {
        aabb: super::EVERYWHERE,
        stay: StayRegion::NOWHERE,
        leaves: SmallVec::new_const(),
        levels: 0,
        unsettled: false,
    };

    /// Does the object count against N in a cell of this generation?
    #[inline]
    const fn counts_in(&self, generation: u32) -> bool {
        generation < self.levels
    }
}

impl ObjectOctree {
    /// An empty octree.
    ///
    /// # Panics
    /// In builds with debug assertions, if the settings do not pass their [check](ObjectOctreeSettings::check).
    #[must_use]
    pub fn new(settings: ObjectOctreeSettings) -> Self {
        debug_assert_eq!(settings.check(), Ok(()));
        Self {
            settings,
            tree: Octree::new(Cell::default()),
            root: None,
            entries: Vec::new(),
            seen: Vec::new(),
            turn: 0,
            overfull: Vec::new(),
            shrunk: Vec::new(),
            unsettled: Vec::new(),
            spare: Vec::new(),
            work: 0,
            level: Level::new(),
            group: Group::default(),
        }
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &ObjectOctreeSettings {
        &self.settings
    }

    /// The octree itself, to be looked at or printed.
    #[must_use]
    pub const fn tree(&self) -> &Octree<Cell> {
        &self.tree
    }

    /// The root cell as laid, without the reach to infinity; `None` while there are no objects.
    #[must_use]
    pub fn root_cell(&self) -> Option<Aabb3d> {
        self.root.map(|root| root.bounds())
    }

    /// The leaves that list an object, in no particular order; none if there is no such object.
    #[must_use]
    pub fn leaves_of(&self, id: ProxyId) -> &[NodeId] {
        self.entries.get(id.index()).map_or(&[], |entry| &entry.leaves)
    }

    /// A number that no mark has yet.
    fn next_turn(&mut self) -> u64 {
        self.turn += 1;
        self.turn
    }

    /// The same objects in a new tree of the same root: what contract 3 compares with.
    fn rebuilt(&self) -> Self {
        let mut other = Self::new(self.settings);
        other.root = self.root;
        other.entries.resize(self.entries.len(), Entry::ABSENT);
        other.plant();
        for (index, entry) in self.entries.iter().enumerate() {
            if !entry.leaves.is_empty() {
                other.arrive(index as u32, &entry.aabb);
            }
        }
        other.restructure();
        other
    }
}

impl Default for ObjectOctree {
    fn default() -> Self {
        Self::new(ObjectOctreeSettings::default())
    }
}

impl BroadPhase for ObjectOctree {
    fn name(&self) -> &'static str {
        "octree"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.take_up(proxies);
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        let compared = self.search_leaves(proxies, pairs);
        self.work += compared;
        compared
    }

    fn asks_filters(&self) -> bool {
        true
    }

    fn traverse(&self, _: &Proxies, visitor: &mut dyn Visitor) {
        let mut stack: SmallVec<[NodeId; 64]> = SmallVec::new();
        stack.push(NodeId::ROOT);
        while let Some(node) = stack.pop() {
            let cell = self.tree.data(node);
            let bounds = cell.bounds();
            if !visitor.enter(&bounds) {
                continue;
            }
            for &object in cell.listed() {
                visitor.object(ProxyId::new(object), &self.entries[object as usize].aabb, &bounds);
            }
            // From the octant next to the viewpoint to the opposite one, none before one that may hide it.
            if self.tree.is_leaf(node) {
                continue;
            }
            let near = cell.octant_towards(visitor.viewpoint());
            stack.extend((0..8).rev().filter_map(|i| self.tree.child(node, Vertex::from_bits(near.bits() ^ i))));
        }
    }

    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        if self.root.is_none() {
            return;
        }
        for leaf in self.tree.leaves(NodeId::ROOT) {
            let cell = self.tree.data(leaf);
            found(Leaf { bounds: cell.cube(), generation: cell.generation(), objects: cell.listed().len() as u32 });
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        let queues = self.overfull.capacity() + self.shrunk.capacity();
        let mut stats = BroadPhaseStats {
            nodes: self.tree.node_count(),
            leaves: self.tree.leaf_count(),
            bytes: self.tree.memory_bytes()
                + self.entries.capacity() * size_of::<Entry>()
                + self.seen.capacity() * size_of::<u64>()
                + queues * size_of::<NodeId>()
                + (self.unsettled.capacity() + self.spare.iter().map(Vec::capacity).sum::<usize>()) * size_of::<u32>()
                + self.spare.capacity() * size_of::<Vec<u32>>()
                + self.group.memory_bytes(),
            ..BroadPhaseStats::default()
        };
        for node in self.tree.subtree(NodeId::ROOT) {
            let cell = self.tree.data(node);
            stats.depth = stats.depth.max(cell.generation());
            stats.entries += cell.listed().len();
            stats.bytes += cell.memory_bytes();
        }
        for entry in &self.entries {
            if entry.leaves.spilled() {
                stats.bytes += entry.leaves.capacity() * size_of::<NodeId>();
            }
        }
        stats
    }
}
