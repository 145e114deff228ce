//! Tries `bevy_octree` on glTF files, as Bevy loads them, headless: all of it is in `tests`.
//!
//! It is a crate of its own, as Bevy's glTF loader brings lights, materials and shaders with it,
//! which nobody else is to build.
