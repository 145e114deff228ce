//! Thin walls, and bullets that are looked at all along their way.

use bevy::prelude::*;
use bevy_octree::prelude::*;

use crate::common::*;

pub const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

/// A static box.
pub fn wall(app: &mut App, center: Vec3, half_size: Vec3) -> Entity {
    let shape = CollisionShape::from_half_size(half_size);
    app.world_mut()
        .spawn((shape, Transform::from_translation(center)))
        .id()
}

/// A wall as thin as paper, across the x axis.
pub fn paper(app: &mut App, x: f32) -> Entity {
    wall(app, Vec3::X * x, Vec3::new(0.001, 50.0, 50.0))
}

/// A swept ball of diameter 0.1 that moves by `step` per tick.
pub fn bullet(app: &mut App, start: Vec3, step: Vec3) -> Entity {
    let shape = CollisionShape::sphere(0.05);
    let velocity = Velocity(step * TICKS_PER_SECOND);
    app.world_mut()
        .spawn((
            shape,
            Swept::default(),
            Transform::from_translation(start),
            velocity,
        ))
        .id()
}

/// A [`bullet`] that loses nothing.
pub fn elastic_bullet(app: &mut App, start: Vec3, step: Vec3) -> Entity {
    let bullet = bullet(app, start, step);
    app.world_mut().entity_mut(bullet).insert(ELASTIC);
    bullet
}

/// Where an entity is, in the space of its parent.
pub fn place(app: &App, entity: Entity) -> Vec3 {
    get::<Transform>(app, entity).translation
}
