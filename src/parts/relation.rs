//! Bodies and their parts, as components.

use bevy::{
    ecs::{
        entity::{EntityHashMap, EntityHashSet},
        lifecycle::HookContext,
        world::DeferredWorld,
    },
    prelude::*,
};
use serde::{Deserialize, Serialize};

use crate::{
    broad_phase::PairFilter,
    components::change_filter,
    disabled::Unfiltered,
    regroup::{self, Regroup},
};

/// Marks an entity that is one thing together with all shapes that hang on it, and its own: see the
/// [module's documentation](crate::parts).
///
/// It is immutable: insert another to change it.
#[doc(alias("rigid body", "compound", "ship", "vehicle", "compound collider"))]
#[derive(
    Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize,
)]
#[reflect(Component, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[component(immutable, on_add = count, on_insert = look_again, on_remove = discount)]
#[require(Transform)]
pub struct CollisionBody {
    /// Do its parts meet each other? By default they do not. What two of them do to each other
    /// changes nothing about how the body moves.
    pub inner_contacts: bool,
}

/// Says which body a shape is a part of. Kept up to date by the library, for all shapes that hang on
/// a [`CollisionBody`], and that of the body itself; what others write is undone in the next tick.
///
/// A cloned entity gets one of its own.
#[derive(Component, Clone, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, FromWorld, PartialEq)]
#[type_path = "bevy_octree"]
#[relationship(relationship_target = BodyParts, allow_self_referential)]
#[component(on_insert = join, on_remove = leave, clone_behavior = Ignore)]
#[doc(alias("collider of", "compound", "parent"))]
pub struct PartOf {
    #[relationship]
    #[entities]
    body: Entity,
    /// Does it meet other parts of the body?
    inner_contacts: bool,
}

impl PartOf {
    pub(super) const fn new(body: Entity, settings: CollisionBody) -> Self {
        Self {
            body,
            inner_contacts: settings.inner_contacts,
        }
    }

    /// Returns the body.
    #[must_use]
    pub const fn body(&self) -> Entity {
        self.body
    }

    /// The number of the body in the broad phase, which no other body has that is there.
    pub(crate) const fn number(&self) -> u32 {
        if self.inner_contacts {
            PairFilter::NO_BODY
        } else {
            self.body.index_u32()
        }
    }
}

/// A body has to be given: this one is none, for reflection to fill in.
impl FromWorld for PartOf {
    fn from_world(_: &mut World) -> Self {
        Self::new(Entity::PLACEHOLDER, CollisionBody::default())
    }
}

/// The parts of a [`CollisionBody`]: the shapes that hang on it and on no body in between, and its
/// own. Comes with the first part and goes with the last.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[relationship_target(relationship = PartOf)]
pub struct BodyParts(EntityHashSet);

impl BodyParts {
    /// Returns all of them, in no particular order.
    #[must_use]
    pub const fn entities(&self) -> &EntityHashSet {
        &self.0
    }
}

/// The bodies of all parts, for queries that see nothing of what is disabled, by whatever component: such parts are parts
/// all the same.
#[derive(Resource, Debug, Default)]
pub(crate) struct KnownParts(EntityHashMap<Entity>);

impl KnownParts {
    /// The body that an entity is a part of; what is part of none is its own.
    pub(crate) fn body_of(&self, entity: Entity) -> Entity {
        self.0.get(&entity).copied().unwrap_or(entity)
    }
}

fn join(mut world: DeferredWorld, context: HookContext) {
    regroup::note_written(&mut world, context.entity);
    let Some(part) = world.get::<PartOf>(context.entity) else {
        return;
    };
    let (body, number) = (part.body(), part.number());
    if let Some(mut known) = world.get_resource_mut::<KnownParts>() {
        known.0.insert(context.entity, body);
    }
    change_filter(world, context, |filter| filter.body = number);
}

fn leave(mut world: DeferredWorld, context: HookContext) {
    regroup::note_written(&mut world, context.entity);
    if let Some(mut known) = world.get_resource_mut::<KnownParts>() {
        known.0.remove(&context.entity);
    }
    change_filter(world, context, |filter| filter.body = PairFilter::NO_BODY);
}

fn count(mut world: DeferredWorld, _: HookContext) {
    let observes = world
        .get_resource_mut::<Regroup>()
        .is_some_and(|mut regroup| {
            regroup.add_body();
            regroup.observe()
        });
    if observes {
        world.commands().queue(observe);
    }
}

fn discount(mut world: DeferredWorld, context: HookContext) {
    regroup::note(&mut world, context.entity);
    if let Some(mut regroup) = world.get_resource_mut::<Regroup>() {
        regroup.remove_body();
    }
}

fn look_again(mut world: DeferredWorld, context: HookContext) {
    regroup::note(&mut world, context.entity);
}

/// Has it noted from now on where entities hang. Apps without bodies do without.
fn observe(world: &mut World) {
    world.add_observer(|event: On<Insert, ChildOf>, mut world: DeferredWorld| {
        regroup::note(&mut world, event.entity);
    });
    world.add_observer(|event: On<Remove, ChildOf>, mut world: DeferredWorld| {
        regroup::note(&mut world, event.entity);
    });
}

pub(super) fn register(app: &mut App) {
    app.init_resource::<Regroup>()
        .register_type::<CollisionBody>()
        .register_type::<PartOf>()
        .register_type::<BodyParts>();
    // Those that came before.
    let world = app.world_mut();
    let mut parts = Unfiltered::<(Entity, &PartOf), ()>::from_world(world);
    let known = parts
        .0
        .iter(world)
        .map(|(entity, part)| (entity, part.body()));
    let known = KnownParts(known.collect());
    world.insert_resource(known);
    let bodies = Unfiltered::<(), With<CollisionBody>>::from_world(world)
        .0
        .iter(world)
        .count();
    world.resource_mut::<Regroup>().begin(bodies);
    if bodies > 0 && world.resource_mut::<Regroup>().observe() {
        observe(world);
    }
}
