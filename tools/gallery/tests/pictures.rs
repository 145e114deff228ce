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

use image::{Rgb, RgbImage, imageops::crop_imm};
use image_compare::{Algorithm, rgb_hybrid_compare, rgb_similarity_structure};

/// How alike structure and colours are all in all, 1 for the same. What drivers do to edges, shadows
/// and flat ground leaves this.
const ALIKE: f64 = 0.75;
/// How alike colours are in the least alike of the [`TILE`]s: one small thing more or less is below
/// it, and what drivers do is not.
const ALIKE_IN_A_TILE: f64 = 0.94;
/// The sides of a tile.
const TILE: [u32; 2] = [32, 24];

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

/// How alike two pictures of one size are: all in all, and where they are least so.
fn alike(a: &RgbImage, b: &RgbImage) -> [f64; 2] {
    let [width, height] = TILE;
    let corners = (0..a.height() / height)
        .flat_map(|row| (0..a.width() / width).map(move |column| [column * width, row * height]));
    let tiles = corners.map(|[x, y]| {
        let [a, b] = [a, b].map(|picture| crop_imm(picture, x, y, width, height).to_image());
        let colors = rgb_similarity_structure(&Algorithm::RootMeanSquared, &a, &b);
        colors.expect("their sizes are the same").score
    });
    let whole = rgb_hybrid_compare(a, b).expect("their sizes are the same");
    [whole.score, tiles.fold(1.0, f64::min)]
}

fn are_alike(a: &RgbImage, b: &RgbImage) -> bool {
    let [whole, tile] = alike(a, b);
    whole >= ALIKE && tile >= ALIKE_IN_A_TILE
}

#[test]
fn one_small_thing_more_is_seen() {
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures/t3_0032.png");
    let before = open(&stored);
    assert_eq!(alike(&before, &before), [1.0; 2]);
    let mut now = before.clone();
    // Smaller than one of its cubes.
    for at in 0..80 {
        now.put_pixel(200 + at % 8, 28 + at / 8, Rgb([87, 181, 232]));
    }
    assert!(!are_alike(&now, &before), "{:?}", alike(&now, &before));
    // What a driver may do: a pixel here and there, a little brighter.
    let mut now = before.clone();
    for (at, pixel) in now.pixels_mut().enumerate() {
        if at % 7 == 0 {
            pixel.0 = pixel.0.map(|part| part.saturating_add(3));
        }
    }
    assert!(are_alike(&now, &before), "{:?}", alike(&now, &before));
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
    // By itself a scene looks as it does after others.
    let alone = drawn.join("alone");
    let status = gallery()
        .args(["--scene", "clusters", "--size", "256x144", "--out"])
        .arg(&alone)
        .status();
    assert!(status.expect("the gallery was built").success());
    let [alone, among] = [&alone, &drawn].map(|folder| open(&folder.join("clusters_0064.png")));
    assert!(alone == among, "clusters, alone and after others");

    let mut others = Vec::new();
    for name in &names {
        let [now, before] = [&drawn, &stored].map(|folder| open(&folder.join(name)));
        if !are_alike(&now, &before) {
            others.push(format!("{name}: {:.3?}", alike(&now, &before)));
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
