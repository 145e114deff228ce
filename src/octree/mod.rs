//! The generic octree.

pub mod direction;
mod iter;
pub mod tree;
mod validate;

pub use direction::{Direction, Edge, Face, ParseDirectionError, Vertex};
pub use iter::{Children, Leaves, Subtree};
pub use tree::{NodeId, Octree};
