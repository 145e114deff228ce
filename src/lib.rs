//! Collision detection for Bevy without a physics engine: an octree that follows moving objects,
//! exact tests, contact messages, and a bounce if you want one.
//!
//! # A tour
//!
//! Seven steps, each a program that runs. Ticks are in [`FixedPostUpdate`](bevy::app::FixedPostUpdate),
//! at the fixed timestep, unless [`OctreePlugins::new`] is given another schedule, as here, so that
//! each update is a tick.
//!
//! ## One cube
//!
//! A shape makes an entity take part, and a velocity moves it. Without one it is at rest, and costs
//! next to nothing.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.25) });
//! let cube = app.world_mut().spawn((CollisionShape::cuboid(1.0, 1.0, 1.0), Velocity(Vec3::X))).id();
//! app.update();
//! assert_eq!(app.world().get::<Transform>(cube).unwrap().translation, Vec3::X * 0.25);
//! ```
//!
//! Further: [`components`], [`motion`], [what moves it otherwise](motion::MovedElsewhere).
//!
//! ## Contacts
//!
//! Who comes to touch whom is told once, as a message; and again when it ends. With a
//! [`Bounce`](response::Bounce), a contact changes the velocity, too.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! #[derive(Resource, Default)]
//! struct Touched(Vec<[Entity; 2]>);
//!
//! fn listen(mut started: MessageReader<CollisionStarted>, mut touched: ResMut<Touched>) {
//!     touched.0.extend(started.read().map(|message| [message.a, message.b]));
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.25) })
//!     .init_resource::<Touched>()
//!     .add_systems(Update, listen.after(CollisionSystems::Report));
//! // A ball on its way to a wall.
//! let ball = (CollisionShape::sphere(0.5), Velocity(Vec3::X * 2.0), Bounce::Reflect { restitution: 1.0 });
//! let ball = app.world_mut().spawn((ball, Transform::from_xyz(-2.0, 0.0, 0.0))).id();
//! let wall = (CollisionShape::cuboid(0.5, 4.0, 4.0), Transform::from_xyz(0.5, 0.0, 0.0));
//! let wall = app.world_mut().spawn(wall).id();
//! for _ in 0..4 {
//!     app.update();
//! }
//! assert_eq!(app.world().resource::<Touched>().0, [[ball, wall]]);
//! assert_eq!(app.world().get::<Velocity>(ball).unwrap().0, Vec3::X * -2.0);
//! ```
//!
//! Further: [`contacts`], with observers, normals and depths; [triggers and pickups](guide::triggers);
//! [things made of parts](guide::parts).
//!
//! ## Filters
//!
//! Layers say who may meet whom. A pair that they rule out is gone before anything is tested.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! collision_layers! {
//!     enum Layer { Rock, Ship, Shot }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! // All in one place: shots meet rocks, and neither each other nor their ship.
//! let mut spawn = |layers| app.world_mut().spawn((CollisionShape::default(), layers)).id();
//! let rock = spawn(CollisionLayers::new(Layer::Rock, LayerMask::ALL));
//! let ship = spawn(CollisionLayers::new(Layer::Ship, Layer::Rock));
//! let shots = [(); 2].map(|()| spawn(CollisionLayers::new(Layer::Shot, Layer::Rock)));
//! app.update();
//! let contacts = app.world().resource::<Contacts>();
//! assert_eq!(contacts.len(), 3);
//! assert!([ship, shots[0], shots[1]].iter().all(|other| contacts.contains(rock, *other)));
//! ```
//!
//! Further: [`filters`], with sensors, lists to ignore, one-way detection and hooks; [`worlds`] apart
//! from each other.
//!
//! ## Queries
//!
//! [`SpatialQuery`](spatial_query::SpatialQuery) is what systems ask: what a ray meets, what is in a
//! blast, who is near.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! fn look(spatial: SpatialQuery) -> (Option<f32>, usize) {
//!     let all = SpatialQueryFilter::DEFAULT;
//!     let hit = spatial.cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &all);
//!     let mut near = Vec::new();
//!     spatial.within(Vec3::ZERO, 6.0, &all, &mut near);
//!     (hit.map(|hit| hit.distance), near.len())
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! for x in [5.0, 10.0] {
//!     app.world_mut().spawn((CollisionShape::sphere(1.0), Transform::from_xyz(x, 0.0, 0.0)));
//! }
//! app.update();
//! assert_eq!(app.world_mut().run_system_cached(look).unwrap(), (Some(4.0), 1));
//! ```
//!
//! Further: [all questions](spatial_query::SpatialQuery#all-questions); [`casters`], which ask in each
//! tick as components.
//!
//! ## Bullets
//!
//! What is fast is on this side of a wall in one tick and beyond it in the next. With
//! [`Swept`](swept::Swept), it is looked at all along its way.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
//!     .insert_resource(MotionSettings { step: Step::Seconds(0.01) });
//! let plate = (CollisionShape::cuboid(0.01, 2.0, 2.0), Transform::from_xyz(4.0, 0.0, 0.0));
//! let plate = app.world_mut().spawn(plate).id();
//! // Nine units in a tick, and it stops where it hits.
//! let bullet = (CollisionShape::sphere(0.02), Velocity(Vec3::X * 900.0), Swept::stopping());
//! let bullet = app.world_mut().spawn(bullet).id();
//! app.update();
//! assert!(app.world().resource::<Contacts>().contains(bullet, plate));
//! assert!(app.world().get::<Transform>(bullet).unwrap().translation.x < 4.0);
//! ```
//!
//! Further: [bullets](guide::bullets), [`swept`].
//!
//! ## Shapes
//!
//! Boxes, balls, capsules, cylinders, cones, hulls, what is rounded, and what consists of such: each
//! meets all others exactly, however it is turned and scaled. What
//! [`CollisionShape`](components::CollisionShape) has no constructor for,
//! [`Shape`](narrow_phase::Shape) has.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! let mut spawn = |shape: CollisionShape, at: Transform| app.world_mut().spawn((shape, at)).id();
//! let turned = Transform::from_rotation(Quat::from_rotation_z(0.5));
//! let cone = spawn(CollisionShape(Shape::cone(0.5, 2.0)), turned);
//! let near = spawn(CollisionShape::capsule(0.4, 1.0), Transform::from_xyz(0.8, 0.0, 0.0));
//! // Its box overlaps that of the cone, and it does not touch it.
//! let beside = spawn(Sphere::new(0.3).into(), Transform::from_xyz(0.3, 1.1, 0.0));
//! app.update();
//! let contacts = app.world().resource::<Contacts>();
//! assert!(contacts.contains(cone, near) && !contacts.contains(cone, beside));
//! ```
//!
//! Further: [shapes, and what each costs](guide::shapes); [shapes as data](guide::shapes_as_data), for
//! files and editors.
//!
//! ## Levels
//!
//! A level is one mesh of any number of polygons, with a tree in it. Its triangles come from code, as
//! here, or from assets: with the feature `mesh`, a `ShapesFromMeshes` beside a glTF scene gives all
//! meshes of it their shapes.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! fn below(spatial: SpatialQuery) -> Option<(f32, Option<u32>)> {
//!     let down = Ray3d::new(Vec3::new(5.0, 2.0, 1.0), Dir3::NEG_Y);
//!     let hit = spatial.cast_ray(down, 100.0, &SpatialQueryFilter::DEFAULT)?;
//!     Some((hit.distance, hit.polygon))
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! // A floor of two triangles.
//! let corners = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
//! let floor = PolygonMesh::new(corners, [[0, 1, 2], [0, 2, 3]])?;
//! let floor = app.world_mut().spawn((CollisionShape::from(floor), StaticShape)).id();
//! let ball = app.world_mut().spawn((CollisionShape::sphere(0.5), Transform::from_xyz(0.0, 0.4, 0.0))).id();
//! app.update();
//! assert!(app.world().resource::<Contacts>().contains(floor, ball));
//! // Which triangle a ray meets is told, too.
//! assert_eq!(app.world_mut().run_system_cached(below)?, Some((2.0, Some(1))));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Further: [`narrow_phase::PolygonMesh`], [`narrow_phase::HeightField`], [`narrow_phase::Voxels`];
//! in the [`guide`], the page on levels from glTF.
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
//! | [`KinematicCharacter`](character::KinematicCharacter) | has it walk by its velocity: along walls, on slopes, stairs and platforms; [`CharacterHits`](character::CharacterHits) lists what it met |
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
//! | `serialize` | serde for what has entities in it or is state of characters: [`CollisionSnapshot`](rollback::CollisionSnapshot), [`KinematicCharacter`](character::KinematicCharacter), [`IgnoreCollisions`](filters::IgnoreCollisions), [`InCollisionWorld`](worlds::InCollisionWorld) and what is in them; the other components are read and written without it |
//! | `libm` | sines and their like by `libm`, to the last bit as on other platforms: see [`rollback`](guide::rollback) |
//! | `multi_threaded` | systems and the broad phase on several threads, shapes of mesh assets beside them |
//!
//! # Guide
//!
//! The [`guide`] has a page for each of some subjects.
//!
//! | page | what it is about |
//! |---|---|
//! | [`shapes`](guide::shapes) | which shape for what, and what each costs |
//! | [`shapes_as_data`](guide::shapes_as_data) | shapes in files, editors and scenes |
//! | [`parts`](guide::parts) | things made of parts |
//! | [`triggers`](guide::triggers) | triggers and pickups |
//! | [`bullets`](guide::bullets) | what is fast |
//! | [`characters`](guide::characters) | who walks: a controller in first person, platforms, crouching |
//! | `levels_from_gltf` | levels from glTF (feature `mesh`) |
//! | [`rollback`](guide::rollback) | what to save, and the same on every machine |
//! | [`broad_phases`](guide::broad_phases) | which broad phase |
//! | [`costs`](guide::costs) | what each capability and each feature costs |
//! | [`engines`](guide::engines) | when to take a physics engine instead, or beside |
//! | [`coming_from`](guide::coming_from) | what is called how elsewhere |
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
pub mod character;
pub mod collision_index;
pub mod collision_order;
pub mod components;
pub mod contacts;
pub mod counters;
#[cfg(feature = "debug_draw")]
pub mod debug_draw;
pub mod diagnostics;
mod disabled;
pub mod filters;
mod frame;
pub mod guide;
mod hierarchy;
mod maintenance;
#[cfg(feature = "mesh")]
pub mod mesh_shape;
pub mod motion;
pub mod move_and_slide;
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
pub mod rollback;
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
        character::CharacterPlugin,
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
        character::{CharacterHits, CharacterSystems, Ground, KinematicCharacter, WalkSettings},
        collision_layers,
        collision_order::CollisionOrder,
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
        move_and_slide::{AtHit, MoveAndSlide, MoveEnd, MoveHit, MoveSettings, Moved},
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
