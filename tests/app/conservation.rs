//! Bounces make no energy, and nobody who is swept leaves a closed room.

use crate::common;

use bevy::prelude::*;
use bevy_octree::{
    motion::{MotionSettings, Step},
    prelude::*,
};
use common::*;
use fastrand::Rng;

const ELASTIC: Bounce = Bounce::Reflect { restitution: 1.0 };

/// What the bodies of a room are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Swept(u32),
    SweptReverse(u32),
    Discrete,
    DiscreteReverse,
    Sensor,
    Static,
}

/// A room with walls around ±`half`, and what is in it.
struct Room {
    app: App,
    half: f32,
    bodies: Vec<(Entity, Kind)>,
    random: Rng,
}

impl Room {
    fn new(half: f32, seed: u64) -> Self {
        let mut app = app(BroadPhaseMethod::default());
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for side in [-1.0, 1.0] {
                let half_size = Vec3::splat(half + 1.0) * (Vec3::ONE - axis) + axis * 0.25;
                let wall = (CollisionShape::from_half_size(half_size), StaticShape);
                app.world_mut().spawn((
                    wall,
                    Transform::from_translation(axis * side * (half + 0.25)),
                ));
            }
        }
        Self {
            app,
            half,
            bodies: Vec::new(),
            random: Rng::with_seed(seed),
        }
    }

    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| (self.random.f32() * 2.0 - 1.0) * size))
    }

    /// Puts bodies where none is, which move by up to `step` along each axis per tick.
    fn fill(
        &mut self,
        shape: &CollisionShape,
        step: f32,
        restitution: f32,
        kinds: impl Iterator<Item = Kind>,
    ) {
        let mut taken: Vec<Vec3> = Vec::new();
        for kind in kinds {
            let at = loop {
                let at = self.vector(self.half - 0.5);
                if taken.iter().all(|other| other.distance(at) > 0.72) {
                    break at;
                }
            };
            taken.push(at);
            let velocity = Velocity(self.vector(step) * TICKS_PER_SECOND);
            let mut body = self
                .app
                .world_mut()
                .spawn((shape.clone(), Transform::from_translation(at)));
            let reflect = Bounce::Reflect { restitution };
            match kind {
                Kind::Swept(sub_steps) => body.insert((velocity, reflect, Swept::new(sub_steps))),
                Kind::SweptReverse(sub_steps) => {
                    body.insert((velocity, Bounce::Reverse, Swept::new(sub_steps)))
                }
                Kind::Discrete => body.insert((velocity, reflect)),
                Kind::DiscreteReverse => body.insert((velocity, Bounce::Reverse)),
                Kind::Sensor => body.insert((velocity, reflect, Swept::default(), Sensor)),
                Kind::Static => body.insert(StaticShape),
            };
            let entity = body.id();
            self.bodies.push((entity, kind));
        }
    }

    fn energy(&self) -> f64 {
        let velocities = self
            .bodies
            .iter()
            .filter_map(|(body, _)| self.app.world().get::<Velocity>(*body));
        velocities
            .map(|velocity| velocity.as_dvec3().length_squared())
            .sum()
    }

    /// Checks after each tick that there is no more energy than before it, and that who is swept is
    /// inside.
    fn check(&mut self, ticks: usize, name: &str) {
        let first = self.energy();
        let mut last = first;
        for n in 1..=ticks {
            tick(&mut self.app, 1);
            let now = self.energy();
            assert!(
                now <= last * (1.0 + 1e-6) && now <= first * (1.0 + 1e-4),
                "{name}, tick {n}: {last} to {now}"
            );
            last = now;
            for &(body, kind) in &self.bodies {
                if matches!(kind, Kind::Swept(_) | Kind::SweptReverse(_)) {
                    let at = get::<Transform>(&self.app, body).translation;
                    assert!(
                        at.abs().max_element() < self.half,
                        "{name}, tick {n}: {kind:?} at {at}"
                    );
                }
            }
        }
    }
}

/// +10 against −10 per second, restitution 1; ten apart.
fn head_on(sub_steps: [u32; 2], ticks: usize) -> [(f32, f32); 2] {
    let mut app = app(BroadPhaseMethod::default());
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0),
    });
    let balls = [0, 1].map(|i| {
        let side = [-1.0, 1.0][i];
        let ball = (
            CollisionShape::sphere(0.5),
            Velocity(Vec3::X * -10.0 * side),
            ELASTIC,
        );
        app.world_mut()
            .spawn((
                ball,
                Swept::new(sub_steps[i]),
                Transform::from_xyz(5.0 * side, 0.0, 0.0),
            ))
            .id()
    });
    tick(&mut app, ticks);
    balls.map(|ball| {
        (
            get::<Transform>(&app, ball).translation.x,
            get::<Velocity>(&app, ball).x,
        )
    })
}

fn assert_near(found: [(f32, f32); 2], expected: [(f32, f32); 2]) {
    let off = found
        .iter()
        .zip(&expected)
        .map(|(a, b)| (a.0 - b.0).abs().max((a.1 - b.1).abs()));
    assert!(
        off.fold(0.0, f32::max) < 1e-3,
        "{found:?}, expected {expected:?}"
    );
}

/// It keeps its velocity for the next tick, and has none in this one.
#[test]
fn who_may_not_bounce_any_more_is_a_wall_at_rest() {
    assert_near(head_on([8, 8], 1), [(-6.0, -10.0), (6.0, 10.0)]);
    assert_near(head_on([8, 0], 1), [(-6.0, -10.0), (0.5, -10.0)]);
    assert_near(head_on([0, 8], 1), [(-0.5, 10.0), (6.0, 10.0)]);
    assert_near(head_on([0, 0], 1), [(-0.5, 10.0), (0.5, -10.0)]);
    // It goes on at the next tick, where nothing is in its way.
    assert_near(head_on([8, 0], 2), [(-16.0, -10.0), (-9.5, -10.0)]);
    assert_near(head_on([0, 0], 5), [(-0.5, 10.0), (0.5, -10.0)]);
}

/// A ball between a wall and another that has come to stay, hit by a third.
#[test]
fn who_has_come_to_stay_is_a_wall_to_all_that_come_after() {
    let mut app = app(BroadPhaseMethod::default());
    app.insert_resource(MotionSettings {
        step: Step::Seconds(1.0),
    });
    let wall = (
        CollisionShape::from_half_size(Vec3::new(0.5, 5.0, 5.0)),
        StaticShape,
    );
    app.world_mut()
        .spawn((wall, Transform::from_xyz(0.5, 0.0, 0.0)));
    let mut ball = |x: f32, velocity: f32, sub_steps: u32| {
        let ball = (
            CollisionShape::sphere(0.5),
            Velocity(Vec3::X * velocity),
            ELASTIC,
        );
        app.world_mut()
            .spawn((
                ball,
                Swept::new(sub_steps),
                Transform::from_xyz(x, 0.0, 0.0),
            ))
            .id()
    };
    let balls = [
        ball(-1.0, 16.0, 0),
        ball(-4.0, 8.0, 8),
        ball(-10.0, 12.0, 8),
    ];
    tick(&mut app, 1);
    let found = balls.map(|ball| {
        (
            get::<Transform>(&app, ball).translation.x,
            get::<Velocity>(&app, ball).x,
        )
    });
    // The first is at the wall for good. The second is thrown back by it after 5/16, exchanges its
    // velocity with the third after 1/2, and is thrown back once more after 5/8.
    for (found, expected) in found
        .into_iter()
        .zip([(-0.5, 16.0), (-6.0, -12.0), (-8.0, -8.0)])
    {
        assert!(
            (found.0 - expected.0)
                .abs()
                .max((found.1 - expected.1).abs())
                < 1e-3,
            "{found:?}, expected {expected:?}"
        );
    }
}

/// The defaults at nine times the size of the room, one bounce for each of many, and all that is
/// between.
fn rooms() -> Vec<(String, Room, usize)> {
    let (ball, cube) = (
        CollisionShape::sphere(0.2),
        CollisionShape::from_half_size(Vec3::splat(0.2)),
    );
    let mut rooms = Vec::new();
    let mut add = |half: f32,
                   shape: &CollisionShape,
                   step: f32,
                   restitution: f32,
                   kinds: &[Kind],
                   count: usize| {
        let name = format!("{count} of {kinds:?}, {step} per tick, restitution {restitution}");
        let mut room = Room::new(half, rooms.len() as u64);
        room.fill(
            shape,
            step,
            restitution,
            kinds.iter().copied().cycle().take(count),
        );
        rooms.push((name, room, count));
    };
    for sub_steps in [0, 1, 2, 3, 5, 8] {
        for (shape, step) in [(&ball, 9.4), (&ball, 0.9), (&cube, 2.0)] {
            add(2.0, shape, step, 1.0, &[Kind::Swept(sub_steps)], 2);
            add(
                2.5,
                shape,
                step,
                1.0,
                &[Kind::Swept(sub_steps), Kind::Swept(8)],
                9,
            );
        }
    }
    add(4.0, &ball, 0.9, 1.0, &[Kind::Swept(1)], 100);
    add(4.0, &ball, 0.9, 0.7, &[Kind::Swept(1), Kind::Swept(8)], 60);
    add(3.0, &cube, 0.4, 1.0, &[Kind::Discrete], 30);
    add(
        3.0,
        &ball,
        0.1,
        1.0,
        &[Kind::Discrete, Kind::DiscreteReverse],
        40,
    );
    let all = [
        Kind::Swept(8),
        Kind::Swept(0),
        Kind::SweptReverse(8),
        Kind::Discrete,
        Kind::SweptReverse(1),
        Kind::DiscreteReverse,
        Kind::Static,
        Kind::Sensor,
        Kind::Swept(1),
    ];
    for step in [0.1, 0.5, 3.0] {
        for shape in [&ball, &cube] {
            add(3.0, shape, step, 1.0, &all, 45);
        }
    }
    rooms
}

#[test]
fn energy_never_grows_and_nobody_leaves() {
    for (name, mut room, count) in rooms() {
        room.check(4000 / (count + 8), &name);
    }
}

/// `cargo test --release --test app -- --ignored conservation::`
#[test]
#[ignore = "a hundred thousand ticks of sixty rooms"]
fn nor_in_a_hundred_thousand_ticks() {
    for (name, mut room, _) in rooms() {
        room.check(100_000, &name);
    }
}
