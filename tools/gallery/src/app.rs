//! The app, with a window and without.

use bevy::{
    app::PluginGroupBuilder,
    camera_controller::free_camera::FreeCameraPlugin,
    diagnostic::FrameTimeDiagnosticsPlugin,
    log::LogPlugin,
    prelude::*,
    render::{RenderPlugin, pipelined_rendering::PipelinedRenderingPlugin},
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_octree::{
    diagnostics::CollisionDiagnosticsPlugin,
    motion::{MotionSettings, Step},
    prelude::*,
};

use crate::{
    arguments::{Arguments, Frames},
    camera,
    capture::{self, Job},
    controls, hand,
    look::{self, Palette},
    panel,
    play::{self, Play, TICKS_PER_SECOND, Tick},
    scene::{self, Gallery, Scene},
    scenes,
    settings::{self, Settings, Wishes},
    solid::Solids,
};

/// The scene that is shown where none is asked for.
const FIRST: &str = "t3";

/// Returns the app with its window.
pub fn in_window(arguments: &Arguments) -> App {
    let window = Window {
        title: "bevy_octree".to_owned(),
        resolution: arguments.size.0.into(),
        ..default()
    };
    let plugins = plugins().set(WindowPlugin {
        primary_window: Some(window),
        ..default()
    });
    let mut app = App::new();
    app.add_plugins(plugins);
    build(&mut app, arguments, true);
    app.add_plugins(controls::plugin);
    app
}

/// Returns the app without a window, and what it is to draw.
pub fn without_window(arguments: &Arguments) -> (App, Job) {
    let plugins = plugins()
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            // Nothing is left out of a picture because it is not compiled yet.
            synchronous_pipeline_compilation: true,
            ..default()
        })
        .disable::<WinitPlugin>()
        // A picture is of the frame that asked for it.
        .disable::<PipelinedRenderingPlugin>();
    let mut app = App::new();
    app.add_plugins(plugins);
    build(&mut app, arguments, arguments.panel);
    app.add_systems(PreUpdate, capture::turn_to_image);
    let gallery = app.world().resource::<Gallery>();
    let shown = if arguments.all {
        gallery.scenes()
    } else {
        std::slice::from_ref(gallery.scene())
    };
    let frames = |scene: &Scene| Frames {
        range: arguments.frames.unwrap_or_else(|| scene.best_tick.into()),
        every: arguments.every,
    };
    let only_gif = arguments.gif.is_some();
    let default = (!only_gif).then(|| "target/gallery".into());
    let job = Job {
        scenes: shown
            .iter()
            .map(|scene| (scene.name.clone(), frames(scene)))
            .collect(),
        size: arguments.size.0,
        out: arguments.out.clone().or(default),
        gif: arguments.gif.clone(),
    };
    (app, job)
}

fn plugins() -> PluginGroupBuilder {
    DefaultPlugins.set(LogPlugin {
        // That there is software to draw with is no news to who asked for it.
        filter: "warn,bevy_render::renderer=error,wgpu=error,naga=error".to_owned(),
        ..default()
    })
}

/// What there is with a window and without.
fn build(app: &mut App, arguments: &Arguments, has_panel: bool) {
    app.add_plugins((
        OctreePlugins::new(Tick),
        CollisionDebugPlugin,
        CollisionDiagnosticsPlugin,
        CollisionPickingPlugin,
        FrameTimeDiagnosticsPlugin::default(),
        FreeCameraPlugin,
    ))
    .add_plugins((scenes::plugin, hand::plugin))
    .init_schedule(Tick)
    .insert_resource(MotionSettings {
        step: Step::Seconds(1.0 / TICKS_PER_SECOND),
    })
    .insert_resource(Play::at_speed(arguments.speed))
    .insert_resource(Settings::from(Wishes {
        objects: arguments.objects,
        max_objects: arguments.max_objects,
        search: arguments.search,
        leaves: arguments.leaves,
    }))
    .init_resource::<Solids>()
    .init_resource::<Palette>()
    .add_observer(camera::look_at_scene)
    .add_observer(look::forget_solids)
    .add_systems(Startup, (camera::spawn, settings::draw_leaves_alone))
    .add_systems(
        Update,
        (
            scene::load,
            settings::apply.run_if(resource_changed::<Settings>),
            play::run_ticks,
            camera::orbit,
            look::dress,
        )
            .chain(),
    )
    .add_systems(
        PostUpdate,
        look::paint
            .run_if(play::ticked.or_eager(resource_changed::<Gallery>))
            .after(TransformSystems::Propagate),
    );
    if has_panel {
        app.add_plugins(panel::plugin);
    }
    let mut gallery = app.world_mut().resource_mut::<Gallery>();
    gallery.show(arguments.scene.as_deref().unwrap_or(FIRST));
}
