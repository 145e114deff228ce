//! Shapes of `bevy_rapier3d`: what is asked about a pair in which there is one. One question
//! decides all of it, the distance of the convex shapes that the two consist of.
//!
//! What is handed on here is all that the exact tests ask, and what [`absent`](../absent.rs)
//! answers where there is no Rapier.

mod cast;
mod convert;
mod convex;
mod faces;
mod gap;
mod gjk;
mod own;
mod own_contact;
mod own_mesh;
mod parts;
mod probe;
mod query;
mod segment_triangle;
mod triangulate;

#[cfg(test)]
mod tests;

pub use cast::{cast_ray, sweep};
pub use faces::{cast_ray_with, passage};
pub use own::{as_own, with_own, with_own_cuboids};
pub use query::{closest_point, closest_points, contact, enclosed, intersects, is_known, side};
