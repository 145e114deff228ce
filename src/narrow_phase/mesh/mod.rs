//! Meshes of polygons, as the exact tests hold them.

#[cfg(feature = "mesh")]
mod bevy_mesh;
pub(super) mod convex_mesh;
pub(super) mod cube;
pub(super) mod polygon_mesh;
pub(super) mod topology;
