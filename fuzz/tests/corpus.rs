//! Inputs that are stored, and random ones, through every target.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use fastrand::Rng;
use fuzz::{TARGETS, Target};

/// So many random inputs for each target,
const RANDOM: usize = 2000;
/// of so many bytes at most, as long as they take no longer than this.
const MOST_BYTES: usize = 600;
const MOST_TIME: Duration = Duration::from_secs(4);

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
        let tried = (0..RANDOM)
            .take_while(|_| started.elapsed() < MOST_TIME)
            .map(|_| {
                let bytes: Vec<u8> = (0..rng.usize(0..MOST_BYTES)).map(|_| rng.u8(..)).collect();
                put(target, &bytes, || format!("{bytes:?}"));
            });
        println!(
            "{}: {} random inputs in {:?}",
            target.name,
            tried.count(),
            started.elapsed()
        );
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
        let tried = (0..RANDOM)
            .take_while(|_| started.elapsed() < MOST_TIME)
            .map(|number| {
                let mut bytes = files[number % files.len()].clone();
                for _ in 0..rng.usize(1..4) {
                    if !bytes.is_empty() {
                        let place = rng.usize(0..bytes.len());
                        bytes[place] = rng.u8(..);
                    }
                }
                put(target, &bytes, || format!("{bytes:?}"));
            });
        println!(
            "{}: {} changed inputs in {:?}",
            target.name,
            tried.count(),
            started.elapsed()
        );
    }
}
