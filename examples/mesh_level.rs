//! A level from a mesh asset: it is waited for, a crate slides through it and past a trigger, and a
//! laser is reflected by its walls. Without a window: it prints what happens, and fails if it does
//! not.
//!
//! `cargo run --release --features mesh --example mesh_level`

use std::time::Duration;

use bevy::{
    asset::AssetPlugin,
    mesh::{Indices, MeshPlugin},
    prelude::*,
};
use bevy_octree::prelude::*;

collision_layers! {
    enum Layer { Level, Crate }
}

const TICK: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.8;
/// How long, wide and high the room is; its middle is the origin.
const ROOM: Vec3 = Vec3::new(20.0, 4.0, 12.0);
const FLOOR: f32 = -ROOM.y / 2.0;
/// The side of the crate.
const CRATE: f32 = 1.0;

#[derive(Component)]
struct Level;

#[derive(Component)]
struct Slides;

#[derive(Resource, Default)]
struct Alarm {
    entered: u32,
    left: u32,
}

fn main() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        MeshPlugin,
        OctreePlugins::new(Update),
    ))
    .insert_resource(MotionSettings {
        step: Step::Seconds(TICK),
    })
    .init_resource::<Alarm>()
    .add_observer(name_what_is_broken)
    .add_systems(Startup, spawn)
    .add_systems(Update, fall.before(CollisionSystems::Motion));

    // A loading screen: shapes are built on other threads, if the app has some.
    let is_loading = |world: &mut World| {
        let mut waiting = world.query_filtered::<(), (
            With<ShapeFromMesh>,
            Without<CollisionShape>,
            Without<ShapeFromMeshError>,
        )>();
        waiting.iter(world).next().is_some()
    };
    for _ in 0..10_000 {
        app.update();
        if !is_loading(app.world_mut()) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let mut levels = app
        .world_mut()
        .query_filtered::<&CollisionShape, With<Level>>();
    assert_eq!(levels.iter(app.world()).count(), 1, "the room has a shape");

    app.world_mut().spawn((
        Slides,
        CollisionShape::cuboid(CRATE, CRATE, CRATE),
        CollisionLayers::new(Layer::Crate, Layer::Level),
        // Held up by the floor, along which it slides.
        (
            Swept::default(),
            Velocity(Vec3::X * 4.0),
            Bounce::Reflect { restitution: 0.0 },
        ),
        ManifoldsEnabled,
        Transform::from_xyz(-7.0, FLOOR + CRATE, 0.0),
    ));
    for _ in 0..240 {
        app.update();
    }
    let Alarm { entered, left } = *app.world().resource();
    assert_eq!((entered, left), (1, 1), "the crate passed the trigger once");

    app.add_systems(Last, (stand, reflect, look_in).chain());
    app.update();
}

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    // Closed, and walked in: not a solid, but its surface.
    commands.spawn((
        Level,
        StaticShape,
        ShapeFromMesh::of(meshes.add(Cuboid::from_size(ROOM)), MeshForm::SurfaceOnly),
        CollisionLayers::new(Layer::Level, LayerMask::ALL),
    ));
    // Of a vertex that is not there.
    let broken = Mesh::from(Cuboid::default()).with_inserted_indices(Indices::U16(vec![0, 1, 99]));
    commands.spawn((
        Name::new("broken statue"),
        ShapeFromMesh::new(meshes.add(broken)),
    ));
    // It hears of the crate, which does not hear of it and slides on.
    let trigger = (
        CollisionShape::cuboid(2.0, ROOM.y, ROOM.z),
        StaticShape,
        Detector,
        CollisionLayers::new(LayerMask::NONE, Layer::Crate),
    );
    commands
        .spawn((trigger, CollisionEventsEnabled))
        .observe(|_: On<CollisionStarted>, mut alarm: ResMut<Alarm>| {
            println!("the crate enters the trigger");
            alarm.entered += 1;
        })
        .observe(|_: On<CollisionEnded>, mut alarm: ResMut<Alarm>| {
            println!("the crate leaves the trigger");
            alarm.left += 1;
        });
}

/// What a mesh has no shape for, a game may put a box in the place of.
fn name_what_is_broken(
    insert: On<Insert, ShapeFromMeshError>,
    errors: Query<(&Name, &ShapeFromMeshError)>,
    mut commands: Commands,
) {
    if let Ok((name, ShapeFromMeshError(error))) = errors.get(insert.entity) {
        println!("the {name} is a box, for: {error}");
        let place = Transform::from_xyz(0.0, FLOOR + 0.5, 4.0);
        commands
            .entity(insert.entity)
            .insert((CollisionShape::default(), StaticShape, place));
    }
}

fn fall(mut falling: Query<&mut Velocity, With<Slides>>) {
    for mut velocity in &mut falling {
        velocity.y -= GRAVITY * TICK;
    }
}

/// On which points does the crate stand?
fn stand(
    crates: Query<(Entity, &Transform), With<Slides>>,
    level: Single<Entity, With<Level>>,
    collisions: Collisions,
) {
    for (entity, at) in &crates {
        let manifold = collisions.manifold(entity, *level);
        let points = manifold.map_or(0, |manifold| manifold.points().len());
        println!(
            "the crate is at {:.2}, and stands on {points} points",
            at.translation
        );
        assert!((at.translation.y - (FLOOR + CRATE / 2.0)).abs() < 0.01);
        assert!(manifold.is_some_and(|manifold| manifold.normal.distance(Vec3::NEG_Y) < 1e-3));
        assert_eq!(points, 4);
    }
}

/// A laser that goes on from wall to wall, by the triangles that it meets.
fn reflect(level: Single<(Entity, &CollisionShape), With<Level>>, spatial: SpatialQuery) -> Result {
    let (room, CollisionShape(Shape::Mesh(mesh))) = *level else {
        unreachable!("it was made from a mesh")
    };
    let filter = SpatialQueryFilter::DEFAULT.on(Layer::Level);
    // Not what it starts on, by which it was reflected just now.
    let options = RayCastOptions::DEFAULT.ignore_start();
    let mut ray = Ray3d::new(Vec3::ZERO, Dir3::new(Vec3::new(1.0, 0.4, 0.3))?);
    let mut triangles = vec![];
    for _ in 0..6 {
        let Some(hit) = spatial.cast_ray_with(ray, 100.0, &filter, &options) else {
            break;
        };
        assert_eq!(hit.entity, room);
        // A hit tells the number of the triangle in Bevy's mesh; the shape has left out those
        // without an area, if there were any.
        let index = hit.polygon.and_then(|number| mesh.polygon_index(number));
        assert_eq!(
            index.map(|index| mesh.normals()[index]),
            Some(hit.face_normal)
        );
        triangles.extend(hit.polygon);
        ray = Ray3d::new(hit.point, Dir3::new(ray.direction.reflect(hit.normal))?);
    }
    println!("the laser meets the triangles {triangles:?}");
    assert_eq!(triangles.len(), 6);
    Ok(())
}

/// From outside, by the faces that face away: past the near wall, into the room.
fn look_in(spatial: SpatialQuery) {
    let filter = SpatialQueryFilter::DEFAULT.on(Layer::Level);
    let ray = Ray3d::new(Vec3::new(-30.0, 1.0, 1.0), Dir3::X);
    let first = |options| spatial.cast_ray_with(ray, 100.0, &filter, &options);
    let outside = first(RayCastOptions::DEFAULT).map(|hit| hit.point.x);
    let inside = first(RayCastOptions::DEFAULT.back_faces()).map(|hit| hit.point.x);
    println!("a ray from outside meets the walls at x = {outside:?}, from inside at {inside:?}");
    assert_eq!([outside, inside], [Some(-ROOM.x / 2.0), Some(ROOM.x / 2.0)]);
}
