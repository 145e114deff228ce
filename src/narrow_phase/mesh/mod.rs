//! Meshes of polygons, as the exact tests hold them.

#[cfg(feature = "mesh")]
pub(super) mod bevy_mesh;
mod convex_hull;
pub(super) mod convex_mesh;
pub(super) mod corners;
pub(super) mod cube;
mod duplicates;
mod edges;
mod junctions;
mod normal;
pub(super) mod polygon_mesh;
mod polygons;
mod quickhull;
mod solids;
pub(super) mod topology;
mod tree_boxes;
#[cfg(any(feature = "mesh", test))]
mod weld;
