//! Data as JSON, as exporters and remotes write it: through the registry and a type path alone.

use bevy::reflect::{
    PartialReflect,
    serde::{
        ReflectDeserializer, ReflectSerializer, TypedReflectDeserializer, TypedReflectSerializer,
    },
};
use serde::de::DeserializeSeed;
use serde_json::{Value, json};

use super::*;

/// Reads a value as an exporter's loader does, knowing the registry and a type path.
fn read(
    registry: &TypeRegistry,
    path: &str,
    value: &Value,
) -> Result<Box<dyn PartialReflect>, serde_json::Error> {
    let registration = registry.get_with_type_path(path).expect("it is registered");
    TypedReflectDeserializer::new(registration, registry).deserialize(value)
}

fn registry() -> AppTypeRegistry {
    app().world().resource::<AppTypeRegistry>().clone()
}

const PATH: &str = "bevy_octree::ShapeDescription";

/// What Blender's exporters write to `extras` of a node, and a remote to `insert_components`.
#[test]
fn an_entity_gets_its_shape_of_json_and_the_registry() {
    let mut app = app();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let entity = app.world_mut().spawn_empty().id();
    let text = json!({ PATH: { "Sphere": { "radius": 0.5 } } });
    let reflected = ReflectDeserializer::new(&registry.read())
        .deserialize(&text)
        .unwrap();
    let info = reflected.get_represented_type_info().unwrap();
    let known = registry.read();
    let component = known.get(info.type_id()).unwrap();
    component.data::<ReflectComponent>().unwrap().insert(
        &mut app.world_mut().entity_mut(entity),
        &*reflected,
        &known,
    );
    app.update();
    assert_eq!(radius(&app, entity), Some(0.5));

    // And out again, the data and the shape.
    for path in [PATH, "bevy_octree::CollisionShape"] {
        let component = known.get_with_type_path(path).unwrap();
        let component = component.data::<ReflectComponent>().unwrap();
        let reflected = component.reflect(app.world().entity(entity)).unwrap();
        let written = ReflectSerializer::new(reflected.as_partial_reflect(), &known);
        let expected = json!({ path: { "Sphere": { "radius": 0.5 } } });
        assert_eq!(serde_json::to_value(&written).unwrap(), expected);
    }
}

/// What `world.mutate_components` does: the value is read as the type that the registry has for
/// the field at the path.
fn mutate(app: &mut App, entity: Entity, path: &str, value: &Value) {
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let component = registry.get_with_type_path(PATH).unwrap();
    let component = component.data::<ReflectComponent>().unwrap();
    let mut data = component
        .reflect_mut(app.world_mut().entity_mut(entity))
        .unwrap();
    let field = data.reflect_path_mut(path).expect(path);
    let value = read(&registry, field.reflect_type_path(), value).expect(path);
    field.try_apply(&*value).expect(path);
    app.update();
}

#[test]
fn a_remote_changes_any_field_by_its_path() {
    let corners = json!([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    let larger = json!([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]]);
    let ball = json!({ "Sphere": { "radius": 0.5 } });
    let cube = json!({ "Cuboid": { "half_size": [1, 1, 1] } });
    let cone = json!({ "Cone": { "radius": 1, "height": 2 } });
    let solid = json!({ "Tetrahedron": { "vertices": corners } });
    let hull = json!({ "ConvexHull": { "points": corners } });
    let faces = json!([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let mesh = json!({ "Mesh": { "vertices": corners, "polygons": faces } });
    let round = json!({ "Rounded": { "core": cube, "radius": 1 } });
    let compound = json!({ "Compound": { "parts": [{ "shape": cube }] } });
    let field = json!({ "HeightField": {
        "rows": 2, "columns": 2, "heights": [0, 0, 0, 1], "cell_size": [1, 1],
    } });
    let voxels = json!({ "Voxels": { "cell_size": 1, "cells": [[0, 0, 0]] } });
    // The data, and what is put at which path.
    let rows = [
        (&ball, ".radius", json!(2)),
        (&ball, "", cube.clone()),
        (&cube, ".half_size", json!([1, 2, 3])),
        (&cube, ".half_size.y", json!(0.5)),
        (&solid, ".vertices", larger.clone()),
        (&solid, ".vertices[3]", json!([0, 0, 4])),
        (&hull, ".points", larger),
        (&mesh, ".vertices[3]", json!([0, 0, 4])),
        (&mesh, ".surface_only", json!(true)),
        (&round, ".core", cone.clone()),
        (&compound, ".parts", json!([{ "shape": ball }])),
        (
            &compound,
            ".parts[0]",
            json!({ "position": [1, 0, 0], "shape": ball }),
        ),
        (&compound, ".parts[0].position", json!([1, 2, 3])),
        (&compound, ".parts[0].rotation", json!([0.6, 0, 0, 0.8])),
        (&compound, ".parts[0].shape", cone),
        (&compound, ".parts[0].shape.half_size.x", json!(3)),
        (&field, ".heights", json!([1, 2, 3, 4])),
        (&field, ".cell_size", json!([1, 2])),
        (&voxels, ".cells", json!([[5, 0, 0]])),
    ];
    for (before, path, value) in rows {
        let mut app = app();
        let before: ShapeDescription = serde_json::from_value(before.clone()).unwrap();
        let entity = app.world_mut().spawn(before).id();
        app.update();
        let shape = get::<CollisionShape>(&app, entity).clone();
        mutate(&mut app, entity, path, &value);
        assert_eq!(error(&app, entity), None, "{path}: {value}");
        assert_ne!(
            get::<CollisionShape>(&app, entity),
            &shape,
            "{path}: {value}"
        );
        // What is read there is what was written, as far as the form goes.
        let data = get::<ShapeDescription>(&app, entity);
        let known = app.world().resource::<AppTypeRegistry>().read();
        let field = data.reflect_path(path).unwrap();
        let written = serde_json::to_value(TypedReflectSerializer::new(field, &known)).unwrap();
        let again = read(&known, field.reflect_type_path(), &written).unwrap();
        let asked = read(&known, field.reflect_type_path(), &value).unwrap();
        assert_eq!(
            again.reflect_partial_eq(&*asked),
            Some(true),
            "{path}: {written}"
        );
    }
}

/// Bevy's reflection does not shorten lists; what is inserted replaces all.
#[test]
fn a_list_gets_shorter_by_inserting_the_data_anew() {
    let cells = |cells: Value| json!({ "Voxels": { "cell_size": 1, "cells": cells } });
    let mut app = app();
    let two: ShapeDescription =
        serde_json::from_value(cells(json!([[0, 0, 0], [9, 0, 0]]))).unwrap();
    let entity = app.world_mut().spawn(two).id();
    app.update();
    let filled = |app: &App| match get::<ShapeDescription>(app, entity) {
        ShapeDescription::Voxels { cells, .. } => cells.clone(),
        _ => panic!("they are voxels"),
    };
    mutate(&mut app, entity, ".cells", &json!([[5, 0, 0]]));
    assert_eq!(filled(&app), [IVec3::X * 5, IVec3::X * 9]);

    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let component = registry.get_with_type_path(PATH).unwrap();
    let component = component.data::<ReflectComponent>().unwrap();
    let one = read(&registry, PATH, &cells(json!([[5, 0, 0]]))).unwrap();
    component.insert(&mut app.world_mut().entity_mut(entity), &*one, &registry);
    assert_eq!(filled(&app), [IVec3::X * 5]);
}

#[test]
fn a_shape_is_written_and_read_as_its_data() {
    let registry = registry();
    let registry = registry.read();
    let path = "bevy_octree::CollisionShape";
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    for shape in [
        CollisionShape::sphere(2.0),
        CollisionShape::cuboid(1.0, 2.0, 3.0),
        CollisionShape::convex(corners, faces).unwrap(),
        CollisionShape::mesh(corners, faces).unwrap(),
    ] {
        let written = TypedReflectSerializer::new(&shape, &registry);
        let value = serde_json::to_value(&written).unwrap();
        let back = read(&registry, path, &value).unwrap();
        assert_eq!(back.try_downcast_ref::<CollisionShape>(), Some(&shape));
        let plain: CollisionShape = serde_json::from_value(value).unwrap();
        assert_eq!(plain, shape);
    }
    let bad = json!({ "Sphere": { "radius": -1.0 } });
    let error = read(&registry, path, &bad).unwrap_err().to_string();
    assert!(error.contains("must be finite and not negative"), "{error}");
}

#[test]
fn what_may_be_left_out_has_its_default_and_all_else_is_asked_for() {
    let registry = registry();
    let registry = registry.read();
    let whole = json!({ "Compound": { "parts": [{ "shape": { "Sphere": { "radius": 0.5 } } }] } });
    let read_whole = read(&registry, PATH, &whole).unwrap();
    let parts = vec![PartDescription::at(Vec3::ZERO, BALL)];
    assert_eq!(
        read_whole.try_downcast_ref(),
        Some(&ShapeDescription::Compound { parts })
    );
    let nonsense = [
        (json!({ "Sphere": {} }), "missing field `radius`"),
        (
            json!({ "Capsule": { "radius": 1.0 } }),
            "missing field `length`",
        ),
        (
            json!({ "Sphere": { "radius": "big" } }),
            "invalid type: string \"big\"",
        ),
        (
            json!({ "Sphere": { "radius": null } }),
            "invalid type: null",
        ),
        (
            json!({ "Sphere": { "radius": 1, "size": 1 } }),
            "unknown field `size`",
        ),
        (
            json!({ "Torus": { "radius": 1 } }),
            "unknown variant `Torus`",
        ),
        (
            json!({ "Cuboid": { "half_size": [1, 2] } }),
            "invalid length 2",
        ),
        (
            json!({ "Tetrahedron": { "vertices": [[0, 0, 0]] } }),
            "invalid length 1",
        ),
        (json!("Sphere"), "invalid type: unit variant"),
        (
            json!({ "Compound": { "parts": [{ "position": [0, 0, 0] }] } }),
            "missing field `shape`",
        ),
        (
            json!({ "Convex": { "vertices": [], "polygons": [[-1]] } }),
            "invalid value: integer `-1`",
        ),
        (json!([]), "invalid type"),
    ];
    for (value, expected) in nonsense {
        let error = read(&registry, PATH, &value).unwrap_err().to_string();
        assert!(error.contains(expected), "{value}: {error}");
    }
}

/// NaN is `null` in JSON, and no number.
#[test]
fn what_is_not_finite_does_not_come_back() {
    let text = serde_json::to_string(&ShapeDescription::Sphere { radius: f32::NAN }).unwrap();
    assert!(serde_json::from_str::<ShapeDescription>(&text).is_err());
}

/// From text, nothing gets in that is too deep for the stack.
#[test]
fn compounds_that_are_too_deep_are_refused_by_the_reader_or_by_the_component() {
    let nested = |depth: usize| {
        let (open, close) = (r#"{"Compound":{"parts":[{"shape":"#, "}]}}");
        let ball = r#"{"Sphere":{"radius":0.5}}"#;
        format!("{}{ball}{}", open.repeat(depth), close.repeat(depth))
    };
    let data: ShapeDescription = serde_json::from_str(&nested(20)).unwrap();
    let mut app = app();
    let entity = app.world_mut().spawn(data).id();
    app.update();
    assert_eq!(
        error(&app, entity),
        Some(&ShapeError::TooDeep(ShapeDescription::MAX_DEPTH))
    );
    for depth in [100, 100_000] {
        let refused = serde_json::from_str::<ShapeDescription>(&nested(depth));
        assert!(refused.unwrap_err().to_string().contains("recursion limit"));
    }
}

#[cfg(feature = "rapier")]
#[test]
fn a_shape_of_rapiers_without_data_says_so() {
    use bevy_rapier3d::parry::shape::SharedShape;
    let ball = CollisionShape::from(SharedShape::ball(0.5));
    let expected = json!({ "Sphere": { "radius": 0.5 } });
    assert_eq!(serde_json::to_value(&ball).unwrap(), expected);
    let bricks = SharedShape::voxels(Vec3::new(1.0, 2.0, 1.0), &[IVec3::ZERO]);
    let error = serde_json::to_value(CollisionShape::from(bricks)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no data for a shape of Rapier's"),
        "{error}"
    );
}
