use std::time::{Duration, Instant};

use bevy::asset::{AssetPlugin, LoadState};

use super::*;

/// Runs a headless app until an asset is loaded or has failed.
fn load(folder: &str, file: &str) -> (App, Handle<SceneDescription>, LoadState) {
    let mut app = App::new();
    let assets = AssetPlugin {
        file_path: folder.to_owned(),
        ..default()
    };
    app.add_plugins((MinimalPlugins, assets, SceneAssetPlugin));
    load_in(app, file)
}

fn load_in(mut app: App, file: &str) -> (App, Handle<SceneDescription>, LoadState) {
    let server = app.world().resource::<AssetServer>().clone();
    let handle = server.load(file.to_owned());
    let start = Instant::now();
    loop {
        app.update();
        let state = server.load_state(&handle);
        if matches!(state, LoadState::Loaded | LoadState::Failed(_)) {
            return (app, handle, state);
        }
        assert!(
            start.elapsed() < Duration::from_secs(30),
            "{file} never loads"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn scene_files_load_headless() {
    let (app, handle, state) = load("assets", "scenes/t3.scene.ron");
    assert!(state.is_loaded(), "{state:?}");
    let scenes = app.world().resource::<Assets<SceneDescription>>();
    let scene = scenes.get(&handle).unwrap();
    assert_eq!((scene.name.as_str(), scene.object_count()), ("t3", 98));
}

#[test]
fn the_plugins_may_come_before_those_of_assets() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        crate::OctreePlugins::default(),
        AssetPlugin::default(),
    ));
    app.finish();
    let (_, _, state) = load_in(app, "scenes/t3.scene.ron");
    assert!(state.is_loaded(), "{state:?}");
}

#[test]
fn malformed_files_fail_with_the_place() {
    let folder = std::env::temp_dir().join(format!("bevy_octree_asset_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("bad.scene.ron"), "(\n  name: 7,\n)").unwrap();
    let (_, _, state) = load(folder.to_str().unwrap(), "bad.scene.ron");
    std::fs::remove_dir_all(&folder).unwrap();
    let LoadState::Failed(error) = state else {
        panic!("{state:?}");
    };
    let message = error.to_string();
    assert!(
        message.contains("bad.scene.ron:2:9: Expected string"),
        "{message}"
    );
}

#[test]
fn the_plugin_does_nothing_without_an_asset_server() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SceneAssetPlugin)).update();
    assert!(!app.world().contains_resource::<Assets<SceneDescription>>());
}
