//! Where, which way and how deep two shapes meet.

mod body;
pub(super) mod buffers;
mod convex;
mod facet;
mod hull;
mod mesh;
mod passing;
mod patch;
mod place;
mod query;
mod sphere;
#[cfg(test)]
mod tests;
