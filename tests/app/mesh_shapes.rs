//! Shapes of mesh assets: what a game sees when there are none, and when what is asked for changes.

use std::time::Duration;

use bevy::{
    asset::{AssetPlugin, io::AssetSourceId},
    mesh::Indices,
    prelude::*,
};
use bevy_octree::{
    narrow_phase::{Shape, ShapeError},
    prelude::*,
};

use crate::common::{
    self,
    warnings::{on_this_thread, told},
};
use common::get;

/// Who listens to the log hears this thread alone.
fn app_without_meshes() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        OctreePlugins::new(Update),
    ));
    on_this_thread(&mut app, Update);
    app
}

fn app() -> App {
    let mut app = app_without_meshes();
    app.init_asset::<Mesh>();
    app
}

fn add(app: &mut App, mesh: impl Into<Mesh>) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// One that names a vertex that is not there.
fn bad() -> Mesh {
    Mesh::from(Cuboid::default()).with_inserted_indices(Indices::U16(vec![0, 1, 99]))
}

/// Updates until something is so, but not for ever.
fn wait(app: &mut App, what: impl Fn(&World) -> bool) {
    for _ in 0..4000 {
        app.update();
        if what(app.world()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("it took too long");
}

fn polygons(world: &World, entity: Entity) -> Option<usize> {
    match &world.get::<CollisionShape>(entity)?.0 {
        Shape::Mesh(mesh) => Some(mesh.polygon_count()),
        Shape::Convex(mesh) => Some(mesh.polygon_count()),
        _ => Some(0),
    }
}

fn fails(world: &World, entity: Entity) -> bool {
    world.get::<ShapeFromMeshError>(entity).is_some()
}

#[test]
fn a_failure_is_a_component_until_there_is_a_shape() {
    #[derive(Resource, Default)]
    struct Heard(Vec<Entity>);
    let mut app = app();
    app.init_resource::<Heard>().add_observer(
        |on: On<Insert, ShapeFromMeshError>, mut heard: ResMut<Heard>| heard.0.push(on.entity),
    );
    let mesh = add(&mut app, bad());
    let of = ShapeFromMesh::new(mesh.clone());
    let [first, second] = [(); 2].map(|()| app.world_mut().spawn(of.clone()).id());
    wait(&mut app, |world| fails(world, first));
    assert!(matches!(
        get::<ShapeFromMeshError>(&app, second).0,
        ShapeError::IndexOutOfRange { polygon: 0, .. }
    ));
    app.update();
    assert_eq!(app.world().resource::<Heard>().0, [first, second]);

    // Mended.
    let put = |app: &mut App, new: Mesh| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let _ = meshes.insert(mesh.id(), new);
    };
    put(&mut app, Cuboid::default().into());
    wait(&mut app, |world| polygons(world, first) == Some(12));
    assert!(![first, second].iter().any(|e| fails(app.world(), *e)));

    // Broken again: the shape stays, and the error is there, too.
    put(&mut app, bad());
    wait(&mut app, |world| fails(world, second));
    assert_eq!(polygons(app.world(), first), Some(12));
    assert_eq!(app.world().resource::<Heard>().0.len(), 4);

    // It goes with what asked, and with what it was about.
    app.world_mut().entity_mut(first).remove::<ShapeFromMesh>();
    assert!(!fails(app.world(), first));
    let good = add(&mut app, Tetrahedron::default());
    app.world_mut()
        .get_mut::<ShapeFromMesh>(second)
        .unwrap()
        .mesh = Some(good);
    wait(&mut app, |world| polygons(world, second) == Some(4));
    assert!(!fails(app.world(), second));
    app.world_mut().entity_mut(second).despawn();
}

#[test]
fn the_log_says_who_what_and_whether_a_shape_stays() {
    let mut app = app();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let unnamed = meshes.add(bad());
    // As one that was loaded has it.
    let server = app.world().resource::<AssetServer>().clone();
    let path = bevy::asset::AssetPath::from("models/rock.glb").with_source(AssetSourceId::Default);
    let loaded: Handle<Mesh> = server.load(path);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let _ = meshes.insert(loaded.id(), bad());
    let world = app.world_mut();
    let bare = world.spawn(ShapeFromMesh::new(unnamed)).id();
    let rock = (Name::new("rock"), ShapeFromMesh::new(loaded));
    let rock = world.spawn((rock, CollisionShape::sphere(1.0))).id();
    let lines = told(|| {
        wait(&mut app, |world| fails(world, bare) && fails(world, rock));
    });
    let about = |entity: Entity| {
        let name = format!("entity {entity}");
        let mut lines = lines.iter().filter(|line| line.contains(&name));
        let line = lines.next().expect("it is told").clone();
        assert_eq!(lines.next(), None);
        line
    };
    let line = about(bare);
    assert!(line.contains("has no shape of its mesh:"), "{line}");
    let line = about(rock);
    let parts = ["\"rock\"", "\"models/rock.glb\"", "keeps its former shape"];
    assert!(parts.iter().all(|part| line.contains(part)), "{line}");
    assert_eq!(polygons(app.world(), rock), Some(0), "the ball");
}

#[test]
fn that_there_are_no_meshes_is_said_once() {
    let mut app = app_without_meshes();
    assert_eq!(told(|| app.update()), Vec::<String>::new());
    app.world_mut().spawn(ShapeFromMesh::new(Handle::default()));
    let lines = told(|| (0..5).for_each(|_| app.update()));
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("Assets<Mesh>"), "{lines:?}");
}

#[test]
fn what_is_asked_for_may_change() {
    let mut app = app();
    let [cuboid, four] = [
        add(&mut app, Cuboid::default()),
        add(&mut app, Tetrahedron::default()),
    ];
    // A placeholder is replaced.
    let ball = CollisionShape::sphere(1.0);
    let entity = app
        .world_mut()
        .spawn((ShapeFromMesh::new(cuboid.clone()), ball.clone()))
        .id();
    assert_eq!(polygons(app.world(), entity), Some(0));
    wait(&mut app, |world| polygons(world, entity) == Some(12));
    // Another one, by a new component and in place.
    app.world_mut()
        .entity_mut(entity)
        .insert(ShapeFromMesh::new(four));
    wait(&mut app, |world| polygons(world, entity) == Some(4));
    app.world_mut()
        .get_mut::<ShapeFromMesh>(entity)
        .unwrap()
        .mesh = Some(cuboid.clone());
    wait(&mut app, |world| polygons(world, entity) == Some(12));
    let is_convex = |world: &World| {
        let shape = world.get::<CollisionShape>(entity);
        shape.is_some_and(|shape| matches!(shape.0, Shape::Convex(_)))
    };
    app.world_mut()
        .get_mut::<ShapeFromMesh>(entity)
        .unwrap()
        .form = MeshForm::Convex;
    wait(&mut app, is_convex);
    // One of its own, later, stays.
    app.world_mut().entity_mut(entity).insert(ball);
    (0..5).for_each(|_| app.update());
    assert_eq!(polygons(app.world(), entity), Some(0));

    // Who no longer asks, gets none.
    let other = ShapeFromMesh::of(cuboid, MeshForm::SurfaceOnly);
    let [goes, stays] = [(); 2].map(|()| app.world_mut().spawn(other.clone()).id());
    app.update();
    app.world_mut().entity_mut(goes).remove::<ShapeFromMesh>();
    wait(&mut app, |world| polygons(world, stays).is_some());
    assert_eq!(polygons(app.world(), goes), None);
}
