//! The N-objects octree as a whole.

use bevy::math::bounding::Aabb3d;
use fearless_simd::Level;
use smallvec::SmallVec;

use super::{
    cell::Cell,
    root_cell::RootCell,
    settings::{ObjectOctreeSettings, PairSearch},
    stay::StayRegion,
};
use crate::{
    broad_phase::{
        boxes::ProxyId,
        engine::{BroadPhase, BroadPhaseStats, Leaf, Visitor},
        group::Group,
        level,
        linear_octree::LinearOctree,
        pairs::Pair,
        proxy::Proxies,
    },
    octree::{NodeId, Octree, Vertex},
};

/// The report's N-objects octree. See the [module's documentation](super).
#[doc(alias("octree", "quadtree"))]
#[derive(Debug)]
pub struct ObjectOctree {
    pub(super) settings: ObjectOctreeSettings,
    pub(super) tree: Octree<Cell>,
    /// Laid when the first objects come, forgotten when the last one goes.
    pub(super) root: Option<RootCell>,
    /// By proxy index.
    pub(super) entries: Vec<Entry>,
    /// By proxy index: where the box may go without a change of its leaves.
    pub(super) stays: Vec<StayRegion>,
    /// By proxy index: the number of generations, from the root down, whose cells the object fits
    /// in. In a cell of one of these, it counts against N.
    pub(super) levels: Vec<u8>,
    /// Objects that left their stay regions in this tick, or are new.
    pub(super) restless: Vec<u32>,
    /// By proxy index: the last count of distinct objects that saw it.
    pub(super) seen: Vec<u64>,
    /// Counts the objects' turns in maintenance and other walks; marks on cells and objects that
    /// equal it were made in the current one.
    pub(super) turn: u64,
    /// Leaves that came to list more than N objects, and nodes of which a child lost one: each at
    /// most once.
    pub(super) overfull: Vec<NodeId>,
    pub(super) shrunk: Vec<NodeId>,
    /// Objects whose list of leaves changed.
    pub(super) unsettled: Vec<u32>,
    /// Emptied lists, for reuse.
    pub(super) spare: Vec<Vec<u32>>,
    /// How much work there has been since it was last seen whether the root fits.
    pub(super) work: u64,
    /// What is searched for pairs, and by queries, unless leaves are.
    pub(super) blocks: Option<LinearOctree>,
    /// The vector instructions that this machine has.
    pub(super) level: Level,
    /// The objects of the leaf that is searched.
    pub(super) group: Group,
}

/// What the octree knows of one object.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// The leaves that the box overlaps; none for an object that is not in the tree.
    pub(super) leaves: SmallVec<[NodeId; 8]>,
    /// Is it in [`ObjectOctree::unsettled`]?
    pub(super) unsettled: bool,
}

impl Entry {
    pub(super) const ABSENT: Self = Self {
        leaves: SmallVec::new_const(),
        unsettled: false,
    };
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
            stays: Vec::new(),
            levels: Vec::new(),
            restless: Vec::new(),
            seen: Vec::new(),
            turn: 0,
            overfull: Vec::new(),
            shrunk: Vec::new(),
            unsettled: Vec::new(),
            spare: Vec::new(),
            work: 0,
            blocks: match settings.search {
                PairSearch::Blocks => Some(LinearOctree::default()),
                PairSearch::Leaves => None,
            },
            level: level::best(),
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
        let mut other = Self::new(ObjectOctreeSettings {
            search: PairSearch::Leaves,
            ..self.settings
        });
        other.root = self.root;
        other.make_room(proxies);
        other.plant();
        for (id, aabb) in proxies.iter() {
            other.arrive(id.get(), aabb);
        }
        other.restructure(proxies.boxes());
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
        if let Some(blocks) = &mut self.blocks {
            blocks.maintain(proxies);
        }
        self.keep_up(proxies);
    }

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        if let Some(blocks) = &mut self.blocks {
            return blocks.find_pairs(proxies, pairs);
        }
        let compared = self.search_leaves(proxies, pairs);
        self.work += compared;
        compared
    }

    fn asks_filters(&self) -> bool {
        true
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        let mut stack: SmallVec<[NodeId; 64]> = SmallVec::new();
        stack.push(NodeId::ROOT);
        while let Some(node) = stack.pop() {
            let cell = self.tree.data(node);
            let bounds = cell.bounds();
            if !visitor.enter(&bounds) {
                continue;
            }
            for &object in cell.listed() {
                visitor.object(
                    ProxyId::new(object),
                    &proxies.boxes()[object as usize],
                    &bounds,
                );
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

    fn inner(&self) -> Option<&dyn BroadPhase> {
        self.blocks
            .as_ref()
            .map(|blocks| -> &dyn BroadPhase { blocks })
    }

    fn stats(&self) -> BroadPhaseStats {
        let queues = self.overfull.capacity() + self.shrunk.capacity();
        let mut stats = BroadPhaseStats {
            nodes: self.tree.node_count(),
            leaves: self.tree.leaf_count(),
            bytes: self.tree.memory_bytes()
                + self.entries.capacity() * size_of::<Entry>()
                + self.stays.capacity() * size_of::<StayRegion>()
                + self.levels.capacity()
                + self.seen.capacity() * size_of::<u64>()
                + queues * size_of::<NodeId>()
                + self.restless.capacity() * size_of::<u32>()
                + (self.unsettled.capacity() + self.spare.iter().map(Vec::capacity).sum::<usize>())
                    * size_of::<u32>()
                + self.spare.capacity() * size_of::<Vec<u32>>()
                + self.group.memory_bytes()
                + self
                    .blocks
                    .as_ref()
                    .map_or(0, |blocks| blocks.stats().bytes),
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
