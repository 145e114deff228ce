//! What `bevy_octree` makes of arbitrary bytes.
//!
//! Each target is a function of bytes, which panics where a promise is broken. It reads them as a
//! file, or takes numbers, shapes and steps from them, and compares what the library answers with
//! what follows without it.
//!
//! `cargo test -p fuzz` puts stored inputs through each, and random ones. `fuzz/run TARGET SECONDS`
//! has libFuzzer look for inputs that reach what none has reached before; it takes a compiler of
//! C++ and no other than stable Rust. A build for it is told by `cfg(fuzzing)`: without that, the
//! programs in `fuzz/targets` put the files through their target that they are given.

#[cfg(fuzzing)]
pub use libfuzzer_sys;

#[path = "../../tests/common/brute_force.rs"]
mod brute_force;
#[expect(dead_code, reason = "tests share it, and ask it for more")]
#[path = "../../tests/common/mod.rs"]
mod common;
mod data;
pub mod meshes;
pub mod operations;
mod oracle;
pub mod scene_files;
pub mod shapes;
pub mod source;
pub mod traces;

/// A target, by its name.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// That of its file, of its folder in `fuzz/corpus`, and of its program.
    pub name: &'static str,
    /// Puts bytes through it.
    pub run: fn(&[u8]),
}

/// All of them.
pub const TARGETS: [Target; 5] = [
    Target {
        name: "meshes",
        run: meshes::run,
    },
    Target {
        name: "operations",
        run: operations::run,
    },
    Target {
        name: "scene_files",
        run: scene_files::run,
    },
    Target {
        name: "shapes",
        run: shapes::run,
    },
    Target {
        name: "traces",
        run: traces::run,
    },
];

/// Puts the files through a target that the program is given.
///
/// # Errors
/// If a file cannot be read.
pub fn replay(run: fn(&[u8])) -> std::io::Result<()> {
    for path in std::env::args_os().skip(1) {
        run(&std::fs::read(&path)?);
        println!("{}: passed", path.display());
    }
    Ok(())
}

/// Writes the program of a target.
#[macro_export]
macro_rules! program {
    ($target:ident) => {
        #[cfg(fuzzing)]
        $crate::libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::$target::run(bytes));

        #[cfg(not(fuzzing))]
        fn main() -> std::io::Result<()> {
            $crate::replay($crate::$target::run)
        }
    };
}
