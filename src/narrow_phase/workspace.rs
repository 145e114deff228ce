//! Memory that outlives a test, so that a test allocates nothing once warm.

use super::StageCounters;
use super::surface::Surface;

/// What the tests write to: counters, and buffers for meshes. One per thread; reuse it.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// How many pairs reached and left each stage since the workspace was made or this was reset.
    pub counters: StageCounters,
    /// The two meshes of a pair, in place.
    pub(super) surfaces: [Surface; 2],
}
