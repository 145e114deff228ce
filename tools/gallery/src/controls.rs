//! Keys.

use std::path::PathBuf;

use bevy::{camera_controller::free_camera::FreeCameraState, prelude::*};

use crate::{
    camera::{self, Eye},
    capture,
    panel::Panel,
    play::Play,
    scene::Gallery,
    settings::Settings,
};

/// The keys, and what each does.
pub const KEYS: &str = "\
Space: pause    .: one tick     R: reset
[ ]: speed      PageUp PageDown: scenes
B: broad phase  L: leaves  N M: their N
O P: objects    H: this panel  F12: picture
C: fly, by WASD QE, right button to look
Drag: turn; right button: move; body: pull";

/// Adds the keys.
pub fn plugin(app: &mut App) {
    app.add_systems(PreUpdate, (press, go_around));
}

/// A scene that is over begins anew.
fn go_around(play: Res<Play>, mut gallery: ResMut<Gallery>) {
    if gallery.scene().ends_at.is_some_and(|end| play.tick >= end) {
        gallery.restart();
    }
}

fn press(
    keys: Res<ButtonInput<KeyCode>>,
    mut play: ResMut<Play>,
    mut gallery: ResMut<Gallery>,
    mut settings: ResMut<Settings>,
    camera: Single<(&mut Eye, &Transform, &mut FreeCameraState)>,
    mut panel: ResMut<Panel>,
    mut commands: Commands,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Space => play.is_paused = !play.is_paused,
            KeyCode::Period => {
                play.is_paused = true;
                play.pending += 1;
            }
            KeyCode::KeyR => gallery.restart(),
            KeyCode::BracketLeft => play.multiply_speed(0.5),
            KeyCode::BracketRight => play.multiply_speed(2.0),
            KeyCode::PageUp => gallery.turn(-1),
            KeyCode::PageDown => gallery.turn(1),
            KeyCode::KeyB => settings.search = settings.search.next(),
            KeyCode::KeyL => settings.leaves = settings.leaves.next(),
            KeyCode::KeyN => settings.max_objects = (settings.max_objects / 2).max(1),
            KeyCode::KeyM => {
                settings.max_objects = settings
                    .max_objects
                    .saturating_mul(2)
                    .min(Settings::MOST_MAX_OBJECTS);
            }
            KeyCode::KeyO | KeyCode::KeyP => {
                let is_more = *key == KeyCode::KeyP;
                if settings.scale_objects(is_more, gallery.scene()) {
                    gallery.restart();
                }
            }
            KeyCode::KeyH => panel.is_hidden = !panel.is_hidden,
            KeyCode::F12 => {
                let name = format!("{}_{:04}.png", gallery.scene().name, play.tick);
                capture::take_screenshot(&mut commands, PathBuf::from(name));
            }
            _ => {}
        }
    }
    if keys.just_pressed(KeyCode::KeyC) {
        let (mut eye, place, mut free) = camera.into_inner();
        camera::toggle_free(&mut eye, place, &mut free);
    }
}
