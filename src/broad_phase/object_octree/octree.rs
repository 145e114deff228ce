//! The N-objects octree as a whole.

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;
use smallvec::SmallVec;

use super::{cell::Cell, list::List, root_cell::RootCell, settings::ObjectOctreeSettings};
use crate::{
    broad_phase::{
        boxes::ProxyId,
        engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
        group::Group,
        pairs::Pair,
        proxy::Proxies,
    },
    octree::{NodeId, Octree, Vertex},
};

/// The report's N-objects octree. See the [module's documentation](super).
#[derive(Debug)]
pub struct ObjectOctree {
    pub(super) settings: ObjectOctreeSettings,
    pub(super) tree: Octree<Cell>,
    /// Laid when the first objects come, forgotten when the last one goes.
    pub(super) root: Option<RootCell>,
    /// By proxy index.
    pub(super) entries: Vec<Entry>,
    /// By proxy index: the last count of distinct objects that saw it.
    pub(super) seen: Vec<u64>,
    /// Counts the objects' turns in maintenance and other walks; marks on cells and objects that
    /// equal it were made in the current one.
    pub(super) turn: u64,
    /// Counts the updates.
    pub(super) ticks: u32,
    /// Leaves that came to list more than N objects, and nodes of which a child lost one: each at
    /// most once.
    pub(super) overfull: Vec<NodeId>,
    pub(super) shrunk: Vec<NodeId>,
    /// All leaves in the order of space, as of the last walk, and whether there have been splits or
    /// merges since.
    pub(super) leaves: Vec<NodeId>,
    pub(super) has_new_shape: bool,
    /// Objects whose leaves may have changed in this tick; some are listed more than once.
    pub(super) restless: Vec<u32>,
    /// Leaves that list so many objects that they are searched in another way.
    pub(super) crowded: Vec<NodeId>,
    /// Emptied lists, for reuse.
    pub(super) spare: Vec<List>,
    /// How much work there has been since it was last seen whether the root fits.
    pub(super) work: u64,
    /// The vector instructions that this machine has.
    pub(super) level: Level,
    /// The objects of a crowded leaf that is searched.
    pub(super) group: Group,
}

/// What the octree knows of one object.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// The leaves that the box overlaps; none for an object that is not in the tree.
    pub(super) leaves: SmallVec<[NodeId; 8]>,
    /// By leaf, of the first eight: where in its list the object was last seen.
    pub(super) hints: [u8; 8],
    /// The number of generations, from the root down, whose cells the object fits in.
    pub(super) levels: u32,
    /// The last update in which it took its turn, in short.
    pub(super) turned: u32,
}

impl Entry {
    pub(super) const ABSENT: Self = Self {
        leaves: SmallVec::new_const(),
        hints: [0; 8],
        levels: 0,
        turned: 0,
    };

    /// Where in the list of its leaf of this number the object may be.
    #[inline]
    pub(super) fn hint(&self, number: usize) -> u8 {
        self.hints.get(number).copied().unwrap_or(u8::MAX)
    }

    /// Notes where in the list of its leaf of this number the object is.
    #[inline]
    pub(super) fn note(&mut self, number: usize, index: usize) {
        if let (Some(hint), Ok(index)) = (self.hints.get_mut(number), u8::try_from(index)) {
            *hint = index;
        }
    }

    /// Adds a leaf, in the list of which the object has this index.
    #[inline]
    pub(super) fn enter(&mut self, leaf: NodeId, index: usize) {
        self.leaves.push(leaf);
        self.note(self.leaves.len() - 1, index);
    }

    /// Takes the leaf of this number away; the last one takes its number.
    #[inline]
    pub(super) fn forget(&mut self, number: usize) {
        let hint = self.hint(self.leaves.len() - 1);
        self.leaves.swap_remove(number);
        self.note(number, usize::from(hint));
    }

    /// Returns `true` if the object counts against N in a cell of this generation.
    #[inline]
    pub(super) const fn counts_in(&self, generation: u32) -> bool {
        generation < self.levels
    }
}

impl ObjectOctree {
    /// Creates an empty octree.
    ///
    /// # Panics
    /// In builds with debug assertions, if the settings do not pass their
    /// [check](ObjectOctreeSettings::check).
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
            ticks: 0,
            overfull: Vec::new(),
            shrunk: Vec::new(),
            leaves: Vec::new(),
            has_new_shape: true,
            restless: Vec::new(),
            crowded: Vec::new(),
            spare: Vec::new(),
            work: 0,
            level: Level::new(),
            group: Group::default(),
        }
    }

    /// Returns the settings.
    #[must_use]
    pub const fn settings(&self) -> &ObjectOctreeSettings {
        &self.settings
    }

    /// Returns the octree itself, to be looked at or printed.
    #[must_use]
    pub const fn tree(&self) -> &Octree<Cell> {
        &self.tree
    }

    /// Returns the root cell as laid, without the reach to infinity; `None` while there are no
    /// objects.
    #[must_use]
    pub fn root_cell(&self) -> Option<Aabb3d> {
        self.root.map(|root| root.bounds())
    }

    /// Returns the leaves that list an object, in no particular order; none if there is no such
    /// object.
    #[must_use]
    pub fn leaves_of(&self, id: ProxyId) -> &[NodeId] {
        self.entries
            .get(id.index())
            .map_or(&[], |entry| &entry.leaves)
    }

    /// A number that no mark has yet.
    pub(super) fn next_turn(&mut self) -> u64 {
        self.turn += 1;
        self.turn
    }

    /// The same objects in a new tree of the same root: what contract 3 compares with.
    pub(super) fn rebuilt(&self, proxies: &Proxies) -> Self {
        let mut other = Self::new(self.settings);
        other.root = self.root;
        other.entries.resize(self.entries.len(), Entry::ABSENT);
        other.plant();
        for (id, aabb) in proxies.iter() {
            other.arrive(id.get(), aabb);
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
        "object"
    }

    fn maintain(&mut self, proxies: &Proxies) {
        self.keep_up(proxies);
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
            for (object, aabb) in cell.list().iter() {
                visitor.object(ProxyId::new(object), &aabb, &bounds);
            }
            // From the octant next to the viewpoint to the opposite one, none before one that may
            // hide it.
            if self.tree.is_leaf(node) {
                continue;
            }
            let near = cell.octant_towards(visitor.viewpoint());
            stack.extend(
                (0..8)
                    .rev()
                    .filter_map(|i| self.tree.child(node, Vertex::from_bits(near.bits() ^ i))),
            );
        }
    }

    fn for_each_leaf(&self, found: &mut dyn FnMut(Leaf)) {
        if self.root.is_none() {
            return;
        }
        for leaf in self.tree.leaves(NodeId::ROOT) {
            let cell = self.tree.data(leaf);
            found(Leaf {
                bounds: cell.cube(),
                generation: cell.generation(),
                objects: cell.listed().len() as u32,
            });
        }
    }

    fn stats(&self) -> BroadPhaseStats {
        let nodes = [&self.overfull, &self.shrunk, &self.leaves, &self.crowded];
        let mut stats = BroadPhaseStats {
            nodes: self.tree.node_count(),
            leaves: self.tree.leaf_count(),
            bytes: self.tree.memory_bytes()
                + self.entries.capacity() * size_of::<Entry>()
                + self.seen.capacity() * size_of::<u64>()
                + nodes.map(Vec::capacity).iter().sum::<usize>() * size_of::<NodeId>()
                + self.restless.capacity() * size_of::<u32>()
                + self.spare.iter().map(List::memory_bytes).sum::<usize>()
                + self.spare.capacity() * size_of::<List>()
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
