//! Shows `bevy_octree` at work: `cargo run --release -p gallery` opens a window with its scenes;
//! `cargo run --release -p gallery -- --scene t3 --frames 0..200 --every 5 --out pictures` draws
//! the same without a window, by any driver that Bevy's renderer finds, those that draw by software
//! included.
//!
//! A scene is a file in `scenes`, with a line there.

mod animation;
mod app;
mod arguments;
mod camera;
mod capture;
mod controls;
mod driver;
mod hand;
mod look;
mod panel;
mod play;
#[path = "../../../examples/common/progress.rs"]
mod progress;
mod scene;
mod scenes;
mod settings;
mod solid;

use std::process::ExitCode;

use bevy::app::AppExit;
use clap::Parser as _;

use crate::{arguments::Arguments, scene::Gallery};

/// The exit code where there is nothing to draw with, or the arguments are wrong.
const CANNOT_BEGIN: u8 = 2;

/// What is told where there is no window to be had.
const NO_DISPLAY: &str = "\
there is no X display (DISPLAY is not set): a window takes X, or XWayland.
Pictures take none: --frames, --out, --gif and --all draw without a window";

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut gallery = bevy::app::App::new();
    scenes::plugin(&mut gallery);
    let scenes = gallery.world().resource::<Gallery>().scenes();
    if arguments.list {
        for scene in scenes {
            println!("{:<12} {}", scene.name, scene.title);
        }
        return ExitCode::SUCCESS;
    }
    if let Some(name) = &arguments.scene
        && !scenes.iter().any(|scene| scene.name == *name)
    {
        let names: Vec<_> = scenes.iter().map(|scene| scene.name.as_str()).collect();
        eprintln!(
            "error: there is no scene `{name}`: expected one of {}",
            names.join(", ")
        );
        return CANNOT_BEGIN.into();
    }
    if !driver::is_there() {
        eprintln!("error: {}", driver::MISSING);
        return CANNOT_BEGIN.into();
    }
    if arguments.wants_pictures() {
        let (mut app, job) = app::without_window(&arguments);
        return match capture::run(&mut app, &job) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    // Bevy would panic.
    if cfg!(target_os = "linux") && std::env::var_os("DISPLAY").is_none_or(|name| name.is_empty()) {
        eprintln!("error: {NO_DISPLAY}");
        return CANNOT_BEGIN.into();
    }
    match app::in_window(&arguments).run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}
