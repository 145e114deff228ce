//! parry's `Bvh`.
//!
//! The incremental engine follows the recipe of rapier's broad phase, the tree's main user, without
//! what a physics engine needs and a list of pairs does not (hash maps, adjacency lists, events):
//!
//! - where fewer than one box in sixteen changed, leaves are reinserted and only their ancestors
//!   refitted;
//! - otherwise leaves are updated in place, one step of incremental optimisation follows, and a
//!   refit of all nodes, which also puts them into depth-first order;
//! - the tree is traversed against itself with change detection, which gives the pairs with a leaf
//!   that changed; those without one are kept from the last frame.
//!
//! On several threads, nodes are refitted and the tree is traversed by parry's parallel versions of
//! these, as rapier does.
//!
//! It runs with the skin that rapier gives to leaves, 4 % of a length unit, and with next to none:
//! a skin saves updates where things are slow, and costs candidates otherwise. (A skin of exactly 0
//! turns change detection off.)

use bevy::math::bounding::Aabb3d;
use parry3d::{
    bounding_volume::Aabb,
    partitioning::{Bvh, BvhBuildStrategy, BvhLeafUpdateStatus, BvhWorkspace},
};

use super::{Boxes, Engine, Pair};

/// As good as none, but not zero.
pub const NO_SKIN: f32 = 1e-30;
/// Rapier's, for objects of about a length unit.
pub const SKIN: f32 = 0.04;

/// Fewer changes than one leaf in so many are taken up leaf by leaf: rapier's figure.
const FEW: usize = 16;

/// A box in this library's terms.
pub fn aabb_of(aabb: &Aabb3d) -> Aabb {
    Aabb {
        mins: aabb.min.to_array().into(),
        maxs: aabb.max.to_array().into(),
    }
}

/// Brings all nodes up to date, on all threads.
fn refit(tree: &mut Bvh, workspace: &mut BvhWorkspace) {
    #[cfg(feature = "parallel")]
    if rayon::current_num_threads() > 1 {
        return tree.refit_parallel(workspace);
    }
    tree.refit(workspace);
}

/// Calls `found` with each pair of leaves that overlap, of which one changed if that is asked for.
/// The tree is traversed on all threads.
fn for_each_pair<const CHANGED: bool>(
    tree: &Bvh,
    workspace: &mut BvhWorkspace,
    found: &mut impl FnMut(u32, u32),
) {
    #[cfg(feature = "parallel")]
    if rayon::current_num_threads() > 1 {
        let pairs = tree.traverse_bvtt_single_tree_parallel::<CHANGED>();
        return pairs.into_iter().for_each(|(a, b)| found(a, b));
    }
    tree.traverse_bvtt_single_tree::<CHANGED>(workspace, found);
}

/// The tree is maintained from frame to frame.
pub struct Incremental {
    skin: f32,
    tree: Bvh,
    workspace: BvhWorkspace,
    boxes: Boxes,
    changes: Vec<(u32, Aabb)>,
    updated: Vec<u32>,
    updated_before: Vec<u32>,
    is_updated: Vec<bool>,
    candidates: Vec<Pair>,
}

impl Incremental {
    /// An empty tree with this skin around its leaves.
    pub fn new(skin: f32) -> Self {
        Self {
            skin,
            tree: Bvh::new(),
            workspace: BvhWorkspace::default(),
            boxes: Boxes::default(),
            changes: vec![],
            updated: vec![],
            updated_before: vec![],
            is_updated: vec![],
            candidates: vec![],
        }
    }

    fn build(&mut self, boxes: &[Aabb3d]) {
        self.tree = Bvh::new();
        for (i, aabb) in boxes.iter().enumerate() {
            self.tree
                .insert_or_update_partially(aabb_of(aabb), i as u32, self.skin);
            self.updated.push(i as u32);
        }
        self.is_updated.resize(boxes.len(), true);
        self.tree
            .rebuild(&mut self.workspace, BvhBuildStrategy::Binned);
        self.tree.refit(&mut self.workspace);
    }
}

impl Engine for Incremental {
    fn update(&mut self, boxes: &[Aabb3d]) {
        for &leaf in &self.updated {
            self.is_updated[leaf as usize] = false;
        }
        std::mem::swap(&mut self.updated, &mut self.updated_before);
        self.updated.clear();

        let first = self.is_updated.is_empty();
        self.changes.clear();
        self.boxes
            .take(boxes, |i, aabb| self.changes.push((i, aabb_of(aabb))));
        if first {
            self.build(boxes);
            return;
        }
        let few = |leaves: usize| leaves * FEW < boxes.len();
        let one_by_one = few(self.changes.len());
        for &(i, aabb) in &self.changes {
            let status = if one_by_one {
                self.tree
                    .reinsert_or_update_with_change_detection(aabb, i, self.skin)
            } else {
                self.tree.insert_or_update_partially(aabb, i, self.skin)
            };
            if status != BvhLeafUpdateStatus::Unchanged {
                self.updated.push(i);
                self.is_updated[i as usize] = true;
            }
        }
        if one_by_one && few(self.updated.len() + self.updated_before.len()) {
            self.tree.refit_partial(&self.updated_before, &self.updated);
        } else {
            if !one_by_one && !self.updated.is_empty() {
                self.tree.optimize_incremental(&mut self.workspace);
            }
            refit(&mut self.tree, &mut self.workspace);
        }
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        let Self {
            tree,
            workspace,
            boxes,
            is_updated,
            candidates,
            ..
        } = self;
        candidates.retain(|&(a, b)| !is_updated[a as usize] && !is_updated[b as usize]);
        for &(a, b) in candidates.iter() {
            if boxes.overlap(a, b) {
                pairs.push((a, b));
            }
        }
        for_each_pair::<true>(tree, workspace, &mut |a, b| {
            candidates.push((a, b));
            if boxes.overlap(a, b) {
                pairs.push((a, b));
            }
        });
    }
}

/// The tree is built anew each frame, by binning.
#[derive(Default)]
pub struct Rebuilt {
    tree: Bvh,
    workspace: BvhWorkspace,
    objects: usize,
}

impl Engine for Rebuilt {
    fn update(&mut self, boxes: &[Aabb3d]) {
        for (i, aabb) in boxes.iter().enumerate() {
            self.tree
                .insert_or_update_partially(aabb_of(aabb), i as u32, 0.0);
        }
        self.objects = boxes.len();
        self.tree
            .rebuild(&mut self.workspace, BvhBuildStrategy::Binned);
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        // Leaves are exact, so that no pair needs a filter.
        for_each_pair::<false>(&self.tree, &mut self.workspace, &mut |a, b| {
            pairs.push((a, b));
        });
    }
}
