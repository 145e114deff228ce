//! Exact tests.

mod contact;
mod convex_mesh;
mod decide;
mod error;
mod oriented_box;
#[cfg(feature = "rapier")]
mod parry;
mod polygon_mesh;
mod separation;
mod shape;
mod stage;
mod topology;
mod workspace;

pub use contact::Contact;
pub use convex_mesh::ConvexMesh;
pub use decide::{Exactness, NarrowPhase, Placed};
pub use error::{BoundsError, ShapeError, ToleranceError};
pub use polygon_mesh::PolygonMesh;
pub use shape::Shape;
pub use stage::{Stage, StageCount, StageCounters};
pub use workspace::Workspace;
