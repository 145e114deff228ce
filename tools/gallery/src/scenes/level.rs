//! A level that is one mesh: hills, with balls and boxes that roll down them.

use bevy::{math::bounding::BoundingVolume as _, prelude::*};
use bevy_octree::prelude::*;

use crate::{
    play::{TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, Scene, showing},
    settings::{Leaves, Settings},
};

const NAME: &str = "level";
/// Squares of two triangles along each side.
const SQUARES: u32 = 120;
/// The side of a square.
const SIDE: f32 = 0.5;
const GRAVITY: f32 = 9.81;
const TICK: f32 = 1.0 / TICKS_PER_SECOND;
/// What is left of the speed of what rolls, after a second.
const ROLLING: f32 = 0.6;

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "hills of 28 800 triangles, one mesh",
        "The ground is one shape, searched by the tree that is built with it. With leaves drawn, it is \
         that tree: green boxes around its triangles.",
        spawn,
    );
    app.add_scene(
        scene
            .view(Vec3::new(0.0, 26.0, 44.0), Vec3::new(0.0, -2.0, 2.0))
            .objects(300, 3000)
            .best_tick(150),
    )
    .add_systems(
        Tick,
        (
            fall.before(CollisionSystems::Motion),
            roll.after(CollisionSystems::Response)
                .before(CollisionSystems::Report),
        )
            .run_if(showing(NAME)),
    )
    .add_systems(Update, draw_tree.run_if(showing(NAME)));
}

/// The height of the ground.
fn height(x: f32, z: f32) -> f32 {
    let waves = 1.6 * (x / 4.5).sin() * (z / 3.8).cos() + 0.5 * (x / 1.9 + z / 2.3).sin();
    let reach = SQUARES as f32 * SIDE / 2.0;
    let rim = (x.abs().max(z.abs()) / reach).powi(12);
    waves + 7.0 * rim
}

/// The ground.
#[derive(Component)]
struct Ground;

/// What gravity pulls, and how far its middle is from what it rolls on.
#[derive(Component)]
struct Rolls(f32);

fn spawn(world: &mut World, objects: usize) {
    let at = |index: u32| (index as f32 - SQUARES as f32 / 2.0) * SIDE;
    let corners = (0..=SQUARES).flat_map(|z| (0..=SQUARES).map(move |x| [at(x), at(z)]));
    let vertices: Vec<_> = corners
        .map(|[x, z]| Vec3::new(x, height(x, z), z))
        .collect();
    let triangles = (0..SQUARES).flat_map(|z| {
        (0..SQUARES).flat_map(move |x| {
            let a = z * (SQUARES + 1) + x;
            let [b, c, d] = [a + SQUARES + 1, a + SQUARES + 2, a + 1];
            [[a, b, c], [a, c, d]]
        })
    });
    match PolygonMesh::new(vertices, triangles) {
        Ok(mesh) => _ = world.spawn((Ground, StaticShape, CollisionShape::from(mesh))),
        Err(error) => error!("the hills: {error}"),
    }
    // Contacts with their depth and normal, for all.
    world.insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    });

    let mut random = fastrand::Rng::with_seed(1);
    let mut share = || random.f32() * 2.0 - 1.0;
    let reach = SQUARES as f32 * SIDE * 0.42;
    for number in 0..objects {
        let (x, z) = (share() * reach, share() * reach);
        let lift = 1.5 + 3.0 * share().abs();
        let place = Transform::from_xyz(x, height(x, z) + lift, z);
        let (shape, restitution, rolls) = if number % 3 == 0 {
            let half_size = Vec3::new(0.45, 0.3, 0.35);
            (CollisionShape::from_half_size(half_size), 0.1, Rolls(0.3))
        } else {
            (CollisionShape::sphere(0.4), 0.3, Rolls(0.4))
        };
        let turned = place.with_rotation(Quat::from_scaled_axis(Vec3::splat(share())));
        world.spawn((
            shape,
            // Who is lifted first is up to this, and not to what was spawned before.
            CollisionOrder(number as u64),
            rolls,
            Velocity::default(),
            Bounce::Reflect { restitution },
            turned,
        ));
    }
}

fn fall(mut rolling: Query<&mut Velocity, With<Rolls>>) {
    for mut velocity in &mut rolling {
        velocity.y -= GRAVITY * TICK;
    }
}

/// What has come to be in the ground, or in another, is lifted out, and turns as what rolls does.
fn roll(
    contacts: Res<Contacts>,
    ground: Single<Entity, With<Ground>>,
    mut rolling: Query<(&mut Transform, &mut Velocity, &Rolls)>,
) {
    for collision in contacts.iter() {
        let Some(contact) = collision.contact else {
            continue;
        };
        let is_ground = [collision.a == *ground, collision.b == *ground];
        if is_ground == [false; 2] {
            // Each half the way.
            for (entity, sign) in [(collision.a, -0.5), (collision.b, 0.5)] {
                if let Ok((mut at, ..)) = rolling.get_mut(entity) {
                    at.translation += contact.normal * (contact.depth * sign);
                }
            }
            continue;
        }
        let collision = if is_ground[0] {
            collision.reversed()
        } else {
            collision
        };
        let (Some(contact), Ok((mut at, mut velocity, Rolls(radius)))) =
            (collision.contact, rolling.get_mut(collision.a))
        else {
            continue;
        };
        let up = -contact.normal;
        at.translation += up * contact.depth;
        let turn = up.cross(velocity.0) * (TICK / radius);
        at.rotation = (Quat::from_scaled_axis(turn) * at.rotation).normalize();
        velocity.0 *= 1.0 - (1.0 - ROLLING) * TICK;
    }
}

/// The boxes of the mesh's tree: by generation all but the lowest, by fill the lowest alone.
fn draw_tree(
    settings: Res<Settings>,
    ground: Query<&CollisionShape, With<Ground>>,
    mut gizmos: Gizmos,
) {
    let Ok(CollisionShape(Shape::Mesh(mesh))) = ground.single() else {
        return;
    };
    let heights = match settings.leaves {
        Leaves::None => return,
        Leaves::Generation => 2..mesh.tree_height(),
        Leaves::Fill => 1..2,
    };
    let top = mesh.tree_height().max(2) as f32 - 1.0;
    for height in heights {
        let color = Color::srgb(0.2, 0.35, 0.4)
            .mix(&Color::srgb(0.2, 0.95, 0.5), 1.0 - height as f32 / top);
        mesh.for_each_tree_box(height, |aabb| {
            let place = Transform::from_translation(aabb.center().into())
                .with_scale(Vec3::from(aabb.half_size()) * 2.0);
            gizmos.cube(place, color);
        });
    }
}
