//! A run: a stress scene in a process of its own, for a process has one pool of threads.

use std::process::Command;

use bevy_octree::scene::stress::StressScene;

use crate::outcome::Outcome;

/// Milliseconds by stage, in the order in which the stages run.
pub type StageMs = Vec<(String, f64)>;

/// What is run, and on how many threads.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub scene: StressScene,
    pub objects: usize,
    pub threads: usize,
    pub frames: u32,
    pub seed: u64,
}

/// Runs `study stress`, and reads what it prints of each stage.
pub fn measure(place: Place) -> Outcome<StageMs> {
    let output = Command::new(std::env::current_exe()?)
        .arg("stress")
        .args(["--scene", &place.scene.to_string()])
        .args(["--objects", &place.objects.to_string()])
        .args(["--threads", &place.threads.to_string()])
        .args(["--frames", &place.frames.to_string()])
        .args(["--seed", &place.seed.to_string()])
        .output()?;
    let printed = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`study stress` failed: {}", error.trim()).into());
    }
    let stages = stage_times(&printed);
    if stages.is_empty() {
        return Err(format!("`study stress` names no stage: {}", printed.trim()).into());
    }
    Ok(stages)
}

/// The stages in a line of `study stress`, whatever they are: `name_ms=time`. The frame's own times
/// come before these.
fn stage_times(line: &str) -> StageMs {
    line.split_whitespace()
        .filter_map(|field| {
            let (name, value) = field.split_once('=')?;
            let name = name.strip_suffix("_ms")?;
            let is_frame = matches!(name, "update" | "p99" | "limit");
            (!is_frame).then_some((name.to_owned(), value.parse().ok()?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_read_whatever_they_are() {
        let line = "scene=brownian update_ms=4.2 p99_ms=5 method=auto motion_ms=1.250 new_stage_ms=0.5 largest=motion";
        let expected = [("motion".to_owned(), 1.25), ("new_stage".to_owned(), 0.5)];
        assert_eq!(stage_times(line), expected);
        assert_eq!(stage_times("no stage at all"), []);
    }
}
