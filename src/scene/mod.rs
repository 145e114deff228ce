//! Scenes: which objects there are, where they start, and how they move.
//!
//! A [`SceneDescription`] is plain data. It is written by hand in a scene file, generated from a
//! [`TestSet`] (the two planes of cubes of Swan, *Fast Collision Detection with an N-Objects
//! Octree*, 1994, section 3.1), or put together in code; [`SceneDescription::spawn`] turns it into
//! entities. A [`CollisionReport`] tells which of them touched, and when.
//!
//! # Scene files
//!
//! With the feature `scene_files`, scenes are read from files and written to them.
//!
//! Scene files are [RON](https://docs.rs/ron) with the extensions `unwrap_variant_newtypes` and
//! `implicit_some` switched on, and are named `*.scene.ron`. Fields not listed in the file take the
//! default given here; unknown fields are errors.
//!
//! | field of the scene | type | default |
//! |---|---|---|
//! | `name` | text | |
//! | `ticks_per_second` | number above 0 | 64 |
//! | `content` | `TestSet(…)` or `Objects([…])` | |
//!
//! `TestSet(rings: 3)` takes the fields of [`TestSet`]. Each entry of `Objects` is
//!
//! | field of an object | type | default |
//! |---|---|---|
//! | `name` | text, unique in the scene | `object_` and its index from 0 |
//! | `shape` | `Cuboid(half_size: (x, y, z))`, `Sphere(radius: r)`, `Convex(vertices: […], polygons: […])`, `Mesh(vertices: […], polygons: […], surface_only: false)`, and all other kinds of [`ShapeDescription`] | |
//! | `position` | `(x, y, z)`; left out with a track | `(0, 0, 0)` |
//! | `rotation` | `(x, y, z)`: Euler angles in degrees | `(0, 0, 0)` |
//! | `scale` | `(x, y, z)`, no component 0 | `(1, 1, 1)` |
//! | `motion` | `Static`, `Velocity(x, y, z)` in units per second, or `Track(keyframes: [(tick, (x, y, z)), …])` | `Static` |
//!
//! The rotation turns about the object's own x axis first, then its own y, then its own z
//! ([`EulerRot::XYZ`]). A track may also set `interpolation` (`Linear`, `Step`, `Smooth`,
//! `Ease(QuadraticInOut)`, …), `outside` (`Hold`, `Loop`) and `start` (`At(tick)`, `Now`); see
//! [`PositionTrack`].
//!
//! ```
//! use bevy_octree::scene::SceneDescription;
//!
//! # #[cfg(feature = "scene_files")] {
//! let scene = SceneDescription::parse(
//!     r#"(
//!         name: "one hit",
//!         content: Objects([
//!             (name: "wall", shape: Cuboid(half_size: (0.5, 2, 2))),
//!             (name: "ball", shape: Sphere(radius: 0.5), position: (-3, 0, 0), motion: Velocity(1, 0, 0)),
//!         ]),
//!     )"#,
//! )?;
//! assert_eq!(scene.object_count(), 2);
//!
//! let error = SceneDescription::parse("(name: \"t3\",\n content: TestSet(ring: 3))").unwrap_err();
//! assert!(error.to_string().starts_with("scene text:2:19: Unexpected field named `ring`"));
//! # }
//! # Ok::<(), bevy_octree::scene::SceneError>(())
//! ```
//!
//! With the feature `asset`, scene files also load through Bevy's asset system.
//!
//! [`EulerRot::XYZ`]: bevy::math::EulerRot::XYZ
//! [`PositionTrack`]: crate::motion::PositionTrack

#[cfg(feature = "asset")]
mod asset;
mod clip_report;
mod cube;
mod description;
mod error;
#[cfg(feature = "scene_files")]
mod file;
mod spawn;
pub mod stress;
mod test_set;

use bevy::prelude::*;

#[cfg(feature = "asset")]
pub use asset::{SceneAssetPlugin, SceneLoader};
pub use clip_report::{CollisionReport, Interval, PairContacts, TickOutOfOrder};
pub use cube::Cube;
pub use description::{Content, Motion, ObjectDescription, SceneDescription};
pub use error::{ObjectProblem, SceneError, SceneProblem};
pub use test_set::{Plane, TestCube, TestSet, TestSetError};

#[doc(no_inline)]
pub use crate::shape_data::ShapeDescription;

/// Makes scenes known to reflection.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        cube::register(app);
        description::register(app);
        test_set::register(app);
    }
}

#[cfg(all(test, feature = "scene_files"))]
mod tests;
