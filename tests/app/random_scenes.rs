//! Random scenes of all kinds of objects, on both paths: the same contacts tick by tick, and those
//! that the exact tests find without any broad phase.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{broad_phase::ObjectOctreeSettings, prelude::*, scene::Cube};
use common::*;
use fastrand::Rng;

const OBJECTS: usize = 50;
const TICKS: usize = 25;

/// An app and a script of random edits, the same for the same seed.
struct Scene {
    app: App,
    rng: Rng,
    objects: Vec<Entity>,
}

impl Scene {
    fn new(method: BroadPhaseMethod, seed: u64) -> Self {
        let mut scene = Self {
            app: app(method),
            rng: Rng::with_seed(seed),
            objects: Vec::new(),
        };
        for _ in 0..OBJECTS {
            scene.spawn();
        }
        scene
    }

    fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| {
            (self.rng.f32() * 2.0 - 1.0) * reach
        }))
    }

    fn rotation(&mut self) -> Quat {
        let axis = self.vector(1.0).try_normalize().unwrap_or(Vec3::X);
        Quat::from_axis_angle(axis, self.rng.f32() * 6.0)
    }

    /// From 0.05 to 5, the small ones more often.
    fn size(&mut self) -> f32 {
        0.05 * 100_f32.powf(self.rng.f32().powi(2))
    }

    fn shape(&mut self) -> CollisionShape {
        if self.rng.bool() {
            CollisionShape::sphere(self.size())
        } else {
            CollisionShape::from_half_size(Vec3::new(self.size(), self.size(), self.size()))
        }
    }

    fn transform(&mut self) -> Transform {
        // Every third is turned and every third scaled, so that aligned pairs occur too.
        let mut transform = Transform::from_translation(self.vector(8.0));
        if self.rng.u8(0..3) == 0 {
            transform.rotation = self.rotation();
        }
        if self.rng.u8(0..3) == 0 {
            transform.scale = self.vector(2.0);
        }
        transform
    }

    fn spawn(&mut self) {
        let object = (self.shape(), self.transform());
        let mut entity = self.app.world_mut().spawn(object);
        self.objects.push(entity.id());
        let bounce = [
            None,
            Some(Bounce::Reverse),
            Some(Bounce::Reflect { restitution: 0.5 }),
        ][self.rng.usize(0..3)];
        if let Some(bounce) = bounce {
            entity.insert(bounce);
        }
        if self.rng.u8(0..3) > 0 {
            let entity = entity.id();
            let velocity = Velocity(self.vector(15.0));
            self.app.world_mut().entity_mut(entity).insert(velocity);
        }
    }

    fn random_object(&mut self) -> usize {
        self.rng.usize(0..self.objects.len())
    }

    fn step(&mut self) {
        match self.rng.u8(0..5) {
            0 => {
                let (object, transform) = (self.random_object(), self.transform());
                *get_mut(&mut self.app, self.objects[object]) = transform;
            }
            1 => {
                let (object, shape) = (self.random_object(), self.shape());
                *get_mut(&mut self.app, self.objects[object]) = shape;
            }
            2 => {
                let (object, rotation) = (self.random_object(), self.rotation());
                get_mut::<Transform>(&mut self.app, self.objects[object]).rotate(rotation);
            }
            3 => {
                let object = self.random_object();
                let entity = self.objects.swap_remove(object);
                self.app.world_mut().despawn(entity);
                self.spawn();
            }
            _ => {}
        }
        tick(&mut self.app, 1);
    }

    fn transforms(&self) -> Vec<Transform> {
        self.objects
            .iter()
            .map(|object| *get(&self.app, *object))
            .collect()
    }
}

#[test]
fn all_paths_find_the_contacts_of_brute_force() {
    let mut seen = 0;
    for seed in 0..40 {
        let settings = ObjectOctreeSettings::with_max_objects([1, 3, 8][seed as usize % 3]);
        let mut octree = Scene::new(BroadPhaseMethod::ObjectOctree(settings), seed);
        let mut exhaustive = Scene::new(BroadPhaseMethod::Exhaustive, seed);
        let mut linear = Scene::new(BroadPhaseMethod::LinearOctree, seed);
        let mut mirror = Mirror::new(settings);
        for number in 1..=TICKS {
            octree.step();
            exhaustive.step();
            linear.step();
            let found = contacts(&octree.app);
            assert_eq!(found, contacts(&linear.app), "seed {seed}, tick {number}");
            assert_eq!(
                found,
                contacts(&exhaustive.app),
                "seed {seed}, tick {number}"
            );
            assert_eq!(
                found,
                brute_force_contacts(&mut octree.app),
                "seed {seed}, tick {number}"
            );
            assert_eq!(
                octree.transforms(),
                exhaustive.transforms(),
                "seed {seed}, tick {number}"
            );
            mirror.follow(&mut octree.app);
            seen += found.len();
        }
        assert_eq!(
            octree.app.world().resource::<Log>(),
            linear.app.world().resource::<Log>(),
            "seed {seed}"
        );
        assert_eq!(
            octree.app.world().resource::<Log>(),
            exhaustive.app.world().resource::<Log>(),
            "seed {seed}"
        );
    }
    assert!(seen > 40 * TICKS, "the scenes have contacts: {seen}");
}

/// Cubes on a lattice, so that faces, edges and corners touch, and borders of cells are met
/// exactly.
#[test]
fn all_paths_agree_on_touching_cubes() {
    for seed in 0..20 {
        let octree = BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(2));
        let [mut octree, mut exhaustive, mut linear] = [
            octree,
            BroadPhaseMethod::Exhaustive,
            BroadPhaseMethod::LinearOctree,
        ]
        .map(|method| {
            let mut rng = Rng::with_seed(seed);
            let mut app = app(method);
            for _ in 0..60 {
                let mut place =
                    || Vec3::from_array(std::array::from_fn(|_| f32::from(rng.i8(-4..5)) * 0.5));
                let (position, velocity) = (place(), Velocity(place() * 0.25 * TICKS_PER_SECOND));
                app.world_mut()
                    .spawn((Cube, Transform::from_translation(position), velocity));
            }
            app
        });
        for number in 1..=TICKS {
            tick(&mut octree, 1);
            tick(&mut exhaustive, 1);
            tick(&mut linear, 1);
            let found = contacts(&octree);
            assert_eq!(found, contacts(&linear), "seed {seed}, tick {number}");
            assert_eq!(found, contacts(&exhaustive), "seed {seed}, tick {number}");
            assert_eq!(
                found,
                brute_force_contacts(&mut octree),
                "seed {seed}, tick {number}"
            );
        }
    }
}
