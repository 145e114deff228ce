//! Shapes by their support functions, and what consists of such: what is asked about a pair in which
//! there is one. One question decides all of it, the distance of the convex shapes that the two
//! consist of.
//!
//! A convex shape is a core, of which no more is known than how far it reaches along a direction,
//! and a radius around it. What is not convex is taken apart, by a tree of its own.

mod cast;
mod convex;
mod faces;
#[cfg(feature = "rapier")]
mod foreign;
#[cfg(not(feature = "rapier"))]
#[path = "foreign/absent.rs"]
mod foreign;
#[cfg(feature = "rapier")]
mod foreign_core;
#[cfg(not(feature = "rapier"))]
#[path = "foreign_core/absent.rs"]
mod foreign_core;
mod gap;
mod gjk;
mod mesh_contact;
mod near_parts;
mod own;
mod pairs;
mod parts;
mod posed;
mod posed_mesh;
mod probe;
mod query;
mod segment_triangle;
mod triangulate;

#[cfg(all(test, feature = "rapier"))]
mod tests;

pub use cast::{cast_ray, sweep};
pub use convex::feature::{Feature, FeatureKind};
pub use faces::{cast_ray_with, passage};
pub use near_parts::{NearPart, each_two, smaller_size};
pub use own::{as_own, with_own};
pub use query::{closest_point, closest_points, contact, enclosed, intersects, is_known, side};
