//! Convex shapes as cores with a radius, in 32-bit floats relative to one of two: the first to be
//! asked about a pair.
//!
//! A ball is a point with a radius, a capsule a segment with one. Where two cores are closest to each
//! other tells all about what is within the radii: the verdict, the contact, the closest points. Of
//! points, segments and boxes there is a closed form for that; of all others, their support
//! functions are asked.

mod balls;
mod body;
mod nearest;
mod quick;
mod search;
mod segments;

pub use balls::Balls;
pub use nearest::Closest;
pub use quick::QuickPair;
pub use search::Bodies;

#[cfg(test)]
mod tests;
