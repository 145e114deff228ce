//! Which entities may meet: layers, static entities, lists of entities to ignore, sensors, detectors,
//! and a hook of one's own.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! collision_layers! {
//!     enum Team { Red, Blue }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::default()));
//! for team in [Team::Red, Team::Red, Team::Blue] {
//!     let other = if let Team::Red = team { Team::Blue } else { Team::Red };
//!     app.world_mut().spawn((CollisionShape::default(), CollisionLayers::new(team, other)));
//! }
//! app.update();
//! app.world_mut().run_schedule(FixedPostUpdate);
//! assert_eq!(app.world().resource::<Contacts>().len(), 2); // each red one with the blue one
//! ```
//!
//! Layers, static entities, detectors and [worlds] are looked at in the broad phase, as are the
//! kinds of pairs in its [settings](crate::settings::BroadPhaseSettings::pair_kinds): a pair that
//! they rule out is gone before anything else sees it. Lists and hooks are asked about candidate
//! pairs, before the exact tests.

mod hooks;
mod ignore;
mod layers;
mod markers;
mod mask;
mod pair_filter;

use bevy::prelude::*;

pub use hooks::{PairHook, PairHookPlugin};
pub use ignore::IgnoreCollisions;
pub(crate) use ignore::ignore_each_other;
pub use layers::CollisionLayers;
pub(crate) use layers::{hear, refresh};
pub use markers::{Detector, Sensor, StaticShape};
pub use mask::{CollisionLayer, LayerMask};
pub(crate) use pair_filter::{FilterParts, filter, may_meet};

#[doc(inline)]
pub use crate::collision_layers;
use crate::worlds;

/// The plugin for layers, static entities, lists of entities to ignore, and worlds.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilterPlugin;

impl Plugin for FilterPlugin {
    fn build(&self, app: &mut App) {
        for register in [
            mask::register,
            layers::register,
            markers::register,
            ignore::register,
            worlds::register,
        ] {
            register(app);
        }
    }
}
