//! One number for all that happens in a room over thousands of ticks: the same by any broad phase, in any order of
//! spawning, by whoever goes back in time, at any number of threads, and of any build.

use bevy::prelude::*;
use bevy_octree::{broad_phase::BroadPhaseMethod, prelude::*, rollback::RollbackPlugin};

use crate::{
    common::fnv::Fnv,
    order::{self, Seen, plain_app, seen},
    rollback::{restore, save},
};

/// May tell how many ticks there are, if not 1 000.
const TICKS: &str = "BEVY_OCTREE_TEST_TICKS";

/// The number after so many ticks, on processors of this kind: what glam computes otherwise elsewhere, such as how a vector
/// is normalised, differs in last bits.
const KNOWN: [(u64, u64); 2] = [(300, 0x048F_A249_AD06_F270), (1_000, 0x6D93_47A2_1555_FA2E)];

/// Whether the numbers are known for what this is compiled for: sines are those of the system, or those of `libm`.
const IS_KNOWN: bool = cfg!(target_arch = "x86_64")
    && cfg!(any(
        feature = "libm",
        all(target_os = "linux", target_env = "gnu")
    ));

/// So many are in the room, walls included.
const COUNT: u64 = 62;

/// A room, and all that has happened in it.
struct Room {
    app: App,
    tick: u64,
    hash: Fnv,
    reversed: bool,
}

impl Room {
    fn new(method: BroadPhaseMethod, order: &[u64], reversed: bool) -> Self {
        Self {
            app: order::room(order, method),
            tick: 0,
            hash: Fnv::default(),
            reversed,
        }
    }

    /// Some go and come in every tenth tick, in one order or the other.
    fn step(&mut self) -> Seen {
        if self.tick % 10 == 9 {
            order::respawn(&mut self.app, COUNT, self.tick, self.reversed);
        }
        self.app.update();
        self.tick += 1;
        let seen = seen(&mut self.app);
        seen.add_to(&mut self.hash);
        seen
    }

    fn check(&self) {
        let known = KNOWN.iter().find(|(tick, _)| *tick == self.tick);
        let Some((tick, known)) = known else { return };
        println!("after {tick} ticks: {:#018X}", self.hash.0);
        if IS_KNOWN {
            assert_eq!(
                self.hash.0, *known,
                "after {tick} ticks: {:#018X}",
                self.hash.0
            );
        }
    }
}

/// The number after so many ticks, by the default broad phase.
#[cfg(feature = "multi_threaded")]
pub fn hash_after(ticks: u64) -> u64 {
    let order: Vec<_> = (0..COUNT).collect();
    let mut room = Room::new(BroadPhaseMethod::default(), &order, false);
    (0..ticks).for_each(|_| _ = room.step());
    room.check();
    room.hash.0
}

#[test]
fn all_that_happens_is_one_number() {
    let ticks = std::env::var(TICKS).ok();
    let ticks = ticks.and_then(|ticks| ticks.parse().ok()).unwrap_or(1_000);
    let shuffled = |seed| order::shuffled_of(COUNT, seed);
    let in_order: Vec<_> = (0..COUNT).collect();
    let object_octree = BroadPhaseMethod::ObjectOctree(default());
    let mut rooms = [
        Room::new(BroadPhaseMethod::LinearOctree, &in_order, false),
        Room::new(BroadPhaseMethod::Exhaustive, &shuffled(1), true),
        Room::new(object_octree, &shuffled(2), true),
        Room::new(BroadPhaseMethod::Auto, &shuffled(3), false),
    ];
    // This one goes back by eight ticks, once in a hundred.
    let back = &mut rooms[3];
    back.app.add_plugins(RollbackPlugin);
    let mut saved = None;
    let (mut told, mut walked) = (0, 0);
    for tick in 0..ticks {
        let back = &mut rooms[3];
        if tick % 100 == 91 {
            saved = Some((save(&mut back.app), back.tick, back.hash));
        }
        if tick % 100 == 99
            && let Some((saved, when, hash)) = &saved
        {
            let before = back.hash;
            restore(&mut back.app, saved);
            (back.tick, back.hash) = (*when, *hash);
            (*when..tick).for_each(|_| _ = back.step());
            assert_eq!(back.hash, before, "once more, up to tick {tick}");
        }
        let [first, others @ ..] = &mut rooms;
        let expected = first.step();
        told += expected.started.len() + expected.ended.len() + expected.events.len();
        walked += expected.walking();
        for other in others {
            assert_eq!(other.step(), expected, "in tick {tick}");
        }
        rooms.iter().for_each(Room::check);
    }
    assert!(told as u64 > 3 * ticks, "{told} are told");
    assert!(walked as u64 > ticks, "{walked} walk on something");
}

/// A level of what is alike: tiles whose tops are in one plane, stairs, walls of blocks, a floor that is a mesh; and a
/// crowd on it.
fn spawn_of_level(app: &mut App, number: u64) {
    let order = CollisionOrder(number);
    let grid = |number: u64, columns: u64| {
        Vec3::new((number % columns) as f32, 0.0, (number / columns) as f32)
    };
    let block = |app: &mut App, size: Vec3, at: Vec3| {
        let shape = CollisionShape::from_half_size(size / 2.0);
        let at = Transform::from_translation(at);
        app.world_mut().spawn((shape, StaticShape, order, at));
    };
    match number {
        // Tiles of 2 by 2.
        0..64 => {
            let at = grid(number, 8) * 2.0 - Vec3::new(7.0, 0.5, 7.0);
            block(app, Vec3::new(2.0, 1.0, 2.0), at);
        }
        // Walls across, of blocks beside each other, with gaps.
        64..88 if !number.is_multiple_of(7) => {
            let at = grid(number - 64, 12) * Vec3::new(1.0, 0.0, 5.0);
            block(
                app,
                Vec3::new(1.0, 2.0, 0.5),
                at + Vec3::new(-5.5, 1.0, -2.5),
            );
        }
        // Stairs.
        88..94 => {
            let step = (number - 87) as f32 * 0.2;
            block(
                app,
                Vec3::new(0.5, step, 3.0),
                Vec3::new(step * 2.5, step / 2.0, 5.5),
            );
        }
        // Beside the tiles, at their height.
        94 => {
            let at = |i: u64| grid(i, 9) - Vec3::new(16.0, 0.0, 4.0);
            let triangles = (0..64).flat_map(|i: u32| {
                let first = i % 8 + i / 8 * 9;
                [
                    [first, first + 9, first + 1],
                    [first + 1, first + 9, first + 10],
                ]
            });
            let ground =
                CollisionShape::mesh((0..81).map(at).collect::<Vec<_>>(), triangles).unwrap();
            app.world_mut().spawn((ground, StaticShape, order));
        }
        100.. => {
            let at = grid(number - 100, 6) * 0.7 + Vec3::new(-8.0, 0.95, -1.0);
            let walking = (KinematicCharacter::default(), CharacterHits::default());
            let body = (CollisionShape::capsule(0.3, 1.2), order);
            app.world_mut()
                .spawn((walking, body, Transform::from_translation(at)));
        }
        _ => {}
    }
}

const LEVEL: u64 = 136;

/// Through the crowd and back, against walls and up the stairs: now this way, now that.
fn steer(app: &mut App, tick: u64) {
    let world = app.world_mut();
    let mut walking = world.query::<(&CollisionOrder, &mut KinematicCharacter)>();
    for (order, mut walking) in walking.iter_mut(world) {
        let (x, z) = match (order.0 + tick / 40) % 5 {
            0 => (1.0, 0.0),
            1 => (1.0, 1.0),
            2 => (0.0, -1.0),
            3 => (-1.0, 0.25),
            _ => (1.0, 0.5),
        };
        let way = Vec3::new(x, 0.0, z).normalize() * 3.0;
        walking.velocity = way + Vec3::Y * (walking.velocity.y - 0.15);
    }
}

/// An app in which other things have been before: some handles have been used, and entities gone.
fn after_others(method: BroadPhaseMethod, others: u64) -> App {
    let mut app = plain_app(method);
    app.init_resource::<order::Events>();
    let spawn = |app: &mut App, number: u64| {
        let mut random = fastrand::Rng::with_seed(number);
        let at = Vec3::from_array([0; 3].map(|_| random.f32() * 20.0 - 10.0));
        let shape = CollisionShape::sphere(0.4 + random.f32());
        let velocity = Velocity(Vec3::from_array([0; 3].map(|_| random.f32() - 0.5)));
        let at = Transform::from_translation(at);
        let ball = (shape, velocity, at, CollisionOrder(number));
        app.world_mut().spawn(ball).id()
    };
    let mut balls: Vec<_> = (0..others).map(|number| spawn(&mut app, number)).collect();
    (0..5).for_each(|_| app.update());
    // They go in several ticks, out of order.
    fastrand::Rng::with_seed(others).shuffle(&mut balls);
    while !balls.is_empty() {
        for ball in balls.drain(..balls.len().min(50)) {
            app.world_mut().despawn(ball);
        }
        app.update();
    }
    // Nobody hears of them any more.
    _ = seen(&mut app);
    app
}

#[test]
fn what_was_there_before_makes_no_difference_to_who_walks() {
    let in_order: Vec<_> = (0..LEVEL).collect();
    let object_octree = BroadPhaseMethod::ObjectOctree(default());
    let shuffled = |seed| order::shuffled_of(LEVEL, seed);
    let mut apps = [
        (BroadPhaseMethod::LinearOctree, 0, in_order),
        (BroadPhaseMethod::LinearOctree, 300, shuffled(4)),
        (BroadPhaseMethod::Exhaustive, 40, shuffled(5)),
        (object_octree, 120, shuffled(6)),
    ]
    .map(|(method, others, order)| {
        let mut app = after_others(method, others);
        order
            .into_iter()
            .for_each(|number| spawn_of_level(&mut app, number));
        app
    });
    let mut walked = 0;
    for tick in 0..300 {
        let mut all = apps.iter_mut().map(|app| {
            steer(app, tick);
            app.update();
            seen(app)
        });
        let first = all.next().unwrap();
        walked += first.walking();
        for (number, other) in all.enumerate() {
            assert_eq!(other, first, "{number} in tick {tick}");
        }
    }
    assert!(walked > 5_000, "{walked} walk on something");
}
