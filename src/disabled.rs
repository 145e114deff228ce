//! Who is disabled, by whatever component, and how to see them all the same.
//!
//! To allow for Bevy's [`Disabled`](bevy::ecs::entity_disabling::Disabled) alone is not enough: apps may have others disable
//! entities, by [`DefaultQueryFilters::register_disabling_component`].

use bevy::{
    ecs::{
        archetype::Archetype,
        entity_disabling::DefaultQueryFilters,
        query::{QueryData, QueryFilter},
        system::System,
    },
    prelude::*,
};

/// Makes the queries of a system see entities that are disabled too, by whatever component.
pub(crate) fn see_disabled<S: IntoSystem<(), Out, M>, Out: 'static, M>(
    world: &mut World,
    system: S,
) -> S::System {
    let mut system = IntoSystem::into_system(system);
    without_filters(world, |world| {
        system.initialize(world);
    });
    system
}

/// Is an entity of this archetype disabled? For systems that [`see_disabled`] entities.
pub(crate) fn is_disabled(archetype: &Archetype, filters: Option<&DefaultQueryFilters>) -> bool {
    filters.is_some_and(|filters| filters.disabling_ids().any(|id| archetype.contains(id)))
}

/// Is this entity disabled?
pub(crate) fn is_entity_disabled(entity: EntityRef, world: &World) -> bool {
    is_disabled(entity.archetype(), world.get_resource())
}

/// Queries that are made while there are no filters never have any.
fn without_filters<T>(world: &mut World, mut make: impl FnMut(&mut World) -> T) -> T {
    let made = world.try_resource_scope(|world, _: Mut<DefaultQueryFilters>| make(world));
    made.unwrap_or_else(|| make(world))
}

/// A query that sees disabled entities too.
pub(crate) struct Unfiltered<D: QueryData + 'static, F: QueryFilter + 'static>(
    pub(crate) QueryState<D, F>,
);

impl<D: QueryData + 'static, F: QueryFilter + 'static> FromWorld for Unfiltered<D, F> {
    fn from_world(world: &mut World) -> Self {
        Self(without_filters(world, QueryState::new))
    }
}
