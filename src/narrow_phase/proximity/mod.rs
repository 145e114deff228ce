//! How far shapes are apart, and where they are closest.

mod boxes;
mod polygons;
mod query;
#[cfg(test)]
mod tests;

pub use query::local_points;
