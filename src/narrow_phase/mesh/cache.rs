//! What is made of a mesh when it is first needed, and then kept.

use std::sync::OnceLock;

/// What a mesh keeps of what has been made of it.
#[derive(Clone, Debug, Default)]
pub struct Cache {
    /// Which way its normals point, if it is closed: 1 outwards, -1 inwards.
    pub outwards: OnceLock<f32>,
}
