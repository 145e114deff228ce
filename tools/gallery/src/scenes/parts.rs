//! Things made of parts: ships that fly about in a glass box, each one thing to all others.

use bevy::prelude::*;
use bevy_octree::{parts::CollisionBody, prelude::*};

use crate::{
    look::OwnLook,
    play::{TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, Scene, showing},
};

const NAME: &str = "parts";
/// Half the sides of the box.
const ROOM: Vec3 = Vec3::new(13.0, 7.0, 9.0);

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "ships of five shapes each",
        "A ship is one thing with five shapes: it bounces as one, its parts never meet each other, and \
         which part was hit is told. Only that part is painted.",
        spawn,
    );
    app.add_scene(
        scene
            .view(Vec3::new(9.0, 10.0, 26.0), Vec3::ZERO)
            .objects(12, 200)
            .best_tick(90)
            .caption(say),
    )
    .add_systems(
        Tick,
        steer.before(CollisionSystems::Motion).run_if(showing(NAME)),
    );
}

#[derive(Component)]
struct Ship;

const PARTS: [([f32; 3], [f32; 3], f32); 5] = [
    ([3.0, 0.9, 0.9], [0.0, 0.0, 0.0], 0.0),
    ([1.0, 0.5, 0.5], [1.8, 0.0, 0.0], 0.0),
    ([0.8, 0.12, 2.0], [-0.5, 0.0, -1.2], 0.4),
    ([0.8, 0.12, 2.0], [-0.5, 0.0, 1.2], -0.4),
    ([0.8, 1.0, 0.12], [-1.2, 0.8, 0.0], 0.0),
];

fn spawn(world: &mut World, objects: usize) {
    let mut random = fastrand::Rng::with_seed(4);
    let mut around = |reach: Vec3| {
        Vec3::from_array(std::array::from_fn(|axis| {
            (random.f32() * 2.0 - 1.0) * reach[axis]
        }))
    };
    for _ in 0..objects {
        let course = around(Vec3::new(1.0, 0.4, 1.0)).normalize_or(Vec3::X) * 6.0;
        let place = Transform::from_translation(around(ROOM - 3.0));
        let ship = (
            Ship,
            CollisionBody::default(),
            Velocity(course),
            Bounce::Reflect { restitution: 1.0 },
            heading(course, place),
        );
        let ship = world
            .spawn((ship, crate::scene::OfScene, Visibility::default()))
            .id();
        for (size, at, turn) in PARTS {
            let [x, y, z] = size;
            let place =
                Transform::from_translation(at.into()).with_rotation(Quat::from_rotation_y(turn));
            world.spawn((CollisionShape::cuboid(x, y, z), place, ChildOf(ship)));
        }
    }
    // The box is of glass: it has a shape, and no look.
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut half_size = ROOM + 1.0;
            half_size[axis] = 0.5;
            let mut at = Vec3::ZERO;
            at[axis] = side * (ROOM[axis] + 0.5);
            world.spawn((
                CollisionShape::from_half_size(half_size),
                StaticShape,
                OwnLook,
                Transform::from_translation(at),
            ));
        }
    }
}

/// A ship points to where it flies: its nose is along x.
fn heading(course: Vec3, place: Transform) -> Transform {
    place.with_rotation(Quat::from_rotation_arc(
        Vec3::X,
        course.normalize_or(Vec3::X),
    ))
}

/// After a bounce, a ship turns to its new course within half a second.
fn steer(mut ships: Query<(&Velocity, &mut Transform), With<Ship>>) {
    for (velocity, mut place) in &mut ships {
        let wanted = heading(velocity.0, *place).rotation;
        if place.rotation.angle_between(wanted) > 0.01 {
            let share = 8.0 / TICKS_PER_SECOND;
            place.rotation = place.rotation.slerp(wanted, share).normalize();
        }
    }
}

fn say(world: &mut World) -> String {
    let contacts = world.resource::<Contacts>();
    let (bodies, parts) = (contacts.body_pairs().len(), contacts.len());
    format!("{bodies} pairs of things in contact, by {parts} pairs of shapes")
}
