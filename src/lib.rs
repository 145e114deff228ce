//! Collision detection for Bevy without a physics engine: an octree that follows moving objects,
//! exact tests, contact messages, and a bounce if you want one.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.25) });
//! // A ball on its way to a wall.
//! let ball = (CollisionShape::sphere(0.5), Velocity(Vec3::X * 2.0), Bounce::Reflect { restitution: 1.0 });
//! let ball = app.world_mut().spawn((ball, Transform::from_xyz(-2.0, 0.0, 0.0))).id();
//! app.world_mut().spawn((CollisionShape::cuboid(0.5, 4.0, 4.0), Transform::from_xyz(0.5, 0.0, 0.0)));
//! for _ in 0..4 {
//!     app.update();
//! }
//! assert_eq!(app.world().get::<Velocity>(ball).unwrap().0, Vec3::X * -2.0);
//! ```
//!
//! Ticks run in [`FixedPostUpdate`](bevy::app::FixedPostUpdate), at the fixed timestep, unless
//! [`OctreePlugins::new`] is given another schedule; the first frames of an app may have none.
//!
//! # What an entity needs
//!
//! | component | what it does |
//! |---|---|
//! | [`CollisionShape`](components::CollisionShape) | makes the entity take part; brings its box and its entry in the index with it |
//! | [`ShapeDescription`](shape_data::ShapeDescription) | has that shape built of plain data, as files and editors have it |
//! | `ShapeFromMesh` | has it built of a mesh asset (feature `mesh`) |
//! | `ShapesFromMeshes` | does that for all meshes under it, as those of a glTF scene (feature `mesh`) |
//! | [`WorldAabb`](components::WorldAabb) | its box in the world, kept up to date |
//! | [`BroadPhaseProxy`](components::BroadPhaseProxy) | its entry in the index |
//! | [`Velocity`](motion::Velocity) | moves it each tick; without one it is at rest, until something else moves it |
//! | [`PositionTrack`](motion::PositionTrack) | moves it along keyframes instead |
//! | [`MovedElsewhere`](motion::MovedElsewhere) | has it moved by something else, such as a physics engine |
//! | [`Bounce`](response::Bounce) | changes its velocity on contact |
//! | [`Swept`](swept::Swept) | has it looked at all along its way, however fast it is |
//! | [`CollisionLayers`](filters::CollisionLayers) | says which others it may meet; [more of the kind](filters) |
//! | [`StaticShape`](filters::StaticShape) | says that it never meets its kind: walls, floors, levels |
//! | [`Sensor`](filters::Sensor) | has it reported, and nothing bounce off it |
//! | [`Detector`](filters::Detector) | has it hear of others that do not hear of it |
//! | [`CollisionBody`](parts::CollisionBody) | makes it one thing with all shapes that hang on it |
//! | [`InCollisionWorld`](worlds::InCollisionWorld) | puts it in a world of its own, apart from all others |
//! | [`CollisionEventsEnabled`](contacts::CollisionEventsEnabled) | has its observers told of its contacts |
//! | [`ManifoldsEnabled`](contacts::ManifoldsEnabled) | has the points found at which it lies on others |
//! | [`CollidingEntities`](contacts::CollidingEntities) | lists the entities that it touches |
//! | [`RayCaster`](casters::RayCaster), [`ShapeCaster`](casters::ShapeCaster) | cast a ray or a shape in each tick; what they meet is in [`RayHits`](casters::RayHits), [`ShapeHits`](casters::ShapeHits) |
//! | [`Cube`](scene::Cube) | shape, velocity and bounce in one: a moving cube |
//!
//! # What comes out
//!
//! | resource or message | what it tells |
//! |---|---|
//! | [`Contacts`](contacts::Contacts) | all pairs in contact, by entity; in systems, through the parameter [`Collisions`](contacts::Collisions) |
//! | [`CollisionStarted`](contacts::CollisionStarted), [`CollisionEnded`](contacts::CollisionEnded) | messages, and events for observers, about pairs that came into contact, or no longer are |
//! | [`BodyCollisionStarted`](contacts::BodyCollisionStarted), [`BodyCollisionEnded`](contacts::BodyCollisionEnded) | the same about things made of [`parts`], once for all of their parts |
//! | [`CandidatePairs`](collision_index::CandidatePairs) | pairs for the exact tests, which systems may thin out |
//! | [`CollisionIndex`](collision_index::CollisionIndex) | the boxes, the broad phase, queries |
//! | [`CollisionCounters`](counters::CollisionCounters) | what happened, in numbers; through Bevy's diagnostics by the [`CollisionDiagnosticsPlugin`](diagnostics::CollisionDiagnosticsPlugin) |
//!
//! [`SpatialQuery`](spatial_query::SpatialQuery) is the way to ask: rays, moving shapes, overlaps,
//! what is near.
//!
//! # Settings
//!
//! | resource | what it says |
//! |---|---|
//! | [`MotionSettings`](motion::MotionSettings) | how long a tick is |
//! | [`BroadPhaseSettings`](settings::BroadPhaseSettings) | how pairs are searched for, and which kinds |
//! | [`NarrowPhase`](narrow_phase::NarrowPhase) | how near counts as contact |
//! | [`CollisionEventSettings`](contacts::CollisionEventSettings) | who is told about contacts, and how much |
//!
//! # Features
//!
//! None is on by default.
//!
//! | feature | what it adds |
//! |---|---|
//! | `rapier` | the module `rapier`: side by side with `bevy_rapier3d`, whose colliders are shapes too |
//! | `mesh` | `PolygonMesh::from_mesh`: shapes from Bevy's `Mesh`; the component `ShapeFromMesh`, which builds them of assets, and `ShapesFromMeshes`, which does so for all meshes of a glTF scene; with `multi_threaded`, on other threads |
//! | `scene_files` | scenes read from RON files, and written to them: [`scene`] |
//! | `asset` | the same through Bevy's asset system |
//! | `reports` | the report over a clip, as CSV and JSON lines: [`CollisionReport`](scene::CollisionReport) |
//! | `debug_draw` | the module `debug_draw`: leaves, shapes, boxes, contacts and queries by Bevy's gizmos |
//! | `picking` | the module `picking`: a backend for `bevy_picking` |
//! | `multi_threaded` | systems and the broad phase on several threads, shapes of mesh assets beside them |
//!
//! # Guide
//!
//! The [`guide`] has a page for each of some subjects: shapes and what each costs, shapes as data,
//! things made of parts, triggers, bullets, levels from glTF (feature `mesh`), and what is called how
//! elsewhere.
//!
//! # Parts
//!
//! [`OctreePlugins`] brings all of it, one of the [`plugins`] for each stage; [`CollisionSystems`]
//! are the sets to order systems of one's own by. The parts also work without Bevy's ECS:
//! [`octree`], [`broad_phase`] and [`narrow_phase`].
//!
//! The system is that of J. Edward Swan II, *Fast Collision Detection with an N-Objects Octree*,
//! Ohio State University, ACCAD, 1994; "Swan 1994" or "the report" in the documentation.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod ancestors;
mod bounds;
pub mod broad_phase;
pub mod casters;
mod change_ticks;
pub mod collision_index;
pub mod components;
pub mod contacts;
pub mod counters;
#[cfg(feature = "debug_draw")]
pub mod debug_draw;
pub mod diagnostics;
pub mod filters;
mod frame;
pub mod guide;
mod hierarchy;
mod maintenance;
#[cfg(feature = "mesh")]
pub mod mesh_shape;
pub mod motion;
pub mod narrow_phase;
pub mod octree;
mod parallel;
pub mod parts;
#[cfg(feature = "picking")]
pub mod picking;
mod plugin;
#[cfg(feature = "rapier")]
pub mod rapier;
mod regroup;
pub mod response;
pub mod scene;
pub mod schedule;
pub mod settings;
pub mod shape_data;
mod shear;
pub mod spatial_query;
pub mod swept;
pub mod trace;
mod way;
pub mod worlds;

pub use plugin::OctreePlugins;
pub use schedule::CollisionSystems;

/// The plugins that [`OctreePlugins`] consist of, to disable or replace: one for each stage of a
/// tick, and what they share.
pub mod plugins {
    #[cfg(feature = "asset")]
    pub use crate::scene::SceneAssetPlugin;
    pub use crate::{
        bounds::BoundsPlugin,
        casters::CasterPlugin,
        contacts::{NarrowPhasePlugin, ReportPlugin},
        filters::FilterPlugin,
        maintenance::BroadPhasePlugin,
        motion::MotionPlugin,
        plugin::CollisionCorePlugin,
        response::BouncePlugin,
        scene::ScenePlugin,
        schedule::CollisionSchedulePlugin,
        swept::SweptPlugin,
    };
}

/// The prelude: what a game writes daily, and no name that Bevy's own prelude has. What is looked
/// into now and then is in its module.
pub mod prelude {
    #[cfg(feature = "debug_draw")]
    pub use crate::debug_draw::{CollisionDebugPlugin, CollisionGizmos, DebugDraw, QueryGizmos};
    #[cfg(feature = "mesh")]
    pub use crate::mesh_shape::{
        MeshForm, MeshRule, ShapeFromMesh, ShapeFromMeshError, ShapesFromMeshes, ShapesProgress,
        ShapesReady,
    };
    #[cfg(feature = "picking")]
    pub use crate::picking::{CollisionPickable, CollisionPickingPlugin};
    #[cfg(feature = "rapier")]
    pub use crate::rapier::{RapierInteropPlugin, ShapeFromRapier};
    pub use crate::{
        broad_phase::BroadPhaseMethod,
        casters::{CasterFilter, CasterIgnores, RayCaster, RayHits, ShapeCaster, ShapeHits},
        collision_layers,
        components::CollisionShape,
        contacts::{
            BodyCollision, BodyCollisionEnded, BodyCollisionStarted, CollidingEntities, Collision,
            CollisionEnded, CollisionEventSettings, CollisionEventsEnabled, CollisionStarted,
            Collisions, Contacts, EventScope, ManifoldsEnabled,
        },
        counters::CollisionCounters,
        filters::{
            CollisionLayer, CollisionLayers, Detector, IgnoreCollisions, LayerMask, PairHook,
            PairHookPlugin, Sensor, StaticShape,
        },
        motion::{MotionSettings, MovedElsewhere, PositionTrack, Step, Velocity},
        narrow_phase::{Compound, Contact, HeightField, Placed, PolygonMesh, Shape, Voxels},
        parts::{BodyParts, CollisionBody, PartOf},
        plugin::OctreePlugins,
        response::Bounce,
        schedule::CollisionSystems,
        settings::BroadPhaseSettings,
        shape_data::{ShapeDescription, ShapeDescriptionError},
        spatial_query::{
            HitLists, PairHit, PointHit, RayCastOptions, RayHit, RayPassage, ShapeCastOptions,
            ShapeContact, ShapeHit, SpatialQuery, SpatialQueryFilter, update_spatial_index,
        },
        swept::{AtSolid, Swept, SweptWay},
        worlds::{CollisionWorld, InCollisionWorld},
    };
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
