//! How far two convex shapes are apart, by the algorithm of Gilbert, Johnson and Keerthi (*A Fast
//! Procedure for Computing the Distance between Complex Objects*, 1988), and how deep they are in
//! each other, by an expanding polytope (van den Bergen, *Proximity Queries and Penetration Depth
//! Computation on 3D Game Objects*, 2001).
//!
//! Both look at the difference of two shapes, the set of all ways from a point of the second to one
//! of the first: how far it is from the origin, and how deep the origin is inside. Whatever is found
//! is certain to its bounds: a plane with all of the difference beyond says that the two are apart,
//! and by how much. The search for the distance is the same in both precisions.

mod common_point;
mod distance;
mod expansion;
mod simplex;
mod vector;

pub use common_point::common_point;
pub use distance::{Found, search};
pub use expansion::{Overlap, Polytope, expand};
pub use simplex::{Simplex, Vertex};
