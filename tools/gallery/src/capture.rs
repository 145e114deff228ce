//! Pictures without a window: each of a scene at rest between two ticks, so that they are the same
//! on every run.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use bevy::{
    camera::RenderTarget,
    prelude::*,
    render::{
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::WindowRef,
};
use image::RgbImage;
use thiserror::Error;

use crate::{
    animation::{self, AnimationError},
    arguments::Frames,
    play::{Play, TICKS_PER_SECOND},
    progress::Progress,
    scene::Gallery,
};

/// What is drawn.
#[derive(Clone, Debug)]
pub struct Job {
    /// Of which scenes, by name, and after how many ticks.
    pub scenes: Vec<(String, Frames)>,
    /// The width and height of a picture.
    pub size: UVec2,
    /// The folder of the pictures.
    pub out: Option<PathBuf>,
    /// The file of the animation.
    pub gif: Option<PathBuf>,
}

/// What can go wrong with pictures.
#[derive(Debug, Error)]
pub enum CaptureError {
    /// The renderer gave no picture.
    #[error("the renderer gave no picture of tick {0}")]
    NoPicture(u64),
    /// A folder cannot be made.
    #[error("{}: {error}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A picture cannot be written.
    #[error("{}: {error}", path.display())]
    Picture {
        /// Which.
        path: PathBuf,
        /// Why.
        error: image::ImageError,
    },
    /// The animation cannot be written.
    #[error(transparent)]
    Animation(#[from] AnimationError),
}

/// How many frames it takes until everything new is drawn: meshes, materials, pipelines, and what
/// follows from the picture before.
const SETTLING: usize = 3;
/// After so many frames there will be no picture any more.
const PATIENCE: usize = 1000;

/// The picture that was asked for.
#[derive(Resource, Default)]
struct Taken(Option<RgbImage>);

/// Draws what is asked for. The app is as its runner would get it.
///
/// # Errors
///
/// If there is no picture, or it cannot be written.
pub fn run(app: &mut App, job: &Job) -> Result<(), CaptureError> {
    app.init_resource::<Taken>();
    app.finish();
    app.cleanup();
    app.world_mut().resource_mut::<Play>().is_paused = true;
    let target = render_to_image(app.world_mut(), job.size);

    let mut pictures = Vec::new();
    let count = job.scenes.iter().map(|(_, frames)| frames.count());
    let mut progress = Progress::new(count.sum());
    for (scene, frames) in &job.scenes {
        app.world_mut().resource_mut::<Gallery>().show(scene);
        app.update();
        for tick in 0..=frames.last() {
            if tick > 0 {
                app.world_mut().resource_mut::<Play>().pending = 1;
                app.update();
            }
            if !frames.contains(tick) {
                continue;
            }
            progress.begin(format!("{scene} at tick {tick}"));
            let picture = picture(app, &target).ok_or(CaptureError::NoPicture(tick))?;
            if let Some(folder) = &job.out {
                save(&picture, folder, &format!("{scene}_{tick:04}.png"))?;
            }
            if job.gif.is_some() {
                pictures.push(picture);
            }
        }
    }
    drop(progress);
    if let (Some(path), Some((_, frames))) = (&job.gif, job.scenes.first()) {
        make_folder(path.parent())?;
        let speed = app.world().resource::<Play>().speed;
        let ticks_per_second = TICKS_PER_SECOND * speed;
        animation::write(path, &pictures, frames.every as f32 / ticks_per_second)?;
    }
    Ok(())
}

/// Has the cameras draw to an image. They are at rest until there is a picture to be made.
fn render_to_image(world: &mut World, size: UVec2) -> Handle<Image> {
    let format = TextureFormat::Rgba8UnormSrgb;
    let mut image = Image::new_target_texture(size.x, size.y, format, None);
    // A copy is made of it.
    image.texture_descriptor.usage |= bevy::render::render_resource::TextureUsages::COPY_SRC;
    let target = world.resource_mut::<Assets<Image>>().add(image);
    // The camera is there after the startup systems.
    world.insert_resource(DrawTo(target.clone()));
    target
}

/// What cameras draw to, where there is no window.
#[derive(Resource, Clone)]
pub struct DrawTo(Handle<Image>);

/// Turns cameras to the image, if there is one.
pub fn turn_to_image(
    target: Option<Res<DrawTo>>,
    mut cameras: Query<(Entity, &mut Camera), Added<Camera>>,
    mut commands: Commands,
) {
    let Some(target) = target else {
        return;
    };
    for (entity, mut camera) in &mut cameras {
        camera.is_active = false;
        let image = RenderTarget::Image(target.0.clone().into());
        commands.entity(entity).insert(image);
    }
}

fn picture(app: &mut App, target: &Handle<Image>) -> Option<RgbImage> {
    set_active(app.world_mut(), true);
    for _ in 0..SETTLING {
        app.update();
    }
    let screenshot = Screenshot::image(target.clone());
    app.world_mut().spawn(screenshot).observe(
        |captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| {
            let picture = captured.image.clone().try_into_dynamic();
            taken.0 = picture.ok().map(|picture| picture.to_rgb8());
        },
    );
    app.update();
    // The picture is on its way; nothing else is drawn meanwhile.
    set_active(app.world_mut(), false);
    for _ in 0..PATIENCE {
        app.update();
        let taken = app.world_mut().resource_mut::<Taken>().0.take();
        if taken.is_some() {
            return taken;
        }
    }
    None
}

fn set_active(world: &mut World, is_active: bool) {
    let mut cameras = world.query::<&mut Camera>();
    for mut camera in cameras.iter_mut(world) {
        camera.is_active = is_active;
    }
}

fn save(picture: &RgbImage, folder: &Path, name: &str) -> Result<(), CaptureError> {
    make_folder(Some(folder))?;
    let path = folder.join(name);
    picture
        .save(&path)
        .map_err(|error| CaptureError::Picture { path, error })
}

fn make_folder(path: Option<&Path>) -> Result<(), CaptureError> {
    let Some(path) = path.filter(|path| !path.as_os_str().is_empty()) else {
        return Ok(());
    };
    fs::create_dir_all(path).map_err(|error| CaptureError::Folder {
        path: path.to_owned(),
        error,
    })
}

/// A picture of the window, as it is.
pub fn take_screenshot(commands: &mut Commands, path: PathBuf) {
    let window = Screenshot(RenderTarget::Window(WindowRef::Primary));
    let save = bevy::render::view::screenshot::save_to_disk(path);
    commands.spawn(window).observe(save);
}
