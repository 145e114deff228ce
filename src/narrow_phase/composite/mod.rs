//! Shapes that are made of many: what they consist of, and the trees by which that is found.
//!
//! | what | its leaves | its tree |
//! |---|---|---|
//! | [`Parts`](parts::Parts), of a compound | shapes, each in its pose | eight boxes to a block, as meshes have it |
//! | [`HeightField`](height_field::HeightField) | triangles | the lowest and highest of tiles, halved level by level |
//! | [`Voxels`](voxels::Voxels) | boxes of full cells | an octree over bricks of 64 cells |
//!
//! Each is a [`BoxTree`](box_tree::BoxTree), and walked by the two functions that are written for
//! all of these: down into whatever a question admits, or near nodes first.

pub(super) mod box_tree;
pub(super) mod height_field;
pub(super) mod parts;
pub(super) mod voxels;
