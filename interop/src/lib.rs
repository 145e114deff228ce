//! Tries `bevy_octree` with crates that games use beside it, headless: rollback by `bevy_ggrs`,
//! replication by `bevy_replicon`, interpolation by `bevy_transform_interpolation`. All of it is in
//! `tests` and `examples`; what they share is here.

pub mod network;
