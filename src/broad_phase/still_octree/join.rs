//! Two trees at once: which boxes of the one are near which of the other.

use std::{borrow::Cow, ops::ControlFlow};

use bevy::math::{Vec3A, bounding::Aabb3d};
use fearless_simd::{Level, dispatch, prelude::*};

use super::StillOctree;
use crate::broad_phase::{
    block::{Block, WIDTH},
    measure::Measure,
};

/// A part of a tree, by its number on its height: a box at height 0, a block of what is below at
/// all others.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    height: u32,
    index: u32,
}

/// A part of each tree that may be near the other.
#[derive(Clone, Copy, Debug)]
struct Task {
    nearness: f32,
    nodes: [Node; 2],
}

/// The pairs of parts that wait, the next one last: memory that outlives a join.
#[derive(Clone, Debug, Default)]
pub(crate) struct JoinStack(Vec<Task>);

/// How many times as large as the other a part has to be for it alone to be looked into.
const LARGER: f32 = 2.0;

impl StillOctree {
    /// Calls `visit` with the indices of each box of this tree and each of another that are within
    /// the limit of each other, and their distance, near ones first if the measure has an order; it
    /// tells the limit from then on.
    ///
    /// `place` puts a box of this tree into the space of the other, and `measure` makes of it what
    /// is asked there: both grow with their box.
    #[inline]
    pub(crate) fn join<M: Measure>(
        &self,
        other: &Self,
        stack: &mut JoinStack,
        limit: f32,
        place: impl Fn(&Aabb3d) -> Aabb3d,
        measure: impl Fn(&Aabb3d) -> M,
        visit: impl FnMut(u32, u32, f32) -> ControlFlow<(), f32>,
    ) {
        let join = Join {
            trees: [self, other],
            tasks: &mut stack.0,
            limit,
            place,
            measure,
            visit,
        };
        join.run(self.level);
    }

    fn root(&self) -> Node {
        Node {
            height: self.levels.height(),
            index: 0,
        }
    }

    /// The bounds of a part.
    #[inline(always)]
    fn bounds(&self, node: Node) -> Aabb3d {
        if node.height == self.levels.height() {
            return self.block(node).bounds();
        }
        let (above, lane) = (node.index as usize / WIDTH, node.index as usize % WIDTH);
        match self.triangles.get(above) {
            Some(triangles) if node.height == 0 => triangles.get(lane),
            _ => self.levels.as_slice()[node.height as usize][above].get(lane),
        }
    }

    /// What is below a part that is no box.
    #[inline(always)]
    fn block(&self, node: Node) -> Cow<'_, Block> {
        if node.height == 1
            && let Some(boxes) = self.boxes_of_triangles(node.index)
        {
            return Cow::Owned(boxes);
        }
        Cow::Borrowed(&self.levels.as_slice()[node.height as usize - 1][node.index as usize])
    }
}

struct Join<'a, P, F, V> {
    trees: [&'a StillOctree; 2],
    tasks: &'a mut Vec<Task>,
    limit: f32,
    place: P,
    measure: F,
    visit: V,
}

impl<M, P, F, V> Join<'_, P, F, V>
where
    M: Measure,
    P: Fn(&Aabb3d) -> Aabb3d,
    F: Fn(&Aabb3d) -> M,
    V: FnMut(u32, u32, f32) -> ControlFlow<(), f32>,
{
    fn run(mut self, level: Level) {
        let [one, other] = self.trees;
        let whole = (self.measure)(&(self.place)(&one.bounds(one.root())));
        self.tasks.clear();
        self.tasks.push(Task {
            nearness: 0.0,
            nodes: [one.root(), other.root()],
        });
        dispatch!(level, simd => {
            while let Some(task) = self.tasks.pop() {
                if M::ORDERED && whole.bound(self.limit).excludes(task.nearness) {
                    continue;
                }
                if self.step(simd, task).is_break() {
                    return;
                }
            }
        });
    }

    /// Looks into one part of a pair, or into both.
    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, Task { nodes, .. }: Task) -> ControlFlow<()> {
        let [one, other] = nodes;
        let [tree, other_tree] = self.trees;
        let own = (self.place)(&tree.bounds(one));
        let bounds = other_tree.bounds(other);
        if one.height == 0 && other.height == 0 {
            let Some(distance) = (self.measure)(&own).test_box(&bounds, self.limit) else {
                return ControlFlow::Continue(());
            };
            let [a, b] = [(tree, one), (other_tree, other)]
                .map(|(tree, node)| tree.owners[node.index as usize]);
            self.limit = (self.visit)(a, b, distance)?;
            return ControlFlow::Continue(());
        }
        let [size, other_size] = [&own, &bounds].map(extent);
        let only_other = one.height == 0 || (other.height > 0 && other_size > LARGER * size);
        let only_one = other.height == 0 || (one.height > 0 && size > LARGER * other_size);
        let start = self.tasks.len();
        if only_other {
            self.meet(simd, one, &own, other, true);
        } else {
            let block = tree.block(one);
            for lane in 0..WIDTH {
                let child = block.get(lane);
                if child.min.x <= child.max.x {
                    let node = Node {
                        height: one.height - 1,
                        index: one.index * WIDTH as u32 + lane as u32,
                    };
                    self.meet(simd, node, &(self.place)(&child), other, !only_one);
                }
            }
        }
        if M::ORDERED {
            let found = &mut self.tasks[start..];
            found.sort_unstable_by(|a, b| b.nearness.total_cmp(&a.nearness));
        }
        ControlFlow::Continue(())
    }

    /// Has a part of the first tree, which is placed, wait with a part of the other, or with what
    /// that one consists of.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S, one: Node, placed: &Aabb3d, other: Node, into: bool) {
        let measure = (self.measure)(placed);
        let bound = measure.bound(self.limit);
        let tree = self.trees[1];
        if !into {
            if let Some(distance) = measure.test_box(&tree.bounds(other), self.limit) {
                self.tasks.push(Task {
                    // The same unit as that of blocks.
                    nearness: measure.bound(distance).0,
                    nodes: [one, other],
                });
            }
            return;
        }
        let block = tree.block(other);
        let (mut hits, nearness) = measure.test_block(simd, &block, bound);
        while hits != 0 {
            let lane = hits.trailing_zeros();
            hits &= hits - 1;
            self.tasks.push(Task {
                nearness: nearness[lane as usize],
                nodes: [
                    one,
                    Node {
                        height: other.height - 1,
                        index: other.index * WIDTH as u32 + lane,
                    },
                ],
            });
        }
    }
}

fn extent(aabb: &Aabb3d) -> f32 {
    (aabb.max - aabb.min).dot(Vec3A::ONE)
}
