//! obvhs' `Bvh2`, maintained as Avian 0.7 maintains its collider trees.
//!
//! Boxes in the tree are 0.05 larger on each side than objects, and stay until an object leaves its
//! own. Where fewer than a tenth do, their leaves are resized one by one, otherwise all nodes are
//! refitted. After the search, the tree is improved for the next frame: leaves that moved are
//! reinserted if they are fewer than 15 %, a part of the tree is rebuilt up to 45 %, and all of it
//! beyond. Pairs are searched for by a query for each object that left its box, and live until that
//! happens again. Avian keeps them in a hash map; here they are a list, which is faster.

use bevy::math::bounding::Aabb3d;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision, rebuild::compute_rebuild_path_flags},
};

use super::{Boxes, Engine, Pair, overlap};

/// Avian's margin, for objects of about a length unit.
const MARGIN: f32 = 0.05;

/// The tree and its tools.
#[derive(Default)]
pub struct Obvhs {
    tree: Bvh2,
    builder: PlocBuilder,
    optimizer: ReinsertionOptimizer,
    flags: Vec<bool>,
    boxes: Boxes,
    enlarged: Vec<Aabb3d>,
    moved: Vec<u32>,
    is_moved: Vec<bool>,
    candidates: Vec<Pair>,
}

/// A box in this library's terms.
pub fn aabb_of(aabb: &Aabb3d) -> Aabb {
    Aabb::new(aabb.min.to_array().into(), aabb.max.to_array().into())
}

fn enlarge(aabb: &Aabb3d) -> Aabb3d {
    Aabb3d {
        min: aabb.min - MARGIN,
        max: aabb.max + MARGIN,
    }
}

impl Obvhs {
    fn build(&mut self, boxes: &[Aabb3d]) {
        self.boxes.0.extend_from_slice(boxes);
        self.enlarged.extend(boxes.iter().map(enlarge));
        self.moved.extend(0..boxes.len() as u32);
        self.is_moved.resize(boxes.len(), true);
        let aabbs: Vec<_> = self.enlarged.iter().map(aabb_of).collect();
        self.tree = self.builder.build(
            PlocSearchDistance::Minimum,
            &aabbs,
            self.moved.clone(),
            SortPrecision::U64,
            0,
        );
        self.tree.init_parents_if_uninit();
        self.tree.init_primitives_to_nodes_if_uninit();
    }

    fn improve(&mut self) {
        let moved = self.moved.len() as f32 / self.boxes.0.len() as f32;
        if moved == 0.0 {
            return;
        }
        let leaves = || {
            self.moved
                .iter()
                .map(|&i| self.tree.primitives_to_nodes[i as usize])
                .collect::<Vec<_>>()
        };
        if moved < 0.15 {
            let leaves = leaves();
            self.optimizer
                .run_with_candidates(&mut self.tree, &leaves, 1);
        } else if moved < 0.45 {
            let leaves = leaves();
            compute_rebuild_path_flags(&self.tree, leaves, &mut self.flags);
            let flags = &self.flags;
            self.builder.partial_rebuild(
                &mut self.tree,
                |node| flags[node],
                PlocSearchDistance::Minimum,
                SortPrecision::U64,
                0,
            );
        } else {
            self.builder.full_rebuild(
                &mut self.tree,
                PlocSearchDistance::Minimum,
                SortPrecision::U64,
                0,
            );
        }
        self.tree.init_parents_if_uninit();
        self.tree.init_primitives_to_nodes_if_uninit();
    }
}

impl Engine for Obvhs {
    fn update(&mut self, boxes: &[Aabb3d]) {
        if self.enlarged.is_empty() {
            self.build(boxes);
            return;
        }
        for i in self.moved.drain(..) {
            self.is_moved[i as usize] = false;
        }
        for (i, (aabb, enlarged)) in boxes.iter().zip(&mut self.enlarged).enumerate() {
            if !(enlarged.min.cmple(aabb.min) & enlarged.max.cmpge(aabb.max)).all() {
                *enlarged = enlarge(aabb);
                self.is_moved[i] = true;
                self.moved.push(i as u32);
            }
        }
        self.boxes.0.copy_from_slice(boxes);
        let one_by_one = self.moved.len() * 10 < boxes.len();
        for &i in &self.moved {
            let (node, aabb) = (
                self.tree.primitives_to_nodes[i as usize] as usize,
                aabb_of(&self.enlarged[i as usize]),
            );
            if one_by_one {
                self.tree.resize_node(node, aabb);
            } else {
                self.tree.nodes[node].set_aabb(aabb);
            }
        }
        if !one_by_one {
            self.tree.refit_all();
        }
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        let Self {
            tree,
            enlarged,
            moved,
            is_moved,
            candidates,
            ..
        } = self;
        candidates.retain(|&(a, b)| !is_moved[a as usize] && !is_moved[b as usize]);
        for &a in moved.iter() {
            tree.aabb_traverse(aabb_of(&enlarged[a as usize]), |tree, node| {
                let node = &tree.nodes[node as usize];
                let first = node.first_index as usize;
                for &b in &tree.primitive_indices[first..first + node.prim_count as usize] {
                    // A pair of two that moved comes up twice.
                    if a != b && !(is_moved[b as usize] && b < a) {
                        candidates.push((a, b));
                    }
                }
                true
            });
        }
        let boxes = &self.boxes.0;
        pairs.extend(
            candidates
                .iter()
                .filter(|&&(a, b)| overlap(&boxes[a as usize], &boxes[b as usize])),
        );
        self.improve();
    }
}
