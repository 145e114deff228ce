use std::f32::consts::TAU;

use super::*;
use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// What is found on all sides of a mesh, and how many polygons were looked at.
fn search(mesh: &PolygonMesh) -> (Vec<Junction>, usize) {
    let mut polygons = Polygons::default();
    mesh.polygons()
        .for_each(|corners| polygons.push(corners).unwrap());
    let mut all = Bits::none(mesh.vertices().len());
    (0..mesh.vertices().len() as u32).for_each(|vertex| all.insert(vertex));
    let search = Junctions {
        vertices: mesh.vertices(),
        polygons: &polygons,
        tree: mesh.tree(),
        slack: 0.0,
    };
    let found = search.search_all(all);
    let most = LEAST_EFFORT + EFFORT * polygons.corners().len();
    (found.junctions, most - found.effort)
}

/// Triangles with vertices of their own.
fn listed(corners: Vec<Vec3>) -> PolygonMesh {
    let triangles = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    PolygonMesh::new(corners, triangles).unwrap()
}

#[test]
fn vertices_at_one_position_are_looked_at_once() {
    let count = 3000_u16;
    let rim = |i: u16| {
        let (sin, cos) = (f32::from(i % count) * TAU / f32::from(count)).sin_cos();
        Vec3::new(cos, sin, 0.3 * sin * sin)
    };
    let fan = (0..count).flat_map(|i| [Vec3::ZERO, rim(i), rim(i + 1)]);
    let (found, looked_at) = search(&listed(fan.collect()));
    assert_eq!(found, []);
    assert!(looked_at < 4 * usize::from(count), "{looked_at}");
}

#[test]
fn crowds_on_one_line_are_bounded() {
    // Sides that lie on one line, over each other, each with a tip of its own.
    let count = 300_u16;
    let triangles = (0..count).flat_map(|i| {
        let at = f32::from(i) / f32::from(count);
        let (sin, cos) = (7.0 * at).sin_cos();
        [Vec3::X * at, Vec3::X * (1.5 + at), Vec3::new(0.5, cos, sin)]
    });
    let (found, _) = search(&listed(triangles.collect()));
    assert!(found.len() <= CROWD * 3 * usize::from(count));
    // Vertices on few sides are found still: the first ends of the first sides.
    let first_ends = found.iter().filter(|junction| junction.vertex % 3 == 0);
    let expected = (1..CROWD).sum::<usize>() + CROWD;
    assert_eq!(first_ends.count(), expected);
}
