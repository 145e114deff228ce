//! The mesh that stands for every cuboid.

use std::sync::LazyLock;

use bevy::math::Vec3;

use super::polygon_mesh::PolygonMesh;

/// The sides of a box whose corners are numbered by their bits: x, y, z from the lowest.
pub const SIDES: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

/// The cube from −1 to 1: every cuboid is this, scaled.
pub static CUBE: LazyLock<PolygonMesh> = LazyLock::new(|| {
    let bits = |i: u8| [i & 1, i >> 1 & 1, i >> 2 & 1];
    let corner = |i| Vec3::from(bits(i).map(|bit| f32::from(bit) * 2.0 - 1.0));
    PolygonMesh::new((0..8).map(corner).collect::<Vec<_>>(), SIDES)
        .expect("the faces of a cube are squares")
});
