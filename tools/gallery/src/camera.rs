//! The camera: around what is looked at, or flying freely; light and sky.

use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraState},
    core_pipeline::tonemapping::Tonemapping,
    input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll},
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    picking::hover::Hovered,
    prelude::*,
};

use crate::{
    hand::Hand,
    panel::Root,
    scene::{Began, Gallery, View},
    settings::Settings,
};

/// The colour behind everything.
const SKY: Color = Color::srgb(0.075, 0.086, 0.11);

/// The camera of the gallery.
#[derive(Component, Clone, Copy, Debug)]
pub struct Eye {
    /// What it goes around, at the start of the scene.
    target: Vec3,
    /// How far that has gone since, where the scene has the camera follow something.
    pub along: Vec3,
    yaw: f32,
    pitch: f32,
    distance: f32,
    /// Whether it flies freely.
    pub is_free: bool,
}

impl From<View> for Eye {
    fn from(view: View) -> Self {
        let offset = view.eye - view.target;
        let distance = offset.length().max(0.1);
        Self {
            target: view.target,
            along: Vec3::ZERO,
            yaw: offset.x.atan2(offset.z),
            pitch: (offset.y / distance).asin(),
            distance,
            is_free: false,
        }
    }
}

impl Eye {
    fn place(&self) -> Transform {
        let turn = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0);
        let target = self.target + self.along;
        Transform::from_translation(target + turn * Vec3::Z * self.distance)
            .looking_at(target, Vec3::Y)
    }
}

/// Spawns the camera and the light.
pub fn spawn(mut commands: Commands) {
    commands.insert_resource(ClearColor(SKY));
    commands.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.85, 0.9, 1.0),
        brightness: 700.0,
        ..default()
    });
    commands.spawn((
        (Camera3d::default(), IsDefaultUiCamera),
        Tonemapping::AcesFitted,
        Projection::from(PerspectiveProjection {
            fov: 40_f32.to_radians(),
            far: 1e6,
            ..default()
        }),
        Eye::from(View {
            eye: Vec3::new(0.0, 0.0, 10.0),
            target: Vec3::ZERO,
        }),
        FreeCamera {
            walk_speed: 8.0,
            run_speed: 30.0,
            keyboard_key_toggle_cursor_grab: KeyCode::Tab,
            ..default()
        },
        at_rest(),
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // From the other side, so that no face is black.
    commands.spawn((
        DirectionalLight {
            illuminance: 2_200.0,
            color: Color::srgb(0.75, 0.85, 1.0),
            ..default()
        },
        Transform::from_xyz(-6.0, 3.0, -4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// A free camera that does not move.
fn at_rest() -> FreeCameraState {
    let mut state = FreeCameraState::default();
    state.enabled = false;
    state
}

/// Another scene is looked at from elsewhere.
pub fn look_at_scene(
    began: On<Began>,
    gallery: Res<Gallery>,
    settings: Res<Settings>,
    mut camera: Single<(&mut Eye, &mut FreeCameraState)>,
    lights: Query<(Entity, &DirectionalLight)>,
    mut commands: Commands,
) {
    let (eye, free) = &mut *camera;
    eye.along = Vec3::ZERO;
    if !began.is_other {
        return;
    }
    **eye = gallery.scene().view_at(settings.objects).into();
    free.enabled = false;
    // Shadows are as sharp as the scene is small.
    let reach = eye.distance * 2.5;
    for (light, kind) in &lights {
        if kind.shadow_maps_enabled {
            let cascades = CascadeShadowConfigBuilder {
                num_cascades: 2,
                first_cascade_far_bound: reach * 0.45,
                maximum_distance: reach,
                ..default()
            };
            commands.entity(light).insert(cascades.build());
        }
    }
}

/// Around with the left button, along with the right one, nearer with the wheel.
pub fn orbit(
    mut camera: Single<(&mut Eye, &mut Transform)>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    hand: Res<Hand>,
    panel: Query<&Hovered, With<Root>>,
    mut is_ours: Local<bool>,
) {
    const RADIANS_PER_DOT: f32 = 0.006;
    let is_over_panel = panel.iter().any(Hovered::get);
    if buttons.any_just_pressed([MouseButton::Left, MouseButton::Right]) {
        *is_ours = !is_over_panel;
    }
    let (eye, place) = &mut *camera;
    if eye.is_free {
        return;
    }
    if !hand.is_busy() && *is_ours {
        let moved = motion.delta;
        if buttons.pressed(MouseButton::Left) {
            eye.yaw -= moved.x * RADIANS_PER_DOT;
            eye.pitch = (eye.pitch + moved.y * RADIANS_PER_DOT).clamp(-1.5, 1.5);
        } else if buttons.pressed(MouseButton::Right) {
            let along = place.rotation * Vec3::new(-moved.x, moved.y, 0.0);
            let step = along * eye.distance * 0.0012;
            eye.target += step;
        }
    }
    if !is_over_panel {
        eye.distance = (eye.distance * (-scroll.delta.y * 0.1).exp()).clamp(0.5, 1e5);
    }
    place.set_if_neq(eye.place());
}

/// Takes the camera in hand, or puts it back on its way around.
pub fn toggle_free(eye: &mut Eye, place: &Transform, free: &mut FreeCameraState) {
    eye.is_free = !eye.is_free;
    free.enabled = eye.is_free;
    if eye.is_free {
        [free.yaw, free.pitch] = [eye.yaw, -eye.pitch];
    } else {
        // It goes around what it looked at last.
        let along = eye.along;
        let from = place.translation - along;
        let target = from + place.forward() * eye.distance;
        *eye = View { eye: from, target }.into();
        eye.along = along;
    }
}
