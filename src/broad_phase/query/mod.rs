//! Queries, written once for every broad phase.

mod cast;
mod flow;
mod hit;
mod pairs;
mod point_distance;
mod region;
mod scaled_distance;
mod search;
#[cfg(test)]
mod tests;

pub use cast::Cast;
pub(super) use cast::Sweep;
pub use flow::Flow;
pub use hit::Hit;
pub use region::Region;
pub(super) use scaled_distance::ScaledDistance;
