//! Shapes of `bevy_rapier3d`: what is asked about a pair in which there is one. One question decides all of it, the distance
//! of the convex shapes that the two consist of.

pub(super) mod cast;
mod convert;
mod convex;
mod gjk;
pub(super) mod own;
mod parts;
pub(super) mod query;
mod triangulate;

#[cfg(test)]
mod tests;
