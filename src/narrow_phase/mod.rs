//! Exact tests.

#[cfg(feature = "mesh")]
mod bevy_mesh;
mod closest;
mod contact;
mod convex_contact;
mod convex_mesh;
mod decide;
mod edge_polygon;
mod error;
mod oriented_box;
mod pair;
#[cfg(feature = "rapier")]
mod parry;
mod polygon_mesh;
mod separation;
mod shape;
mod stage;
mod surface;
mod topology;
#[cfg(feature = "rapier")]
mod triangulate;
mod workspace;

#[cfg(all(test, feature = "rapier"))]
mod parry_tests;
#[cfg(test)]
mod tests;

pub use contact::Contact;
pub use convex_mesh::ConvexMesh;
pub use decide::{Exactness, NarrowPhase};
pub use error::{BoundsError, ShapeError, ToleranceError};
pub use pair::Placed;
pub use polygon_mesh::PolygonMesh;
pub use shape::Shape;
pub use stage::{Stage, StageCount, StageCounters};
pub use workspace::Workspace;
