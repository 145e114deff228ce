//! What a stress scene may have beyond boxes that move, to see what it costs.

use bevy::{
    ecs::system::{SystemParam, SystemParamItem},
    math::Isometry3d,
    prelude::*,
};
use bevy_octree::prelude::*;
use clap::ValueEnum;

/// What every object of a scene has, beyond a box that moves.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// The geometry of every contact is computed.
    Geometry,
    /// `CollisionEventsEnabled`, and observers of both events.
    Events,
    /// `ManifoldsEnabled`.
    Manifolds,
    /// `CollidingEntities`.
    Colliding,
    /// One of four layers, each of which meets itself alone.
    Layers,
    /// A hook that looks at a component of both, and admits all.
    Hook,
    /// A list of one entity to ignore.
    Ignore,
    /// `Sensor`.
    Sensor,
    /// `Swept`.
    Swept,
    /// A `RayCaster`, ten units long.
    Ray,
    /// A `ShapeCaster`: a ball of radius 0.5, ten units far.
    Cast,
    /// A body of four parts, in place of its box: each a quarter of that.
    Parts,
    /// The same four as a compound: one entity.
    Compound,
}

/// Looks at both, and lets them meet.
#[derive(SystemParam)]
struct Look<'w, 's>(Query<'w, 's, &'static Transform>);

impl PairHook for Look<'static, 'static> {
    fn admits(hook: &SystemParamItem<'_, '_, Self>, a: Entity, b: Entity) -> bool {
        hook.0.contains(a) && hook.0.contains(b)
    }
}

/// The four quarters of a box, along x.
fn quarters(half_size: Vec3) -> [(Vec3, Vec3); 4] {
    let part = half_size * Vec3::new(0.25, 1.0, 1.0);
    [-3.0, -1.0, 1.0, 3.0].map(|at| (Vec3::X * (at * part.x), part))
}

impl Extra {
    /// What the app has to have, before its first update.
    pub fn install(self, app: &mut App) {
        match self {
            Self::Geometry => {
                app.world_mut()
                    .resource_mut::<CollisionEventSettings>()
                    .geometry = EventScope::All;
            }
            Self::Events => {
                app.add_observer(|_: On<CollisionStarted>| {})
                    .add_observer(|_: On<CollisionEnded>| {});
            }
            Self::Hook => {
                app.add_plugins(PairHookPlugin::<Look>::default());
            }
            _ => {}
        }
    }

    /// Gives it to the objects, each with half the size of its box.
    pub fn give(self, world: &mut World, objects: &[(Entity, Vec3)]) {
        for (number, &(entity, half_size)) in objects.iter().enumerate() {
            let mut object = world.entity_mut(entity);
            match self {
                Self::Geometry | Self::Hook => {}
                Self::Events => {
                    object.insert(CollisionEventsEnabled);
                }
                Self::Manifolds => {
                    object.insert(ManifoldsEnabled);
                }
                Self::Colliding => {
                    object.insert(CollidingEntities::default());
                }
                Self::Layers => {
                    let layer = LayerMask::layer(number as u32 % 4);
                    object.insert(CollisionLayers::new(layer, layer));
                }
                Self::Ignore => {
                    let other = objects[(number + 1) % objects.len()].0;
                    object.insert(IgnoreCollisions::from(other));
                }
                Self::Sensor => {
                    object.insert(Sensor);
                }
                Self::Swept => {
                    object.insert(Swept::default());
                }
                Self::Ray => {
                    object.insert(RayCaster::new(Vec3::ZERO, Dir3::X).with_length(10.0));
                }
                Self::Cast => {
                    let ball = Shape::sphere(0.5);
                    object.insert(ShapeCaster::new(ball, Vec3::ZERO, Dir3::X).with_length(10.0));
                }
                Self::Parts => {
                    object
                        .remove::<CollisionShape>()
                        .insert(CollisionBody::default())
                        .with_children(|parts| {
                            for (at, part) in quarters(half_size) {
                                parts.spawn((
                                    CollisionShape::from_half_size(part),
                                    Transform::from_translation(at),
                                ));
                            }
                        });
                }
                Self::Compound => {
                    let parts = quarters(half_size).map(|(at, part)| {
                        (
                            Isometry3d::from_translation(at),
                            Shape::from_half_size(part),
                        )
                    });
                    if let Ok(compound) = Shape::compound(parts) {
                        object.insert(CollisionShape(compound));
                    }
                }
            }
        }
    }
}
