//! Levels from glTF files: what an artist exports is collided with.

mod file;
mod stage;

use std::f32::consts::TAU;

use bevy::{
    gltf::GltfExtras, math::Affine3A, mesh::Mesh3d, prelude::*, world_serialization::WorldAssetRoot,
};
use bevy_octree::{
    mesh_shape::MeshShapeCounts,
    narrow_phase::{Shape, ShapeError},
    prelude::*,
};

use file::{File, LINES, Primitive, STRIP, TRIANGLES};
use stage::Stage;

collision_layers! {
    enum Layer { Ground, Water }
}

fn counts(shapes: usize, errors: usize, left_out: usize) -> MeshShapeCounts {
    MeshShapeCounts {
        shapes,
        errors,
        left_out,
        waiting: 0,
    }
}

fn affine(at: Transform) -> Affine3A {
    at.compute_affine()
}

/// Ten groups, turned, scaled and mirrored, of ten nodes each; and where the middle of each node's
/// mesh is.
fn hundred_nodes() -> (File, Vec<(String, Vec3)>) {
    let mut file = File::default();
    let meshes = [
        file.mesh("Crate", &[Primitive::of(Cuboid::new(1.0, 0.5, 0.75))]),
        file.mesh("Ball", &[Primitive::of(Sphere::new(0.5))]),
        file.mesh("Cone", &[Primitive::of(Cone::new(0.5, 1.0))]),
    ];
    let mut middles = vec![];
    for group in 0..10 {
        let turn = TAU * group as f32 / 10.0;
        let mirror = if group % 3 == 0 { -1.0 } else { 1.0 };
        let at = Transform {
            translation: Quat::from_rotation_y(turn) * Vec3::X * 40.0,
            rotation: Quat::from_euler(EulerRot::XYZ, turn, 0.3, -turn),
            scale: Vec3::new(mirror, 1.0, 1.0 + 0.1 * group as f32),
        };
        let parent = file.node(&format!("Group_{group}"), at, None);
        for number in 0..10 {
            let local = Transform {
                translation: Vec3::new(number as f32 * 3.0 - 15.0, 0.2, 0.1),
                rotation: Quat::from_rotation_z(0.4 * number as f32),
                scale: Vec3::new(1.0, 1.0 + 0.05 * number as f32, 1.0),
            };
            let name = format!("Node_{group}_{number}");
            let child = file.node(&name, local, Some(meshes[number % 3]));
            file.adopt(parent, child);
            middles.push((name, (affine(at) * affine(local)).translation.into()));
        }
    }
    (file, middles)
}

#[test]
fn a_scene_of_a_hundred_named_nodes_collides_after_one_line() {
    let (file, middles) = hundred_nodes();
    let mut stage = Stage::new();
    let root = stage.spawn(&file, ShapesFromMeshes::default());
    assert_eq!(stage.ready(root, 1), counts(100, 0, 0));
    // What moves meets each of them, and nothing but these.
    let probes: Vec<Entity> = (middles.iter())
        .map(|(_, middle)| {
            let probe = (
                CollisionShape::sphere(0.1),
                Transform::from_translation(*middle),
            );
            stage
                .app
                .world_mut()
                .spawn((probe, Velocity::default()))
                .id()
        })
        .collect();
    stage.tick(1);
    let meshes = stage.meshes();
    let contacts = stage.app.world().resource::<Contacts>();
    for ((name, _), probe) in middles.iter().zip(&probes) {
        let with: Vec<Entity> = contacts
            .of(*probe)
            .map(|contact| {
                if contact.a == *probe {
                    contact.b
                } else {
                    contact.a
                }
            })
            .collect();
        assert_eq!(with, meshes[name], "{name}");
    }
    // One for each mesh, whatever the number of nodes.
    let shape = |name: &str| {
        let shape = stage
            .app
            .world()
            .get::<CollisionShape>(meshes[name][0])
            .unwrap();
        let Shape::Mesh(mesh) = &shape.0 else {
            panic!("{shape:?}")
        };
        std::sync::Arc::as_ptr(mesh)
    };
    assert_eq!(shape("Node_0_0"), shape("Node_7_3"));
    assert_ne!(shape("Node_0_0"), shape("Node_0_1"));
    // It follows what moves.
    for probe in probes {
        stage.app.world_mut().despawn(probe);
    }
    stage
        .app
        .world_mut()
        .entity_mut(root)
        .insert(Transform::from_xyz(0.0, 100.0, 0.0));
    stage.tick(1);
    assert!(stage.at(middles[50].1).is_empty());
    assert_eq!(
        stage.at(middles[50].1 + Vec3::Y * 100.0),
        [middles[50].0.clone()]
    );
}

#[test]
fn rules_decide_by_names_materials_and_functions() {
    let mut file = File::default();
    let [rock, water] = ["Rock", "Water_deep"].map(|name| file.material(name));
    let cube = Primitive::of(Cuboid::default());
    let rocky = file.mesh("Cube", &[cube.clone().with_material(rock)]);
    let mixed = [
        cube.clone().with_material(rock),
        cube.clone().with_material(water),
    ];
    let mixed = file.mesh("Mixed", &mixed);
    let node = |file: &mut File, name: &str, x: f32, mesh| {
        file.node(name, Transform::from_xyz(x, 0.0, 0.0), mesh)
    };
    node(&mut file, "Floor", 0.0, Some(rocky));
    node(&mut file, "Grass.001", 3.0, Some(rocky));
    node(&mut file, "Shore", 6.0, Some(mixed));
    node(&mut file, "Door_trigger", 9.0, Some(rocky));
    let props = node(&mut file, "Props", 12.0, None);
    let barrel = node(&mut file, "Barrel", 0.0, Some(rocky));
    file.adopt(props, barrel);
    let lamp = node(&mut file, "Lamp", 15.0, Some(rocky));
    file.extras(lamp, serde_json::json!({ "collision": "none" }));

    let mut stage = Stage::new();
    let says_none = |entity: EntityRef| {
        let extras = entity.get::<GltfExtras>();
        extras.is_some_and(|extras| extras.value.contains("\"none\""))
    };
    let root = stage.spawn(
        &file,
        ShapesFromMeshes::default()
            .with((
                StaticShape,
                CollisionLayers::new(Layer::Ground, LayerMask::ALL),
            ))
            .decide(move |mesh| mesh.path().any(says_none).then_some(MeshRule::NONE))
            .name("Grass*", None)
            .name("*_trigger", MeshRule::new(MeshForm::Cuboid).with(Sensor))
            .name("Props", MeshForm::SurfaceOnly)
            .material(
                "Water*",
                MeshRule::new(MeshForm::Cuboid)
                    .with(CollisionLayers::new(Layer::Water, LayerMask::ALL)),
            ),
    );
    assert_eq!(stage.ready(root, 1), counts(5, 0, 2));
    let meshes = stage.meshes();
    let world = stage.app.world();
    let has_shape = |mesh: Entity| world.get::<CollisionShape>(mesh).is_some();
    let is_box = |mesh: Entity| {
        let shape = world.get::<CollisionShape>(mesh);
        shape.is_some_and(|shape| matches!(shape.0, Shape::Cuboid { .. }))
    };
    let is_on = |mesh: Entity, layer: Layer| {
        let layers = world.get::<CollisionLayers>(mesh).unwrap();
        layers.memberships == LayerMask::from(layer)
    };
    assert!(!has_shape(meshes["Grass.001"][0]) && !has_shape(meshes["Lamp"][0]));
    assert!(world.get::<StaticShape>(meshes["Lamp"][0]).is_none());
    let (floor, trigger) = (meshes["Floor"][0], meshes["Door_trigger"][0]);
    assert!(has_shape(floor) && !is_box(floor) && is_on(floor, Layer::Ground));
    assert!(is_box(trigger) && world.get::<Sensor>(trigger).is_some());
    assert!(world.get::<StaticShape>(trigger).is_some() && world.get::<Sensor>(floor).is_none());
    let [rock, water] = *meshes["Shore"] else {
        panic!("of two materials")
    };
    assert!(!is_box(rock) && is_on(rock, Layer::Ground));
    assert!(is_box(water) && is_on(water, Layer::Water));
    let CollisionShape(Shape::Mesh(barrel)) = world.get(meshes["Barrel"][0]).unwrap() else {
        panic!("a mesh")
    };
    assert!(!barrel.has_inside());
}

/// A wedge, which no mirror leaves as it is: all of it is where x, y and z are positive.
const WEDGE: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
const SIDES: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
/// Somewhere in it.
const WITHIN: Vec3 = Vec3::splat(0.1);

fn wedge() -> Primitive {
    Primitive {
        positions: WEDGE.to_vec(),
        indices: Some(SIDES.to_vec()),
        mode: TRIANGLES,
        material: None,
        has_normals: false,
    }
}

#[test]
fn whatever_exporters_write_is_met_or_told_of() {
    let mut file = File::default();
    let whole = file.mesh("Wedge", &[wedge()]);
    let bare = Primitive {
        positions: SIDES.map(|index| WEDGE[usize::from(index)]).to_vec(),
        indices: None,
        ..wedge()
    };
    let bare = file.mesh("No indices", &[bare]);
    let strip = Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.0, 1.0)],
        indices: None,
        mode: STRIP,
        ..wedge()
    };
    let strip = file.mesh("Strip", &[strip]);
    let lines = Primitive {
        indices: None,
        mode: LINES,
        ..wedge()
    };
    let lines = file.mesh("Lines", &[lines]);
    let out_of_range = Primitive {
        indices: Some(vec![0, 1, 99]),
        has_normals: true,
        ..wedge()
    };
    let out_of_range = file.mesh("Out of range", &[out_of_range]);
    let needle = Primitive {
        indices: Some(vec![0, 1, 1]),
        ..wedge()
    };
    let needle = file.mesh("Needle", &[needle]);
    let mut node = |name: &str, x: f32, scale: Vec3, mesh| {
        let at = Transform::from_xyz(x, 0.0, 0.0).with_scale(scale);
        file.node(name, at, Some(mesh))
    };
    node("Plain", 0.0, Vec3::ONE, whole);
    node("Mirrored", 10.0, Vec3::NEG_ONE, whole);
    node("Stretched", 20.0, Vec3::new(4.0, 1.0, -0.5), whole);
    node("Bare", 30.0, Vec3::ONE, bare);
    node("Strip", 40.0, Vec3::ONE, strip);
    node("Lines", 50.0, Vec3::ONE, lines);
    node("Out of range", 60.0, Vec3::ONE, out_of_range);
    node("Needle", 70.0, Vec3::ONE, needle);
    node("Flattened", 80.0, Vec3::new(1.0, 0.0, 1.0), whole);
    // Stretched in its parent's axes, not in its own.
    let parent = node("Skewed", 90.0, Vec3::new(3.0, 1.0, 1.0), whole);
    let turned = Transform::from_rotation(Quat::from_rotation_z(TAU / 8.0));
    let child = file.node(
        "Sheared",
        turned.with_translation(Vec3::Y * 4.0),
        Some(whole),
    );
    file.adopt(parent, child);

    let mut stage = Stage::new();
    let root = stage.spawn(&file, ShapesFromMeshes::default());
    assert_eq!(stage.ready(root, 1), counts(8, 3, 0));
    stage.tick(1);
    let at = |stage: &mut Stage, x: f32, offset: Vec3| stage.at(Vec3::X * x + offset);
    let nobody: [&str; 0] = [];
    assert_eq!(at(&mut stage, 0.0, WITHIN), ["Plain"]);
    assert_eq!(at(&mut stage, 0.0, -WITHIN), nobody);
    assert_eq!(at(&mut stage, 10.0, -WITHIN), ["Mirrored"]);
    assert_eq!(at(&mut stage, 10.0, WITHIN), nobody);
    assert_eq!(
        at(&mut stage, 20.0, WITHIN * Vec3::new(4.0, 1.0, -0.5)),
        ["Stretched"]
    );
    assert_eq!(
        at(&mut stage, 20.0, WITHIN * Vec3::new(4.0, 1.0, 0.5)),
        nobody
    );
    assert_eq!(at(&mut stage, 30.0, WITHIN), ["Bare"]);
    assert_eq!(at(&mut stage, 40.0, Vec3::new(0.7, 0.0, 0.7)), ["Strip"]);
    assert_eq!(
        at(&mut stage, 80.0, WITHIN * Vec3::new(1.0, 0.0, 1.0)),
        ["Flattened"]
    );
    let within = turned.rotation * WITHIN + Vec3::Y * 4.0;
    assert_eq!(
        at(&mut stage, 90.0, within * Vec3::new(3.0, 1.0, 1.0)),
        ["Sheared"]
    );

    let mut error = |node: &str| {
        let mesh = stage.mesh(node);
        let world = stage.app.world();
        assert!(world.get::<CollisionShape>(mesh).is_none());
        world.get::<ShapeFromMeshError>(mesh).unwrap().0.clone()
    };
    assert!(matches!(error("Lines"), ShapeError::Topology(_)));
    assert!(matches!(
        error("Out of range"),
        ShapeError::IndexOutOfRange { .. }
    ));
    assert_eq!(error("Needle"), ShapeError::Empty);
}

#[test]
fn a_file_that_cannot_be_loaded_harms_nobody() {
    let mut stage = Stage::new();
    // The loader refuses it.
    let mut file = File::default();
    let nothing = file.mesh_of_nothing("Nothing");
    file.node("Node", Transform::IDENTITY, Some(nothing));
    let root = stage.spawn(&file, ShapesFromMeshes::default());
    // Not there; and no such mesh in the file.
    let lost = ["lost.gltf#Mesh0/Primitive0", "level.gltf#Mesh0/Primitive0"].map(|path| {
        let mesh = Mesh3d(stage.load(path));
        let lost = (Name::new("lost"), mesh, ChildOf(root));
        stage.app.world_mut().spawn(lost).id()
    });
    assert_eq!(stage.ready(root, 1), counts(0, 2, 0));
    for lost in lost {
        let error = stage.app.world().get::<ShapeFromMeshError>(lost).unwrap();
        assert!(matches!(error.0, ShapeError::NotLoaded(_)), "{error:?}");
    }
}

#[test]
fn scenes_come_again_and_rules_change() {
    let mut file = File::default();
    let cube = file.mesh("Cube", &[Primitive::of(Cuboid::default())]);
    let floor = file.node("Floor", Transform::IDENTITY, Some(cube));
    let box_ = file.node("Box", Transform::from_xyz(3.0, 0.0, 0.0), Some(cube));
    file.adopt(floor, box_);
    let mut stage = Stage::new();
    let root = stage.spawn(&file, ShapesFromMeshes::default());
    assert_eq!(stage.ready(root, 1), counts(2, 0, 0));
    stage.tick(1);
    assert_eq!(stage.at(Vec3::X * 3.0), ["Box"]);

    // The scene goes, and comes again.
    let end_scene = |stage: &mut Stage| {
        let mut root = stage.app.world_mut().entity_mut(root);
        root.remove::<WorldAssetRoot>()
            .despawn_related::<Children>();
    };
    end_scene(&mut stage);
    stage.tick(3);
    assert!(stage.at(Vec3::X * 3.0).is_empty());
    let scene = stage.load("level.gltf#Scene0");
    stage
        .app
        .world_mut()
        .entity_mut(root)
        .insert(WorldAssetRoot(scene));
    assert_eq!(stage.ready(root, 2), counts(2, 0, 0));

    // Fewer shapes by other rules, then nothing for who comes later.
    let rules = ShapesFromMeshes::default().name("Box", None);
    stage.app.world_mut().entity_mut(root).insert(rules);
    assert_eq!(stage.ready(root, 3), counts(1, 0, 1));
    assert!(stage.at(Vec3::X * 3.0).is_empty());
    assert_eq!(stage.at(Vec3::ZERO), ["Floor"]);
    stage
        .app
        .world_mut()
        .entity_mut(root)
        .remove::<ShapesFromMeshes>();
    end_scene(&mut stage);
    stage.tick(3);
    let scene = stage.load("level.gltf#Scene0");
    stage
        .app
        .world_mut()
        .entity_mut(root)
        .insert(WorldAssetRoot(scene));
    stage.wait(|world| world.get::<Children>(root).is_some());
    stage.tick(3);
    assert!(stage.at(Vec3::ZERO).is_empty());
}
