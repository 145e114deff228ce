//! Lists of entities to ignore.

use bevy::{
    ecs::{entity::EntityHashSet, lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};

use crate::{
    collision_index::{CandidatePairs, CollisionIndex},
    components::in_index,
    schedule::{PairFilterSystems, add_to_tick},
};

/// Lists entities that this one does not meet: its owner, its parts.
///
/// One of the two having the other in its list is enough. Entities in the list that are gone, or
/// have no shape, do no harm. It is immutable: insert a new list to change it.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let ship = app.world_mut().spawn(CollisionShape::sphere(1.0)).id();
/// app.world_mut().spawn((CollisionShape::sphere(0.1), IgnoreCollisions::from(ship)));
/// app.update();
/// assert!(app.world().resource::<Contacts>().is_empty());
/// ```
#[doc(alias("IgnoreCollision", "collision exception", "owner"))]
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Deref, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(immutable, on_insert = look_again, on_discard = look_again)]
pub struct IgnoreCollisions(#[entities] pub EntityHashSet);

impl<const N: usize> From<[Entity; N]> for IgnoreCollisions {
    fn from(entities: [Entity; N]) -> Self {
        Self(entities.into_iter().collect())
    }
}

impl From<Entity> for IgnoreCollisions {
    fn from(entity: Entity) -> Self {
        Self::from([entity])
    }
}

impl FromIterator<Entity> for IgnoreCollisions {
    fn from_iter<I: IntoIterator<Item = Entity>>(entities: I) -> Self {
        Self(entities.into_iter().collect())
    }
}

/// Has the pairs of an entity sought anew, those in which nothing moved too.
fn look_again(mut world: DeferredWorld, context: HookContext) {
    in_index(&mut world, context.entity, CollisionIndex::look_again);
}

/// Does one of the two have the other in its list?
pub(crate) fn ignore_each_other<'a>(
    [a, b]: [Entity; 2],
    list: impl Fn(Entity) -> Option<&'a IgnoreCollisions>,
) -> bool {
    let ignores = |one, other| list(one).is_some_and(|list| list.contains(&other));
    ignores(a, b) || ignores(b, a)
}

pub(super) fn register(app: &mut App) {
    app.register_type::<IgnoreCollisions>();
    add_to_tick(app, |app, schedule| {
        let some_ignore = |lists: Query<(), With<IgnoreCollisions>>| !lists.is_empty();
        app.add_systems(
            schedule,
            ignore.in_set(PairFilterSystems).run_if(some_ignore),
        );
    });
}

/// Takes out pairs of which one entity ignores the other.
pub(super) fn ignore(
    lists: Query<&IgnoreCollisions>,
    index: Res<CollisionIndex>,
    mut candidates: ResMut<CandidatePairs>,
) {
    candidates
        .retain(|pair| !ignore_each_other(index.entities(*pair), |entity| lists.get(entity).ok()));
}
