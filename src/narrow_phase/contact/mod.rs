//! Where, which way and how deep two shapes meet.

mod convex;
mod passing;
mod query;
#[cfg(test)]
mod tests;
