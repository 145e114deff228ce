//! Casts what casters say, all of them side by side.

use bevy::{
    ecs::{
        archetype::Archetype,
        component::Mutable,
        entity_disabling::DefaultQueryFilters,
        query::{QueryData, QueryFilter},
    },
    math::DAffine3,
    prelude::*,
};

use super::{filter::CasterFilter, hits::Hits};
use crate::{
    ancestors, disabled,
    hierarchy::{self, Link},
    parallel,
    parts::CollisionBody,
    spatial_query::{SpatialQuery, SpatialQueryFilter},
    worlds::InCollisionWorld,
};

/// A component that says what is cast.
pub(super) trait Caster: Component {
    /// Where it is told what was met.
    type Hits: Component<Mutability = Mutable> + Hits;

    /// Which entities it sees; `None` if it looks at none at all.
    fn filter(&self) -> Option<&CasterFilter>;

    /// Finds what is met, given where the entity is.
    fn find(
        &self,
        pose: &DAffine3,
        spatial: &SpatialQuery,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<<Self::Hits as Hits>::Hit>,
    );
}

type Parts<'a, C> = (
    Entity,
    &'a C,
    &'a mut <C as Caster>::Hits,
    Option<&'a InCollisionWorld>,
    &'a Archetype,
);

type Item<'a, 'w, 's, C> = <Parts<'a, C> as QueryData>::Item<'w, 's>;

/// A disabled entity meets nothing, and its hits say so. For a system that [sees
/// it](disabled::see_disabled).
pub(super) fn cast<C: Caster>(
    mut casters: Query<Parts<C>>,
    links: Query<Link>,
    parents: Query<&ChildOf>,
    bodies: Query<(), With<CollisionBody>>,
    filters: Option<Res<DefaultQueryFilters>>,
    spatial: SpatialQuery,
) {
    let parent = |entity| parents.get(entity).ok().map(ChildOf::parent);
    // Where there are none, nobody looks for one.
    let are_bodies = !bodies.is_empty();
    let body = |entity| {
        let look = |entity| Some((entity, parent(entity)));
        let up = are_bodies.then(|| ancestors::up(entity, look))?;
        up.map_while(Result::ok)
            .find(|entity| bodies.contains(*entity))
    };
    let renew = |caster: Item<'_, '_, '_, C>| {
        let (entity, caster, mut hits, world, archetype) = caster;
        let has_changed = hits.bypass_change_detection().renew(|hits| {
            let is_disabled = disabled::is_disabled(archetype, filters.as_deref());
            let filter = caster.filter().filter(|_| !is_disabled);
            if let Some(filter) = filter
                && let Some(pose) = pose(entity, &links)
            {
                filter.apply(entity, world, parent, body, |filter| {
                    caster.find(&pose, &spatial, filter, hits);
                });
            }
        });
        if has_changed {
            hits.set_changed();
        }
    };
    if parallel::is_on() {
        casters.par_iter_mut().for_each(renew);
    } else {
        casters.iter_mut().for_each(renew);
    }
}

/// Where an entity is in the world, by now; `None` if that is nowhere.
pub(crate) fn pose<F: QueryFilter>(entity: Entity, links: &Query<Link, F>) -> Option<DAffine3> {
    // Without a transform of its own, there is no walk up.
    links.get(entity).ok()?;
    let look = |entity| {
        let (transform, parent) = links.get(entity).ok()?;
        Some((hierarchy::local(transform), parent.map(ChildOf::parent)))
    };
    ancestors::up(entity, look)
        .try_fold(DAffine3::IDENTITY, |below, local| {
            local.map(|local| local * below)
        })
        .ok()
        .filter(DAffine3::is_finite)
}

/// A direction of an entity's own space in the world; `None` if nothing is left of it there.
pub(super) fn direction(own: Dir3, pose: &DAffine3) -> Option<Dir3> {
    let there = pose.transform_vector3(own.as_dvec3()).try_normalize()?;
    Dir3::new(there.as_vec3()).ok()
}
