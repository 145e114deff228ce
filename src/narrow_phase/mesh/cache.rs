//! What is made of a mesh when it is first needed, and then kept.

use std::sync::OnceLock;

/// What a mesh keeps of what has been made of it.
#[derive(Clone, Debug, Default)]
pub struct Cache {
    /// Which side of its polygons is outside.
    pub facing: OnceLock<Facing>,
}

/// Which way the normals of a mesh point, where they are those of solids.
#[derive(Clone, Debug)]
pub enum Facing {
    /// All outwards, or all inwards.
    Outwards(bool),
    /// By polygon: whether it is outwards.
    Each(Box<[bool]>),
}
