//! World boxes from transforms and shapes.

use bevy::{
    ecs::{entity_disabling::Disabled, schedule::InternedScheduleLabel, system::RegisteredSystemError},
    prelude::*,
};

use crate::{
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    narrow_phase::{BoundsError, NarrowPhase, Placed},
    plugin::{CollisionSystems, NarrowPhaseSettings},
};

/// Computes the [`WorldAabb`] of every entity whose shape or place in the world changed.
///
/// The place is taken from the [`Transform`]s of the entity and its ancestors, not from `GlobalTransform`, which is up
/// to date only after transform propagation: boxes are right in the tick in which something moved.
///
/// An entity whose box cannot be computed (a transform that is not finite, its own or an ancestor's) is left out of
/// collision detection, with a warning in the log, until its transform, an ancestor's, or its shape changes again. One
/// whose shape has no end has an [endless](WorldAabb::ENDLESS) box.
#[derive(Clone, Debug)]
pub struct BoundsPlugin(pub(crate) InternedScheduleLabel);

impl Plugin for BoundsPlugin {
    fn build(&self, app: &mut App) {
        let outdate = outdate_all.run_if(resource_changed::<NarrowPhaseSettings>);
        app.add_systems(self.0, (outdate, update_roots, update_children).chain().in_set(CollisionSystems::Bounds))
            .add_observer(on_unparented);
    }
}

/// Boxes are grown by the tolerance: when that changes, so do all of them.
fn outdate_all(mut proxies: Query<&mut BroadPhaseProxy>) {
    proxies.iter_mut().for_each(|mut proxy| proxy.set_changed());
}

/// Brings all boxes up to date, at any moment.
pub(crate) fn refresh(world: &mut World) -> Result<(), RegisteredSystemError> {
    world.run_system_cached(update_roots)?;
    world.run_system_cached(update_children)
}

type Bounded<'a> = (Entity, &'a CollisionShape, &'a Transform, &'a mut WorldAabb, &'a mut BroadPhaseProxy);
type ChangedRoot = (Without<ChildOf>, Or<(Changed<Transform>, Changed<CollisionShape>, Changed<BroadPhaseProxy>)>);

fn update_roots(mut roots: Query<Bounded, ChangedRoot>, settings: Res<NarrowPhaseSettings>) {
    for (entity, shape, transform, mut aabb, mut proxy) in &mut roots {
        proxy.bypass_change_detection().pose = *transform;
        *aabb = world_aabb(settings.tests(), entity, shape, transform);
    }
}

type Child<'a> = (Entity, Ref<'a, CollisionShape>, &'a mut WorldAabb, &'a mut BroadPhaseProxy);
/// What an ancestor, or the entity itself, has to do with where an entity is.
pub(crate) type Ancestor<'a> = (Ref<'a, Transform>, Option<Ref<'a, ChildOf>>);

pub(crate) fn update_children(
    mut children: Query<Child, With<ChildOf>>,
    // A disabled parent is still where it is.
    ancestors: Query<Ancestor, Allow<Disabled>>,
    settings: Res<NarrowPhaseSettings>,
) {
    for (entity, shape, mut aabb, mut proxy) in &mut children {
        let (world, moved) = place_in_world(entity, &ancestors);
        if moved || shape.is_changed() || proxy.is_changed() {
            let pose = world.compute_transform();
            proxy.bypass_change_detection().pose = pose;
            *aabb = world_aabb(settings.tests(), entity, &shape, &pose);
        }
    }
}

/// Where an entity is in the world, by its own transform and those of its ancestors; and whether any of these changed.
pub(crate) fn place_in_world(entity: Entity, ancestors: &Query<Ancestor, Allow<Disabled>>) -> (GlobalTransform, bool) {
    let (mut world, mut changed) = (GlobalTransform::IDENTITY, false);
    let mut next = Some(entity);
    while let Some(Ok((transform, parent))) = next.map(|ancestor| ancestors.get(ancestor)) {
        changed |= transform.is_changed() || parent.as_ref().is_some_and(|parent| parent.is_changed());
        world = *transform * world;
        next = parent.map(|parent| parent.parent());
    }
    (world, changed)
}

pub(crate) fn world_aabb(
    tests: &NarrowPhase,
    entity: Entity,
    shape: &CollisionShape,
    transform: &Transform,
) -> WorldAabb {
    match tests.world_aabb(Placed::new(&shape.0, transform)) {
        Ok(aabb) => WorldAabb(aabb),
        Err(BoundsError::Unbounded) => WorldAabb::ENDLESS,
        Err(error) => {
            tracing::warn!("{entity} is left out of collision detection: {error}");
            WorldAabb::NONE
        }
    }
}

/// An entity that loses its parent is elsewhere from then on, and so are its descendants.
fn on_unparented(
    event: On<Remove, ChildOf>,
    children: Query<&Children, Allow<Disabled>>,
    mut proxies: Query<&mut BroadPhaseProxy, Allow<Disabled>>,
) {
    for entity in std::iter::once(event.entity).chain(children.iter_descendants(event.entity)) {
        if let Ok(mut proxy) = proxies.get_mut(entity) {
            proxy.set_changed();
        }
    }
}
