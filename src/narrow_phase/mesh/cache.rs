//! What is made of a mesh when it is first needed, and then kept.

use std::sync::OnceLock;

use super::facing::Facing;

/// What a mesh keeps of what has been made of it.
#[derive(Clone, Debug, Default)]
pub struct Cache {
    /// Which side of its polygons is outside.
    pub facing: OnceLock<Facing>,
}
