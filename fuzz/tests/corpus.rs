//! Inputs that are stored, and random ones, through every target.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::Instant,
};

use fastrand::Rng;
use fuzz::{TARGETS, Target};

/// So many bytes at most has a random input.
const MOST_BYTES: usize = 600;

/// So many random inputs are put through a target: what takes some seconds.
fn inputs(target: &Target) -> usize {
    match target.name {
        "operations" => 100,
        "scene_files" => 400,
        "shapes" => 500,
        _ => 1500,
    }
}

fn stored(target: &Target) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target.name);
    let entries =
        fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Puts bytes through a target, and says which they were if it fails.
fn put(target: &Target, bytes: &[u8], name: impl Fn() -> String) {
    if catch_unwind(AssertUnwindSafe(|| (target.run)(bytes))).is_err() {
        panic!("{}: {}", target.name, name());
    }
}

fn told(target: &Target, which: &str, started: Instant) {
    let (count, time) = (inputs(target), started.elapsed());
    println!("{}: {count} {which} inputs in {time:?}", target.name);
}

#[test]
fn every_stored_input_passes_its_target() {
    for target in &TARGETS {
        let files = stored(target);
        assert!(!files.is_empty(), "{} has no inputs", target.name);
        for file in files {
            put(target, &fs::read(&file).unwrap(), || {
                file.display().to_string()
            });
        }
    }
}

#[test]
fn random_bytes_pass_every_target() {
    for target in &TARGETS {
        let started = Instant::now();
        let mut rng = Rng::with_seed(1994);
        for _ in 0..inputs(target) {
            let bytes: Vec<u8> = (0..rng.usize(0..MOST_BYTES)).map(|_| rng.u8(..)).collect();
            put(target, &bytes, || format!("{bytes:?}"));
        }
        told(target, "random", started);
    }
}

/// Stored inputs with some bytes changed, which reach further than random ones.
#[test]
fn stored_inputs_with_a_few_changes_pass_their_target() {
    for target in &TARGETS {
        let started = Instant::now();
        let mut rng = Rng::with_seed(31);
        let files: Vec<Vec<u8>> = stored(target)
            .iter()
            .map(|file| fs::read(file).unwrap())
            .collect();
        for number in 0..inputs(target) {
            let mut bytes = files[number % files.len()].clone();
            for _ in 0..rng.usize(1..4) {
                if !bytes.is_empty() {
                    let place = rng.usize(0..bytes.len());
                    bytes[place] = rng.u8(..);
                }
            }
            put(target, &bytes, || format!("{bytes:?}"));
        }
        told(target, "changed", started);
    }
}
