//! Which body each shape belongs to, looked up where that may have changed.

use bevy::{
    ecs::{
        archetype::ArchetypeEntity, entity::EntityHashSet, message::signal_message_update_system,
    },
    prelude::*,
};

use super::relation::{CollisionBody, PartOf};
use crate::{
    ancestors,
    components::CollisionShape,
    regroup::{Due, Regroup},
    schedule::{CollisionSystems, add_to_tick},
};

/// Parts are told to which bodies they belong in this set: before anything moves.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RegroupSystems;

pub(super) fn register(app: &mut App) {
    add_to_tick(app, |app, schedule| {
        // Bevy's own system lets messages age, and touches nothing else.
        let regroup = regroup
            .in_set(RegroupSystems)
            .ambiguous_with(signal_message_update_system)
            .run_if(is_regroup_due);
        let set = RegroupSystems
            .after(CollisionSystems::First)
            .before(CollisionSystems::Motion);
        app.configure_sets(schedule, set)
            .add_systems(schedule, regroup);
    });
}

/// May something belong to another body than is known?
pub(crate) fn is_regroup_due(regroup: Res<Regroup>) -> bool {
    regroup.is_due()
}

/// Brings [`PartOf`] up to date on all entities of which it may have changed, and on what hangs on
/// them. Linear in these.
pub(crate) fn regroup(world: &mut World) {
    let Some(mut regroup) = world.get_resource_mut::<Regroup>() else {
        return;
    };
    let Due { mut entities, all } = regroup.take();
    regroup.set_writes(true);
    if all {
        entities = all_of(world);
    }
    // Whatever the order in which they were noted.
    entities.sort_unstable();
    entities.dedup();
    let mut visited = EntityHashSet::default();
    let mut open = Vec::new();
    for root in entities.drain(..) {
        if visited.contains(&root) || world.get_entity(root).is_err() {
            continue;
        }
        open.push((root, body_above(world, root)));
        while let Some((entity, above)) = open.pop() {
            if !visited.insert(entity) {
                continue;
            }
            let is_body = world.get::<CollisionBody>(entity).is_some();
            let body = if is_body { Some(entity) } else { above };
            put(world, entity, body);
            let children = world.get::<Children>(entity).into_iter().flatten();
            open.extend(children.map(|child| (*child, body)));
        }
    }
    world.resource_mut::<Regroup>().set_writes(false);
}

/// All that are parts, or may be, disabled ones included.
fn all_of(world: &World) -> Vec<Entity> {
    let [part, shape] = [
        world.component_id::<PartOf>(),
        world.component_id::<CollisionShape>(),
    ];
    let archetypes = world.archetypes().iter().filter(|archetype| {
        let mut ids = [part, shape].into_iter().flatten();
        ids.any(|id| archetype.contains(id))
    });
    archetypes
        .flat_map(|archetype| archetype.entities().iter().map(ArchetypeEntity::id))
        .collect()
}

/// The nearest body above an entity.
fn body_above(world: &World, entity: Entity) -> Option<Entity> {
    let parent = |entity| world.get::<ChildOf>(entity).map(ChildOf::parent);
    let look = |entity| Some((entity, parent(entity)));
    ancestors::up(parent(entity)?, look)
        .map_while(Result::ok)
        .find(|entity| world.get::<CollisionBody>(*entity).is_some())
}

/// Makes an entity a part of a body, if it has a shape, and of no other.
fn put(world: &mut World, entity: Entity, body: Option<Entity>) {
    let has_shape = world.get::<CollisionShape>(entity).is_some();
    let body = body.filter(|_| has_shape);
    let part = body.and_then(|body| Some(PartOf::new(body, *world.get(body)?)));
    if world.get::<PartOf>(entity) == part.as_ref() {
        return;
    }
    let mut entity = world.entity_mut(entity);
    match part {
        Some(part) => _ = entity.insert(part),
        None => _ = entity.remove::<PartOf>(),
    }
    let id = entity.id();
    world.resource_mut::<Regroup>().note_to_sweep(id);
}
