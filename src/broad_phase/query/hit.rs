//! What a query finds.

use crate::broad_phase::boxes::ProxyId;

/// An object that a query found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Which one.
    pub proxy: ProxyId,
    /// How far away it is: along the way of a cast, in a straight line from the point to which it
    /// is near; 0 inside.
    pub distance: f32,
}

impl Hit {
    /// Returns `true` if it is nearer than another, or as near and has the lower handle.
    pub(super) fn is_before(&self, other: &Self) -> bool {
        (self.distance, self.proxy) < (other.distance, other.proxy)
    }
}
