//! Who answers to what an entity meets: itself, or the body that it is a part of.

use bevy::{
    ecs::{archetype::Archetype, entity_disabling::DefaultQueryFilters, system::SystemParam},
    prelude::*,
};

use super::bounce::Bounce;
use crate::{
    disabled::{is_disabled, is_entity_disabled},
    parts::{CollisionBody, PartOf},
    swept::Swept,
};

/// Tells who answers in place of a part: its body, if that bounces or is swept.
#[derive(SystemParam)]
pub(super) struct Answering<'w, 's> {
    parts: Query<'w, 's, &'static PartOf>,
    bodies: Query<'w, 's, &'static Archetype, Answers>,
    filters: Option<Res<'w, DefaultQueryFilters>>,
}

/// A body that answers for its parts.
type Answers = (
    With<CollisionBody>,
    With<Transform>,
    Or<(With<Bounce>, With<Swept>)>,
);

impl Answering<'_, '_> {
    /// Does everything answer for itself?
    pub(super) fn is_idle(&self) -> bool {
        self.parts.is_empty() || self.bodies.is_empty()
    }

    pub(super) fn who(&self, entity: Entity) -> Entity {
        let body = self.parts.get(entity).map(PartOf::body);
        body.ok()
            .filter(|body| {
                let archetype = self.bodies.get(*body);
                archetype.is_ok_and(|archetype| !is_disabled(archetype, self.filters.as_deref()))
            })
            .unwrap_or(entity)
    }
}

/// The body that answers in place of an entity, if there is one; that may be the entity itself. As
/// [`Answering`] tells.
pub(super) fn lead_of(entity: Entity, world: &World) -> Option<Entity> {
    let body = world.get::<PartOf>(entity)?.body();
    is_lead(body, world).then_some(body)
}

/// Does a body answer for its parts?
pub(super) fn is_lead(body: Entity, world: &World) -> bool {
    world.get_entity(body).is_ok_and(|entity| {
        entity.contains::<CollisionBody>()
            && entity.contains::<Transform>()
            && (entity.contains::<Bounce>() || entity.contains::<Swept>())
            && !is_entity_disabled(entity, world)
    })
}
