//! Collision detection for Bevy without a physics engine.
#![forbid(unsafe_code)]
#![warn(missing_docs, clippy::doc_markdown)]

mod bounds;
pub mod broad_phase;
pub mod collision_index;
pub mod components;
pub mod contacts;
pub mod counters;
pub mod motion;
pub mod narrow_phase;
pub mod octree;
pub mod plugin;
pub mod response;
pub mod scene;

pub use bounds::BoundsPlugin;
pub use plugin::{CollisionSystems, OctreePlugins};

/// What most users need.
pub mod prelude {
    pub use crate::{
        broad_phase::{Method, ObjectOctreeSettings},
        collision_index::{BroadPhaseSettings, CandidatePairs, CollisionIndex},
        components::{CollisionShape, Cube, WorldAabb},
        contacts::{CollisionEnded, CollisionStarted, Contacts},
        counters::CollisionCounters,
        motion::{CollisionClock, MotionSettings, PositionTrack, Step, Velocity},
        narrow_phase::Shape,
        plugin::{CollisionSystems, NarrowPhaseSettings, OctreePlugins},
        response::{Bounce, BouncePlugin},
    };
}
