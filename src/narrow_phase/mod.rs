//! Exact tests: whether two objects whose boxes overlap are in contact, and where.
//!
//! The tests form a hierarchy, as in the report (Swan, *Fast Collision Detection with an N-Objects
//! Octree*, 1994, sections 1.4 and 2.3): partial decisions, each dearer than the one before, and a
//! complete one at the end. A pair leaves the chain at the first [`Stage`] that is sure.
//!
//! | stage | rejects | accepts |
//! |---|---|---|
//! | [`Bounds`](Stage::Bounds) | pairs whose axis-aligned boxes are apart | |
//! | [`Spheres`](Stage::Spheres) | pairs whose bounding spheres are apart | two spheres |
//! | [`Boxes`](Stage::Boxes) | pairs whose oriented boxes are apart along one of 15 axes | overlapping cuboids; a sphere and a cuboid |
//! | [`Complete`](Stage::Complete) | all that is left | all that is left |
//!
//! [`StageCounters`] tell how many pairs reached and left each stage.
//!
//! ```
//! use bevy::math::Vec3;
//! use bevy::transform::components::Transform;
//! use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Stage, Workspace};
//!
//! let tests = NarrowPhase::default();
//! let mut workspace = Workspace::default();
//! let cube = Shape::cuboid(1.0, 1.0, 1.0);
//! let (here, beside) = (Transform::IDENTITY, Transform::from_xyz(1.0, 0.0, 0.0));
//! let (a, b) = (Placed::new(&cube, &here), Placed::new(&cube, &beside));
//!
//! // Face to face counts as contact.
//! assert!(tests.intersects(a, b, &mut workspace));
//! assert_eq!(workspace.counters[Stage::Boxes].accepted, 1);
//! let contact = tests.contact(a, b, &mut workspace).unwrap();
//! assert_eq!((contact.normal, contact.depth), (Vec3::X, 0.0));
//! ```
//!
//! # What the last stage decides
//!
//! Two meshes are in contact where their surfaces come as close as the tolerance, or where one is
//! inside the other.
//!
//! * Every mesh of more than a few polygons has a tree of them, in its own space, built with the
//!   mesh and shared by all that have the shape. Scale, mirrors and turns are put on what is asked,
//!   not on the mesh. A search of the tree, or a join of two, finds the polygons that are near
//!   enough to the other shape for the question; only these are looked at.
//! * Every edge of one against every polygon of the other, both ways, decides whether the
//!   *surfaces* meet: an edge crosses a polygon, ends on it, or comes close to its border. Each of
//!   the closest pairs of points of two surfaces has an edge on one side, so nothing is missed, and
//!   the borders are part of the polygons, so edges that run along borders and polygons that share
//!   a plane are contact. A cuboid and the triangles of a mesh with a tree are compared along the
//!   axes that could part them, which says the same; a sphere, by the closest point.
//! * That does *not* see one mesh that is wholly inside the other, and so a point of each connected
//!   part of one is tested against the volume of the other, by winding number. What the closed
//!   parts of a mesh enclose is [inside](PolygonMesh::has_inside), whatever else is in the mesh; of
//!   an open one, and of a [surface only](PolygonMesh::surface_only), nothing is.
//! * Nothing is swept: as in the report, an object that moves further in a tick than objects are
//!   thick can pass through them. For those see [`NarrowPhase::time_of_impact`].
//!
//! # Numbers
//!
//! Everything is computed relative to the position of one of the two, so that a pair far from the
//! origin gets the verdict it would get close to it, for the positions as 32-bit floats hold them.
//! Verdicts do not depend on the order of the two. Early stages reject only at twice the tolerance,
//! and [`Stage::Boxes`] accepts cuboids only if it is sure that they overlap, so that the last
//! stage has the last word where it could differ: [`Exactness::EdgePolygon`] forces it, and agrees.
//!
//! Whatever is finite is decided, however large: what is beyond 10⁹ is looked at at a smaller
//! scale, by a power of two. Where even a position or a sum of sizes exceeds the range of 32-bit
//! floats, there are [no bounds](BoundsError::NonFinite) and no contacts.
//!
//! Nothing is allocated per pair once the buffers of the [`Workspace`] have grown to what meshes
//! have near each other (but for the depth of Rapier shapes that overlap, and for points that may
//! be inside a mesh with vertices on the edges of other polygons). Two cuboids take in the order of
//! 15 ns if turned alike, and 75 ns if not.
//!
//! # Rays, sweeps, distances
//!
//! [`NarrowPhase::cast_ray`], [`NarrowPhase::sweep`], [`NarrowPhase::closest_point`] and
//! [`NarrowPhase::closest_points`] answer for the same shapes, exactly.
//! [`NarrowPhase::time_of_impact`] is a sweep of two that both move, and may turn. The first time
//! of impact of two shapes made of polygons is the least of those of corners and faces, both ways,
//! and of edges, each the solution of a linear equation: nothing is iterated, and nothing has to be
//! convex. A cuboid meets the triangles of a mesh with a tree when it overlaps them along each axis
//! that could part the two.
//!
//! [`RayCastOptions`] and [`ShapeCastOptions`] say what is met: which faces, whether solids are
//! hollow, and whether what is touched at the start counts; [`NarrowPhase::cast_ray_through`] tells
//! where a ray leaves what it enters. What is met of a mesh is told by the number of the polygon.
//!
//! # Round shapes, and shapes of many
//!
//! Capsules, frusta (cylinders and cones are such), half-spaces and [rounded](Rounded) shapes are
//! known by how far they reach along a direction. One question decides all about a pair in which
//! there is one: the distance of the two, of what is behind their radius (of a capsule, a segment).
//! It is known in closed form or by 32-bit floats, relative to one of the two, and where these cannot
//! tell, by 64-bit ones. [Compounds](Compound), [height fields](HeightField) and [voxels](Voxels) are
//! taken apart by trees of their own into such shapes and triangles. So all shapes meet all others,
//! with the tolerance as here. Rays meet capsules and frusta in closed form.
//!
//! Height fields are surfaces, without an inside; a closed mesh has one for all shapes. The depth of
//! two shapes that are round where they overlap is the end of an iteration, which is off by less than
//! a millionth of their sizes, and its normal by the root of that; distances and times of impact are
//! exact.
//!
//! # Rapier
//!
//! With the feature `rapier`, a `bevy_rapier3d` collider is a shape too. Scale is not applied to
//! it: `bevy_rapier3d` has done so already. Balls, cuboids, capsules, cylinders, cones, hulls,
//! triangles, segments, half-spaces, meshes, what is round of these and compounds of them are
//! converted once, and are then as our own. Height fields, voxels and polylines
//! are taken apart by parry, and decided as our own parts are. Meshes and height fields of Rapier are
//! surfaces, without an inside.
//!
//! Nothing is known of how two half-spaces meet, nor of shapes of somebody else's making
//! (`ShapeType::Custom`) that have neither a support map nor parts, but of how rays and points meet
//! these: such pairs count as apart, have no distance, and the first one that is tested in an app
//! logs a warning with both entities. A shape without an end has [no
//! bounds](BoundsError::Unbounded) for a broad phase, but perhaps a [side](NarrowPhase::side), and
//! can be tested.

mod answer;
mod bounds;
mod cast;
mod cast_options;
mod composite;
mod compound;
mod construct;
mod contact;
mod content;
mod cores;
mod decide;
mod error;
mod fit;
mod frame;
mod gjk;
mod leaves;
mod length;
mod mesh;
mod proximity;
#[cfg(feature = "rapier")]
mod rapier_shape;
mod rounded;
mod settings;
mod shape;
mod stage;
mod support;
#[cfg(test)]
mod tests;
mod turned;

pub use answer::{Contact, Impact, Passage, Proximity, TimedContact};
pub use cast::moving::Moving;
pub use cast_options::{RayCastOptions, ShapeCastOptions};
pub use composite::height_field::HeightField;
pub use composite::voxels::{Faces, Voxels};
pub use contact::manifold::{Manifold, ManifoldPoint};
pub use error::{BoundsError, ShapeError, ToleranceError};
pub(crate) use fit::Fit;
pub(crate) use frame::approach::approach;
pub use frame::placed::Placed;
pub use frame::workspace::Workspace;
#[cfg(feature = "mesh")]
pub(crate) use mesh::bevy_mesh::mesh_triangles;
pub use mesh::convex_mesh::ConvexMesh;
pub use mesh::polygon_mesh::PolygonMesh;
pub use rounded::{Rounded, RoundedCore};
pub use settings::{Exactness, NarrowPhase};
#[cfg(feature = "rapier")]
pub use shape::RapierShape;
pub use shape::{Compound, Shape};
pub use stage::{Stage, StageCount, StageCounters};
pub(crate) use support::is_known;
