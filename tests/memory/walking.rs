//! Who walks takes no memory.

use bevy::{ecs::system::SystemState, prelude::*};
use bevy_octree::{character::walk, prelude::*};

use crate::{
    allocator::{alone, assert_flat, peak_of},
    app,
};

/// Stairs, a ramp, a mesh and walls that meet.
fn scene() -> App {
    let mut app = app(1.0 / 60.0);
    let mut spawn = |shape: CollisionShape, at: Transform| {
        app.world_mut().spawn((shape, at, StaticShape));
    };
    spawn(
        CollisionShape::cuboid(60.0, 1.0, 60.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    );
    for i in 0..6 {
        let at = Transform::from_xyz(6.0 + i as f32 * 0.4, 0.1 * (i + 1) as f32, 0.0);
        spawn(CollisionShape::cuboid(4.0, 0.2 * (i + 1) as f32, 4.0), at);
    }
    for angle in [0.3_f32, -0.3] {
        let turn = Quat::from_rotation_y(angle);
        let at = Transform::from_xyz(-8.0, 1.0, 3.0 * angle.signum()).with_rotation(turn);
        spawn(CollisionShape::cuboid(12.0, 3.0, 0.5), at);
    }
    let row = 41;
    let vertices: Vec<_> = (0..row * row)
        .map(|i| {
            let (x, z) = ((i % row) as f32, (i / row) as f32);
            Vec3::new(x - 20.0, 0.4 * (x.sin() + z.cos()) - 0.2, z + 8.0)
        })
        .collect();
    let triangles = (0..40 * 40).flat_map(|i| {
        let a = i / 40 * row + i % 40;
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    });
    spawn(
        CollisionShape::mesh(vertices, triangles).unwrap(),
        Transform::default(),
    );
    app.update();
    app
}

#[test]
fn a_walk_allocates_nothing() {
    let _alone = alone();
    let mut app = scene();
    let shape = Shape::capsule(0.4, 1.0);
    let world = app.world_mut();
    let mut state = SystemState::<MoveAndSlide>::new(world);
    let mover = state.get(world).unwrap();
    let go = || {
        let (mut at, mut ground, mut fall) = (Transform::from_xyz(0.0, 1.0, 0.0), None, 0.0);
        for tick in 0..600 {
            let angle = (tick / 100) as f32 * 1.1;
            let way = Vec3::new(angle.cos(), 0.0, angle.sin()) * 6.0;
            let filter = SpatialQueryFilter::DEFAULT;
            let velocity = way + Vec3::Y * (fall - 0.16);
            let walked = walk(
                &mover,
                &shape,
                &at,
                velocity,
                1.0 / 60.0,
                ground.as_ref(),
                &WalkSettings::default(),
                &filter,
                |_| AtHit::Slide,
            );
            (at, ground, fall) = (walked.pose, walked.ground, walked.velocity.y);
            let moved = mover.move_and_slide(
                &shape,
                &at,
                way * 3.0,
                0.1,
                &MoveSettings::default(),
                &filter,
                |_| AtHit::Slide,
            );
            assert_eq!(moved.end, MoveEnd::Done);
        }
    };
    go();
    let peak = peak_of(go);
    // The test harness may write a line meanwhile.
    assert!(peak < 1024, "{peak} bytes");
}

#[test]
fn a_crowd_that_walks_stays_as_large() {
    let _alone = alone();
    let mut app = scene();
    for i in 0..40 {
        let at = Transform::from_xyz((i % 8) as f32 - 4.0, 1.0, (i / 8) as f32 - 2.0);
        let walker = (KinematicCharacter::default(), CharacterHits::default());
        app.world_mut()
            .spawn((walker, CollisionShape::capsule(0.3, 1.0), at));
    }
    let mut tick = 0;
    assert_flat("a crowd", 200, 400, || {
        tick += 1;
        let angle = (tick / 50) as f32;
        let world = app.world_mut();
        let mut walking = world.query::<&mut KinematicCharacter>();
        for mut walking in walking.iter_mut(world) {
            let fall = walking.velocity.y - 0.16;
            walking.velocity = Vec3::new(angle.cos() * 3.0, fall, angle.sin() * 3.0);
        }
        app.update();
    });
}
