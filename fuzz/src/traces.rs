//! Recordings of boxes: read, written, read again, and searched for pairs.

use std::io::{self, Cursor, Read};

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_octree::{
    broad_phase::{BroadPhaseMethod, ObjectOctreeSettings, ProxyId, SpatialIndex},
    trace::{TraceError, TraceHeader, TraceProblem, TraceReader, TraceWriter},
};

use crate::{brute_force, source::Source};

const HEADER: usize = 304;
const BOX: usize = 32;
/// The pairs of more boxes are not looked for.
const MOST_BOXES: usize = 48;
/// No more frames are looked at of recordings without objects.
const MOST_FRAMES: usize = 64;

/// Reads the bytes as a recording; or, by the first one, makes a recording of them.
pub fn run(bytes: &[u8]) {
    let mut source = Source::new(bytes);
    match source.byte() & 1 {
        0 => check(source.rest()),
        _ => check(&recording(&mut source)),
    }
}

/// A recording that is right, but for what numbers there may be in boxes and names.
fn recording(source: &mut Source) -> Vec<u8> {
    let mut name = || -> Vec<u8> {
        let mut name = source.list(20, Source::byte);
        name.resize(128, 0);
        name
    };
    let names = [name(), name()].concat();
    source.may_go_wild();
    let objects = source.below(12);
    let frames = source.below(6);
    let mut file = names;
    for count in [objects as i32, frames as i32, 0, 0] {
        file.extend(count.to_le_bytes());
    }
    let mut put = |source: &mut Source| {
        let (center, half) = (source.vector(), source.sizes());
        for corner in [center - half, center + half] {
            file.extend(
                corner
                    .extend(0.0)
                    .to_array()
                    .map(f32::to_le_bytes)
                    .as_flattened(),
            );
        }
    };
    (0..=objects * (frames + 1)).for_each(|_| put(source));
    if source.byte() & 15 == 1 {
        file.truncate(source.below(file.len()));
    }
    file
}

/// A source that hands out a few bytes at a time, and is interrupted.
struct Slow<'a> {
    bytes: &'a [u8],
    reads: usize,
}

impl Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.reads += 1;
        if self.reads.is_multiple_of(3) {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let few = buffer.len().min(1 + self.reads * 7 % 61);
        self.bytes.read(&mut buffer[..few])
    }
}

type Frames = Vec<Vec<Aabb3d>>;

/// All that can be read, and why there is no more.
fn read(source: impl Read) -> (Option<TraceHeader>, Frames, Option<TraceError>) {
    let mut reader = match TraceReader::new(source, "bytes") {
        Ok(reader) => reader,
        Err(error) => return (None, vec![], Some(error)),
    };
    let header = reader.header().clone();
    let mut frames = vec![];
    let error = loop {
        match reader.next_frame() {
            Ok(Some(boxes)) => frames.push(boxes.to_vec()),
            Ok(None) => break None,
            Err(error) => break Some(error),
        }
    };
    (Some(header), frames, error)
}

fn check(file: &[u8]) {
    let (header, frames, error) = read(file);
    let slow = Slow {
        bytes: file,
        reads: 0,
    };
    let slowly = read(slow);
    assert_eq!(
        (format!("{header:?}"), &frames),
        (format!("{:?}", slowly.0), &slowly.1),
        "read a few bytes at a time"
    );
    assert_eq!(
        error.as_ref().map(ToString::to_string),
        slowly.2.as_ref().map(ToString::to_string),
        "read a few bytes at a time"
    );
    if let Some(error) = &error {
        check_error(file, header.as_ref(), &frames, error);
    }
    let Some(header) = header else {
        return;
    };
    let boxes = header.objects as usize;
    assert!(frames.iter().all(|frame| frame.len() == boxes));
    for (number, frame) in frames.iter().enumerate() {
        for (object, aabb) in frame.iter().enumerate() {
            let start = HEADER + BOX * (number * boxes + object);
            assert_eq!(
                *aabb,
                raw_box(&file[start..]),
                "frame {number}, object {object}"
            );
        }
    }
    if error.is_none() {
        assert_eq!(header.file_bytes(), file.len() as u128);
        assert_eq!(header.box_sets(), frames.len() as u64);
        check_written(&header, &frames);
    }
    if (1..=MOST_BOXES).contains(&boxes) {
        check_pairs(&frames);
    }
}

/// A box as it stands in the file.
fn raw_box(bytes: &[u8]) -> Aabb3d {
    let corner = |first: usize| {
        Vec3A::from([0, 1, 2].map(|axis| {
            let start = 4 * (first + axis);
            f32::from_le_bytes(std::array::from_fn(|byte| bytes[start + byte]))
        }))
    };
    Aabb3d {
        min: corner(0),
        max: corner(4),
    }
}

/// An error is where it says, and is one.
fn check_error(file: &[u8], header: Option<&TraceHeader>, frames: &Frames, error: &TraceError) {
    assert!(!error.to_string().is_empty());
    let offset = usize::try_from(error.offset).expect("within the file");
    assert!(offset <= file.len(), "{error} in {} bytes", file.len());
    let number = |at: usize| i32::from_le_bytes(std::array::from_fn(|byte| file[at + byte]));
    match &error.problem {
        TraceProblem::EndsInHeader => assert!(file.len() < HEADER && offset == file.len()),
        TraceProblem::NotAscii { byte, .. } => {
            assert!(!byte.is_ascii() && file[offset] == *byte);
        }
        TraceProblem::NegativeCount { value, .. } => {
            assert!(*value < 0 && number(offset) == *value);
        }
        TraceProblem::TooManyEmptyFrames(frames) => {
            assert!(number(256) == 0 && number(260) as u32 == *frames);
        }
        TraceProblem::EndsInBoxes { objects, frames } => {
            let whole =
                HEADER as u128 + BOX as u128 * u128::from(*objects) * (u128::from(*frames) + 1);
            assert!(offset == file.len() && (file.len() as u128) < whole);
        }
        TraceProblem::TrailingBytes { .. } => {
            let header = header.expect("it was read");
            assert_eq!(header.file_bytes(), offset as u128);
            assert_eq!(frames.len() as u64, header.box_sets());
        }
        TraceProblem::Box { frame, object, .. } => {
            assert_eq!(*frame, frames.len() as u64);
            let objects = header.expect("it was read").objects as usize;
            assert_eq!(offset, HEADER + BOX * (frames.len() * objects + object));
            let aabb = raw_box(&file[offset..]);
            let is_finite = aabb.min.is_finite() && aabb.max.is_finite();
            assert!(
                !is_finite || aabb.min.cmpgt(aabb.max).any(),
                "{aabb:?} is a box"
            );
        }
        problem => panic!("reading does not write: {problem}"),
    }
}

/// What is written is what was read.
fn check_written(header: &TraceHeader, frames: &Frames) {
    let write = || {
        let mut writer = TraceWriter::new(
            Cursor::new(Vec::new()),
            "written",
            &header.scene,
            &header.object_type,
            header.objects as usize,
        )?;
        for frame in frames {
            writer.write_frame(frame)?;
        }
        writer.finish()
    };
    let written = write()
        .expect("what can be read can be written")
        .into_inner();
    let (again, boxes, error) = read(&written[..]);
    assert!(error.is_none(), "{error:?}");
    let again = again.expect("a header was written");
    let counts = |header: &TraceHeader| (header.objects, header.frames);
    assert_eq!(
        (&again.scene, &again.object_type, counts(&again), &boxes),
        (&header.scene, &header.object_type, counts(header), frames)
    );
    for aabb in boxes.iter().flatten() {
        assert!(again.world.min.cmple(aabb.min).all() && again.world.max.cmpge(aabb.max).all());
    }
}

/// Each broad phase finds the pairs of each frame.
fn check_pairs(frames: &Frames) {
    let methods = [
        BroadPhaseMethod::Auto,
        BroadPhaseMethod::LinearOctree,
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(2)),
        BroadPhaseMethod::Exhaustive,
    ];
    for method in &methods {
        let mut index = SpatialIndex::new(method);
        let mut ids: Vec<ProxyId> = vec![];
        for frame in frames.iter().take(MOST_FRAMES) {
            for (object, aabb) in frame.iter().enumerate() {
                match ids.get(object) {
                    Some(id) => index.set(*id, aabb).expect("it is there"),
                    None => ids.push(index.insert(*aabb).expect("it was checked")),
                }
            }
            index.update();
            let mut found: Vec<[u32; 2]> = index
                .find_pairs()
                .iter()
                .map(|pair| [pair.a.get(), pair.b.get()])
                .collect();
            found.sort_unstable();
            let expected = brute_force::overlapping_pairs(frame);
            if let Err(difference) = brute_force::compare(&found, &expected) {
                panic!("{method:?}: {difference}\n{frame:?}");
            }
        }
    }
}
