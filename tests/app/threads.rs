//! Everything is the same at any number of threads, its order included: pairs, answers of queries,
//! contacts, messages, where bodies are and how they move.
//!
//! A process has one pool of threads. So the test runs itself, in a process of its own for each
//! number.

use std::{
    hash::{DefaultHasher, Hash, Hasher},
    process::Command,
};

use bevy::{
    ecs::message::MessageCursor,
    math::bounding::RayCast3d,
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_octree::{
    broad_phase::{HitLists, SpatialIndex},
    prelude::*,
    scene::stress::{StressScene, StressSimulation},
};
use fastrand::Rng;

use crate::common::{TICKS_PER_SECOND, app, tick};

/// Tells the process of its own how many threads besides the main one it is to use.
const HELPERS: &str = "BEVY_OCTREE_TEST_HELPERS";
/// May tell for how many ticks the app and the room run, if not for 120 and 300.
const TICKS: &str = "BEVY_OCTREE_TEST_TICKS";

/// Runs a scene with enough objects for several jobs, and returns a hash of all pairs in their
/// order.
fn run(scene: StressScene) -> u64 {
    let mut simulation = StressSimulation::new(scene, 20_000, 4);
    let mut index = SpatialIndex::new(&BroadPhaseMethod::LinearOctree);
    let ids: Vec<_> = simulation
        .boxes()
        .iter()
        .map(|aabb| index.insert(*aabb).unwrap())
        .collect();
    let mut hasher = DefaultHasher::new();
    for _ in 0..12 {
        index.update();
        index
            .find_pairs()
            .iter()
            .for_each(|pair| pair.hash(&mut hasher));
        simulation.step();
        for (id, aabb) in ids.iter().zip(simulation.boxes()) {
            index.set(*id, aabb).unwrap();
        }
    }
    index.update();
    ask(&index, &mut hasher);
    hasher.finish()
}

/// Queries for many, whose answers come in an order too.
fn ask(index: &SpatialIndex, hasher: &mut DefaultHasher) {
    let mut pairs = 0;
    index.for_each_pair_among(
        0.4,
        |id| id.get() % 9 != 0,
        |a, b, distance| {
            pairs += 1;
            (a, b, distance.to_bits()).hash(hasher);
        },
    );
    assert!(pairs > 5000, "{pairs}");
    let points: Vec<Vec3> = index
        .proxies()
        .iter()
        .map(|(_, aabb)| (aabb.max + 1.0).into())
        .collect();
    let (mut nearest, mut first) = (HitLists::default(), vec![]);
    index.k_nearest_of_each(&points, 3, 5.0, &mut nearest);
    let casts: Vec<_> = points
        .iter()
        .map(|point| RayCast3d::new(*point, Dir3::X, 20.0))
        .collect();
    index.cast_each(&casts, &mut first);
    for (near, first) in nearest.iter().zip(&first) {
        for hit in near.iter().chain(first) {
            (hit.proxy, hit.distance.to_bits()).hash(hasher);
        }
    }
}

/// An app in which much happens: bodies of all kinds that move, turn, bounce and rest, some of them
/// swept, some children, some that come and go. Enough of them for several jobs in each stage.
struct Crowd {
    app: App,
    rng: Rng,
    /// The oldest first.
    guests: Vec<Entity>,
    started: MessageCursor<CollisionStarted>,
    ended: MessageCursor<CollisionEnded>,
    hasher: DefaultHasher,
}

/// Half the side of the space that they begin in.
const HALF: f32 = 14.0;

impl Crowd {
    fn new() -> Self {
        let mut crowd = Self {
            app: app(BroadPhaseMethod::default()),
            rng: Rng::with_seed(9),
            guests: Vec::new(),
            started: MessageCursor::default(),
            ended: MessageCursor::default(),
            hasher: DefaultHasher::new(),
        };
        crowd.app.add_systems(FixedPreUpdate, (stay_near, spin));
        for number in 0..9000 {
            crowd.spawn(number);
        }
        crowd
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| (self.rng.f32() * 2.0 - 1.0) * size))
    }

    fn spawn(&mut self, number: usize) -> Entity {
        let half_size = Vec3::splat(0.3) + self.vector(0.1);
        let shape = match number % 3 {
            0 => CollisionShape::sphere(half_size.x),
            _ => CollisionShape::from_half_size(half_size),
        };
        let at = Transform::from_translation(self.vector(HALF));
        let velocity = Velocity(self.vector(0.05) * TICKS_PER_SECOND);
        let turned = at.with_rotation(Quat::from_scaled_axis(self.vector(1.0)));
        let world = self.app.world_mut();
        let reflect = Bounce::Reflect { restitution: 0.9 };
        match number % 10 {
            0 => world.spawn((shape, turned, StaticShape)).id(),
            1 => world.spawn((shape, turned, Spinning)).id(),
            2 => world.spawn((shape, at, velocity, Bounce::Reverse)).id(),
            3 => world.spawn((shape, at, velocity, reflect)).id(),
            4 if number % 70 == 4 => world
                .spawn((shape, at, velocity, reflect, Swept::default()))
                .id(),
            5 if number % 20 == 5 => {
                let parent = world.spawn((shape.clone(), at, velocity)).id();
                let arm = Transform::from_xyz(0.0, 0.8, 0.0);
                world.spawn((shape, arm, ChildOf(parent)));
                parent
            }
            6 if number % 20 == 6 => {
                // A thing made of parts, every third one swept.
                let body = (CollisionBody::default(), turned, velocity, reflect);
                let body = world.spawn(body).id();
                if number % 60 == 6 {
                    world.entity_mut(body).insert(Swept::default());
                }
                for arm in [Vec3::ZERO, Vec3::X * 0.8, Vec3::Z * 0.8] {
                    let arm = Transform::from_translation(arm);
                    world.spawn((shape.clone(), arm, ChildOf(body)));
                }
                body
            }
            6 => {
                let ray = RayCaster::default().with_max_hits(3).with_length(4.0);
                let casts = (ray, ShapeCaster::default().with_length(1.0));
                let rays = (shape, turned, velocity, casts.0);
                if number % 70 == 6 {
                    world.spawn((rays, casts.1)).id()
                } else {
                    world.spawn(rays).id()
                }
            }
            _ => world.spawn((shape, at, velocity)).id(),
        }
    }

    fn tick(&mut self, number: usize) {
        // Some come and some go, so that handles are used again.
        for _ in 0..self.rng.usize(0..4) {
            let guest = self.spawn(number);
            self.guests.push(guest);
        }
        if self.guests.len() > 40 {
            let oldest = self.guests.remove(self.rng.usize(0..10));
            self.app.world_mut().despawn(oldest);
        }
        tick(&mut self.app, 1);
        let hits = self
            .app
            .world_mut()
            .query::<(&RayHits, Option<&ShapeHits>)>();
        let world = self.app.world();
        let hasher = &mut self.hasher;
        for event in self.started.read(world.resource()) {
            (event.a, event.b, event.bodies, event.time.to_bits()).hash(hasher);
        }
        let bodies = world.resource::<Contacts>().body_pairs();
        for BodyCollision {
            a,
            b,
            parts,
            contacts,
            ..
        } in bodies
        {
            (a, b, parts, contacts).hash(hasher);
        }
        for event in self.ended.read(world.resource()) {
            (event.a, event.b).hash(hasher);
        }
        for contact in world.resource::<Contacts>().iter() {
            (contact.a, contact.b).hash(hasher);
        }
        for (rays, shapes) in hits.iter_manual(world) {
            for hit in rays {
                (hit.entity, hit.distance.to_bits()).hash(hasher);
            }
            for hit in shapes.into_iter().flatten() {
                (hit.entity, hit.distance.to_bits()).hash(hasher);
            }
        }
    }

    /// A hash of all that happened, and of how it ended.
    fn finish(mut self) -> u64 {
        let world = self.app.world_mut();
        let mut bodies = world.query::<(Entity, &Transform, Option<&Velocity>)>();
        for (entity, transform, velocity) in bodies.iter(world) {
            entity.hash(&mut self.hasher);
            let bits = |vector: Vec3| vector.to_array().map(f32::to_bits);
            bits(transform.translation).hash(&mut self.hasher);
            velocity
                .map(|velocity| bits(velocity.0))
                .hash(&mut self.hasher);
        }
        self.hasher.finish()
    }
}

/// Turns in its place.
#[derive(Component)]
struct Spinning;

fn spin(mut spinning: Query<&mut Transform, With<Spinning>>) {
    for mut transform in &mut spinning {
        transform.rotate_local_y(0.05);
    }
}

/// Who gets far away turns around.
fn stay_near(mut moving: Query<(&Transform, &mut Velocity), Without<ChildOf>>) {
    for (transform, mut velocity) in &mut moving {
        let outwards = transform.translation * velocity.0;
        let is_leaving =
            transform.translation.abs().cmpgt(Vec3::splat(HALF)) & outwards.cmpgt(Vec3::ZERO);
        if is_leaving.any() {
            velocity.0 = Vec3::select(is_leaving, -velocity.0, velocity.0);
        }
    }
}

/// How many ticks are asked for, if any are.
fn ticks_asked() -> Option<usize> {
    std::env::var(TICKS).ok()?.parse().ok()
}

fn run_app() -> u64 {
    let mut crowd = Crowd::new();
    (0..ticks_asked().unwrap_or(120)).for_each(|number| crowd.tick(number));
    crowd.finish()
}

/// A crowd of characters that run together, between walls and on a platform that turns; a hash of where they get to.
fn run_characters() -> u64 {
    let mut app = app(BroadPhaseMethod::default());
    let solid = |x: f32, y: f32, z: f32| CollisionShape::cuboid(x, y, z);
    app.world_mut().spawn((
        solid(60.0, 1.0, 60.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
        StaticShape,
    ));
    for i in 0..40 {
        let at = Transform::from_xyz(
            (i % 8) as f32 * 4.0 - 14.0,
            0.1,
            (i / 8) as f32 * 5.0 - 10.0,
        );
        let at = at.with_rotation(Quat::from_rotation_y(i as f32));
        app.world_mut()
            .spawn((solid(1.5, 0.2 + (i % 3) as f32, 1.0), at, StaticShape));
    }
    let disk = (
        CollisionShape::cylinder(4.0, 0.2),
        Transform::default(),
        Spinning,
    );
    app.world_mut().spawn(disk);
    app.add_systems(FixedPreUpdate, spin);
    let walkers: Vec<_> = (0..100)
        .map(|i| {
            let at = Transform::from_xyz(
                (i % 10) as f32 * 1.1 - 5.0,
                3.0,
                (i / 10) as f32 * 1.1 - 5.0,
            );
            let shape = if i % 3 == 0 {
                solid(0.5, 1.8, 0.5)
            } else {
                CollisionShape::capsule(0.3, 1.0)
            };
            app.world_mut()
                .spawn((
                    KinematicCharacter::default(),
                    CharacterHits::default(),
                    shape,
                    at,
                ))
                .id()
        })
        .collect();
    let mut hasher = DefaultHasher::new();
    for number in 0..60 {
        for walker in &walkers {
            let at = app.world().get::<Transform>(*walker).unwrap().translation;
            let mut walking = app
                .world_mut()
                .get_mut::<KinematicCharacter>(*walker)
                .unwrap();
            let aim = if number < 40 { -at } else { Vec3::X };
            walking.velocity =
                aim.with_y(0.0).normalize_or_zero() * 3.0 + Vec3::Y * (walking.velocity.y - 0.15);
        }
        tick(&mut app, 1);
        for walker in &walkers {
            let at = app.world().get::<Transform>(*walker).unwrap();
            at.translation
                .to_array()
                .map(f32::to_bits)
                .hash(&mut hasher);
            at.rotation.to_array().map(f32::to_bits).hash(&mut hasher);
            app.world()
                .get::<CharacterHits>(*walker)
                .unwrap()
                .len()
                .hash(&mut hasher);
        }
    }
    hasher.finish()
}

/// Is run in a process of its own, by the test below; prints the hash of each scene.
#[test]
#[ignore = "a part of the other test"]
fn in_a_process_of_its_own() {
    let helpers = std::env::var(HELPERS).unwrap().parse().unwrap();
    let pool = ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(helpers).build());
    assert_eq!(pool.thread_num(), helpers);
    for scene in [
        StressScene::Brownian,
        StressScene::Gravity,
        StressScene::Static90,
    ] {
        println!("hash {scene} {}", run(scene));
    }
    println!("hash app {}", run_app());
    println!("hash characters {}", run_characters());
    let ticks = ticks_asked().unwrap_or(300) as u64;
    println!("hash room {}", crate::determinism::hash_after(ticks));
}

#[test]
fn all_is_the_same_at_any_number_of_threads() {
    let hashes = |threads: usize| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "threads::in_a_process_of_its_own",
                "--ignored",
                "--nocapture",
            ])
            .env(HELPERS, (threads - 1).to_string())
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let found: Vec<String> = text
            .lines()
            .filter_map(|line| Some(line.split_once("hash ")?.1.to_owned()))
            .collect();
        assert_eq!(found.len(), 6, "{threads} threads: {text}");
        found
    };
    let alone = hashes(1);
    for threads in [2, 3, 4, 8] {
        assert_eq!(hashes(threads), alone, "{threads} threads");
    }
}
