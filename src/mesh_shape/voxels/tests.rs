//! Voxels are where the mesh is, and nowhere else.

use bevy::{math::primitives, mesh::Mesh};
use proptest::prelude::*;

use super::*;
use crate::narrow_phase::mesh_triangles;

fn triangles(mesh: impl Into<Mesh>) -> Vec<[Vec3; 3]> {
    mesh_triangles(&mesh.into()).unwrap()
}

fn moved(triangles: Vec<[Vec3; 3]>, by: Vec3) -> Vec<[Vec3; 3]> {
    let moved = |triangle: [Vec3; 3]| triangle.map(|corner| corner + by);
    triangles.into_iter().map(moved).collect()
}

/// Has its sides on borders between cells.
#[test]
fn a_box_of_cells_is_just_these() {
    let cube = triangles(primitives::Cuboid::new(2.0, 1.0, 1.5));
    let cells = filled(&moved(cube, Vec3::new(1.0, 0.5, 0.75)), 0.5).unwrap();
    assert_eq!(cells.len(), 4 * 2 * 3);
    let low = cells.iter().copied().reduce(IVec3::min);
    let high = cells.iter().copied().reduce(IVec3::max);
    assert_eq!((low, high), (Some(IVec3::ZERO), Some(IVec3::new(3, 1, 2))));
    // A floor that faces up is below where it is.
    let floor = triangles(primitives::Plane3d::new(
        Vec3::Y,
        bevy::math::Vec2::splat(1.0),
    ));
    let cells = filled(&floor, 1.0).unwrap();
    assert!(cells.iter().all(|cell| cell.y == -1));
    assert_eq!(
        cells
            .iter()
            .filter(|cell| cell.x.abs() < 1 && cell.z.abs() < 1)
            .count(),
        1
    );
}

#[test]
fn what_is_enclosed_is_filled_and_what_is_open_is_not() {
    let ball = triangles(primitives::Sphere::new(5.0));
    let cells = filled(&ball, 1.0).unwrap();
    assert!(cells.contains(&IVec3::ZERO));
    let volume = 4.0 / 3.0 * std::f32::consts::PI * 125.0;
    assert!(
        (volume..2.0 * volume).contains(&(cells.len() as f32)),
        "{}",
        cells.len()
    );
    let half: Vec<_> = (ball.into_iter())
        .filter(|triangle| triangle.iter().all(|corner| corner.y < 0.1))
        .collect();
    let cells = filled(&half, 1.0).unwrap();
    assert!(!cells.contains(&IVec3::ZERO) && !cells.contains(&IVec3::NEG_ONE));
}

#[test]
fn bad_sizes_are_refused() {
    let cube = triangles(primitives::Cuboid::default());
    for size in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(
            matches!(voxels(&cube, size), Err(ShapeError::VoxelSize(_))),
            "{size}"
        );
    }
    for size in [1e-3, 1e-20, f32::MIN_POSITIVE] {
        assert!(
            matches!(voxels(&cube, size), Err(ShapeError::TooManyVoxels { .. })),
            "{size}"
        );
    }
    assert!(voxels(&cube, 1e6).is_ok());
    assert_eq!(filled(&cube, 1e30).map(|cells| cells.len()), Ok(8));
    let needle = [[Vec3::ZERO, Vec3::X, Vec3::X]];
    assert!(matches!(voxels(&needle, 1.0), Err(ShapeError::Empty)));
}

proptest! {
    #[test]
    fn every_point_of_a_triangle_is_in_a_voxel(
        corners in prop::array::uniform3(prop::array::uniform3(-4.0_f32..4.0)),
        weights in prop::array::uniform3(0.01_f64..1.0),
        size in 0.2_f32..2.0,
    ) {
        let triangle = corners.map(Vec3::from);
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3() / f64::from(size));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        prop_assume!(normal != DVec3::ZERO);
        let cells = filled(&[triangle], size).unwrap();
        let sum: f64 = weights.iter().sum();
        let point = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
        let from_border = (point - point.round()).abs().min_element();
        prop_assert!(from_border < 1e-3 || cells.contains(&point.floor().as_ivec3()));
        // And none is far from it.
        for cell in cells {
            let off = (cell.as_dvec3() + 0.5 - a).dot(normal).abs();
            prop_assert!(off < 0.87, "{cell} is {off} off");
        }
    }
}
