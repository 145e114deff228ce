//! Scene files through Bevy's asset system.

use std::{io, str};

use bevy::{
    asset::{AssetApp, AssetLoader, AssetServer, LoadContext, io::Reader},
    prelude::*,
};

use super::{description::SceneDescription, error::SceneError};

/// Teaches Bevy's asset system to load a [`SceneDescription`] from a file named `*.scene.ron`.
///
/// It may come before `AssetPlugin` or after it: if before, it is at work once all plugins are
/// [finished](App::finish). Does nothing in an app without an [`AssetServer`], which can call
/// [`SceneDescription::load`].
///
/// ```
/// use bevy::{asset::AssetPlugin, prelude::*};
/// use bevy_octree::scene::{SceneAssetPlugin, SceneDescription};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, AssetPlugin::default(), SceneAssetPlugin));
/// let scene: Handle<SceneDescription> = app.world().resource::<AssetServer>().load("scenes/t3.scene.ron");
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneAssetPlugin;

impl Plugin for SceneAssetPlugin {
    fn build(&self, app: &mut App) {
        register(app);
    }

    fn finish(&self, app: &mut App) {
        if !register(app) {
            tracing::debug!("no AssetServer: scenes do not load through the asset system");
        }
    }
}

/// Registers the loader, once; false without an asset server.
fn register(app: &mut App) -> bool {
    if !app.world().contains_resource::<AssetServer>() {
        return false;
    }
    if !app.world().contains_resource::<Assets<SceneDescription>>() {
        app.init_asset::<SceneDescription>()
            .register_asset_loader(SceneLoader);
    }
    true
}

/// Loads a [`SceneDescription`] from RON, as [`SceneDescription::load`] does.
#[derive(Clone, Copy, Debug, Default, TypePath)]
#[type_path = "bevy_octree"]
pub struct SceneLoader;

impl AssetLoader for SceneLoader {
    type Asset = SceneDescription;
    type Settings = ();
    type Error = SceneError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<SceneDescription, SceneError> {
        let path = context.path().path();
        let unreadable = |source| SceneError::Read {
            path: path.to_owned(),
            source,
        };
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await.map_err(unreadable)?;
        let text = str::from_utf8(&bytes)
            .map_err(|error| unreadable(io::Error::new(io::ErrorKind::InvalidData, error)))?;
        SceneDescription::parse_from(text, &path.display().to_string())
    }

    fn extensions(&self) -> &[&str] {
        &["scene.ron"]
    }
}

#[cfg(test)]
mod tests;
