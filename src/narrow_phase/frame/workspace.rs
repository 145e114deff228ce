//! Memory that outlives a test, so that a test allocates nothing once warm.

use super::{memory::Memory, solid::Solid, surface::Surface};
use crate::broad_phase::JoinStack;
use crate::narrow_phase::stage::StageCounters;

/// The memory that the tests write to: counters, and buffers for meshes. One per thread; reuse it.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// How many pairs reached and left each stage since the workspace was made or this was reset.
    pub counters: StageCounters,
    /// The two meshes of a pair, in place.
    pub(in crate::narrow_phase) surfaces: [Surface; 2],
    /// The two convex solids of a pair, in place.
    pub(in crate::narrow_phase) solids: [Solid; 2],
    /// The parts of two trees that are still to be compared.
    pub(in crate::narrow_phase) stack: JoinStack,
    /// What contacts are found with.
    pub(in crate::narrow_phase) contact: Memory,
    /// There was a pair of shapes about which nothing can be said; and somebody has been told.
    unknown: [bool; 2],
}

impl Workspace {
    /// A verdict, if there is one; apart, and a note, if not.
    pub(in crate::narrow_phase) fn known(&mut self, verdict: Option<bool>) -> bool {
        self.unknown[0] |= verdict.is_none();
        verdict == Some(true)
    }

    /// Was there a pair about which nothing can be said, for the first time?
    pub(crate) fn is_first_unknown(&mut self) -> bool {
        let [met, told] = self.unknown;
        self.unknown[1] = met;
        met && !told
    }
}
