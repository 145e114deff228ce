//! What comes along a way, and where it first meets something: rays, shapes, two shapes that both move.

mod ray;
mod sweep;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod time_of_impact;
