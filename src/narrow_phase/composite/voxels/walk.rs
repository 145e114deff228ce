//! The tree of voxels, from the root down to boxes of cells.

use bevy::math::{I64Vec3, IVec3, Vec3A};

use super::{
    Voxels,
    brick::{self, FULL},
    faces::Faces,
};
use crate::{
    narrow_phase::composite::box_tree::{Below, BoxTree, Child},
    octree::{NodeId, Vertex},
};

/// A box of full cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// The cell with the lowest numbers.
    pub first: IVec3,
    /// The cell with the highest numbers.
    pub last: IVec3,
    /// The lower corner of the box.
    pub low: Vec3A,
    /// The upper corner.
    pub high: Vec3A,
    /// The faces of the box that are the border of the solid: each as a whole, or no part of it.
    pub faces: Faces,
}

/// A cube of bricks that is not empty.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// `None` within a larger node that is full.
    node: Option<NodeId>,
    /// The lowest brick.
    corner: I64Vec3,
    /// It is as many bricks wide as 2 to the power of this.
    height: u32,
}

impl Voxels {
    fn root(&self) -> Option<Node> {
        (self.len > 0).then_some(Node {
            node: Some(NodeId::ROOT),
            corner: self.corner,
            height: self.height,
        })
    }

    /// The mask of a node that is not split.
    fn mask(&self, node: Node) -> u64 {
        node.node.map_or(FULL, |node| *self.tree.data(node))
    }

    /// The children of a node that is larger than a brick, but for those that are empty.
    fn children(&self, parent: Node) -> impl Iterator<Item = Node> {
        let height = parent.height - 1;
        // One that is full has children that are, though the tree has none.
        let split = parent.node.filter(|node| self.tree.is_split(*node));
        Vertex::ALL.into_iter().filter_map(move |octant| {
            let node = split.and_then(|node| self.tree.child(node, octant));
            let is_empty = |node| self.tree.is_leaf(node) && *self.tree.data(node) == 0;
            if node.is_some_and(is_empty) {
                return None;
            }
            let bits = octant.bits();
            let side = I64Vec3::new(
                (bits & 1).into(),
                (bits >> 1 & 1).into(),
                (bits >> 2).into(),
            );
            Some(Node {
                node,
                corner: parent.corner + (side << height),
                height,
            })
        })
    }

    /// All bricks that are not empty, with their masks.
    pub(super) fn bricks(&self) -> impl Iterator<Item = (IVec3, u64)> {
        let mut stack: Vec<_> = self.root().into_iter().collect();
        std::iter::from_fn(move || {
            loop {
                let node = stack.pop()?;
                if node.height == 0 {
                    return Some((node.corner.as_ivec3(), self.mask(node)));
                }
                let first = stack.len();
                stack.extend(self.children(node));
                stack[first..].reverse();
            }
        })
    }

    /// A node in its box, which is no larger than that of all cells.
    #[inline]
    fn in_box(&self, node: Node, [low, high]: [Vec3A; 2]) -> Child<Node, Cells> {
        Child {
            low: self.place(node.corner << 2).max(low),
            high: self
                .place((node.corner + (1 << node.height)) << 2)
                .min(high),
            below: Below::Node(node),
        }
    }
}

impl BoxTree for Voxels {
    type Node = Node;
    type Leaf = Cells;

    fn top(&self) -> Option<Child<Node, Cells>> {
        Some(self.in_box(self.root()?, self.corners()?))
    }

    #[inline]
    fn for_each_child(&self, node: Node, mut found: impl FnMut(Child<Node, Cells>)) {
        let Some(bounds) = self.corners() else {
            return;
        };
        if node.height > 0 {
            let children = self.children(node);
            return children
                .map(|child| self.in_box(child, bounds))
                .for_each(found);
        }
        let (brick, mask) = (node.corner.as_ivec3(), self.mask(node));
        let exposed = brick::exposed(mask, |face| self.mask_of(brick + face.offset()));
        brick::for_each_box(mask, &exposed, |part| {
            let cell = |of: [u32; 3]| -> IVec3 {
                let [x, y, z] = of.map(|at| at as i32);
                (brick << 2) + IVec3::new(x, y, z)
            };
            let (first, last) = (cell(part.first), cell(part.last));
            let low = self.place(first.as_i64vec3());
            let high = self.place(last.as_i64vec3() + 1);
            let faces = part.faces;
            found(Child {
                low,
                high,
                below: Below::Leaf(Cells {
                    first,
                    last,
                    low,
                    high,
                    faces,
                }),
            });
        });
    }
}
