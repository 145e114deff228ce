//! Shapes of an entity's own mesh, and of all meshes below one: what comes, goes and changes.

use std::time::Duration;

use bevy::{
    asset::AssetPlugin,
    mesh::{Indices, Mesh3d},
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_octree::{mesh_shape::MeshShapeCounts, narrow_phase::Shape, prelude::*};

use crate::common::warnings::{on_this_thread, told};

#[derive(Resource, Default)]
struct Told(Vec<(Entity, [usize; 3])>);

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        OctreePlugins::new(Update),
    ))
    .init_asset::<Mesh>()
    .init_resource::<Told>()
    .add_observer(|ready: On<ShapesReady>, mut told: ResMut<Told>| {
        let MeshShapeCounts {
            shapes,
            errors,
            left_out,
            waiting,
        } = ready.counts;
        assert_eq!(waiting, 0);
        told.0.push((ready.entity, [shapes, errors, left_out]));
    });
    // Who listens to the log hears this thread alone.
    on_this_thread(&mut app, Update);
    app
}

fn add(app: &mut App, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh))
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

/// Waits for what is told next; shapes, errors, left out.
fn ready(app: &mut App) -> (Entity, [usize; 3]) {
    wait(app, |world| !world.resource::<Told>().0.is_empty());
    let told = std::mem::take(&mut app.world_mut().resource_mut::<Told>().0);
    assert_eq!(told.len(), 1, "{told:?}");
    told[0]
}

/// Runs some ticks, in which nothing is told.
fn quiet(app: &mut App) {
    (0..20).for_each(|_| {
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    });
    let told = &app.world().resource::<Told>().0;
    assert!(told.is_empty(), "{told:?}");
}

fn shape(world: &World, entity: Entity) -> Option<&Shape> {
    Some(&world.get::<CollisionShape>(entity)?.0)
}

fn polygons(world: &World, entity: Entity) -> Option<usize> {
    match shape(world, entity)? {
        Shape::Mesh(mesh) => Some(mesh.polygon_count()),
        _ => Some(0),
    }
}

fn has_shape(app: &App, entity: Entity) -> bool {
    shape(app.world(), entity).is_some()
}

#[test]
fn an_entity_has_the_shape_of_its_own_mesh_whichever_it_is() {
    let mut app = app();
    let [cube, four] = [
        add(&mut app, Cuboid::default()),
        add(&mut app, Tetrahedron::default()),
    ];
    // It comes later.
    let own = app.world_mut().spawn(ShapeFromMesh::default()).id();
    let named = ShapeFromMesh::new(cube.0.clone());
    let named = app.world_mut().spawn((named, four.clone())).id();
    wait(&mut app, |world| polygons(world, named) == Some(12));
    assert!(!has_shape(&app, own));
    app.world_mut().entity_mut(own).insert(cube);
    wait(&mut app, |world| polygons(world, own) == Some(12));
    // By a new component, and in place.
    app.world_mut().entity_mut(own).insert(four.clone());
    wait(&mut app, |world| polygons(world, own) == Some(4));
    let tall = add(&mut app, Cuboid::new(1.0, 5.0, 1.0));
    app.world_mut().get_mut::<Mesh3d>(own).unwrap().0 = tall.0;
    app.world_mut().get_mut::<ShapeFromMesh>(own).unwrap().form = MeshForm::Cuboid;
    wait(
        &mut app,
        |world| matches!(shape(world, own), Some(Shape::Cuboid { half_size }) if half_size.y == 2.5),
    );
    // What is not meant changes nothing, be it a shape of the game's own.
    app.world_mut()
        .entity_mut(named)
        .insert(CollisionShape::sphere(1.0));
    app.world_mut().entity_mut(named).insert(four);
    (0..5).for_each(|_| app.update());
    assert_eq!(polygons(app.world(), named), Some(0));
    // It stays when its mesh goes.
    app.world_mut().entity_mut(own).remove::<Mesh3d>();
    (0..5).for_each(|_| app.update());
    assert!(has_shape(&app, own));
}

#[test]
fn the_nearest_rules_count_and_what_is_its_own_master_is_left_alone() {
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let rules = ShapesFromMeshes::new(None).name("wall", MeshForm::Cuboid);
    let root = world.spawn((Name::new("wall"), rules, cube.clone())).id();
    let mut spawn = |parent: Entity, bundle| {
        let mesh = (cube.clone(), ChildOf(parent));
        world.spawn((mesh, bundle)).id()
    };
    let wall = spawn(root, Name::new("wall"));
    let in_wall = spawn(wall, Name::new("brick"));
    let grass = spawn(root, Name::new("grass"));
    let inner = spawn(root, Name::new("wall"));
    let in_inner = spawn(inner, Name::new("wall"));
    let [placed, asking] = [(); 2].map(|()| spawn(root, Name::new("wall")));
    world.entity_mut(inner).insert(ShapesFromMeshes::default());
    world.entity_mut(placed).insert(CollisionShape::sphere(1.0));
    world
        .entity_mut(asking)
        .insert(ShapeFromMesh::own(MeshForm::SurfaceOnly));
    wait(&mut app, |world| world.resource::<Told>().0.len() == 2);
    let mut told = std::mem::take(&mut app.world_mut().resource_mut::<Told>().0);
    told.sort_by_key(|(root, _)| root.index_u32());
    // The name of the root is that of its own mesh alone.
    assert_eq!(told, [(root, [3, 0, 3]), (inner, [2, 0, 0])]);
    let is_box = |entity| matches!(shape(app.world(), entity), Some(Shape::Cuboid { .. }));
    assert!(is_box(root) && is_box(wall) && is_box(in_wall));
    assert!(!has_shape(&app, grass) && !is_box(inner) && !is_box(in_inner));
    assert!(matches!(
        shape(app.world(), placed),
        Some(Shape::Sphere { .. })
    ));
    assert!(!is_box(asking));
}

#[test]
fn who_comes_later_is_found_and_each_time_is_told_once() {
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let root = app.world_mut().spawn(ShapesFromMeshes::default()).id();
    // No mesh, nothing to tell.
    let node = app.world_mut().spawn(ChildOf(root)).id();
    quiet(&mut app);
    assert!(!app.world().get::<ShapesProgress>(root).unwrap().is_ready());
    // A mesh where there was none; one below; all of a hierarchy that was elsewhere.
    app.world_mut().entity_mut(node).insert(cube.clone());
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
    app.world_mut().spawn((cube.clone(), ChildOf(node)));
    assert_eq!(ready(&mut app), (root, [2, 0, 0]));
    let elsewhere = app.world_mut().spawn_empty().id();
    let far_below = (0..3).fold(elsewhere, |parent, _| {
        app.world_mut().spawn((cube.clone(), ChildOf(parent))).id()
    });
    quiet(&mut app);
    assert!(!has_shape(&app, far_below));
    app.world_mut().entity_mut(elsewhere).insert(ChildOf(root));
    assert_eq!(ready(&mut app), (root, [5, 0, 0]));
    assert!(has_shape(&app, far_below));
    assert!(app.world().get::<ShapesProgress>(root).unwrap().is_ready());
    // Gone, and told of when something comes.
    app.world_mut().entity_mut(elsewhere).despawn();
    quiet(&mut app);
    app.world_mut().spawn((cube, ChildOf(root)));
    assert_eq!(ready(&mut app), (root, [3, 0, 0]));
    app.world_mut().entity_mut(root).despawn();
    quiet(&mut app);
}

#[test]
fn one_that_never_loads_is_waited_for_until_it_goes() {
    let mut app = app();
    let [cube, broken] = [add(&mut app, Cuboid::default()), add(&mut app, bad())];
    let nowhere = Mesh3d(app.world().resource::<Assets<Mesh>>().reserve_handle());
    let world = app.world_mut();
    let root = world.spawn((ShapesFromMeshes::default(), cube)).id();
    let fault = (Name::new("fault"), broken, ChildOf(root));
    let fault = world.spawn(fault).id();
    let never = world.spawn((nowhere.clone(), ChildOf(root))).id();
    let lines = told(|| quiet(&mut app));
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("\"fault\"") && lines[0].contains(&format!("entity {fault}")));
    let counts = app.world().get::<ShapesProgress>(root).unwrap().counts();
    let MeshShapeCounts {
        shapes,
        errors,
        left_out,
        waiting,
    } = counts;
    assert_eq!([shapes, errors, left_out, waiting], [1, 1, 0, 1]);
    app.world_mut().entity_mut(never).despawn();
    assert_eq!(ready(&mut app), (root, [1, 1, 0]));
    // Another one of the kind is loaded after all, as somebody else's.
    app.world_mut().spawn((nowhere.clone(), ChildOf(root)));
    quiet(&mut app);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let _ = meshes.insert(nowhere.id(), Tetrahedron::default().into());
    assert_eq!(ready(&mut app), (root, [2, 1, 0]));
}

/// Nobody can know whether a mesh will come; who waits for long is told of, once.
#[test]
fn who_waits_for_long_is_told_of() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs(4)));
    let cube = add(&mut app, Cuboid::default());
    let nowhere = Mesh3d(app.world().resource::<Assets<Mesh>>().reserve_handle());
    let world = app.world_mut();
    let there = world.spawn((cube.clone(), ShapeFromMesh::default())).id();
    let never = world.spawn((Name::new("never"), nowhere, ShapeFromMesh::default()));
    let never = never.id();
    let meshless = world.spawn(ShapeFromMesh::default()).id();
    let lines = told(|| {
        wait(&mut app, |world| shape(world, there).is_some());
        (0..20).for_each(|_| app.update());
    });
    assert_eq!(lines.len(), 2, "{lines:?}");
    for (entity, name) in [(never, "\"never\""), (meshless, "")] {
        let who = format!("entity {entity}");
        let is_told = |line: &String| {
            line.contains(&who) && line.contains(name) && line.contains("waiting for its mesh")
        };
        assert!(lines.iter().any(is_told), "{lines:?}");
    }
    // It comes after all.
    app.world_mut().entity_mut(meshless).insert(cube);
    let lines = told(|| {
        wait(&mut app, |world| shape(world, meshless).is_some());
        (0..20).for_each(|_| app.update());
    });
    assert_eq!(lines, [""; 0]);
}

#[test]
fn other_rules_take_back_what_the_former_gave() {
    #[derive(Component, Clone)]
    struct Wet;
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let rules = ShapesFromMeshes::default().with(StaticShape);
    let pond = MeshRule::new(MeshForm::Cuboid).with((Sensor, Wet));
    let root = world.spawn(rules.clone().name("pond", pond)).id();
    let [pond, rock] = ["pond", "rock"].map(|name| {
        let mesh = (Name::new(name), cube.clone(), ChildOf(root));
        world.spawn(mesh).id()
    });
    assert_eq!(ready(&mut app), (root, [2, 0, 0]));
    let has = |app: &App, entity: Entity| {
        let entity = app.world().entity(entity);
        [
            entity.contains::<Wet>(),
            entity.contains::<Sensor>(),
            entity.contains::<StaticShape>(),
        ]
    };
    assert_eq!(has(&app, pond), [true; 3]);
    assert!(!app.world().entity(rock).contains::<Wet>());

    // In place: the form of the rock is the same, and so is its shape.
    let as_ptr = |app: &App| match shape(app.world(), rock) {
        Some(Shape::Mesh(mesh)) => std::sync::Arc::as_ptr(mesh),
        other => panic!("{other:?}"),
    };
    let before = as_ptr(&app);
    let before_tick = app
        .world()
        .entity(rock)
        .get_ref::<CollisionShape>()
        .unwrap()
        .last_changed();
    *app.world_mut().get_mut::<ShapesFromMeshes>(root).unwrap() =
        rules.clone().name("rock", MeshRule::default().with(Wet));
    // A rule without a form gives nothing.
    assert_eq!(ready(&mut app), (root, [1, 0, 1]));
    assert!(!has_shape(&app, rock) && !app.world().entity(rock).contains::<StaticShape>());
    assert!(!app.world().entity(pond).contains::<Wet>());
    assert!(app.world().entity(pond).contains::<StaticShape>());
    assert_eq!(polygons(app.world(), pond), Some(12));
    app.world_mut().entity_mut(root).insert(rules.clone());
    assert_eq!(ready(&mut app), (root, [2, 0, 0]));
    assert_eq!(as_ptr(&app), before);
    let tick = |app: &App| {
        app.world()
            .entity(rock)
            .get_ref::<CollisionShape>()
            .unwrap()
            .last_changed()
    };
    assert_ne!(tick(&app), before_tick);
    let same = tick(&app);
    app.world_mut().entity_mut(root).insert(rules.with(Wet));
    assert_eq!(ready(&mut app), (root, [2, 0, 0]));
    assert!(app.world().entity(rock).contains::<Wet>());
    assert_eq!(tick(&app), same, "a shape of the same form stays");

    // Without rules, all stays as it is.
    app.world_mut()
        .entity_mut(root)
        .remove::<ShapesFromMeshes>();
    let late = app.world_mut().spawn((cube, ChildOf(root))).id();
    quiet(&mut app);
    assert!(has_shape(&app, rock) && !has_shape(&app, late));
    assert!(app.world().get::<ShapesProgress>(root).is_none());
    app.world_mut()
        .entity_mut(root)
        .insert(ShapesFromMeshes::new(MeshForm::Cuboid));
    assert_eq!(ready(&mut app), (root, [3, 0, 0]));
    assert_eq!(polygons(app.world(), rock), Some(0));
    assert!(!app.world().entity(rock).contains::<Wet>());
}

#[test]
fn meshes_that_move_elsewhere_are_decided_about_anew() {
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let root = world
        .spawn(ShapesFromMeshes::default().name("decoration", None))
        .id();
    let other = world.spawn(ShapesFromMeshes::new(MeshForm::Cuboid)).id();
    let decoration = world.spawn((Name::new("decoration"), ChildOf(root))).id();
    let mesh = world.spawn((cube, ChildOf(root))).id();
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
    app.world_mut().entity_mut(mesh).insert(ChildOf(decoration));
    assert_eq!(ready(&mut app), (root, [0, 0, 1]));
    assert!(!has_shape(&app, mesh));
    app.world_mut().entity_mut(mesh).insert(ChildOf(other));
    assert_eq!(ready(&mut app), (other, [1, 0, 0]));
    assert_eq!(polygons(app.world(), mesh), Some(0));
    app.world_mut().entity_mut(mesh).remove::<ChildOf>();
    quiet(&mut app);
    assert!(has_shape(&app, mesh), "what is taken away keeps its shape");
    // Another mesh where it is.
    app.world_mut().entity_mut(mesh).insert(ChildOf(root));
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
    let four = add(&mut app, Tetrahedron::default());
    app.world_mut().entity_mut(mesh).insert(four);
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
    assert_eq!(polygons(app.world(), mesh), Some(4));
}

#[test]
fn a_clone_has_shapes_of_its_own() {
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let root = world.spawn(ShapesFromMeshes::default()).id();
    let mesh = world.spawn((cube, ChildOf(root))).id();
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
    let copy = app
        .world_mut()
        .entity_mut(root)
        .clone_and_spawn_with_opt_out(|cloner| {
            cloner.linked_cloning(true);
        });
    assert_eq!(ready(&mut app), (copy, [1, 0, 0]));
    let below = app.world().get::<Children>(copy).unwrap()[0];
    assert_ne!(below, mesh);
    app.world_mut()
        .entity_mut(copy)
        .insert(ShapesFromMeshes::new(None));
    assert_eq!(ready(&mut app), (copy, [0, 0, 1]));
    assert!(has_shape(&app, mesh) && !has_shape(&app, below));
}

/// Observers do what they like, and rules go on with who is left.
#[test]
fn observers_may_despawn_what_rules_insert_into() {
    let mut app = app();
    app.add_observer(
        |on: On<Insert, Sensor>, mut commands: Commands, names: Query<&Name>| {
            if names
                .get(on.entity)
                .is_ok_and(|name| name.as_str() == "doomed")
            {
                commands.entity(on.entity).despawn();
            }
        },
    );
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let rules = ShapesFromMeshes::default().with(Sensor).with(StaticShape);
    let root = world.spawn(rules).id();
    for name in ["doomed", "spared", "doomed"] {
        world.spawn((Name::new(name), cube.clone(), ChildOf(root)));
    }
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
}

#[test]
fn a_function_sees_what_is_above_a_mesh() {
    let mut app = app();
    let cube = add(&mut app, Cuboid::default());
    let world = app.world_mut();
    let rules = ShapesFromMeshes::new(None).decide(|mesh| {
        let names: Vec<_> = mesh.names().collect();
        assert_eq!(mesh.material(), None);
        assert_eq!(mesh.path().next().unwrap().id(), mesh.entity().id());
        (names == ["mesh", "node"]).then_some(MeshForm::Cuboid.into())
    });
    let root = world.spawn((Name::new("root"), rules)).id();
    let node = world.spawn((Name::new("node"), ChildOf(root))).id();
    let nameless = world.spawn(ChildOf(node)).id();
    world.spawn((Name::new("mesh"), cube, ChildOf(nameless)));
    assert_eq!(ready(&mut app), (root, [1, 0, 0]));
}
