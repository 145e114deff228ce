//! The order in which entities are told, where that has to be the same on several machines.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use serde::{Deserialize, Serialize};

use crate::{
    collision_index::CollisionIndex,
    components::{self, BroadPhaseProxy},
};

/// Where an entity stands in the order of all: by a number of its own, and not by its [`Entity`].
///
/// Contacts, messages, events and responses come in the order of entities, and of several things that
/// are as near, a query takes the first. That order is the same on every run of a program, but not on
/// two machines, or after a [rollback](crate::rollback) which spawns things anew: there the same thing
/// has another `Entity`. Give all that take part a number that they have everywhere, such as that by
/// which they are known in the network, when they are spawned; then they are told, and answer, in the
/// order of these numbers, whatever they were spawned in.
///
/// Who has none comes after all whose numbers have 32 bits, by its `Entity`. Of two with the same number, contacts take the one
/// with the lower `Entity` first, and queries the one with the lower handle in the index, which is up to who came and went: so
/// give each its own. One with another number leaves the index and enters it anew: what it
/// is in contact with ends, and starts.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{prelude::*, scene::Cube};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let mut spawn = |x, number| app.world_mut().spawn((Cube, CollisionOrder(number), Transform::from_xyz(x, 0.0, 0.0))).id();
/// let (later, earlier) = (spawn(0.0, 7), spawn(0.5, 3));
/// app.update();
/// let contact = app.world().resource::<Contacts>().iter().next().unwrap();
/// assert_eq!((contact.a, contact.b), (earlier, later));
/// ```
///
/// # Cost
/// 8 bytes for each object; a sort of the contacts in each tick. Without any, nothing.
#[doc(alias("network id", "rollback id", "deterministic", "sort key"))]
#[derive(
    Component,
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Reflect,
    Serialize,
    Deserialize,
)]
#[reflect(
    Component,
    Clone,
    Debug,
    Default,
    PartialEq,
    Hash,
    Serialize,
    Deserialize
)]
#[type_path = "bevy_octree"]
#[component(immutable, on_insert = enter_anew, on_remove = leave)]
pub struct CollisionOrder(pub u64);

/// What is in the index with another number leaves it, and comes back in the next tick.
fn enter_anew(mut world: DeferredWorld, HookContext { entity, .. }: HookContext) {
    let number = world.get::<CollisionOrder>(entity).map(|order| order.0);
    let id = world
        .get::<BroadPhaseProxy>(entity)
        .and_then(BroadPhaseProxy::id);
    let known = id
        .zip(world.get_resource::<CollisionIndex>())
        .and_then(|(id, index)| index.order_given(id));
    if id.is_some() && known != number {
        components::leave(&mut world, entity);
    }
}

fn leave(mut world: DeferredWorld, HookContext { entity, .. }: HookContext) {
    // Bodies without a shape are not in the index.
    if let Some(CollisionOrder(order)) = world.get(entity).copied()
        && let Some(mut index) = world.get_resource_mut::<CollisionIndex>()
    {
        index.remember_order(entity, order);
    }
    components::leave(&mut world, entity);
}

pub(crate) fn register(app: &mut App) {
    app.register_type::<CollisionOrder>();
}
