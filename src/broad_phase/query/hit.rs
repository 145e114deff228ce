//! What a query finds.

use crate::broad_phase::{boxes::ProxyId, proxy::Proxies};

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
    /// Returns `true` if it is nearer than another, or as near and comes [before](Proxies::order) it.
    pub(crate) fn is_before(&self, other: &Self, proxies: &Proxies) -> bool {
        let is_as_near = self.distance == other.distance;
        self.distance < other.distance
            || (is_as_near && proxies.order(self.proxy) < proxies.order(other.proxy))
    }
}
