//! Traces in files.

use std::{fs, path::PathBuf};

use bevy_octree::{
    broad_phase::overlap,
    scene::stress::{StressScene, StressSimulation},
    trace::{EXTENSION, TraceError, TraceHeader, TraceProblem, TraceReader, TraceWriter},
};

#[path = "../common/brute_force.rs"]
mod brute_force;

const OBJECTS: usize = 70;
const FRAMES: usize = 5;

/// A file that goes with the test.
struct TraceFile(PathBuf);

impl TraceFile {
    /// A recorded scene.
    fn record(scene: StressScene, test: &str) -> Self {
        let name = format!("bevy_octree_{test}_{scene}_{}", std::process::id());
        let path = std::env::temp_dir().join(name).with_extension(EXTENSION);
        let file = Self(path);
        let mut simulation = StressSimulation::new(scene, OBJECTS, 4);
        let mut writer = TraceWriter::create(&file.0, scene.name(), "box", OBJECTS).unwrap();
        for _ in 0..=FRAMES {
            writer.write_frame(simulation.boxes()).unwrap();
            simulation.step();
        }
        writer.finish().unwrap();
        file
    }

    fn problem(&self) -> TraceError {
        TraceReader::open(&self.0).unwrap_err()
    }
}

impl Drop for TraceFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

#[test]
fn a_recorded_scene_is_read_back_bit_for_bit() {
    for scene in StressScene::ALL {
        let file = TraceFile::record(scene, "round_trip");
        let mut reader = TraceReader::open(&file.0).unwrap();
        let TraceHeader {
            scene: name,
            objects,
            frames,
            world,
            ..
        } = reader.header().clone();
        assert_eq!(
            (name.as_str(), objects as usize, frames as usize),
            (scene.name(), OBJECTS, FRAMES)
        );
        assert_eq!(fs::metadata(&file.0).unwrap().len(), 304 + 32 * 70 * 6);

        let mut simulation = StressSimulation::new(scene, OBJECTS, 4);
        let mut frames = 0;
        while let Some(boxes) = reader.next_frame().unwrap() {
            assert_eq!(boxes, simulation.boxes(), "{scene}, frame {frames}");
            assert!(
                boxes
                    .iter()
                    .all(|aabb| aabb.min.cmpge(world.min).all() && aabb.max.cmple(world.max).all())
            );
            simulation.step();
            frames += 1;
        }
        assert_eq!(frames, FRAMES + 1);
    }
}

#[test]
fn the_size_of_a_file_is_checked_before_anything_is_replayed() {
    let file = TraceFile::record(StressScene::Brownian, "size");
    let bytes = fs::read(&file.0).unwrap();
    fs::write(&file.0, &bytes[..bytes.len() - 1]).unwrap();
    let error = file.problem();
    assert_eq!(
        (error.offset, &error.file),
        (bytes.len() as u64 - 1, &file.0)
    );
    assert!(
        matches!(error.problem, TraceProblem::EndsInBoxes { .. }),
        "{error}"
    );

    fs::write(&file.0, [&bytes[..], b"more"].concat()).unwrap();
    let error = file.problem();
    assert_eq!(error.offset, bytes.len() as u64);
    assert!(
        matches!(error.problem, TraceProblem::TrailingBytes { .. }),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .contains("expected the file to end here, with 13744 bytes"),
        "{error}"
    );
}

#[test]
fn a_trace_that_was_not_finished_is_none() {
    let file = TraceFile::record(StressScene::Brownian, "unfinished");
    let simulation = StressSimulation::new(StressScene::Brownian, OBJECTS, 4);
    let mut writer = TraceWriter::create(&file.0, "brownian", "box", OBJECTS).unwrap();
    writer.write_frame(simulation.boxes()).unwrap();
    drop(writer);
    let error = file.problem();
    assert!(
        matches!(
            error.problem,
            TraceProblem::NegativeCount {
                field: "frames",
                value: -1
            }
        ),
        "{error}"
    );
}

#[test]
fn a_file_that_cannot_be_opened_is_named() {
    let error = TraceReader::open("no/such/file.aabbs").unwrap_err();
    assert!(matches!(error.problem, TraceProblem::Io(_)));
    assert!(
        error
            .to_string()
            .starts_with("no/such/file.aabbs: byte 0: "),
        "{error}"
    );
}

#[test]
fn the_check_of_a_replay_knows_all_pairs() {
    for scene in StressScene::ALL {
        let mut simulation = StressSimulation::new(scene, 500, 3);
        for _ in 0..4 {
            let boxes = simulation.boxes();
            let others =
                |i: usize| (i + 1..boxes.len()).filter(move |j| overlap(&boxes[i], &boxes[*j]));
            let all: Vec<_> = (0..boxes.len())
                .flat_map(|i| others(i).map(move |j| [i as u32, j as u32]))
                .collect();
            assert_eq!(brute_force::overlapping_pairs(boxes), all, "{scene}");
            (0..16).for_each(|_| simulation.step());
        }
    }
    assert!(brute_force::overlapping_pairs(&[]).is_empty());
}

#[test]
fn the_check_of_a_replay_names_the_first_difference() {
    let [a, b, c] = [[0, 1], [0, 2], [3, 4]];
    let check = |found: &[[u32; 2]]| brute_force::compare(found, &[a, b]);
    assert_eq!(check(&[a, b]), Ok(()));
    for missing in [&[][..], &[b], &[c]] {
        assert_eq!(check(missing).unwrap_err(), "the pair (0, 1) was not found");
    }
    assert_eq!(check(&[a]).unwrap_err(), "the pair (0, 2) was not found");
    assert_eq!(
        check(&[a, b, c]).unwrap_err(),
        "the pair (3, 4) was found, but its boxes do not overlap"
    );
    assert_eq!(
        check(&[a, a, b]).unwrap_err(),
        "the pair (0, 1) was found twice"
    );
}
