//! Where, which way and how deep two shapes meet.

mod around;
mod body;
pub(super) mod buffers;
mod claims;
mod convex;
mod facet;
mod features;
mod flush;
mod hull;
mod large_hull;
pub(super) mod manifold;
mod mesh;
mod meshes;
mod passing;
mod patch;
mod place;
mod query;
mod sphere;
mod summit;
mod support;
#[cfg(test)]
mod tests;
