//! The entities that an entity is in contact with, as a component of its own.

use bevy::{
    ecs::{archetype::Archetype, entity::EntityHashSet, entity_disabling::DefaultQueryFilters},
    prelude::*,
};

use super::list::Contacts;
use crate::{components::BroadPhaseProxy, disabled, parts::CollisionBody};

/// The entities that this entity is in contact with, as far as it hears of them (see
/// [`Detector`](crate::filters::Detector)). Add it to entities that are to have it; it is
/// kept up to date in the set [`Report`](crate::CollisionSystems::Report), together with the
/// messages.
///
/// It counts as [changed](bevy::ecs::query::Changed) only in ticks in which the set changed.
/// Entities that are gone leave it in the tick in which their contact ends. In an entity without a
/// shape it is empty. What others write to it is undone at the next tick.
///
/// Where entities are copied into another world, as from a scene, those in the set are mapped to
/// their copies.
///
/// That of a [`CollisionBody`](crate::parts::CollisionBody) lists the bodies that its parts touch,
/// sensors or not, and what they touch that is part of none.
///
/// The order in which it iterates is not that of the contacts: for that see
/// [`Collisions::colliding_with`](super::Collisions::colliding_with).
#[doc(alias("overlapping bodies", "get_overlapping_bodies", "touching"))]
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Deref, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(clone_behavior = Ignore)]
pub struct CollidingEntities(#[entities] pub EntityHashSet);

type Lists<'a> = (
    Entity,
    &'a mut CollidingEntities,
    Option<&'a BroadPhaseProxy>,
    Has<CollisionBody>,
    &'a Archetype,
);

pub(super) fn is_in_use(lists: Query<(), With<CollidingEntities>>) -> bool {
    !lists.is_empty()
}

/// A disabled entity touches nothing, and its list says so. For a system that [sees
/// it](disabled::see_disabled).
pub(super) fn follow_contacts(
    contacts: Res<Contacts>,
    filters: Option<Res<DefaultQueryFilters>>,
    mut lists: Query<Lists>,
) {
    for (entity, mut list, proxy, is_body, archetype) in &mut lists {
        if disabled::is_disabled(archetype, filters.as_deref()) {
            update(&mut list, std::iter::empty);
            continue;
        }
        if is_body {
            let others = || {
                let pairs = contacts.body_pairs();
                pairs.filter_map(move |pair| {
                    let [a_hears, b_hears] = pair.hears;
                    let hears = (pair.a == entity && a_hears) || (pair.b == entity && b_hears);
                    pair.other(entity).filter(|_| hears)
                })
            };
            // Solid parts and sensors may touch the same one; these come one after the other.
            let others = || {
                let mut last = None;
                others().filter(move |other| last.replace(*other) != Some(*other))
            };
            update(&mut list, others);
            continue;
        }
        let others = || {
            let own = proxy
                .and_then(BroadPhaseProxy::id)
                .map(|id| contacts.of_handle(entity, id));
            own.into_iter()
                .flatten()
                .map(|contact| contact.other(entity))
        };
        update(&mut list, others);
    }
}

/// Has a list consist of these, each given once, and touches it only if it does not.
fn update<I: Iterator<Item = Entity>>(list: &mut Mut<CollidingEntities>, others: impl Fn() -> I) {
    if others().count() != list.len() || !others().all(|other| list.contains(&other)) {
        list.0.clear();
        list.0.extend(others());
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<CollidingEntities>();
}

#[cfg(test)]
mod tests {
    use bevy::ecs::entity::EntityHashMap;

    use super::*;

    #[test]
    fn entities_are_mapped() {
        let mut world = World::new();
        let [a, b, copy_of_a] = [(); 3].map(|()| world.spawn_empty().id());
        let mut list = CollidingEntities(EntityHashSet::from_iter([a, b]));
        CollidingEntities::map_entities(&mut list, &mut EntityHashMap::from_iter([(a, copy_of_a)]));
        assert_eq!(
            list,
            CollidingEntities(EntityHashSet::from_iter([copy_of_a, b]))
        );
    }
}
