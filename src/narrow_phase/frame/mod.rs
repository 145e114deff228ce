//! Two placed shapes in a frame of their own, and what is computed in it.

pub(super) mod apart;
pub(super) mod approach;
pub(super) mod case;
pub(super) mod chord;
pub(super) mod closest;
pub(super) mod common_point;
pub(super) mod cuboid_mesh;
pub(super) mod cuboid_triangle;
pub(super) mod edge_polygon;
pub(super) mod local_aabb;
pub(super) mod memory;
pub(super) mod near_faces;
pub(super) mod near_point;
pub(super) mod near_triangles;
pub(super) mod oriented_box;
pub(super) mod outward;
pub(super) mod placed;
pub(super) mod placing;
pub(super) mod separation;
pub(super) mod smaller;
pub(super) mod solid;
pub(super) mod surface;
pub(super) mod two_solids;
pub(super) mod workspace;
