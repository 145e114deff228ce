//! Who is told about contacts, and how much.

use bevy::prelude::*;

/// Opts an entity in to collision events: its observers are told of the contacts that it starts and
/// ends, and where they are is computed.
///
/// It may come and go at any time, and is looked at in the set
/// [`NarrowPhase`](crate::CollisionSystems::NarrowPhase). What an entity is told of are its
/// contacts *while it has opted in*: one that opts in during a contact is told at the next tick
/// that it started, and one that opts out is told at the next tick that it ended. So for every
/// start there is one end, whatever happens.
///
/// Who else is told, is up to the [`CollisionEventSettings`]. Costs by the contact: where all of 20
/// 000 moving cubes opt in and 782 contacts start and end in each tick, a tick takes 1.12 times the
/// instructions.
#[doc(alias("ActiveEvents", "collision event"))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionEventsEnabled;

/// Asks for the manifolds of the contacts of an entity: up to four points at which it lies on
/// another. They are read by [`Contacts::manifold`](super::Contacts::manifold) and
/// [`Collisions::manifold`](super::Collisions::manifold).
///
/// It asks for these alone: [`Collision::contact`](super::Collision::contact) stays `None` unless
/// somebody asks for that, too. The manifold tells the same and more, by its normal and its first
/// point, which is as deep as the contact.
///
/// It may come and go at any time, and is looked at in the set
/// [`NarrowPhase`](crate::CollisionSystems::NarrowPhase). Costs by the contact in which something
/// moves, and nothing where no entity has it.
#[doc(alias("contact manifold", "contact points"))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ManifoldsEnabled;

/// Which contacts something is done for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[type_path = "bevy_octree"]
pub enum EventScope {
    /// All of them.
    All,
    /// Those of entities with [`CollisionEventsEnabled`]; for manifolds, with
    /// [`ManifoldsEnabled`].
    Enabled,
}

/// The settings of reports, as a resource: who is told about contacts, and how much.
///
/// May be changed at any time: contacts that come into a scope start for it, and contacts that
/// leave it end, at the next tick.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionEventSettings {
    /// The contacts that messages are written for: by default, all. [`EventScope::Enabled`] are
    /// those of which one entity or both have opted in.
    pub messages: EventScope,
    /// The entities that events are triggered for: by default, those that have opted in. Observers
    /// are looked for once for each event, and there may be none: [`EventScope::All`] is not free.
    pub observers: EventScope,
    /// The contacts of which the geometry is computed, in every tick in which one of the two
    /// entities moves: by default, those of which one entity or both have opted in. It is computed
    /// for every contact that an event is triggered for in any case.
    pub geometry: EventScope,
    /// The contacts of which the manifold is computed, in every tick in which one of the two
    /// entities moves: by default, those of which one entity or both have [`ManifoldsEnabled`].
    pub manifolds: EventScope,
}

impl Default for CollisionEventSettings {
    fn default() -> Self {
        Self {
            messages: EventScope::All,
            observers: EventScope::Enabled,
            geometry: EventScope::Enabled,
            manifolds: EventScope::Enabled,
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<CollisionEventSettings>()
        .register_type::<CollisionEventSettings>()
        .register_type::<CollisionEventsEnabled>()
        .register_type::<ManifoldsEnabled>();
}
