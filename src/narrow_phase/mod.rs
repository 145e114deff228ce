//! Exact tests.
mod shape;
pub use shape::Shape;
