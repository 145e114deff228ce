//! Writing a trace, frame by frame.

use std::{
    fs::File,
    io::{Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    error::{TraceError, TraceProblem},
    header::{
        BOX_BYTES, BOXES_AT_ONCE, COUNTS_OFFSET, HEADER_BYTES, MOST_EMPTY_FRAMES, TEXT_BYTES,
        WORLD_OFFSET,
    },
};
use crate::broad_phase::check_box;

/// Writes a trace frame by frame.
///
/// The number of frames and the world's box are filled in by [`finish`](Self::finish); a trace that
/// was not finished is an error to a reader. See the [module's documentation](super) for an
/// example.
#[derive(Debug)]
pub struct TraceWriter<W> {
    sink: W,
    name: PathBuf,
    objects: u32,
    offset: u64,
    /// How many box sets have been written.
    written: u64,
    world: Aabb3d,
    bytes: Vec<u8>,
}

impl TraceWriter<File> {
    /// Creates a file, or empties it, and writes its header.
    ///
    /// # Errors
    /// As [`new`](Self::new), or if the file cannot be created.
    pub fn create(
        path: impl AsRef<Path>,
        scene: &str,
        object_type: &str,
        objects: usize,
    ) -> Result<Self, TraceError> {
        let path = path.as_ref();
        let file = File::create(path);
        let file = file.map_err(|error| TraceError {
            file: path.to_owned(),
            offset: 0,
            problem: error.into(),
        })?;
        Self::new(file, path, scene, object_type, objects)
    }
}

impl<W: Write + Seek> TraceWriter<W> {
    /// Writes the header of a trace, from the sink's start. The sink need not be buffered. Errors
    /// speak of it as `name`.
    ///
    /// # Errors
    /// If the sink cannot be written to, a text is not ASCII or longer than 128 bytes, or the
    /// number of objects is above [`i32::MAX`].
    pub fn new(
        sink: W,
        name: impl Into<PathBuf>,
        scene: &str,
        object_type: &str,
        objects: usize,
    ) -> Result<Self, TraceError> {
        let world = Aabb3d {
            min: Vec3A::INFINITY,
            max: Vec3A::NEG_INFINITY,
        };
        let bytes = vec![0; HEADER_BYTES];
        let mut writer = Self {
            sink,
            name: name.into(),
            objects: 0,
            offset: 0,
            written: 0,
            world,
            bytes,
        };
        writer.put_text(0, "the scene's name", scene)?;
        writer.put_text(TEXT_BYTES, "the type of object", object_type)?;
        writer.objects = writer.count(COUNTS_OFFSET, "objects", objects as u64)?;
        writer.bytes[COUNTS_OFFSET..][..4].copy_from_slice(&writer.objects.to_le_bytes());
        // Not finished yet: no reader takes this for a trace.
        writer.bytes[COUNTS_OFFSET + 4..][..4].copy_from_slice(&(-1_i32).to_le_bytes());
        writer.flush()?;
        Ok(writer)
    }

    /// Writes the boxes of a frame, the initial box set first.
    ///
    /// # Errors
    /// If there is not one box for each object, if there are more frames than the format takes, if
    /// a box is not finite or is inverted, or if the sink cannot be written to. The first two leave
    /// the trace as it was; after the others it cannot be used.
    pub fn write_frame(&mut self, boxes: &[Aabb3d]) -> Result<(), TraceError> {
        if boxes.len() != self.objects as usize {
            let problem = TraceProblem::WrongBoxCount {
                expected: self.objects,
                found: boxes.len(),
            };
            return Err(self.error(self.offset, problem));
        }
        let frames = self.count(COUNTS_OFFSET + 4, "frames", self.written)?;
        if boxes.is_empty() && frames > MOST_EMPTY_FRAMES {
            return Err(self.error(self.offset, TraceProblem::TooManyEmptyFrames(frames)));
        }
        for (chunk, boxes) in boxes.chunks(BOXES_AT_ONCE).enumerate() {
            for (index, aabb) in boxes.iter().enumerate() {
                if let Err(error) = check_box(aabb) {
                    let object = chunk * BOXES_AT_ONCE + index;
                    let problem = TraceProblem::Box {
                        frame: self.written,
                        object,
                        error,
                    };
                    return Err(self.error(self.offset + self.bytes.len() as u64, problem));
                }
                self.world = Aabb3d {
                    min: self.world.min.min(aabb.min),
                    max: self.world.max.max(aabb.max),
                };
                self.bytes.extend(from_box(aabb));
            }
            self.flush()?;
        }
        self.written += 1;
        Ok(())
    }

    /// Fills in the number of frames and the world's box, and gives the sink back.
    ///
    /// # Errors
    /// If no frame was written, or the sink cannot be written to.
    pub fn finish(mut self) -> Result<W, TraceError> {
        let Some(frames) = self.written.checked_sub(1) else {
            return Err(self.error(self.offset, TraceProblem::NoBoxes));
        };
        let frames = self.count(COUNTS_OFFSET + 4, "frames", frames)?;
        self.patch(COUNTS_OFFSET + 4, &frames.to_le_bytes())?;
        let nothing = Aabb3d {
            min: Vec3A::ZERO,
            max: Vec3A::ZERO,
        };
        let world = if self.objects == 0 {
            nothing
        } else {
            self.world
        };
        self.patch(WORLD_OFFSET, &from_box(&world))?;
        self.io(W::flush)?;
        Ok(self.sink)
    }

    /// Overwrites a part of the header.
    fn patch(&mut self, offset: usize, bytes: &[u8]) -> Result<(), TraceError> {
        self.offset = offset as u64;
        self.bytes.extend_from_slice(bytes);
        self.io(|sink| sink.seek(SeekFrom::Start(offset as u64)).map(|_| ()))?;
        self.flush()
    }

    /// Writes what is in the buffer.
    fn flush(&mut self) -> Result<(), TraceError> {
        let bytes = std::mem::take(&mut self.bytes);
        self.io(|sink| sink.write_all(&bytes))?;
        self.offset += bytes.len() as u64;
        self.bytes = bytes;
        self.bytes.clear();
        Ok(())
    }

    fn io(&mut self, work: impl FnOnce(&mut W) -> std::io::Result<()>) -> Result<(), TraceError> {
        work(&mut self.sink).map_err(|error| self.error(self.offset, error.into()))
    }

    fn put_text(
        &mut self,
        offset: usize,
        field: &'static str,
        text: &str,
    ) -> Result<(), TraceError> {
        if text.len() > TEXT_BYTES {
            return Err(self.error(
                offset as u64,
                TraceProblem::TextTooLong {
                    field,
                    length: text.len(),
                },
            ));
        }
        if let Some((index, byte)) = text.bytes().enumerate().find(|(_, byte)| !byte.is_ascii()) {
            return Err(self.error(
                (offset + index) as u64,
                TraceProblem::NotAscii { field, byte },
            ));
        }
        self.bytes[offset..offset + text.len()].copy_from_slice(text.as_bytes());
        Ok(())
    }

    /// Checks that the format can tell a number.
    fn count(&self, offset: usize, field: &'static str, value: u64) -> Result<u32, TraceError> {
        let count = i32::try_from(value)
            .ok()
            .and_then(|count| u32::try_from(count).ok());
        count.ok_or_else(|| self.error(offset as u64, TraceProblem::CountTooLarge { field, value }))
    }

    fn error(&self, offset: u64, problem: TraceProblem) -> TraceError {
        TraceError {
            file: self.name.clone(),
            offset,
            problem,
        }
    }
}

fn from_box(aabb: &Aabb3d) -> [u8; BOX_BYTES] {
    let mut bytes = [0; BOX_BYTES];
    let numbers = aabb
        .min
        .extend(0.0)
        .to_array()
        .into_iter()
        .chain(aabb.max.extend(0.0).to_array());
    for (four, number) in bytes.as_chunks_mut().0.iter_mut().zip(numbers) {
        *four = number.to_le_bytes();
    }
    bytes
}
