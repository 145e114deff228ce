use std::io::Cursor;

use super::header::{BOXES_AT_ONCE, MOST_EMPTY_FRAMES};
use super::*;
use crate::broad_phase::BoxError;
use bevy::math::{Vec3A, bounding::Aabb3d};

const NAME: &str = "some.aabbs";

fn cube(x: f32) -> Aabb3d {
    Aabb3d {
        min: Vec3A::new(x, -1.5, 0.0),
        max: Vec3A::new(x + 1.0, 2.0, 1e-3),
    }
}

/// A trace of three frames and the initial box set, of two objects each.
fn trace() -> Vec<u8> {
    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "two", "cube", 2).unwrap();
    for frame in 0..4 {
        writer
            .write_frame(&[cube(frame as f32), cube(-10.0)])
            .unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn read(bytes: &[u8]) -> Result<Vec<Vec<Aabb3d>>, TraceError> {
    let mut reader = TraceReader::new(bytes, NAME)?;
    let mut frames = Vec::new();
    while let Some(boxes) = reader.next_frame()? {
        frames.push(boxes.to_vec());
    }
    Ok(frames)
}

fn patched(offset: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = trace();
    file[offset..offset + bytes.len()].copy_from_slice(bytes);
    file
}

#[test]
fn what_is_written_is_read() {
    let file = trace();
    let header = TraceReader::new(&file[..], NAME).unwrap().header().clone();
    let world = Aabb3d {
        min: Vec3A::new(-10.0, -1.5, 0.0),
        max: Vec3A::new(4.0, 2.0, 1e-3),
    };
    let expected = TraceHeader {
        scene: "two".into(),
        object_type: "cube".into(),
        objects: 2,
        frames: 3,
        world,
    };
    assert_eq!(header, expected);
    assert_eq!(
        (header.box_sets(), header.file_bytes()),
        (4, file.len() as u128)
    );
    let frames = (0..4)
        .map(|frame| vec![cube(frame as f32), cube(-10.0)])
        .collect::<Vec<_>>();
    assert_eq!(read(&file).unwrap(), frames);
}

#[test]
fn the_layout_is_broadmarks() {
    let file = trace();
    assert_eq!(file.len(), 304 + 32 * 2 * 4);
    assert_eq!(
        (&file[..4], &file[128..133]),
        (&b"two\0"[..], &b"cube\0"[..])
    );
    assert_eq!(
        file[256..272],
        [2, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    );
    let numbers: Vec<_> = file[304..336]
        .as_chunks()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes))
        .collect();
    assert_eq!(numbers, [0.0, -1.5, 0.0, 0.0, 1.0, 2.0, 1e-3, 0.0]);
}

#[test]
fn what_is_not_read_may_be_anything() {
    for offset in [10, 264, 268, 304 + 12, 304 + 28] {
        assert_eq!(
            read(&patched(offset, &[0xff; 4])).unwrap(),
            read(&trace()).unwrap()
        );
    }
}

#[test]
fn a_trace_cut_anywhere_is_an_error_that_says_where_it_ends() {
    let file = trace();
    for end in (0..file.len())
        .step_by(7)
        .chain([303, 304, 305, file.len() - 1])
    {
        let error = read(&file[..end]).unwrap_err();
        assert_eq!(
            (error.offset, error.file.to_str()),
            (end as u64, Some(NAME))
        );
        assert_eq!(
            matches!(error.problem, TraceProblem::EndsInHeader),
            end < 304,
            "{error}"
        );
    }
    let error = read(&file[..400]).unwrap_err().to_string();
    let expected = "some.aabbs: byte 400: the file ends here, expected 560 bytes for 2 objects and 3 frames: 304 + 32 · 2 · (3 + 1)";
    assert_eq!(error, expected);
}

#[test]
fn bytes_after_the_end_are_an_error() {
    let mut file = trace();
    file.push(0);
    let error = read(&file).unwrap_err();
    assert_eq!(error.offset, 560);
    assert!(
        matches!(error.problem, TraceProblem::TrailingBytes { .. }),
        "{error}"
    );
}

#[test]
fn counts_are_checked_and_never_believed() {
    let error = read(&patched(256, &(-2_i32).to_le_bytes())).unwrap_err();
    assert_eq!(
        error.to_string(),
        "some.aabbs: byte 256: expected the number of objects, 0 or more, found -2"
    );
    let error = read(&patched(260, &i32::MIN.to_le_bytes())).unwrap_err();
    assert!(
        error.offset == 260
            && matches!(
                error.problem,
                TraceProblem::NegativeCount {
                    field: "frames",
                    ..
                }
            )
    );
    // No memory is taken for boxes that do not come.
    let error = read(&patched(
        256,
        &[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f],
    ))
    .unwrap_err();
    assert!(
        error.offset == 560 && matches!(error.problem, TraceProblem::EndsInBoxes { .. }),
        "{error}"
    );
}

#[test]
fn texts_are_ascii() {
    let error = read(&patched(130, &[0xc3])).unwrap_err().to_string();
    assert_eq!(
        error,
        "some.aabbs: byte 130: expected ASCII in the type of object, found the byte 0xc3"
    );
    let new = |scene: &str| TraceWriter::new(Cursor::new(Vec::new()), NAME, scene, "cube", 2);
    assert!(matches!(
        new("größe").unwrap_err().problem,
        TraceProblem::NotAscii { byte: 0xc3, .. }
    ));
    assert!(matches!(
        new(&"x".repeat(129)).unwrap_err().problem,
        TraceProblem::TextTooLong { length: 129, .. }
    ));
    assert!(new(&"x".repeat(128)).is_ok());
}

#[test]
fn bad_boxes_are_named_by_frame_and_object() {
    // The second object of frame 2.
    let offset = 304 + 32 * 5;
    let error = read(&patched(offset + 20, &f32::NAN.to_le_bytes())).unwrap_err();
    assert_eq!(error.offset, offset as u64);
    let TraceProblem::Box {
        frame: 2,
        object: 1,
        error: BoxError::NotFinite(_),
    } = error.problem
    else {
        panic!("{error}");
    };
    let error = read(&patched(offset, &100.0_f32.to_le_bytes())).unwrap_err();
    assert!(
        matches!(
            error.problem,
            TraceProblem::Box {
                error: BoxError::Inverted(_),
                ..
            }
        ),
        "{error}"
    );

    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", 1).unwrap();
    let error = writer
        .write_frame(&[Aabb3d {
            min: Vec3A::ONE,
            max: Vec3A::ZERO,
        }])
        .unwrap_err();
    assert!(
        error.offset == 304
            && matches!(
                error.problem,
                TraceProblem::Box {
                    frame: 0,
                    object: 0,
                    ..
                }
            ),
        "{error}"
    );
}

#[test]
fn the_writer_takes_whole_frames_and_at_least_one() {
    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", 2).unwrap();
    let error = writer.write_frame(&[cube(0.0)]).unwrap_err();
    assert!(
        matches!(
            error.problem,
            TraceProblem::WrongBoxCount {
                expected: 2,
                found: 1
            }
        ),
        "{error}"
    );
    assert!(matches!(
        writer.finish().unwrap_err().problem,
        TraceProblem::NoBoxes
    ));
    let error = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", 1 << 31).unwrap_err();
    assert!(
        error.offset == 256 && matches!(error.problem, TraceProblem::CountTooLarge { .. }),
        "{error}"
    );
}

#[test]
fn a_trace_of_nothing_has_its_frames() {
    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", 0).unwrap();
    writer.write_frame(&[]).unwrap();
    writer.write_frame(&[]).unwrap();
    let file = writer.finish().unwrap().into_inner();
    assert_eq!(file.len(), 304);
    assert_eq!(read(&file).unwrap(), vec![Vec::new(); 2]);
}

#[test]
fn frames_that_take_no_space_are_few() {
    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", 0).unwrap();
    for _ in 0..=MOST_EMPTY_FRAMES {
        writer.write_frame(&[]).unwrap();
    }
    let error = writer.write_frame(&[]).unwrap_err();
    assert!(
        matches!(error.problem, TraceProblem::TooManyEmptyFrames(65_537)),
        "{error}"
    );
    let mut file = writer.finish().unwrap().into_inner();
    assert_eq!(read(&file).unwrap().len(), 65_537);

    file[260..264].copy_from_slice(&i32::MAX.to_le_bytes());
    let error = TraceReader::new(&file[..], NAME).unwrap_err().to_string();
    assert_eq!(
        error,
        "some.aabbs: byte 260: expected at most 65536 frames of no objects, found 2147483647"
    );
}

#[test]
fn a_frame_may_be_larger_than_the_buffer() {
    let boxes: Vec<_> = (0..2 * BOXES_AT_ONCE + 5).map(|x| cube(x as f32)).collect();
    let mut writer = TraceWriter::new(Cursor::new(Vec::new()), NAME, "", "", boxes.len()).unwrap();
    writer.write_frame(&boxes).unwrap();
    assert_eq!(
        read(&writer.finish().unwrap().into_inner()).unwrap(),
        [boxes]
    );
}
