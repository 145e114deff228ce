//! Collision detection for Bevy without a physics engine.
#![forbid(unsafe_code)]
#![warn(missing_docs, clippy::doc_markdown)]

pub mod broad_phase;
pub mod components;
pub mod motion;
pub mod narrow_phase;
pub mod octree;
pub mod scene;
