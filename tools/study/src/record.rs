//! Records a stress scene as a trace file, which `replay` and other programs can read.
//!
//! `cargo run --release -p study -- record --help` explains the arguments.

use std::path::PathBuf;

use bevy_octree::{
    scene::stress::StressSimulation,
    trace::{EXTENSION, TraceWriter},
};
use clap::Args;

use crate::{outcome::Outcome, progress::Progress, which_scene::WhichScene};

/// Records a stress scene as a trace: the boxes of all objects, frame by frame, in Broadmark's
/// .aabbs format.
///
/// Prints one line about the file. The same arguments give the same file on any machine.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    which: WhichScene,
    /// How many frames follow the initial boxes. The file takes 32 bytes for each object and frame.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true)]
    frames: u32,
    /// The file to write; if it exists, it is replaced. By default, the scene's name with the
    /// ending .aabbs.
    #[arg(long)]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let &Arguments {
        which: WhichScene {
            scene,
            objects,
            seed,
        },
        frames,
        ..
    } = arguments;
    let path = arguments
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(scene.name()).with_extension(EXTENSION));
    let mut writer = TraceWriter::create(&path, scene.name(), "box", objects)?;
    let mut simulation = StressSimulation::new(scene, objects, seed);
    let mut progress = Progress::new(u64::from(frames) + 1);
    progress.begin("initial boxes");
    writer.write_frame(simulation.boxes())?;
    for frame in 1..=frames {
        progress.begin(format!("frame {frame}"));
        simulation.step();
        writer.write_frame(simulation.boxes())?;
    }
    drop(progress);
    let bytes = writer.finish()?.metadata()?.len();
    println!(
        "trace={} scene={scene} objects={objects} frames={frames} seed={seed} bytes={bytes}",
        path.display()
    );
    Ok(())
}
