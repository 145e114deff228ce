//! What comes along a way, and where it first meets something: rays, shapes, two shapes that both
//! move.

mod advance;
mod chord;
mod faces;
mod first_impact;
mod flat_meeting;
mod lift;
mod local_ray;
mod moments;
pub(super) mod moving;
mod nearest_polygon;
mod parting_planes;
mod pass_by;
mod passage;
mod ray;
mod round_chord;
mod sweep;
mod sweep_with;
#[cfg(test)]
pub(super) mod tests;
mod time_of_impact;
mod window;
