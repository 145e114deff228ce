//! What an entity says of itself: static, or a sensor.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};

use crate::components::change_filter;

/// Marks an entity that does not meet others of its kind: walls, floors, scenery.
///
/// Two static entities make no pair, however they overlap, and however they are moved; unless the
/// [`PairKinds`](crate::settings::BroadPhaseSettings::pair_kinds) say otherwise.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(on_insert = is_static, on_remove = is_not_static)]
#[doc(alias("static collider", "static body", "fixed", "scenery"))]
pub struct StaticShape;

/// Marks an entity whose contacts are reported, and that nothing bounces off; nor does it bounce
/// off anything.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[doc(alias("trigger", "area"))]
pub struct Sensor;

fn is_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = true);
}

fn is_not_static(world: DeferredWorld, context: HookContext) {
    change_filter(world, context, |filter| filter.is_static = false);
}

pub(super) fn register(app: &mut App) {
    app.register_type::<StaticShape>().register_type::<Sensor>();
}
