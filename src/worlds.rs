//! Independent worlds: many matches, levels or simulations in one app, whose entities never meet.
//!
//! A world is an entity, and entities say which one they are in. Those that say nothing are in the
//! default world.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! let world = app.world_mut();
//! let matches = [world.spawn_empty().id(), world.spawn_empty().id()];
//! for of_match in matches {
//!     for _ in 0..2 {
//!         world.spawn((CollisionShape::default(), InCollisionWorld(of_match)));
//!     }
//! }
//! app.update();
//! assert_eq!(app.world().resource::<Contacts>().len(), 2); // all four are in the same place
//!
//! // A match that is over takes its entities with it.
//! app.world_mut().despawn(matches[0]);
//! app.update();
//! assert_eq!(app.world().resource::<Contacts>().len(), 1);
//! ```
//!
//! Each entity says for itself which world it is in, children too: a hitbox that hangs on a ship is
//! in the default world unless it has an [`InCollisionWorld`] of its own.
//!
//! Queries see one world at a time: the default one, or that of
//! [`SpatialQueryFilter::in_world`](crate::spatial_query::SpatialQueryFilter::in_world); or all of
//! them, by [`in_any_world`](crate::spatial_query::SpatialQueryFilter::in_any_world).
//!
//! # Cost
//!
//! All worlds share one index. Worlds that overlap in space cost each other tests of boxes in the
//! broad phase, and no more: a pair of two worlds is gone before anything else sees it. Worlds that
//! are apart cost each other none.
//!
//! A whole tick of ten worlds of 2 000 moving cubes each, one contact to every two cubes or fewer,
//! on one thread:
//!
//! | all ten in the same place | cubes move up to 1/40 of their side | up to half of it |
//! |---|---|---|
//! | time, by that of ten far apart | 1.05 | 1.3 |
//! | time, by ten times that of one alone | 1.1 | 1.4 |
//! | instructions, by those of ten far apart | 1.05 | 1.16 |
//!
//! Slow objects pay less, for pairs of two worlds are sought once in several ticks.

use bevy::{
    ecs::{entity::EntityHashSet, lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};

use crate::{broad_phase::PairFilter, components::change_filter};

/// Names the world that an entity is in.
///
/// Insert another to move it; remove it, and the entity is in the default world. Contacts follow at
/// the next tick.
///
/// It is about this entity alone: its children say for themselves which world they are in.
#[derive(Component, FromTemplate, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Clone, Debug, FromWorld, PartialEq)]
#[type_path = "bevy_octree"]
#[relationship(relationship_target = CollisionWorld)]
#[component(on_insert = enter, on_remove = leave)]
pub struct InCollisionWorld(#[entities] pub Entity);

/// An entity has to be given: this one is none, for reflection to fill in.
impl FromWorld for InCollisionWorld {
    fn from_world(_: &mut World) -> Self {
        Self(Entity::PLACEHOLDER)
    }
}

/// The entities that are in this world. It comes by itself to an entity that is named in an
/// [`InCollisionWorld`], and goes with the last of them.
///
/// When it is despawned, so are they; when only this component is removed, they are in the default
/// world.
#[doc(alias("physics world", "match", "room", "dimension"))]
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[relationship_target(relationship = InCollisionWorld, linked_spawn)]
pub struct CollisionWorld(EntityHashSet);

impl CollisionWorld {
    /// Returns all of them, in no particular order.
    #[must_use]
    pub const fn entities(&self) -> &EntityHashSet {
        &self.0
    }
}

/// The number of a world in the broad phase. A despawned world takes its entities with it, so that
/// no two worlds of one number have entities at a time; and no entity has the number of the default
/// world.
pub(crate) const fn number(world: Entity) -> u32 {
    world.index_u32()
}

fn enter(world: DeferredWorld, context: HookContext) {
    let Some(&InCollisionWorld(entered)) = world.get(context.entity) else {
        return;
    };
    change_filter(world, context, |filter| filter.world = number(entered));
}

fn leave(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| {
        filter.world = PairFilter::DEFAULT_WORLD;
    });
}

pub(crate) fn register(app: &mut App) {
    app.register_type::<InCollisionWorld>()
        .register_type::<CollisionWorld>();
}
