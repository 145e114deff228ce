//! Queries under the mouse: what its ray meets, what is in a ball there, what is nearest to it.

use std::f32::consts::TAU;

use bevy::prelude::*;
use bevy_octree::prelude::*;

use crate::{
    play::{Play, TICKS_PER_SECOND, Tick},
    scene::{AddScene as _, OfScene, Scene, showing},
};

const NAME: &str = "queries";
/// Half the sides of what objects are in.
const ROOM: Vec3 = Vec3::new(10.0, 3.5, 7.0);
/// The ball around what is met.
const BLAST: f32 = 2.2;
/// How many of the nearest are shown.
const NEAREST: usize = 6;

/// Adds the scene.
pub fn plugin(app: &mut App) {
    let scene = Scene::new(
        NAME,
        "a ray, a region and the nearest, under the mouse",
        "Orange: what the ray of the mouse meets, and where. Pink: what is in a ball around that point. \
         Green: from the point to the six that are nearest, by their exact shapes.",
        spawn,
    );
    app.insert_gizmo_config(
        Answers,
        GizmoConfig {
            depth_bias: -0.95,
            ..default()
        },
    )
    .add_scene(
        scene
            .view(Vec3::new(6.0, 10.0, 21.0), Vec3::ZERO)
            .objects(220, 5000)
            .best_tick(50)
            .caption(say),
    )
    .add_systems(
        Tick,
        spin.before(CollisionSystems::Motion).run_if(showing(NAME)),
    )
    .add_systems(Last, ask.run_if(showing(NAME)));
}

/// Lines that are seen through what is in front of them.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Answers;

/// How it turns, in radians per second.
#[derive(Component)]
struct Spin(Vec3);

/// What was found.
#[derive(Component, Default)]
struct Found {
    met: Option<f32>,
    in_ball: usize,
}

fn spawn(world: &mut World, objects: usize) {
    let mut random = fastrand::Rng::with_seed(5);
    let mut share = || random.f32() * 2.0 - 1.0;
    let octahedron = [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let hull = CollisionShape::convex_hull(octahedron.map(|corner| corner * 0.6));
    let kinds = [
        CollisionShape::cuboid(0.9, 0.5, 0.7),
        CollisionShape::sphere(0.4),
        CollisionShape::capsule(0.22, 0.7),
        CollisionShape::cylinder(0.35, 0.7),
        CollisionShape(Shape::cone(0.45, 0.9)),
        hull.unwrap_or_else(|_| CollisionShape::sphere(0.5)),
    ];
    for number in 0..objects {
        let at = Vec3::new(share(), share(), share()) * ROOM;
        let turn = Quat::from_scaled_axis(Vec3::new(share(), share(), share()) * 3.0);
        world.spawn((
            kinds[number % kinds.len()].clone(),
            Spin(Vec3::new(share(), share(), share())),
            Transform::from_translation(at).with_rotation(turn),
        ));
    }
    world.spawn((OfScene, Found::default()));
}

fn spin(mut spinning: Query<(&Spin, &mut Transform)>) {
    for (spin, mut place) in &mut spinning {
        let turn = Quat::from_scaled_axis(spin.0 / TICKS_PER_SECOND);
        place.rotation = (turn * place.rotation).normalize();
    }
}

/// The ray of the mouse; without a window, one that goes around by itself.
fn ray(windows: Query<&Window>, camera: (&Camera, &GlobalTransform), tick: u64) -> Option<Ray3d> {
    let (camera, eye) = camera;
    if let Ok(window) = windows.single() {
        return camera
            .viewport_to_world(eye, window.cursor_position()?)
            .ok();
    }
    let turn = tick as f32 / 200.0 * TAU;
    let target = Vec3::new(turn.cos() * 5.0, (2.0 * turn).sin() * 1.5, turn.sin() * 3.0);
    let from = eye.translation();
    Some(Ray3d::new(from, Dir3::new(target - from).ok()?))
}

fn ask(
    windows: Query<&Window>,
    camera: Single<(&Camera, &GlobalTransform)>,
    play: Res<Play>,
    spatial: SpatialQuery,
    places: Query<(&CollisionShape, &GlobalTransform)>,
    mut found: Query<&mut Found>,
    mut gizmos: Gizmos<Answers>,
) {
    let Ok(mut found) = found.single_mut() else {
        return;
    };
    *found = Found::default();
    let Some(ray) = ray(windows, *camera, play.tick) else {
        return;
    };
    let filter = SpatialQueryFilter::DEFAULT;
    let Some(hit) = spatial.cast_ray(ray, 1000.0, &filter) else {
        return;
    };
    found.met = Some(hit.distance);
    let [orange, pink, green] = [
        Color::srgb(1.0, 0.55, 0.05),
        Color::srgb(0.95, 0.55, 0.8),
        Color::srgb(0.1, 0.9, 0.6),
    ];
    // From a little aside of the eye, so that the ray is seen as a line.
    let aside = ray.origin + Vec3::new(1.5, -1.2, 0.0);
    gizmos.line(aside, hit.point, orange);
    gizmos.arrow(hit.point, hit.point + hit.normal * 1.2, orange);
    gizmos.sphere(hit.point, BLAST, pink.with_alpha(0.35));
    let mut outline = |entity, color| {
        if let Ok((CollisionShape(shape), place)) = places.get(entity)
            && let Ok(aabb) = shape.world_aabb(&place.compute_transform())
        {
            gizmos.aabb_3d(aabb, Transform::IDENTITY, color);
        }
    };
    outline(hit.entity, orange);
    spatial.for_each_sphere_intersection(hit.point, BLAST, &filter, |entity| {
        found.in_ball += 1;
        if entity != hit.entity {
            outline(entity, pink);
        }
    });
    let mut nearest = Vec::new();
    let others = filter.except(hit.entity);
    spatial.k_nearest(hit.point, NEAREST, f32::INFINITY, &others, &mut nearest);
    for near in nearest {
        gizmos.line(hit.point, near.point, green);
        gizmos.sphere(near.point, 0.06, green);
    }
}

fn say(world: &mut World) -> String {
    let mut found = world.query::<&Found>();
    let Some(found) = found.iter(world).next() else {
        return String::new();
    };
    match found.met {
        Some(distance) => format!(
            "met at a distance of {distance:.2}; {} in the ball",
            found.in_ball
        ),
        None => "nothing is under the mouse".to_owned(),
    }
}
