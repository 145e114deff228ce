//! The apps.

use std::{str::FromStr, time::Duration};

use bevy::{prelude::*, time::TimeUpdateStrategy};

use super::scene::{Scene, move_cubes};

/// A way to detect collisions in an app.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contestant {
    /// This crate.
    Ours,
    /// Avian, kinematic bodies.
    Avian,
    /// Rapier, kinematic bodies.
    Rapier,
    /// Rapier, colliders without bodies.
    RapierBodyless,
    /// None: the cubes only move.
    Movement,
}

/// Events since the counts were last reset.
#[derive(Resource, Clone, Copy, Default)]
pub struct Events {
    /// Collisions that started.
    pub started: u64,
    /// Collisions that ended.
    pub ended: u64,
}

impl Contestant {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 5] = [
        Self::Ours,
        Self::Avian,
        Self::Rapier,
        Self::RapierBodyless,
        Self::Movement,
    ];

    /// The name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Avian => "avian",
            Self::Rapier => "rapier",
            Self::RapierBodyless => "rapier-bodyless",
            Self::Movement => "movement",
        }
    }

    /// An app with the cubes of a scene in it.
    pub fn app(self, scene: Scene) -> App {
        let (places, motion) = scene.begin();
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
                1.0 / 60.0,
            )))
            .init_resource::<Events>()
            .add_systems(Update, move_cubes);
        match self {
            Self::Ours => ours(&mut app),
            Self::Avian => avian(&mut app),
            Self::Rapier | Self::RapierBodyless => rapier(&mut app),
            Self::Movement => {}
        }
        app.finish();
        app.cleanup();
        let world = app.world_mut();
        let (moving, statics) = (places.moving, places.statics);
        match self {
            Self::Ours => {
                use bevy_octree::prelude::*;
                let shape = CollisionShape::cuboid(1.0, 1.0, 1.0);
                spawn(world, moving, || shape.clone());
                spawn(world, statics, || (shape.clone(), StaticShape));
            }
            Self::Avian => {
                use avian3d::prelude::*;
                // Avian takes full sides.
                let collider = Collider::cuboid(1.0, 1.0, 1.0);
                spawn(world, moving, || {
                    (
                        RigidBody::Kinematic,
                        collider.clone(),
                        Sensor,
                        CollisionEventsEnabled,
                    )
                });
                spawn(world, statics, || (RigidBody::Static, collider.clone()));
            }
            Self::Rapier => {
                use bevy_rapier3d::prelude::*;
                spawn(world, moving, || {
                    (RigidBody::KinematicPositionBased, rapier_collider())
                });
                // What moves asks for pairs with what is fixed.
                spawn(world, statics, || {
                    (RigidBody::Fixed, Collider::cuboid(0.5, 0.5, 0.5))
                });
            }
            Self::RapierBodyless => {
                use bevy_rapier3d::prelude::*;
                spawn(world, moving, rapier_collider);
                spawn(world, statics, || Collider::cuboid(0.5, 0.5, 0.5));
            }
            Self::Movement => {
                spawn(world, moving, || ());
                spawn(world, statics, || ());
            }
        }
        app.insert_resource(motion);
        app
    }
}

/// Spawns cubes, each with a bundle more.
fn spawn<C: Bundle, B: Bundle>(world: &mut World, cubes: Vec<C>, more: impl Fn() -> B) {
    for cube in cubes {
        world.spawn((cube, more()));
    }
}

impl FromStr for Contestant {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|contestant| contestant.name() == name)
            .ok_or_else(|| {
                format!(
                    "unknown app: expected one of {}",
                    Self::ALL.map(Self::name).join(", ")
                )
            })
    }
}

fn ours(app: &mut App) {
    use bevy_octree::prelude::*;
    let count = |mut started: MessageReader<CollisionStarted>,
                 mut ended: MessageReader<CollisionEnded>,
                 mut events: ResMut<Events>| {
        events.started += started.read().count() as u64;
        events.ended += ended.read().count() as u64;
    };
    app.add_plugins(OctreePlugins::new(PostUpdate))
        .add_systems(Last, count);
}

fn avian(app: &mut App) {
    use avian3d::{collider_tree::ColliderTreeOptimization, prelude::*};
    let count = |mut started: MessageReader<CollisionStart>,
                 mut ended: MessageReader<CollisionEnd>,
                 mut events: ResMut<Events>| {
        events.started += started.read().count() as u64;
        events.ended += ended.read().count() as u64;
    };
    app.add_plugins(PhysicsPlugins::new(PostUpdate))
        .insert_resource(SubstepCount(1))
        .insert_resource(ColliderTreeOptimization {
            optimize_in_place: true,
            ..default()
        })
        .add_systems(Last, count);
}

fn rapier(app: &mut App) {
    use bevy_rapier3d::prelude::*;
    let count = |mut reader: MessageReader<CollisionEvent>, mut events: ResMut<Events>| {
        for event in reader.read() {
            match event {
                CollisionEvent::Started(..) => events.started += 1,
                CollisionEvent::Stopped(..) => events.ended += 1,
            }
        }
    };
    app.insert_resource(TimestepMode::Fixed {
        dt: 1.0 / 60.0,
        substeps: 1,
    })
    .add_plugins(RapierPhysicsPlugin::<()>::default())
    .add_systems(Last, count);
}

/// What makes a cube take part in rapier's world.
type RapierCollider = (
    bevy_rapier3d::prelude::Collider,
    bevy_rapier3d::prelude::Sensor,
    bevy_rapier3d::prelude::ActiveEvents,
    bevy_rapier3d::prelude::ActiveCollisionTypes,
);

fn rapier_collider() -> RapierCollider {
    use bevy_rapier3d::prelude::*;
    // Rapier takes half sides.
    (
        Collider::cuboid(0.5, 0.5, 0.5),
        Sensor,
        ActiveEvents::COLLISION_EVENTS,
        ActiveCollisionTypes::all(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn started(contestant: Contestant, objects: usize, statics: usize) -> u64 {
        let mut app = contestant.app(Scene {
            objects,
            statics,
            seed: 1,
        });
        (0..30).for_each(|_| app.update());
        app.world().resource::<Events>().started
    }

    #[test]
    fn all_apps_see_the_same_collisions_more_or_less() {
        for (objects, statics) in [(500, 0), (200, 600)] {
            assert_eq!(started(Contestant::Movement, objects, statics), 0);
            let ours = started(Contestant::Ours, objects, statics);
            assert!(ours > 100);
            for contestant in [
                Contestant::Avian,
                Contestant::Rapier,
                Contestant::RapierBodyless,
            ] {
                let theirs = started(contestant, objects, statics);
                assert!(
                    theirs.abs_diff(ours) < ours / 8,
                    "{}: {theirs}, ours: {ours}",
                    contestant.name()
                );
            }
        }
    }

    #[test]
    fn nothing_happens_where_nothing_moves() {
        for contestant in Contestant::ALL {
            assert_eq!(started(contestant, 0, 100), 0, "{}", contestant.name());
        }
    }
}
