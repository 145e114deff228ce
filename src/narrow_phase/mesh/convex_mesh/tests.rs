//! What is accepted as convex.

use bevy::math::{Quat, Vec3};

use super::*;
use crate::narrow_phase::mesh::polygon_mesh::tests::cube;

#[test]
fn cube_is_convex_whichever_way_it_faces() {
    let mut inside_out = cube();
    inside_out.flip();
    let convex = ConvexMesh::new(inside_out).unwrap();
    assert_eq!(convex.normals(), cube().normals());
}

#[test]
fn dented_and_open_and_flat_meshes_are_refused() {
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let build = |polygons: &[[u32; 3]], corners: [Vec3; 4]| {
        ConvexMesh::new(PolygonMesh::new(corners, polygons)?)
    };
    assert!(build(&triangles, corners).is_ok());
    let error = build(&triangles[1..], corners).unwrap_err();
    assert!(matches!(error, ShapeError::NotClosed { .. }));
    let mut flat = corners;
    flat[3] = Vec3::new(0.3, 0.3, 0.0);
    assert_eq!(build(&triangles, flat).unwrap_err(), ShapeError::Flat);

    // A cube with a pyramid pressed into its top.
    let cube = cube();
    let mut vertices = cube.vertices().to_vec();
    vertices.push(Vec3::new(0.0, 0.0, 0.5));
    let mut polygons: Vec<Vec<u32>> = cube.polygons().map(<[u32]>::to_vec).collect();
    let top = polygons.remove(1);
    for i in 0..4 {
        polygons.push(vec![top[i], top[(i + 1) % 4], 8]);
    }
    let dented = PolygonMesh::new(vertices, polygons).unwrap();
    assert!(dented.is_closed());
    let error = ConvexMesh::new(dented).unwrap_err();
    assert!(matches!(error, ShapeError::NotConvex { .. }), "{error}");
}

/// A ball of rings of squares, and triangles at its poles, with vertices moved by `place`.
fn ball(rings: u32, place: impl Fn(Vec3) -> Vec3) -> PolygonMesh {
    let count = 2 * rings;
    let angle = |share: u32, of: u32| std::f32::consts::PI * share as f32 / of as f32;
    let mut points = vec![Vec3::Y, Vec3::NEG_Y];
    for i in 1..rings {
        for j in 0..count {
            let (theta, phi) = (angle(i, rings), angle(j, rings));
            let (sin, cos) = theta.sin_cos();
            points.push(Vec3::new(sin * phi.cos(), cos, sin * phi.sin()));
        }
    }
    let at = |i: u32, j: u32| 2 + (i - 1) * count + j % count;
    let mut triangles = Vec::new();
    for j in 0..count {
        triangles.push([0, at(1, j + 1), at(1, j)]);
        triangles.push([1, at(rings - 1, j), at(rings - 1, j + 1)]);
        for i in 1..rings - 1 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    let points: Vec<_> = points.into_iter().map(place).collect();
    PolygonMesh::new(points, triangles).unwrap()
}

#[test]
fn many_triangles_are_convex_wherever_they_are() {
    let turn = Quat::from_rotation_z(0.7) * Quat::from_rotation_x(0.4);
    for (size, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 100.0)] {
        let mesh = ball(100, |at| turn * at * size + offset);
        let convex = ConvexMesh::new(mesh);
        assert!(convex.is_ok(), "{size}, {offset}: {}", convex.unwrap_err());
    }
}

#[test]
fn dents_are_found_however_fine_the_mesh_is() {
    for depth in [0.3, 0.02, 0.002] {
        // The cap above a plane is mirrored down.
        let height = 1.0 - depth;
        let dented = |at: Vec3| at.with_y(at.y.min(2.0 * height - at.y));
        let error = ConvexMesh::new(ball(100, dented)).unwrap_err();
        assert!(
            matches!(error, ShapeError::NotConvex { .. }),
            "{depth}: {error}"
        );
    }
    // Cut off, it is flat.
    let cut = |at: Vec3| at.with_y(at.y.min(0.9));
    let cut = ball(100, |at| Quat::from_rotation_z(0.7) * cut(at));
    assert!(ConvexMesh::new(cut).is_ok());
}

#[test]
fn what_winds_twice_is_not_convex() {
    // A prism over the star of five corners, whose sides bend outwards all around.
    let at = |i: u32, y: f32| {
        let (sin, cos) = (std::f32::consts::TAU * 0.4 * i as f32).sin_cos();
        Vec3::new(cos, y, sin)
    };
    let vertices: Vec<_> = (0..5)
        .flat_map(|i| [at(i, -1.0), at(i, 1.0)])
        .chain([Vec3::NEG_Y, Vec3::Y])
        .collect();
    let triangles = (0..5).flat_map(|i| {
        let (low, next) = (2 * i, (2 * i + 2) % 10);
        [
            [low, low + 1, next],
            [low + 1, next + 1, next],
            [low, next, 10],
            [next + 1, low + 1, 11],
        ]
    });
    let star = PolygonMesh::new(vertices, triangles).unwrap();
    assert!(star.is_closed());
    let error = ConvexMesh::new(star).unwrap_err();
    assert!(matches!(error, ShapeError::NotConvex { .. }), "{error}");
}

#[test]
fn parts_and_surfaces_are_refused() {
    let cube = cube();
    let far = cube.vertices().iter().map(|at| *at + 5.0);
    let vertices: Vec<_> = cube.vertices().iter().copied().chain(far).collect();
    let second = cube
        .polygons()
        .map(|corners| corners.iter().map(|i| i + 8).collect());
    let both: Vec<Vec<u32>> = cube.polygons().map(<[u32]>::to_vec).chain(second).collect();
    let two = PolygonMesh::new(vertices, both).unwrap();
    assert_eq!(
        ConvexMesh::new(two).unwrap_err(),
        ShapeError::NotConnected(2)
    );
    let error = ConvexMesh::new(cube.surface_only()).unwrap_err();
    assert_eq!(error, ShapeError::SurfaceOnly);
}
