//! Motion: velocities, position tracks, the clock.
mod clip;
mod track;
pub use clip::{CollisionReport, Interval, PairContacts, TickOutOfOrder};
pub use track::{Interpolation, Outside, PositionTrack, TrackError};
