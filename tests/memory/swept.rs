//! Continuous detection takes no more memory the longer it runs: by an allocator that counts.

use crate::{allocator, app, common};

use allocator::{alone, assert_flat_but_for};
use bevy::prelude::*;
use bevy_octree::prelude::*;

fn wall(app: &mut App, center: Vec3, half_size: Vec3) {
    let shape = CollisionShape::from_half_size(half_size);
    app.world_mut()
        .spawn((shape, Transform::from_translation(center)));
}

fn ball(app: &mut App, center: Vec3, velocity: Vec3, parts: impl Bundle) {
    let shape = CollisionShape::sphere(0.1);
    let moving = (Velocity(velocity), Bounce::Reflect { restitution: 1.0 });
    app.world_mut()
        .spawn((shape, moving, Transform::from_translation(center), parts));
}

#[test]
fn memory_stays_flat() {
    let _alone = alone();
    // One ball between two walls, that bounces once per tick.
    let mut one = app(1.0);
    for x in [-1.0, 1.0] {
        wall(&mut one, Vec3::X * x, Vec3::new(0.1, 5.0, 5.0));
    }
    ball(&mut one, Vec3::ZERO, Vec3::X * 2.0, Swept::default());
    assert_flat_but_for(0, "one ball", 5_000, 15_000, || common::tick(&mut one, 1));
    drop(one);

    // A room of balls, a quarter of them swept.
    let mut many = app(1.0);
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            wall(
                &mut many,
                axis * side * 8.0,
                Vec3::splat(8.0) * (Vec3::ONE - axis) + axis * 0.5,
            );
        }
    }
    let mut random = fastrand::Rng::with_seed(1);
    let mut vector =
        |size: f32| Vec3::from_array([0; 3].map(|_| (random.f32() * 2.0 - 1.0) * size));
    for place in 0..400 {
        let (center, velocity) = (vector(6.0), vector(0.5));
        match place % 4 {
            0 => ball(&mut many, center, velocity * 4.0, Swept::default()),
            _ => ball(&mut many, center, velocity, ()),
        }
    }
    assert_flat_but_for(0, "a room of balls", 2_500, 7_500, || {
        common::tick(&mut many, 1);
    });
}
