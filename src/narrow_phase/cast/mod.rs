//! What comes along a way, and where it first meets something: rays, shapes, two shapes that both
//! move.

mod advance;
mod first_impact;
mod moments;
pub(super) mod moving;
mod ray;
mod sweep;
#[cfg(test)]
pub(super) mod tests;
mod time_of_impact;
