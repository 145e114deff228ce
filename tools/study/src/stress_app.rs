//! A stress scene in a headless app.

use std::time::Instant;

use bevy::{math::bounding::BoundingVolume, prelude::*};
use bevy_octree::{
    prelude::*,
    scene::stress::{StressScene, StressSimulation},
};

use crate::{
    extra::Extra,
    outcome::Outcome,
    stage_times::{STAGES, StageTimes},
};

/// Which scene, and how it is searched.
#[derive(Clone, Debug)]
pub struct Setup {
    pub scene: StressScene,
    pub objects: usize,
    pub seed: u64,
    pub method: BroadPhaseMethod,
    pub with: Option<Extra>,
}

/// An app with a stress scene in it, and the times of its frames.
pub struct StressApp {
    app: App,
    /// The milliseconds of each frame.
    pub update_ms: Vec<f64>,
}

#[derive(Resource, Deref, DerefMut)]
struct Simulation(StressSimulation);

/// The index of the entity's box in the simulation.
#[derive(Component)]
struct Object(usize);

impl StressApp {
    /// The app after its first update, in which all entities come in. That update is not timed.
    pub fn new(setup: &Setup) -> Outcome<Self> {
        let simulation = StressSimulation::new(setup.scene, setup.objects, setup.seed);
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
            .insert_resource(BroadPhaseSettings {
                method: setup.method.clone(),
                ..default()
            })
            .add_systems(
                Update,
                (step, follow).chain().in_set(CollisionSystems::Motion),
            );
        StageTimes::install(&mut app, Update);
        if let Some(extra) = setup.with {
            extra.install(&mut app);
        }
        app.finish();
        app.cleanup();

        let boxes = simulation.boxes().iter().enumerate();
        let entities = boxes.map(|(object, aabb)| {
            let shape = CollisionShape::try_from_half_size(aabb.half_size().into())?;
            Ok((
                Object(object),
                shape,
                Transform::from_translation(aabb.center().into()),
            ))
        });
        let entities = entities.collect::<Outcome<Vec<_>>>()?;
        let entities: Vec<_> = app.world_mut().spawn_batch(entities).collect();
        if let Some(extra) = setup.with {
            let halves = simulation
                .boxes()
                .iter()
                .map(|aabb| Vec3::from(aabb.half_size()));
            let objects: Vec<_> = entities.into_iter().zip(halves).collect();
            extra.give(app.world_mut(), &objects);
        }
        app.insert_resource(Simulation(simulation));
        app.update();
        app.world_mut().resource_mut::<StageTimes>().reset();
        Ok(Self {
            app,
            update_ms: Vec::new(),
        })
    }

    /// Runs and times a frame. Not inlined, so that profilers can tell it from what is done once.
    #[inline(never)]
    pub fn frame(&mut self) {
        let start = Instant::now();
        self.app.update();
        self.update_ms.push(start.elapsed().as_secs_f64() * 1e3);
    }

    /// What happened, since the start.
    pub fn counters(&self) -> &CollisionCounters {
        self.app.world().resource()
    }

    /// Each stage's mean time per frame, in milliseconds, with its name; last what is left of the
    /// frame.
    pub fn stages_ms(&self) -> Vec<(&'static str, f64)> {
        let frames = self.update_ms.len().max(1) as f64;
        let sums = &self.app.world().resource::<StageTimes>().sums;
        let stages = STAGES
            .iter()
            .zip(sums)
            .map(|((_, name), sum)| (*name, sum.as_secs_f64() * 1e3 / frames));
        let mut stages: Vec<_> = stages.collect();
        let timed: f64 = stages.iter().map(|(_, ms)| ms).sum();
        stages.push(("other", self.update_ms.iter().sum::<f64>() / frames - timed));
        stages
    }
}

fn step(mut simulation: ResMut<Simulation>) {
    simulation.step();
}

/// Entities go where their boxes are. What does not move must not count as changed.
fn follow(simulation: Res<Simulation>, mut entities: Query<(&Object, &mut Transform)>) {
    entities.par_iter_mut().for_each(|(object, mut transform)| {
        let center = simulation.boxes()[object.0].center().into();
        if transform.translation != center {
            transform.translation = center;
        }
    });
}
