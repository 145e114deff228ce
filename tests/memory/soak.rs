//! Constant spawning and despawning: as many bytes after many ticks as after a few, an index that
//! holds what the world holds, and as much work per tick.
//!
//! `BEVY_OCTREE_SOAK_TICKS` is the number of ticks with 50 objects; of those with many there are a
//! hundredth of it: 200 objects, or 50 000 from 100 000 ticks on. What a tick takes is printed, by tenths of the run:
//! `cargo test --release --test memory -- soak:: --nocapture`.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

use bevy::prelude::*;
use bevy_octree::{collision_index::CollisionIndex, prelude::*};
use fastrand::Rng;

use crate::{
    allocator::{alone, assert_flat},
    app,
};

fn ticks() -> usize {
    let asked = std::env::var("BEVY_OCTREE_SOAK_TICKS");
    asked.map_or(4000, |number| number.parse().expect("a number of ticks"))
}

/// How long this thread has been at work, where the system tells; else, how late it is.
fn time_at_work(since: Instant) -> Duration {
    let at_work = || {
        let line = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        line.split(' ').next()?.parse().ok()
    };
    at_work().map_or_else(|| since.elapsed(), Duration::from_nanos)
}

/// A tenth of a run.
#[derive(Clone, Copy, Default)]
struct Tenth {
    ticks: u32,
    began: Duration,
    /// Objects that moved, pairs of boxes that were compared, and candidates.
    work: u64,
}

impl Tenth {
    fn work_per_tick(&self) -> f64 {
        self.work as f64 / f64::from(self.ticks)
    }
}

struct Soak {
    app: App,
    /// The ticks that are to come, and have been.
    ticks: usize,
    ticked: usize,
    since: Instant,
    tenths: [Tenth; 10],
    rng: Rng,
    alive: VecDeque<Entity>,
    side: f32,
    contacts: u64,
}

impl Soak {
    fn new(count: usize, ticks: usize) -> Self {
        let mut soak = Self {
            app: app(1.0 / 64.0),
            ticks,
            ticked: 0,
            since: Instant::now(),
            tenths: [Tenth::default(); 10],
            rng: Rng::with_seed(1),
            alive: VecDeque::new(),
            side: (count as f32).cbrt() * 1.5,
            contacts: 0,
        };
        for _ in 0..count {
            soak.spawn();
        }
        soak
    }

    /// One of all kinds, in turn.
    fn spawn(&mut self) {
        let mut vector =
            |reach: f32| Vec3::from_array([(); 3].map(|()| (self.rng.f32() - 0.5) * reach));
        let (at, way) = (
            Transform::from_translation(vector(self.side)),
            Velocity(vector(20.0)),
        );
        let kind = self.rng.u8(0..8);
        let shape = CollisionShape::sphere(0.4);
        let mut entity = self.app.world_mut().spawn((shape, at));
        match kind {
            0 => _ = entity.insert((way, Swept::default(), Bounce::Reflect { restitution: 1.0 })),
            1 => _ = entity.insert((way, Bounce::Reverse)),
            2 => _ = entity.insert(CollisionEventsEnabled),
            3 => _ = entity.insert((CollidingEntities::default(), Sensor)),
            4 => _ = entity.insert((ManifoldsEnabled, CollisionLayers::from_bits(2, 3))),
            5 => _ = entity.insert(StaticShape),
            6 => {
                // A body with a part, which goes with it.
                entity.insert((CollisionBody::default(), way));
                entity.with_child((
                    CollisionShape::default(),
                    Transform::from_xyz(0.5, 0.0, 0.0),
                ));
            }
            _ => {}
        }
        self.alive.push_back(entity.id());
    }

    /// The eldest goes, and others come in its place; one loses its shape for a tick.
    fn tick(&mut self, changes: usize) {
        for _ in 0..changes {
            if let Some(eldest) = self.alive.pop_front() {
                self.app.world_mut().despawn(eldest);
            }
            self.spawn();
        }
        let other = self.alive[self.rng.usize(0..self.alive.len())];
        let shape = self
            .app
            .world_mut()
            .entity_mut(other)
            .take::<CollisionShape>();
        self.app.update();
        if let Some(shape) = shape {
            self.app.world_mut().entity_mut(other).insert(shape);
        }
        let counters = self.app.world().resource::<CollisionCounters>().tick;
        self.contacts += counters.contacts;
        // Whatever is tried once more belongs to the last.
        let tenth = &mut self.tenths[(self.ticked * 10 / self.ticks).min(9)];
        if tenth.ticks == 0 {
            tenth.began = time_at_work(self.since);
        }
        tenth.ticks += 1;
        tenth.work += counters.moved + counters.pairs_tested + counters.candidates;
        self.ticked += 1;
    }

    /// The index holds what the world holds.
    fn check(&mut self) {
        self.app.update();
        let world = self.app.world_mut();
        let shapes = world.query::<&CollisionShape>().iter(world).count();
        let index = world.resource::<CollisionIndex>().index();
        assert_eq!(index.proxies().len(), shapes);
        assert!(index.proxies().capacity() < 2 * shapes + 64);
        assert!(self.contacts > 0);
        let counters = world.resource::<CollisionCounters>();
        let open = counters.total.started - counters.total.ended;
        assert_eq!(open as usize, world.resource::<Contacts>().len());
        let ended = time_at_work(self.since);
        let ends = self.tenths[1..].iter().map(|next| next.began);
        let tenths = self.tenths.iter().zip(ends.chain([ended]));
        for (number, (tenth, ended)) in tenths.enumerate() {
            let micros = (ended - tenth.began).as_secs_f64() * 1e6 / f64::from(tenth.ticks);
            println!(
                "tenth {number}: {} ticks, {micros:.1} microseconds and {:.1} steps of work per tick",
                tenth.ticks,
                tenth.work_per_tick()
            );
        }
        // The first is that in which lists are filled and things come to move. It may become less, where another
        // broad phase is chosen.
        let [early, late] = [1, 9].map(|tenth| self.tenths[tenth].work_per_tick());
        assert!(
            late < 1.25 * early,
            "{early} steps of work per tick at first, {late} at last"
        );
    }
}

#[test]
fn fifty_objects_that_come_and_go() {
    let _alone = alone();
    let (warm_up, rounds) = (ticks() / 2, ticks());
    let mut soak = Soak::new(50, warm_up + rounds);
    assert_flat("50 objects", warm_up, rounds, || soak.tick(1));
    soak.check();
}

#[test]
fn many_objects_that_come_and_go() {
    let _alone = alone();
    // Fewer of them where the run is short.
    let count = if ticks() >= 100_000 { 50_000 } else { 200 };
    let changes = count / 100;
    // A hundred ticks are a generation.
    let (warm_up, rounds) = ((ticks() * 3 / 20).min(2000), ticks() / 100);
    let mut soak = Soak::new(count, warm_up + rounds);
    assert_flat("many objects", warm_up, rounds, || soak.tick(changes));
    soak.check();
}
