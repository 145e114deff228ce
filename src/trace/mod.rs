//! Trace files: the boxes of all objects, frame by frame, in the `.aabbs` format of Broadmark.
//!
//! Broadmark (Serpa and Rodrigues, *Broadmark: A Testing Framework for Broad-Phase Collision
//! Detection Algorithms*, 2020) records scenes once and replays them through each algorithm. A
//! [`TraceReader`] streams such a file through one buffer, whatever its length; a [`TraceWriter`]
//! writes one.
//!
//! ```
//! use std::io::Cursor;
//! use bevy_octree::{scene::stress::{StressScene, StressSimulation}, trace::{TraceReader, TraceWriter}};
//!
//! let mut simulation = StressSimulation::new(StressScene::Brownian, 100, 1);
//! let mut writer = TraceWriter::new(Cursor::new(Vec::new()), "in memory", "brownian", "cube", 100)?;
//! for _ in 0..3 {
//!     writer.write_frame(simulation.boxes())?;
//!     simulation.step();
//! }
//! let file = writer.finish()?.into_inner();
//! assert_eq!(file.len(), 304 + 32 * 100 * 3);
//!
//! let mut reader = TraceReader::new(&file[..], "in memory")?;
//! assert_eq!((reader.header().objects, reader.header().frames), (100, 2));
//! while let Some(boxes) = reader.next_frame()? {
//!     assert_eq!(boxes.len(), 100);
//! }
//!
//! let cut = TraceReader::new(&file[..300], "in memory").unwrap_err();
//! assert_eq!(cut.to_string(), "in memory: byte 300: the file ends here, expected a header of 304 bytes");
//! # Ok::<(), bevy_octree::trace::TraceError>(())
//! ```
//!
//! # Layout
//!
//! All numbers are little-endian.
//!
//! | offset | type | what |
//! |---|---|---|
//! | 0 | 128 bytes | the scene's name: ASCII, padded with NUL; what follows the first NUL is not read |
//! | 128 | 128 bytes | the type of object, likewise |
//! | 256 | `i32` | N, the number of objects, not negative |
//! | 260 | `i32` | F, the number of frames after the initial box set, not negative |
//! | 264 | 2 × `i32` | zero; not read |
//! | 272 | box | the world's box; not checked, since nothing depends on it |
//! | 304 | N boxes | the initial box set, in the order of the objects |
//! | 304 + 32·N·f | N boxes | frame f, for f from 1 to F |
//!
//! A box is 8 × `f32`: min x, y, z, 0, max x, y, z, 0. The zeros are written and not read. A box
//! that is not finite, or whose minimum lies above its maximum, is an error, in reading as in
//! writing. The file ends with the last box. Without objects, there are at most 65 536 frames: they
//! take no space, and a file must not take longer to read than it is long.

mod error;
mod header;
mod reader;
mod writer;

pub use error::{TraceError, TraceProblem};
pub use header::{EXTENSION, TraceHeader};
pub use reader::TraceReader;
pub use writer::TraceWriter;

#[cfg(test)]
mod tests;
