//! From the data of entities to their shapes, as it changes.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};

use super::description::{CoreDescription, PartDescription, ShapeDescription};
use crate::{
    components::CollisionShape,
    disabled,
    narrow_phase::ShapeError,
    schedule::{CollisionSystems, add_to_tick},
};

/// Why an entity has no shape of its [`ShapeDescription`]: a component that is inserted, at the start
/// of a tick, on entities with one that makes none.
///
/// A shape that the entity had before stays. It is removed once that is no longer so: when the
/// data is changed to something that makes a shape, and with the `ShapeDescription`. An observer of
/// `On<Insert, ShapeDescriptionError>` is told of each failure.
///
/// It is not written to files: there, the data is what counts.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ShapeDescriptionError(
    /// What is wrong with the data.
    pub ShapeError,
);

impl ShapeDescription {
    /// Nothing is described any more, so nothing is wrong with it.
    pub(super) fn on_remove(mut world: DeferredWorld, context: HookContext) {
        let mut commands = world.commands();
        commands
            .entity(context.entity)
            .try_remove::<ShapeDescriptionError>();
    }
}

type Described<'a> = (
    Entity,
    &'a ShapeDescription,
    Option<&'a Name>,
    Has<CollisionShape>,
    Has<ShapeDescriptionError>,
);

/// Builds what was described anew since the last time.
fn follow(mut commands: Commands, changed: Query<Described, Changed<ShapeDescription>>) {
    for (entity, description, name, has_shape, has_error) in &changed {
        let mut entity_commands = commands.entity(entity);
        match description.build() {
            Ok(shape) => {
                entity_commands.try_insert(CollisionShape(shape));
                if has_error {
                    entity_commands.try_remove::<ShapeDescriptionError>();
                }
            }
            Err(error) => {
                let who = called(entity, name);
                if has_shape {
                    tracing::warn!("{who} keeps its former shape, as its data makes none: {error}");
                } else {
                    tracing::warn!("{who} has no shape of its data: {error}");
                }
                entity_commands.try_insert(ShapeDescriptionError(error));
            }
        }
    }
}

/// An entity, as the log has it.
fn called(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(
        || format!("entity {entity}"),
        |name| format!("entity {entity} \"{name}\""),
    )
}

pub(crate) fn register(app: &mut App) {
    app.register_type::<ShapeDescription>()
        .register_type::<CoreDescription>()
        .register_type::<PartDescription>()
        .register_type::<ShapeDescriptionError>();
    add_to_tick(app, |app, schedule| {
        // One that is disabled is to have the right shape when it no longer is.
        let follow = disabled::see_disabled(app.world_mut(), follow);
        app.add_systems(schedule, follow.in_set(CollisionSystems::First));
    });
}
