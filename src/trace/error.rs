//! What can be wrong with a trace.

use std::{io, path::PathBuf};

use thiserror::Error;

use super::header::{MOST_EMPTY_FRAMES, file_bytes};
use crate::broad_phase::BoxError;

/// Why a trace cannot be read or written: in which file, where in it, and what was expected.
#[derive(Debug, Error)]
#[error("{}: byte {offset}: {problem}", file.display())]
pub struct TraceError {
    /// The file, by the name given to the reader or writer.
    pub file: PathBuf,
    /// The offset in the file of what the problem is about, in bytes.
    pub offset: u64,
    /// What is wrong there.
    #[source]
    pub problem: TraceProblem,
}

/// What is wrong at some offset of a trace.
#[derive(Debug, Error)]
pub enum TraceProblem {
    /// The file cannot be opened, read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is shorter than any trace.
    #[error("the file ends here, expected a header of 304 bytes")]
    EndsInHeader,
    /// The file is shorter than its header says.
    #[error("the file ends here, expected {}", size(*objects, *frames))]
    EndsInBoxes {
        /// The number of objects.
        objects: u32,
        /// The number of frames after the initial box set.
        frames: u32,
    },
    /// The file is longer than its header says.
    #[error("expected the file to end here, with {}", size(*objects, *frames))]
    TrailingBytes {
        /// The number of objects.
        objects: u32,
        /// The number of frames after the initial box set.
        frames: u32,
    },
    /// A text has a byte that is not ASCII.
    #[error("expected ASCII in {field}, found the byte {byte:#04x}")]
    NotAscii {
        /// Which text.
        field: &'static str,
        /// The first such byte.
        byte: u8,
    },
    /// A text does not fit.
    #[error("expected at most 128 bytes for {field}, found {length}")]
    TextTooLong {
        /// Which text.
        field: &'static str,
        /// Its length in bytes.
        length: usize,
    },
    /// A number of objects or frames is negative.
    #[error("expected the number of {field}, 0 or more, found {value}")]
    NegativeCount {
        /// What is counted.
        field: &'static str,
        /// The number.
        value: i32,
    },
    /// More objects or frames than the format can tell.
    #[error("expected at most {} {field}, found {value}", i32::MAX)]
    CountTooLarge {
        /// What is counted.
        field: &'static str,
        /// The number.
        value: u64,
    },
    /// More frames than are taken from a trace without objects, in which they take no space.
    #[error("expected at most {max} frames of no objects, found {0}", max = MOST_EMPTY_FRAMES)]
    TooManyEmptyFrames(u32),
    /// A box cannot be used.
    #[error("expected a box for object {object} in frame {frame}: {error}")]
    Box {
        /// The frame, 0 for the initial box set.
        frame: u64,
        /// The index of the object.
        object: usize,
        /// What is wrong with its box.
        #[source]
        error: BoxError,
    },
    /// A frame to be written has too many boxes or too few.
    #[error("expected a box for each of {expected} objects, found {found}")]
    WrongBoxCount {
        /// The number of objects.
        expected: u32,
        /// The number of boxes.
        found: usize,
    },
    /// A trace was finished before its initial box set was written.
    #[error("expected the initial box set, found the end of the trace")]
    NoBoxes,
}

fn size(objects: u32, frames: u32) -> String {
    let bytes = file_bytes(objects, frames);
    format!(
        "{bytes} bytes for {objects} objects and {frames} frames: 304 + 32 · {objects} · ({frames} + 1)"
    )
}
