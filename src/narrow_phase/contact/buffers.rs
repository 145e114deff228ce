//! Memory of contacts that outlives a test.

use bevy::math::Vec3A;

use super::{
    facet::WayOut, flush::Flush, hull::Hull, large_hull::Room, patch::Patch, summit::Summits,
};
use crate::narrow_phase::gjk::Polytope;

/// What a polygon says about the contact of its mesh with a solid.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// Where its corners begin and end.
    pub corners: [u32; 2],
    /// Of two meshes, which polygons it is about.
    pub polygons: [u32; 2],
    pub normal: Vec3A,
    pub way: WayOut,
}

/// A polygon in touch with a solid.
#[derive(Clone, Copy, Debug)]
pub struct Touching {
    pub polygon: u32,
    /// Where its corners begin and end.
    pub corners: [u32; 2],
    pub normal: Vec3A,
    /// The least and the greatest components of its corners.
    pub bounds: [Vec3A; 2],
}

/// The memory that contacts write to.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    pub hull: Hull,
    /// That of a solid of many faces.
    pub room: Room,
    /// Polygons that may be in touch, by index.
    pub polygons: Vec<u32>,
    /// Those that are.
    pub touching: Vec<Touching>,
    /// The corners of those that are, in the frame of the solid.
    pub corners: Vec<Vec3A>,
    pub claims: Vec<Claim>,
    /// The claims, by depth.
    pub order: Vec<u32>,
    /// A face of the solid.
    pub face: Vec<Vec3A>,
    pub patch: Patch,
    /// What lies on parts that join.
    pub flush: Flush,
    /// How far two meshes reach.
    pub summits: Summits,
    /// That of two convex shapes whose overlap is sought.
    pub polytope: Polytope,
}
