//! Queries, written once for every broad phase.

mod cast;
mod flow;
mod height;
mod hit;
mod lists;
#[cfg(test)]
mod near_tests;
mod pairs;
mod point_distance;
mod region;
mod scaled_distance;
mod search;
#[cfg(test)]
mod tests;

pub use cast::Cast;
pub(crate) use cast::Sweep;
pub use flow::Flow;
pub(crate) use height::Height;
pub use hit::Hit;
pub use lists::HitLists;
pub(crate) use lists::answer_each;
pub(crate) use pairs::with_gaps;
pub(crate) use region::Overlap;
pub use region::Region;
pub(crate) use scaled_distance::ScaledDistance;
