//! Shapes by the methods of Bevy's remote protocol, as an editor calls them; without a network.
#![cfg(feature = "remote")]

use bevy::{ecs::system::RunSystemOnce, prelude::*};
use bevy_octree::{narrow_phase::Shape, prelude::*};
use bevy_remote::{BrpResult, builtin_methods as methods};
use serde_json::{Value, json};

const DATA: &str = "bevy_octree::ShapeDescription";
const SHAPE: &str = "bevy_octree::CollisionShape";
const ERROR: &str = "bevy_octree::ShapeDescriptionError";

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
    app
}

type Method = fn(In<Option<Value>>, &mut World) -> BrpResult;

fn call(app: &mut App, method: Method, params: Value) -> Result<Value, String> {
    method(In(Some(params)), app.world_mut()).map_err(|error| error.message)
}

fn get(app: &mut App, entity: &Value, component: &str) -> Option<Value> {
    let params = json!({ "entity": entity, "components": [component] });
    let found = app
        .world_mut()
        .run_system_once_with(methods::process_remote_get_components_request, Some(params))
        .unwrap()
        .map_err(|error| error.message)
        .unwrap();
    found["components"].get(component).cloned()
}

#[test]
fn an_editor_spawns_reads_changes_and_mends_a_shape() {
    let mut app = app();
    // As JSON says it.
    let data = json!({ DATA: { "Capsule": { "radius": 0.25, "length": 2.0 } } });
    let spawn = methods::process_remote_spawn_entity_request;
    let spawned = call(&mut app, spawn, json!({ "components": data })).unwrap();
    let entity = spawned["entity"].clone();
    app.update();
    // The shape is read as its data, too.
    let capsule = json!({ "Capsule": { "radius": 0.25, "length": 2.0 } });
    assert_eq!(get(&mut app, &entity, DATA), Some(capsule.clone()));
    assert_eq!(get(&mut app, &entity, SHAPE), Some(capsule));

    // A slider.
    let mutate = methods::process_remote_mutate_components_request;
    let slide = |radius: f32| json!({ "entity": entity, "component": DATA, "path": ".radius", "value": radius });
    call(&mut app, mutate, slide(0.5)).unwrap();
    app.update();
    let mut all = app.world_mut().query::<&CollisionShape>();
    let shape = all.single(app.world()).unwrap();
    assert!(
        matches!(
            shape.0,
            Shape::Capsule {
                radius: 0.5,
                half_length: 1.0
            }
        ),
        "{shape:?}"
    );

    // Another kind, and one that makes none, which the entity says.
    let insert = methods::process_remote_insert_components_request;
    let put = |data: Value| json!({ "entity": entity, "components": { DATA: data } });
    let cells = json!({ "Voxels": { "cell_size": 0.5, "cells": [[0, 0, 0], [1, 0, 0]] } });
    call(&mut app, insert, put(cells)).unwrap();
    app.update();
    assert_eq!(get(&mut app, &entity, ERROR), None);
    call(
        &mut app,
        insert,
        put(json!({ "Sphere": { "radius": -1.0 } })),
    )
    .unwrap();
    app.update();
    let mut all = app
        .world_mut()
        .query::<(&CollisionShape, &ShapeDescriptionError)>();
    let (shape, error) = all.single(app.world()).unwrap();
    assert!(
        matches!(shape.0, Shape::Voxels(_)),
        "it keeps what it had: {shape:?}"
    );
    assert!(error.0.to_string().contains("radius"), "{error:?}");
    call(
        &mut app,
        insert,
        put(json!({ "Sphere": { "radius": 1.0 } })),
    )
    .unwrap();
    app.update();
    let mut all = app
        .world_mut()
        .query_filtered::<&CollisionShape, Without<ShapeDescriptionError>>();
    let shape = all.single(app.world()).unwrap();
    assert!(
        matches!(shape.0, Shape::Sphere { radius: 1.0 }),
        "{shape:?}"
    );

    // What is no shape at all is refused, and nothing happens.
    let nonsense = put(json!({ "Teapot": {} }));
    assert!(call(&mut app, insert, nonsense).is_err());
    app.update();
    assert_eq!(
        get(&mut app, &entity, DATA),
        Some(json!({ "Sphere": { "radius": 1.0 } }))
    );
}
