//! The generic octree: a tree with an out-degree of eight, the directions of a cubical lattice, and
//! neighbour-finding.
//!
//! An octree divides a cube into eight, some of these into eight again, and so on. What the cubes
//! stand for, what is kept in them and when they are split is decided elsewhere: [`Octree<T>`] is
//! the abstract data type of Swan, *Fast Collision Detection with an N-Objects Octree*, 1994,
//! section 2.1, and knows neither coordinates nor objects. A node's place is its octant in its
//! parent, and a neighbour is found from octants alone.
//!
//! ```
//! use bevy::math::Vec3;
//! use bevy_octree::octree::{Face, Octree, Vertex, directions_toward};
//!
//! // A node for each cell, with a count of the things in it.
//! let mut tree = Octree::new(0_u32);
//! let root = tree.root();
//! tree.split(root);
//! let cell = tree.child(root, Vertex::LDF).unwrap();
//! *tree.data_mut(cell) += 3;
//!
//! // The cells that a thing may enter when it moves up and to the right: seven directions, three
//! // of which lead somewhere; the others leave the root.
//! let ahead = directions_toward(Vec3::new(1.0, 1.0, -1.0));
//! let entered = ahead.iter().filter_map(|&direction| tree.neighbor(cell, direction));
//! assert_eq!(entered.count(), 3);
//!
//! // A node that is split keeps its neighbours, and its children have it as theirs.
//! let right = tree.face_neighbor(cell, Face::R).unwrap();
//! tree.split_with(right, |octant| octant.bits());
//! let small = tree.child(right, Vertex::LUF).unwrap();
//! assert_eq!(tree.face_neighbor(cell, Face::R), Some(right));
//! assert_eq!(tree.face_neighbor(small, Face::L), Some(cell));
//!
//! // Joining hands back what was in the removed nodes.
//! let mut count = 0;
//! tree.join(root, |things| count += things);
//! assert_eq!(count, 3 + (0..8).sum::<u32>());
//! assert_eq!(tree.to_string(), "root leaf 0");
//! ```
//!
//! # The parts
//!
//! [`Direction`] and its kinds [`Face`], [`Edge`] and [`Vertex`] name the 26 directions, and fix
//! the axes: right is +x, up is +y, and front is −z, as in Bevy. A [`Vertex`] is an octant too: the
//! bits of its value say on which side of each axis it lies. [`directions_toward`] quantises a
//! vector to directions.
//!
//! [`Octree`] is an arena. Siblings stand side by side in blocks of eight, and a [`NodeId`] is a
//! block's number and a slot in it, so that a node's octant is a part of its handle and its parent
//! is kept once for all eight. Removed blocks wait in a list to be used again, which makes
//! splitting and joining cheap, and free of allocation in a tree that has been as large before.
//! Nothing recurses: trees may be as deep as memory allows.
//!
//! Neighbour-finding ([`Octree::neighbor`]) works on tables of how a step from an octant crosses
//! the borders of its block ([`Direction::adj`], [`Direction::reflect`], [`Edge::common_face`],
//! [`Vertex::common_face`], [`Vertex::common_edge`]).
//!
//! # Names in the report
//!
//! | report | here |
//! |---|---|
//! | `octDirection` | [`Direction`], with [`Face`], [`Edge`] and [`Vertex`] where only these are meant |
//! | `OMEGA` | [`None`] |
//! | `octNode` | [`NodeId`] |
//! | `octCreate`, `octDispose` | [`Octree::new`], dropping |
//! | `octClear` | [`Octree::clear`], and [`Octree::reset`] for the whole tree |
//! | `octParent`, `octChild`, `octChildType` | [`Octree::parent`], [`Octree::child`], [`Octree::child_type`] |
//! | `octIsSplit` | [`Octree::is_split`], [`Octree::is_leaf`] |
//! | `octSplit`, `octJoin` | [`Octree::split`], [`Octree::join`] |
//! | `octGeneration` | [`Octree::generation`] |
//! | `octData`, `octSwapData` | [`Octree::data`], [`Octree::data_mut`], [`Octree::swap_data`] |
//! | `octInitChildIterator`, `octNextChild` | [`Octree::children`] |
//! | `octPrint` | [`Octree::display`], [`Octree::display_with`], and `Display` of the tree |
//! | `octDirToStr`, `octStrToDir` | `Display` and `FromStr` of the directions |
//! | `octAdj`, `octReflect` | [`Direction::adj`], [`Direction::reflect`] |
//! | `octCommonFace` | [`Edge::common_face`], [`Vertex::common_face`] |
//! | `octCommonEdge` | [`Vertex::common_edge`] |
//! | `octGtEqFaceNeighbor` | [`Octree::face_neighbor`] |
//! | `octGtEqEdgeNeighbor` | [`Octree::edge_neighbor`] |
//! | `octGtEqVertexNeighbor` | [`Octree::vertex_neighbor`] |
//! | `Vector3ToDirection` | [`directions_toward`] |
//! | defensive, efficient implementation | with, without `debug_assertions` |
//!
//! The report's "requires" clauses are types where they can be, such as a [`Face`] where only a
//! face is allowed, and `debug_assert!` where not. [`Octree::grow`] has no counterpart there: it is
//! what lets the root of a tree be replaced by a larger one.

mod direction;
mod display;
mod iter;
mod neighbor;
mod node;
mod quantize;
mod tables;
#[cfg(test)]
mod tests;
mod tree;
mod validate;

pub use direction::{Direction, Edge, Face, ParseDirectionError, Vertex};
pub use iter::{Leaves, Subtree};
pub use node::{Children, NodeId};
pub use quantize::directions_toward;
pub use tree::Octree;
