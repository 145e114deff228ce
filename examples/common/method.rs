//! Broad phases by name.

use bevy_octree::broad_phase::{Method, UnknownMethod};

/// The method of this name; `object` is the report's N-objects octree.
pub fn method(name: &str) -> Result<Method, UnknownMethod> {
    if name.eq_ignore_ascii_case("object") { "octree".parse() } else { name.parse() }
}
