//! A small picture of each scene looks as it did when it was stored.
//!
//! Where there is nothing to draw with, it says so and does nothing. With the environment variable
//! `UPDATE_PICTURES` set, the pictures are stored anew: look at them before they are committed.

use std::{
    collections::BTreeSet,
    env, fs,
    io::{Write as _, stderr},
    path::{Path, PathBuf},
    process::Command,
};

use image::RgbImage;
use image_compare::rgb_hybrid_compare;

/// 1 for the same; drivers differ in edges and shadows by what this leaves, and a colour, an object
/// or a line more or less is below it.
const ALIKE: f64 = 0.97;

fn gallery() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gallery"));
    // The assets of a program are sought beside its manifest.
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn pictures(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).expect("the folder is there");
    let names = entries.map(|entry| entry.expect("it can be read").file_name());
    names
        .map(|name| name.into_string().expect("names are plain"))
        .filter(|name| name.ends_with(".png"))
        .collect()
}

fn open(path: &Path) -> RgbImage {
    image::open(path).expect("it is a picture").to_rgb8()
}

#[test]
fn scenes_look_as_they_did() {
    let stored = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/pictures");
    let drawn = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    fs::remove_dir_all(&drawn).ok();
    let output = gallery()
        .args(["--all", "--size", "256x144", "--out"])
        .arg(&drawn)
        .output()
        .expect("the gallery was built");
    let words = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(2) && words.contains("mesa-vulkan-drivers") {
        // Past the test's capture, so that it is heard although the test passes.
        _ = writeln!(stderr(), "\nSKIPPED: scenes_look_as_they_did\n{words}");
        return;
    }
    assert!(output.status.success(), "{words}");

    let names = pictures(&drawn);
    if env::var_os("UPDATE_PICTURES").is_some() {
        for old in pictures(&stored) {
            fs::remove_file(stored.join(old)).expect("it can be removed");
        }
        for name in &names {
            fs::copy(drawn.join(name), stored.join(name)).expect("it can be copied");
        }
    }
    assert_eq!(names, pictures(&stored), "drawn and stored");
    let mut others = Vec::new();
    for name in &names {
        let [now, before] = [&drawn, &stored].map(|folder| open(&folder.join(name)));
        let alike = rgb_hybrid_compare(&now, &before).expect("their sizes are the same");
        if alike.score < ALIKE {
            others.push(format!("{name}: {:.3}", alike.score));
        }
    }
    assert!(
        others.is_empty(),
        "these look different from {}; {} has them now: {others:#?}",
        stored.display(),
        drawn.display()
    );
}

#[test]
fn a_driver_that_is_missing_is_named() {
    // Bevy's renderer looks for no backend of that name.
    let output = gallery()
        .args(["--scene", "t0", "--frames", "0", "--size", "32x32"])
        .env("WGPU_BACKEND", "none")
        .output()
        .expect("the gallery was built");
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words}");
    assert!(words.contains("mesa-vulkan-drivers libvulkan1"), "{words}");
}

#[test]
fn wrong_arguments_are_explained() {
    for (arguments, expected) in [
        (&["--scene", "nowhere"][..], "there is no scene `nowhere`"),
        (&["--frames", "9..9"], "there is no tick in 9..9"),
        (&["--size", "big"], "expected one like 1280x720"),
        (&["--every", "0"], "0 is not in"),
    ] {
        let output = gallery().args(arguments).output().expect("it was built");
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(words.contains(expected), "{words}");
    }
}
