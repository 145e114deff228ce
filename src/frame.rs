//! The space that a velocity is in, and the way from there to the world and back.

use bevy::{
    math::{DAffine3, DMat3, DVec3},
    prelude::*,
};

use crate::{ancestors, disabled::is_entity_disabled, motion::Velocity};

/// What an entity hangs on: where its parent is in the world, how it is turned and stretched, and
/// how fast it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    to_world: DAffine3,
    /// `None` if an ancestor is scaled to nothing.
    to_own: Option<DAffine3>,
    drift: DVec3,
    depth: u32,
}

/// An ancestor of an entity, in the space of its own parent.
pub(crate) struct Ancestor {
    pub(crate) transform: Transform,
    /// Zero for one that nothing moves.
    pub(crate) velocity: Vec3,
    pub(crate) parent: Option<Entity>,
}

impl Ancestor {
    /// That of an app, as it is now.
    pub(crate) fn of(entity: Entity, world: &World) -> Option<Self> {
        let entity = world.get_entity(entity).ok()?;
        let velocity = entity
            .get::<Velocity>()
            .filter(|_| !is_entity_disabled(entity, world));
        Some(Self {
            transform: *entity.get()?,
            velocity: velocity.map_or(Vec3::ZERO, |velocity| velocity.0),
            parent: entity.get().map(ChildOf::parent),
        })
    }
}

impl Frame {
    /// That of an entity with this parent. A parent without a [`Transform`] ends the walk, as it
    /// does for boxes.
    pub(crate) fn of(parent: Entity, mut look: impl FnMut(Entity) -> Option<Ancestor>) -> Self {
        let (mut to_world, mut drift, mut depth) = (DAffine3::IDENTITY, DVec3::ZERO, 0);
        let with_parent = |entity| {
            let ancestor = look(entity)?;
            let parent = ancestor.parent;
            Some((ancestor, parent))
        };
        // What is its own ancestor has no box, and meets nothing.
        for ancestor in ancestors::up(parent, with_parent).map_while(Result::ok) {
            let Transform {
                translation,
                rotation,
                scale,
            } = ancestor.transform;
            let linear =
                DMat3::from_quat(rotation.as_dquat()) * DMat3::from_diagonal(scale.as_dvec3());
            to_world = DAffine3::from_mat3_translation(linear, translation.as_dvec3()) * to_world;
            // What is not finite moves nothing.
            let own = if ancestor.velocity.is_finite() {
                ancestor.velocity.as_dvec3()
            } else {
                DVec3::ZERO
            };
            drift = linear * drift + own;
            depth += 1;
        }
        let to_own = Some(to_world.inverse()).filter(DAffine3::is_finite);
        Self {
            to_world,
            to_own,
            drift,
            depth,
        }
    }

    /// How many ancestors there are.
    pub(crate) const fn depth(&self) -> u32 {
        self.depth
    }

    /// May a velocity in the world be expressed by one in this space?
    pub(crate) const fn leads_back(&self) -> bool {
        self.to_own.is_some()
    }

    /// The velocity in the world of what is at rest in this space.
    pub(crate) fn drift(&self) -> Vec3 {
        self.drift.as_vec3()
    }

    /// The same, going faster by so much.
    pub(crate) fn drifting(self, faster: Vec3) -> Self {
        Self {
            drift: self.drift + faster.as_dvec3(),
            ..self
        }
    }

    /// The velocity in the world of what has a velocity in this space.
    pub(crate) fn velocity_in_world(&self, own: Vec3) -> Vec3 {
        (self.to_world.transform_vector3(own.as_dvec3()) + self.drift).as_vec3()
    }

    /// The velocity in this space of what has a velocity in the world.
    pub(crate) fn own_velocity(&self, in_world: Vec3) -> Option<Vec3> {
        Some(
            self.to_own?
                .transform_vector3(in_world.as_dvec3() - self.drift)
                .as_vec3(),
        )
    }

    /// The position in the world of what is at a position in this space.
    pub(crate) fn position_in_world(&self, own: Vec3) -> Vec3 {
        self.to_world.transform_point3(own.as_dvec3()).as_vec3()
    }

    /// The position in this space of what is at a position in the world.
    pub(crate) fn own_position(&self, in_world: Vec3) -> Option<Vec3> {
        Some(self.to_own?.transform_point3(in_world.as_dvec3()).as_vec3())
    }
}

#[cfg(test)]
mod tests;
