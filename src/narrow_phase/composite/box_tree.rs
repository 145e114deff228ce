//! Trees of boxes, and how they are walked.

use std::cmp::Ordering;

use bevy::math::Vec3A;
use smallvec::SmallVec;

/// So many nodes may wait to be looked at before memory is allocated for them.
const WAITING: usize = 32;

/// A tree whose nodes are boxes around what is below them, in one space.
pub trait BoxTree {
    /// What names an inner node.
    type Node: Copy;
    /// What is found.
    type Leaf: Copy;

    /// All of it; `None` if there is nothing.
    fn top(&self) -> Option<Child<Self::Node, Self::Leaf>>;

    /// Calls `found` with each child of a node.
    fn for_each_child(&self, node: Self::Node, found: impl FnMut(Child<Self::Node, Self::Leaf>));

    /// Visits all leaves whose boxes are admitted, as are those of all nodes above them; in no
    /// particular order. A node is asked about just before it is entered, so that one who has found
    /// enough may end the walk by admitting nothing more.
    fn walk(
        &self,
        admits: &mut (impl FnMut(Vec3A, Vec3A) -> bool + ?Sized),
        visit: &mut (impl FnMut(Self::Leaf) + ?Sized),
    ) where
        Self: Sized,
    {
        if let Some(top) = self.top() {
            enter(self, top, admits, visit);
        }
    }

    /// Visits leaves, near ones first: of the children of each node, in the order of the distances
    /// that `distance` tells of their boxes. Left out are those of which it tells none, with all
    /// below: it is asked again before a node is entered, if anything was visited in the meantime.
    fn walk_near(
        &self,
        distance: &mut (impl FnMut(Vec3A, Vec3A) -> Option<f32> + ?Sized),
        visit: &mut (impl FnMut(Self::Leaf) + ?Sized),
    ) where
        Self: Sized,
    {
        // Those that wait, the nearest of each family last; when they were asked about.
        let mut waiting: Waiting<Self::Node, Self::Leaf> = SmallVec::new();
        let mut visited = 0;
        if let Some(top) = self.top()
            && let Some(rank) = distance(top.low, top.high)
        {
            waiting.push((rank, visited, top));
        }
        while let Some((_, asked, child)) = waiting.pop() {
            if asked != visited && distance(child.low, child.high).is_none() {
                continue;
            }
            match child.below {
                Below::Leaf(leaf) => {
                    visit(leaf);
                    visited += 1;
                }
                Below::Node(node) => {
                    let first = waiting.len();
                    self.for_each_child(node, |child| {
                        if let Some(rank) = distance(child.low, child.high) {
                            waiting.push((rank, visited, child));
                        }
                    });
                    let far_first = |a: f32, b: f32| b.partial_cmp(&a).unwrap_or(Ordering::Equal);
                    waiting[first..].sort_unstable_by(|a, b| far_first(a.0, b.0));
                }
            }
        }
    }
}

/// A box in a tree, by its corners, and what is in it.
#[derive(Clone, Copy, Debug)]
pub struct Child<N, L> {
    pub low: Vec3A,
    pub high: Vec3A,
    pub below: Below<N, L>,
}

/// What waits to be looked at: how near it is, after how many visits that was told, and what it is.
type Waiting<N, L> = SmallVec<[(f32, u32, Child<N, L>); WAITING]>;

/// What is in a box.
#[derive(Clone, Copy, Debug)]
pub enum Below<N, L> {
    Node(N),
    Leaf(L),
}

fn enter<T: BoxTree>(
    tree: &T,
    child: Child<T::Node, T::Leaf>,
    admits: &mut (impl FnMut(Vec3A, Vec3A) -> bool + ?Sized),
    visit: &mut (impl FnMut(T::Leaf) + ?Sized),
) {
    if !admits(child.low, child.high) {
        return;
    }
    match child.below {
        Below::Leaf(leaf) => visit(leaf),
        Below::Node(node) => {
            tree.for_each_child(node, |child| enter(tree, child, admits, visit));
        }
    }
}
