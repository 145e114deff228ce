//! Motion: velocities, position tracks, the clock.
mod track;
pub use track::{Interpolation, Outside, PositionTrack, TrackError};
