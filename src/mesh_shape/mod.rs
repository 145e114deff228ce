//! Shapes of entities from mesh assets, one by one and for whole scenes, built beside the ticks
//! where there are threads for it.
//!
//! | component | what it does |
//! |---|---|
//! | [`ShapeFromMesh`] | builds the shape of an entity: of its own `Mesh3d`, or of a mesh that is named |
//! | [`ShapesFromMeshes`] | does that for all meshes under an entity, as a glTF scene has them, by rules |
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! fn load_level(mut commands: Commands) {
//!     // Beside the `WorldAssetRoot` of a glTF scene: whatever it spawns can be collided with.
//!     commands
//!         .spawn(ShapesFromMeshes::default().with(StaticShape))
//!         .observe(|ready: On<ShapesReady>| println!("{} shapes", ready.counts.shapes));
//! }
//! ```
//!
//! # Threads
//!
//! With the feature `multi_threaded`, or Bevy's of that name, shapes are built on the threads of
//! Bevy's `AsyncComputeTaskPool`, and ticks go on meanwhile. Without it, there are no other threads:
//! the tick that finds the asset builds the shape itself, and takes as much longer (on the web,
//! between two frames). Which it is, is a matter of how long a tick takes, and of the tick in which
//! shapes appear; all else is the same. A large level in an app of one thread is best waited for on
//! a loading screen.
//!
//! # Levels from glTF
//!
//! Bevy's loader makes an entity of each node, with its `Name` and `Transform`, and below it one
//! with a `Mesh3d` for each *primitive* of its mesh: for each material that is on it. So
//!
//! * the name that an artist gave is that of the mesh's parent; rules by
//!   [name](ShapesFromMeshes::name) therefore look at the mesh and at all between it and the root;
//! * an object of two materials is two meshes, neither of which is closed. It is met as a surface,
//!   and has no inside. What has to be solid is of one material, or is a
//!   [hull, box or voxels](MeshForm) of each;
//! * nodes that share a mesh share the shape, whatever their transforms;
//! * scales that are negative or differ by axis are applied to the shape, and what a scaled parent
//!   shears is [sheared](crate::plugins::BoundsPlugin#sheared-shapes);
//! * skinned and morphed meshes have the shape of the mesh as it is stored;
//! * materials are known by the component `GltfMaterialName`, which is read by reflection, as Bevy
//!   registers it: this crate does not depend on `bevy_gltf`.
//!
//! # What exporters get wrong
//!
//! Nothing of it panics. Where no shape can be made, the log says so, with entity and name, and the
//! entity gets a [`ShapeFromMeshError`]:
//!
//! | the mesh | what becomes of it |
//! |---|---|
//! | has no indices, or is a strip | its triangles are taken |
//! | consists of lines or points | error: [`Topology`](crate::narrow_phase::ShapeError::Topology) |
//! | has no positions, or not as `Float32x3` | error: [`NoPositions`](crate::narrow_phase::ShapeError::NoPositions) |
//! | names vertices that are not there, or has bad numbers | error: [`IndexOutOfRange`](crate::narrow_phase::ShapeError::IndexOutOfRange), [`NonFiniteVertex`](crate::narrow_phase::ShapeError::NonFiniteVertex) |
//! | has no triangle with an area | error: [`Empty`](crate::narrow_phase::ShapeError::Empty) |
//! | has some such triangles, and vertices that are there twice | they are left out; the vertices are welded |
//! | has triangles twice, or wound inside out | as [`PolygonMesh`](crate::narrow_phase::PolygonMesh) says; solids face out |
//! | closes but for a few edges | it is a surface, and the log names an edge |
//! | is in the memory of the renderer alone | error: [`NoAccess`](crate::narrow_phase::ShapeError::NoAccess) |
//! | cannot be loaded | error: [`NotLoaded`](crate::narrow_phase::ShapeError::NotLoaded), until it is loaded after all |
//! | is never loaded | is waited for; after more than ten seconds the log says who waits, once |
//!
//! A node whose scale is zero along an axis makes a flat shape; one whose numbers are not finite is
//! left out of collision detection, as any entity that is nowhere.

mod enclosing;
mod form;
mod progress;
mod rules;
mod shape_from_mesh;
mod shapes_from_meshes;
mod voxels;
mod waiting;

use bevy::prelude::App;

pub use form::MeshForm;
pub use progress::{MeshShapeCounts, ShapesProgress, ShapesReady};
pub use rules::{FoundMesh, MeshRule};
pub use shape_from_mesh::{ShapeFromMesh, ShapeFromMeshError};
pub use shapes_from_meshes::ShapesFromMeshes;

pub(crate) fn register(app: &mut App) {
    shape_from_mesh::register(app);
    shapes_from_meshes::register(app);
    waiting::register(app);
}
