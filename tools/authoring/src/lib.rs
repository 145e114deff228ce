//! Tries the shapes as data of `bevy_octree` on Bevy's own ways to write them, headless: scenes by
//! `bsn!`, and, with the feature `remote`, the methods of the remote protocol. All of it is in
//! `tests`.
//!
//! It is a crate of its own, as nobody else is to build what these bring.
