//! Shapes appear once they are built, and nobody is left without a word.

use std::time::Duration;

use bevy::{asset::AssetPlugin, mesh::Indices};

use super::*;
use crate::{
    narrow_phase::{PolygonMesh, Shape},
    plugin::OctreePlugins,
};

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        OctreePlugins::new(Update),
    ));
    app.init_asset::<Mesh>();
    app
}

fn add(app: &mut App, mesh: impl Into<Mesh>) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// Updates until something is so, but not for ever.
fn wait(app: &mut App, what: impl Fn(&World) -> bool) {
    for _ in 0..4000 {
        app.update();
        if what(app.world()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("it took too long");
}

fn mesh_of(world: &World, entity: Entity) -> Option<&PolygonMesh> {
    match &world.get::<CollisionShape>(entity)?.0 {
        Shape::Mesh(mesh) => Some(mesh),
        Shape::Convex(mesh) => Some(mesh),
        _ => None,
    }
}

#[test]
fn shapes_appear_by_their_form_and_are_shared() {
    let mut app = app();
    let mesh = add(&mut app, Cuboid::default());
    let mut spawn = |form| {
        let mesh = mesh.clone();
        app.world_mut().spawn(ShapeFromMesh::of(mesh, form)).id()
    };
    let forms = [
        MeshForm::AsItIs,
        MeshForm::AsItIs,
        MeshForm::Solid,
        MeshForm::SurfaceOnly,
        MeshForm::Convex,
    ];
    let entities = forms.map(&mut spawn);
    wait(&mut app, |world| {
        entities.iter().all(|e| mesh_of(world, *e).is_some())
    });
    let world = app.world();
    let inside = entities.map(|entity| mesh_of(world, entity).unwrap().has_inside());
    assert_eq!(inside, [true, true, true, false, true]);
    let shape = |i: usize| &world.get::<CollisionShape>(entities[i]).unwrap().0;
    assert!(
        matches!((shape(0), shape(1)), (Shape::Mesh(a), Shape::Mesh(b)) if std::sync::Arc::ptr_eq(a, b))
    );
    assert!(matches!(shape(4), Shape::Convex(_)));
    // One that asks later has it at once.
    let late = app.world_mut().spawn(ShapeFromMesh::new(mesh)).id();
    app.update();
    assert!(mesh_of(app.world(), late).is_some());
}

#[test]
fn a_mesh_that_changes_is_built_again() {
    let mut app = app();
    let mesh = add(&mut app, Cuboid::default());
    let entity = app.world_mut().spawn(ShapeFromMesh::new(mesh.clone())).id();
    wait(&mut app, |world| mesh_of(world, entity).is_some());
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let _ = meshes.insert(mesh.id(), Tetrahedron::default().into());
    wait(&mut app, |world| {
        mesh_of(world, entity).is_some_and(|mesh| mesh.polygon_count() == 4)
    });
}

#[test]
fn a_mesh_that_loads_late_or_is_bad_does_no_harm() {
    let mut app = app();
    let reserved = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let bad = Mesh::from(Cuboid::default()).with_inserted_indices(Indices::U16(vec![0, 1, 99]));
    let bad = add(&mut app, bad);
    let late = app
        .world_mut()
        .spawn(ShapeFromMesh::new(reserved.clone()))
        .id();
    let never = app.world_mut().spawn(ShapeFromMesh::new(bad)).id();
    for _ in 0..5 {
        app.update();
    }
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let _ = meshes.insert(reserved.id(), Sphere::new(1.0).into());
    wait(&mut app, |world| mesh_of(world, late).is_some());
    assert!(mesh_of(app.world(), never).is_none());
}
