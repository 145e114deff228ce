//! The space that a velocity is in, and the way from there to the world and back.

use bevy::{
    ecs::entity_disabling::Disabled,
    math::{DAffine3, DMat3, DVec3},
    prelude::*,
};

use crate::{ancestors, motion::Velocity};

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
            .filter(|_| !entity.contains::<Disabled>());
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

    /// The position in this space of what is at a position in the world.
    pub(crate) fn own_position(&self, in_world: Vec3) -> Option<Vec3> {
        Some(self.to_own?.transform_point3(in_world.as_dvec3()).as_vec3())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-reach..reach).prop_map(Vec3::from)
    }

    /// Turned, stretched, mirrored; with a child of its own, sheared.
    fn places() -> impl Strategy<Value = Transform> {
        let scale =
            prop::array::uniform3(prop_oneof![0.25f32..4.0, -4f32..-0.25]).prop_map(Vec3::from);
        (vectors(10.0), vectors(2.0), scale).prop_map(|(translation, turn, scale)| Transform {
            translation,
            rotation: Quat::from_scaled_axis(turn),
            scale,
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// What moves for a moment, together with all that it hangs on, moves as far in the world
        /// as the velocity says.
        #[test]
        fn a_velocity_in_the_world_is_what_moves_there(
            chain in prop::collection::vec((places(), vectors(5.0)), 1..4),
            (place, own) in (vectors(3.0), vectors(5.0)),
        ) {
            let mut world = World::new();
            let mut parent = None;
            for (transform, velocity) in &chain {
                let entity = world.spawn((*transform, Velocity(*velocity))).id();
                if let Some(parent) = parent.replace(entity) {
                    world.entity_mut(entity).insert(ChildOf(parent));
                }
            }
            let frame = Frame::of(parent.unwrap(), |entity| Ancestor::of(entity, &world));
            let in_world = |seconds: f64| chain.iter().rev().fold(place.as_dvec3() + own.as_dvec3() * seconds, |at, (t, v)| {
                let turned = t.rotation.as_dquat() * (t.scale.as_dvec3() * at);
                turned + t.translation.as_dvec3() + v.as_dvec3() * seconds
            });
            let moved = (in_world(1.0) - in_world(0.0)).as_vec3();
            let size = 1.0 + moved.length();
            prop_assert!(frame.velocity_in_world(own).distance(moved) < 1e-4 * size);
            let back = [frame.own_velocity(moved), frame.own_position(in_world(0.0).as_vec3())].map(Option::unwrap);
            prop_assert!(back[0].distance(own) < 1e-2 && back[1].distance(place) < 1e-2, "{back:?}");
        }
    }

    #[test]
    fn what_goes_round_in_circles_or_is_flat_has_an_answer() {
        let mut world = World::new();
        let round = Ancestor {
            transform: Transform::IDENTITY,
            velocity: Vec3::X,
            parent: None,
        };
        let parent = world
            .spawn(Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)))
            .id();
        let look = |_| {
            Some(Ancestor {
                parent: Some(parent),
                ..round
            })
        };
        assert!(Frame::of(parent, look).depth() < 4);
        let flat = Frame::of(parent, |entity| Ancestor::of(entity, &world));
        assert_eq!(
            (flat.leads_back(), flat.own_velocity(Vec3::X)),
            (false, None)
        );
        assert_eq!(flat.velocity_in_world(Vec3::ONE), Vec3::new(1.0, 0.0, 1.0));
    }
}
