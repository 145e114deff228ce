//! What the report's scenes are made of.

use bevy::prelude::*;

use crate::{components::CollisionShape, motion::Velocity, response::Bounce};

/// A moving cube of side 1 that bounces: everything that a cube of the report's test sets needs, in
/// one component. Scale it by its [`Transform`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[type_path = "bevy_octree"]
#[reflect(Component, Debug, Default, PartialEq)]
#[require(CollisionShape, Velocity, Bounce)]
pub struct Cube;

pub(super) fn register(app: &mut App) {
    app.register_type::<Cube>();
}
