use std::f32::consts::{PI, TAU};

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;

use super::*;
use crate::narrow_phase::frame::{
    edge_polygon::fill_second_to_search,
    placed::{Placed, PlacedPair},
    workspace::Workspace,
};
use crate::narrow_phase::shape::Shape;

/// The triangles of a ball of so many columns and rows: of its two poles, and of one row after the other.
pub fn ball_polygons(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    let at = |row: u32, column: u32| 2 + (row - 1) * columns + column % columns;
    let mut polygons = Vec::new();
    for column in 0..columns {
        polygons.push([0, at(1, column), at(1, column + 1)]);
        polygons.push([1, at(rows - 1, column + 1), at(rows - 1, column)]);
        for row in 1..rows - 1 {
            let quad = [(0, 0), (1, 0), (1, 1), (0, 1)];
            let [a, b, c, d] = quad.map(|(down, right)| at(row + down, column + right));
            polygons.extend([[a, b, c], [a, c, d]]);
        }
    }
    polygons
}

/// A ball of so many columns with bumps, none of its vertices quite in its place.
fn bumpy_ball(columns: u32, rows: u32) -> PolygonMesh {
    let mut state = 1u32;
    let mut shake = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut vertices = vec![Vec3::Y, Vec3::NEG_Y];
    for row in 1..rows {
        for column in 0..columns {
            let (polar, around) = (
                PI * row as f32 / rows as f32,
                TAU * column as f32 / columns as f32,
            );
            let ring = Vec3::new(polar.sin() * around.sin(), 0.0, polar.sin() * around.cos());
            let bump = 1.0 + 0.3 * (5.0 * around).sin() * polar.sin() + 0.15 * shake();
            vertices.push((ring + Vec3::Y * polar.cos()) * bump);
        }
    }
    PolygonMesh::new(vertices, ball_polygons(columns, rows)).unwrap()
}

#[test]
fn what_is_closest_tells_the_side_as_winding_does() {
    let mesh = bumpy_ball(12, 9);
    assert!(mesh.is_one_solid() && mesh.tree().is_some());
    let (mesh, point) = (Shape::from(mesh), Shape::sphere(0.0));
    for scale in [
        Vec3::ONE,
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(2.0, 0.5, 1.3),
    ] {
        let turned = Transform::from_rotation(Quat::from_rotation_x(0.7)).with_scale(scale);
        let (mut told, mut inside) = (0, 0);
        for i in 0..4000u32 {
            let coordinate = |step: f32| (i as f32 * step).fract() * 3.0 - 1.5;
            let position = Vec3::new(coordinate(0.754_88), coordinate(0.569_84), coordinate(0.43));
            let at = Transform::from_translation(turned.transform_point(position));
            let placed = [Placed::new(&point, &at), Placed::new(&mesh, &turned)];
            let pair = PlacedPair::new(placed[0], placed[1], 1e-4).unwrap();
            let mut workspace = Workspace::default();
            let (mesh, surface) = fill_second_to_search(&pair, &mut workspace).unwrap();
            let center = pair.box_a.center;
            let closest = surface.closest_of_all(mesh, center, f32::INFINITY).unwrap();
            let truth = surface.encloses(mesh, center);
            let side = is_behind(mesh, surface.placing(), &closest, center, pair.tolerance);
            assert!(
                side.is_none_or(|side| side == truth),
                "{position} {closest:?}"
            );
            told += u32::from(side.is_some());
            inside += u32::from(truth);
        }
        assert!(told > 3900, "{told} are told, with {scale}");
        assert!((400..2000).contains(&inside), "{inside}");
    }
}

#[test]
fn borders_tell_nothing() {
    let triangle = PolygonMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], [[0u32, 1, 2]]).unwrap();
    let (shape, here) = (Shape::from(triangle.clone()), Transform::IDENTITY);
    let placed = Placed::new(&shape, &here);
    let pair = PlacedPair::new(placed, placed, 1e-4).unwrap();
    let placing = Placing::of((&triangle, Vec3A::ONE), placed, &pair.box_a);
    let side = |point: Vec3A, on: Vec3A| {
        let closest = ClosestPoint {
            point: on,
            distance: point.distance(on),
            normal: Vec3A::Z,
            polygon: 0,
        };
        is_behind(&triangle, &placing, &closest, point, 1e-4)
    };
    let middle = Vec3A::new(0.5, 0.0, 0.0);
    assert_eq!(side(middle + Vec3A::NEG_Y, middle), None);
    assert_eq!(side(Vec3A::new(-1.0, -1.0, 0.0), Vec3A::ZERO), None);
    let over = Vec3A::new(0.2, 0.2, 0.0);
    assert_eq!(side(over + Vec3A::Z, over), Some(false));
    assert_eq!(side(over - Vec3A::Z, over), Some(true));
}
