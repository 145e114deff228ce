//! The apps.

use std::{str::FromStr, time::Duration};

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_octree::scene::stress::{StressScene, StressSimulation};

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

/// What moves the cubes.
#[derive(Resource)]
struct Simulation(StressSimulation);

/// The number of a cube in the simulation.
#[derive(Component)]
struct Number(usize);

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

    /// An app with so many moving cubes.
    pub fn app(self, objects: usize, seed: u64) -> App {
        let simulation = StressSimulation::new(StressScene::Brownian, objects, seed);
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
        let places = simulation
            .boxes()
            .iter()
            .map(|aabb| Vec3::from((aabb.min + aabb.max) * 0.5));
        let cubes = places
            .enumerate()
            .map(|(i, place)| (Number(i), Transform::from_translation(place)));
        let world = app.world_mut();
        match self {
            Self::Ours => {
                let shape = bevy_octree::components::CollisionShape::cuboid(1.0, 1.0, 1.0);
                world.spawn_batch(cubes.map(|cube| (cube, shape.clone())).collect::<Vec<_>>());
            }
            Self::Avian => {
                use avian3d::prelude::*;
                // Avian takes full sides.
                let collider = Collider::cuboid(1.0, 1.0, 1.0);
                let body = || {
                    (
                        RigidBody::Kinematic,
                        collider.clone(),
                        Sensor,
                        CollisionEventsEnabled,
                    )
                };
                world.spawn_batch(cubes.map(|cube| (cube, body())).collect::<Vec<_>>());
            }
            Self::Rapier => {
                use bevy_rapier3d::prelude::*;
                let body = || (RigidBody::KinematicPositionBased, rapier_collider());
                world.spawn_batch(cubes.map(|cube| (cube, body())).collect::<Vec<_>>());
            }
            Self::RapierBodyless => {
                world.spawn_batch(
                    cubes
                        .map(|cube| (cube, rapier_collider()))
                        .collect::<Vec<_>>(),
                );
            }
            Self::Movement => {
                world.spawn_batch(cubes.collect::<Vec<_>>());
            }
        }
        app.insert_resource(Simulation(simulation));
        app
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

/// Moves every cube, in all apps alike.
fn move_cubes(mut simulation: ResMut<Simulation>, mut cubes: Query<(&Number, &mut Transform)>) {
    simulation.0.step();
    let boxes = simulation.0.boxes();
    for (number, mut transform) in &mut cubes {
        let aabb = &boxes[number.0];
        transform.translation = ((aabb.min + aabb.max) * 0.5).into();
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

    #[test]
    fn all_apps_see_the_same_collisions_more_or_less() {
        let started = |contestant: Contestant| {
            let mut app = contestant.app(500, 1);
            (0..30).for_each(|_| app.update());
            app.world().resource::<Events>().started
        };
        assert_eq!(started(Contestant::Movement), 0);
        let ours = started(Contestant::Ours);
        assert!(ours > 100);
        for contestant in [
            Contestant::Avian,
            Contestant::Rapier,
            Contestant::RapierBodyless,
        ] {
            let theirs = started(contestant);
            assert!(
                theirs.abs_diff(ours) < ours / 8,
                "{}: {theirs}, ours: {ours}",
                contestant.name()
            );
        }
    }
}
