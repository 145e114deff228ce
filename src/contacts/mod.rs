//! Contacts: the exact verdict on every candidate pair, how it changes from tick to tick, who is
//! told, and for those who ask, the points at which two lie on each other.
//!
//! ```text
//! CandidatePairs --test_candidates--> Verdicts --merge_verdicts--> Contacts --Report--> messages, events, CollidingEntities
//!                                      ^    |
//!                                      resolve_impacts
//! ```

mod adjacency;
mod arrangement;
mod bodies;
mod body_events;
mod buckets;
mod colliding_entities;
mod collisions;
mod events;
mod find_manifolds;
mod ledger;
mod list;
mod manifolds;
mod narrow;
mod order;
mod pair;
mod report;
mod saved;
mod settings;
mod verdicts;
mod watched;
mod who;

use bevy::prelude::*;

pub use bodies::BodyCollision;
pub(crate) use bodies::Places;
pub use body_events::{BodyCollisionEnded, BodyCollisionStarted};
pub use colliding_entities::CollidingEntities;
pub use collisions::Collisions;
pub use events::{CollisionEnded, CollisionStarted};
pub use list::Contacts;
pub use narrow::NarrowPhasePlugin;
pub use pair::Collision;
pub(crate) use pair::{ContactKey, ContactPair, SweptContact};
pub use report::ReportPlugin;
pub(crate) use saved::SavedContacts;
pub use settings::{CollisionEventSettings, CollisionEventsEnabled, EventScope, ManifoldsEnabled};
pub(crate) use verdicts::Verdicts;

/// What others read though nothing is tested or told.
pub(crate) fn register(app: &mut App) {
    for register in [
        list::register,
        verdicts::register,
        settings::register,
        events::register,
        bodies::register,
        body_events::register,
        colliding_entities::register,
    ] {
        register(app);
    }
}
