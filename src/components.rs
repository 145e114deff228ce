//! The components that an entity carries to take part in collision detection.

use bevy::prelude::*;

use crate::narrow_phase::Shape;

/// The shape of an entity. Inserting it makes the entity take part in collision detection.
#[derive(Component, Clone, Debug, Deref)]
#[require(Transform)]
pub struct CollisionShape(pub Shape);

impl From<Shape> for CollisionShape {
    fn from(shape: Shape) -> Self {
        Self(shape)
    }
}

/// How fast and where to an entity moves, in units per second.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect, Deref, DerefMut)]
#[reflect(Component, Debug, Default, PartialEq)]
#[require(Transform)]
pub struct Velocity(pub Vec3);
