//! The generic octree.
