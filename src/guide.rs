//! Pages about one subject each, for whoever wants to get something done: they go through several
//! modules of the crate, and each snippet is a program that is compiled and run.

#[doc = include_str!("../docs/guide/broad_phases.md")]
pub mod broad_phases {}

#[doc = include_str!("../docs/guide/bullets.md")]
pub mod bullets {}

#[doc = include_str!("../docs/guide/characters.md")]
pub mod characters {}

#[doc = include_str!("../docs/guide/coming_from.md")]
pub mod coming_from {}

#[doc = include_str!("../docs/guide/costs.md")]
pub mod costs {}

#[doc = include_str!("../docs/guide/engines.md")]
pub mod engines {}

// What it is about is there with that feature alone.
#[cfg(feature = "mesh")]
#[doc = include_str!("../docs/guide/levels_from_gltf.md")]
pub mod levels_from_gltf {}

#[doc = include_str!("../docs/guide/parts.md")]
pub mod parts {}

#[doc = include_str!("../docs/guide/rollback.md")]
pub mod rollback {}

#[doc = include_str!("../docs/guide/shapes.md")]
pub mod shapes {}

#[doc = include_str!("../docs/guide/shapes_as_data.md")]
pub mod shapes_as_data {}

#[doc = include_str!("../docs/guide/triggers.md")]
pub mod triggers {}
