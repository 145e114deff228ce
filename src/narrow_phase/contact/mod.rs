//! Where, which way and how deep two shapes meet.

mod convex;
mod passing;
mod query;
mod sphere;
#[cfg(test)]
mod tests;
