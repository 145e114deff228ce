//! What a trace says about itself, and where in the file it does.

use bevy::math::bounding::Aabb3d;

/// The name of a trace file ends in this, after a dot.
pub const EXTENSION: &str = "aabbs";

pub(super) const TEXT_BYTES: usize = 128;
pub(super) const COUNTS_OFFSET: usize = 2 * TEXT_BYTES;
pub(super) const WORLD_OFFSET: usize = COUNTS_OFFSET + 16;
pub(super) const HEADER_BYTES: usize = WORLD_OFFSET + BOX_BYTES;
pub(super) const BOX_BYTES: usize = 32;
/// Without objects, there are no more frames than this.
pub(super) const MOST_EMPTY_FRAMES: u32 = 1 << 16;
/// The boxes that are read and written at a time.
pub(super) const BOXES_AT_ONCE: usize = 2048;

/// What a trace file says about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceHeader {
    /// The scene's name.
    pub scene: String,
    /// The type of object.
    pub object_type: String,
    /// How many objects there are, in every box set.
    pub objects: u32,
    /// How many frames follow the initial box set.
    pub frames: u32,
    /// A box around everything, in all frames.
    pub world: Aabb3d,
}

impl TraceHeader {
    /// Returns how many sets of boxes there are: the initial one and one for each frame.
    #[must_use]
    pub const fn box_sets(&self) -> u64 {
        self.frames as u64 + 1
    }

    /// Returns the size of the whole file, in bytes.
    #[must_use]
    pub const fn file_bytes(&self) -> u128 {
        file_bytes(self.objects, self.frames)
    }
}

pub(super) const fn file_bytes(objects: u32, frames: u32) -> u128 {
    HEADER_BYTES as u128 + BOX_BYTES as u128 * objects as u128 * (frames as u128 + 1)
}
