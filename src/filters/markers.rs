//! What an entity says of itself: static, a sensor, or a detector.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use serde::{Deserialize, Serialize};

use crate::components::change_filter;

/// Marks an entity that does not meet others of its kind: walls, floors, scenery.
///
/// Two static entities make no pair, however they overlap, and however they are moved; unless the
/// [`PairKinds`](crate::settings::BroadPhaseSettings::pair_kinds) say otherwise.
#[doc(alias(
    "static collider",
    "static body",
    "fixed",
    "scenery",
    "StaticBody3D",
    "immovable"
))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[component(on_insert = is_static, on_remove = is_not_static)]
pub struct StaticShape;

/// Marks an entity whose contacts are reported, and that nothing bounces off; nor does it bounce
/// off anything.
///
/// Rays and other queries see it as they see all others, unless their filter is
/// [`without_sensors`](crate::spatial_query::SpatialQueryFilter::without_sensors). How to make a
/// trigger or a pickup of it: see the [guide](crate::guide::triggers).
#[doc(alias(
    "trigger",
    "area",
    "trigger volume",
    "ghost object",
    "hitbox",
    "hurtbox",
    "Area3D"
))]
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
pub struct Sensor;

/// Marks an entity that hears of all that is on a layer which it may meet, though that may not meet
/// it: detection is one-way.
///
/// Without it, two entities meet if each is on a layer that the [other may
/// meet](super::CollisionLayers::filters). With it, what the other may meet no longer decides
/// whether the two are in contact, but only whether the other hears of it:
///
/// | | told: messages | told: observers, [`CollidingEntities`], [`Collisions::of`] | bounces |
/// |---|---|---|---|
/// | who may meet the other | yes | yes | as ever |
/// | who may not | | no | no: for the other it is a wall that moves as its velocity says |
///
/// In the list of all [`Contacts`](crate::contacts::Contacts), such a pair is one contact like all
/// others, and [`hears`](crate::contacts::Collision::hears) tells who hears of it. Its
/// [message](crate::contacts::CollisionStarted) has the detector first. A detector on no layer at
/// all is one that nobody ever hears of.
///
/// Pairs of which neither hears are gone in the broad phase, like all that layers rule out; an app
/// without detectors pays nothing for them.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// collision_layers! {
///     enum Layer { Ground, Player }
/// }
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let ground = CollisionLayers::new(Layer::Player, Layer::Ground);
/// let player = app.world_mut().spawn((CollisionShape::sphere(1.0), ground, CollidingEntities::default())).id();
/// // A trap: on no layer, and so nothing that a player hears of.
/// let players = CollisionLayers::new(LayerMask::NONE, Layer::Player);
/// let trap = app.world_mut().spawn((CollisionShape::sphere(5.0), Sensor, Detector, players, CollidingEntities::default())).id();
/// app.update();
/// assert!(app.world().get::<CollidingEntities>(trap).unwrap().contains(&player));
/// assert!(app.world().get::<CollidingEntities>(player).unwrap().is_empty());
/// ```
///
/// [`CollidingEntities`]: crate::contacts::CollidingEntities
/// [`Collisions::of`]: crate::contacts::Collisions::of
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[component(on_insert = is_detector, on_remove = is_no_detector)]
#[doc(alias("one-way", "one way", "monitoring", "area", "trigger"))]
pub struct Detector;

fn is_detector(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_detector = true);
}

fn is_no_detector(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_detector = false);
}

fn is_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = true);
}

fn is_not_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = false);
}

pub(super) fn register(app: &mut App) {
    app.register_type::<StaticShape>()
        .register_type::<Sensor>()
        .register_type::<Detector>();
}
