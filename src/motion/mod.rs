//! Motion: velocities, position tracks, the clock.
