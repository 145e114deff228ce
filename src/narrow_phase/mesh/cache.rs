//! What is made of a mesh when it is first needed, and then kept.

#[cfg(feature = "rapier")]
use std::sync::Arc;
use std::sync::OnceLock;

#[cfg(feature = "rapier")]
use bevy_rapier3d::parry::shape::TriMesh;

/// What a mesh keeps of what has been made of it. It is of no size if there is nothing to make.
#[derive(Clone, Debug, Default)]
pub struct Cache {
    /// Which way its normals point, if it is closed: 1 outwards, -1 inwards.
    pub outwards: OnceLock<f32>,
    /// The mesh as parry knows it, made when it first meets a Rapier shape; `None` if parry refuses
    /// it.
    #[cfg(feature = "rapier")]
    pub triangles: OnceLock<Option<Arc<TriMesh>>>,
}
