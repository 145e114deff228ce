//! Tries `bevy_octree` in scenes that Bevy's macro `bsn!` writes, headless: all of it is in `tests`.
//!
//! It is a crate of its own, as the macro's `bevy_scene` brings assets with it, which nobody else is
//! to build. What a remote does to the same components is in the library's own `tests/app`, as JSON
//! that goes through the registry: Bevy's remote protocol itself depends on the renderer.
