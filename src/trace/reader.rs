//! Reading a trace, frame by frame.

use std::{
    fs::File,
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    error::{TraceError, TraceProblem},
    header::{
        BOX_BYTES, BOXES_AT_ONCE, COUNTS_OFFSET, HEADER_BYTES, MOST_EMPTY_FRAMES, TEXT_BYTES,
        TraceHeader, WORLD_OFFSET,
    },
};
use crate::broad_phase::check_box;

/// Reads a trace frame by frame into one buffer: memory is that of a single frame.
///
/// See the [module's documentation](super) for the layout, an example, and what counts as an error.
#[derive(Debug)]
pub struct TraceReader<R> {
    source: R,
    name: PathBuf,
    header: TraceHeader,
    offset: u64,
    /// How many box sets have been read.
    read: u64,
    bytes: Vec<u8>,
    boxes: Vec<Aabb3d>,
}

impl TraceReader<File> {
    /// Opens a file, reads its header, and compares the file's size with what that says.
    ///
    /// # Errors
    /// If the file cannot be read, or its header or size is not that of a trace.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, TraceError> {
        let path = path.as_ref();
        let io = |error: io::Error| TraceError {
            file: path.to_owned(),
            offset: 0,
            problem: error.into(),
        };
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        let reader = Self::new(file, path)?;
        let expected = reader.header.file_bytes();
        // A pipe or a device has no size; its end is noticed when it comes.
        if metadata.is_file() && u128::from(metadata.len()) != expected {
            let TraceHeader {
                objects, frames, ..
            } = reader.header;
            let (offset, problem) = match u64::try_from(expected) {
                Ok(end) if end < metadata.len() => {
                    (end, TraceProblem::TrailingBytes { objects, frames })
                }
                _ => (
                    metadata.len(),
                    TraceProblem::EndsInBoxes { objects, frames },
                ),
            };
            return Err(TraceError {
                file: path.to_owned(),
                offset,
                problem,
            });
        }
        Ok(reader)
    }
}

impl<R: Read> TraceReader<R> {
    /// Reads the header of a trace from anything that can be read. The source need not be buffered.
    /// Errors speak of it as `name`.
    ///
    /// # Errors
    /// If the source cannot be read, or does not begin with the header of a trace.
    pub fn new(source: R, name: impl Into<PathBuf>) -> Result<Self, TraceError> {
        let world = Aabb3d {
            min: Vec3A::ZERO,
            max: Vec3A::ZERO,
        };
        let header = TraceHeader {
            scene: String::new(),
            object_type: String::new(),
            objects: 0,
            frames: 0,
            world,
        };
        let mut reader = Self {
            source,
            name: name.into(),
            header,
            offset: 0,
            read: 0,
            bytes: Vec::new(),
            boxes: Vec::new(),
        };
        let length = reader.fill(HEADER_BYTES)?;
        if length < HEADER_BYTES {
            return Err(reader.error(length as u64, TraceProblem::EndsInHeader));
        }
        reader.header = TraceHeader {
            scene: reader.text(0, "the scene's name")?,
            object_type: reader.text(TEXT_BYTES, "the type of object")?,
            objects: reader.count(COUNTS_OFFSET, "objects")?,
            frames: reader.count(COUNTS_OFFSET + 4, "frames")?,
            world: to_box(&std::array::from_fn(|i| reader.bytes[WORLD_OFFSET + i])),
        };
        let TraceHeader {
            objects, frames, ..
        } = reader.header;
        if objects == 0 && frames > MOST_EMPTY_FRAMES {
            return Err(reader.error(
                COUNTS_OFFSET as u64 + 4,
                TraceProblem::TooManyEmptyFrames(frames),
            ));
        }
        reader.offset = HEADER_BYTES as u64;
        Ok(reader)
    }

    /// Returns what the trace says about itself.
    #[must_use]
    pub const fn header(&self) -> &TraceHeader {
        &self.header
    }

    /// Returns the boxes of the next frame, the initial box set first; `None` after the last.
    ///
    /// # Errors
    /// If the source cannot be read, ends early, goes on after the last frame, or has a box that is
    /// not finite or is inverted. After an error, no further frame can be relied on.
    pub fn next_frame(&mut self) -> Result<Option<&[Aabb3d]>, TraceError> {
        let TraceHeader {
            objects, frames, ..
        } = self.header;
        if self.read == self.header.box_sets() {
            return match self.fill(1)? {
                0 => Ok(None),
                _ => Err(self.error(self.offset, TraceProblem::TrailingBytes { objects, frames })),
            };
        }
        self.boxes.clear();
        // The buffer grows with what is really there: a header may promise anything.
        while self.boxes.len() < objects as usize {
            let wanted = BOX_BYTES * (objects as usize - self.boxes.len()).min(BOXES_AT_ONCE);
            let length = self.fill(wanted)?;
            if length < wanted {
                let end = self.offset + length as u64;
                return Err(self.error(end, TraceProblem::EndsInBoxes { objects, frames }));
            }
            for bytes in self.bytes.as_chunks().0 {
                let aabb = to_box(bytes);
                if let Err(error) = check_box(&aabb) {
                    let problem = TraceProblem::Box {
                        frame: self.read,
                        object: self.boxes.len(),
                        error,
                    };
                    return Err(self.error(self.offset, problem));
                }
                self.boxes.push(aabb);
                self.offset += BOX_BYTES as u64;
            }
        }
        self.read += 1;
        Ok(Some(&self.boxes))
    }

    /// Reads so many bytes, or fewer if the source ends; returns how many.
    fn fill(&mut self, wanted: usize) -> Result<usize, TraceError> {
        self.bytes.resize(wanted, 0);
        let mut length = 0;
        while length < wanted {
            match self.source.read(&mut self.bytes[length..]) {
                Ok(0) => break,
                Ok(more) => length += more,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.error(self.offset + length as u64, error.into())),
            }
        }
        Ok(length)
    }

    fn text(&self, offset: usize, field: &'static str) -> Result<String, TraceError> {
        let text = self.bytes[offset..offset + TEXT_BYTES]
            .split(|byte| *byte == 0)
            .next()
            .unwrap_or_default();
        match text.iter().enumerate().find(|(_, byte)| !byte.is_ascii()) {
            Some((index, &byte)) => Err(self.error(
                (offset + index) as u64,
                TraceProblem::NotAscii { field, byte },
            )),
            None => Ok(text.iter().copied().map(char::from).collect()),
        }
    }

    fn count(&self, offset: usize, field: &'static str) -> Result<u32, TraceError> {
        let value = i32::from_le_bytes(std::array::from_fn(|i| self.bytes[offset + i]));
        u32::try_from(value)
            .map_err(|_| self.error(offset as u64, TraceProblem::NegativeCount { field, value }))
    }

    fn error(&self, offset: u64, problem: TraceProblem) -> TraceError {
        TraceError {
            file: self.name.clone(),
            offset,
            problem,
        }
    }
}

fn to_box(bytes: &[u8; BOX_BYTES]) -> Aabb3d {
    let numbers = bytes.as_chunks().0;
    let corner = |first: usize| {
        Vec3A::from_array(std::array::from_fn(|axis| {
            f32::from_le_bytes(numbers[first + axis])
        }))
    };
    Aabb3d {
        min: corner(0),
        max: corner(4),
    }
}
