//! Shapes that follow Rapier's colliders.

use std::sync::Arc;

use bevy::{
    ecs::{lifecycle::HookContext, schedule::InternedScheduleLabel, world::DeferredWorld},
    prelude::*,
};
use bevy_rapier3d::geometry::{Collider, RapierColliderHandle};

use crate::{
    components::CollisionShape, disabled, narrow_phase::Shape, schedule::CollisionSystems,
};

/// Gives an entity the shape of its Rapier `Collider`.
///
/// Its [`CollisionShape`] comes with the collider, follows it when it changes or is scaled, and
/// goes with it, or with this marker. A shape that others give to the entity is replaced.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(on_remove = drop_shape)]
#[doc(alias = "collider")]
pub struct ShapeFromRapier;

pub(super) fn register(app: &mut App) {
    app.add_observer(on_collider_removed)
        .register_type::<ShapeFromRapier>();
}

pub(super) fn add_systems(app: &mut App, schedule: InternedScheduleLabel) {
    let follow = disabled::see_disabled(app.world_mut(), follow_colliders);
    app.add_systems(
        schedule,
        follow
            .after(CollisionSystems::Motion)
            .before(CollisionSystems::Bounds),
    );
}

type Followed<'a> = (Entity, &'a Collider, Option<&'a mut CollisionShape>);
/// Colliders that Rapier has scaled: it does so right after it gave them a handle.
type Known = (With<ShapeFromRapier>, With<RapierColliderHandle>);
type Altered = Or<(
    Changed<Collider>,
    Added<ShapeFromRapier>,
    Added<RapierColliderHandle>,
)>;

fn follow_colliders(
    mut commands: Commands,
    // What changes in a disabled entity is not seen as a change once it is enabled.
    mut colliders: Query<Followed, (Known, Altered)>,
) {
    for (entity, collider, shape) in &mut colliders {
        match shape {
            // Colliders are marked as changed more often than they do. Who writes to a shape that
            // is shared, here too, writes to a copy.
            Some(shape) if matches!(&shape.0, Shape::Rapier(known) if Arc::ptr_eq(&known.raw().0, &collider.raw.0)) =>
                {}
            Some(mut shape) => shape.0 = collider.into(),
            None => {
                commands
                    .entity(entity)
                    .try_insert(CollisionShape(collider.into()));
            }
        }
    }
}

/// The shape goes in the moment in which the collider goes.
fn on_collider_removed(event: On<Remove, Collider>, mut world: DeferredWorld) {
    if world.get::<ShapeFromRapier>(event.entity).is_some() {
        world
            .commands()
            .entity(event.entity)
            .try_remove::<CollisionShape>();
    }
}

fn drop_shape(mut world: DeferredWorld, context: HookContext) {
    world
        .commands()
        .entity(context.entity)
        .try_remove::<CollisionShape>();
}
