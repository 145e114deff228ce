use std::f32::consts::TAU;

use bevy::math::{DVec3, Dir3, IVec3, Quat, Vec3};
use bevy::transform::components::Transform;

use super::*;
use crate::narrow_phase::frame::{
    outward::tests::ball_polygons, placed::Placed, workspace::Workspace,
};
use crate::narrow_phase::{settings::NarrowPhase, shape::Shape};

/// A ball of so many columns and rows of triangles, whose vertices are moved.
fn ball(columns: u32, rows: u32, moved: impl Fn(Vec3) -> Vec3) -> PolygonMesh {
    let mut vertices = vec![Vec3::Y, Vec3::NEG_Y];
    for row in 1..rows {
        for column in 0..columns {
            let polar = TAU * 0.5 * row as f32 / rows as f32;
            let around = TAU * column as f32 / columns as f32;
            let ring = Vec3::new(around.sin(), 0.0, around.cos());
            vertices.push(ring * polar.sin() + Vec3::Y * polar.cos());
        }
    }
    let vertices: Vec<Vec3> = vertices.into_iter().map(moved).collect();
    PolygonMesh::new(vertices, ball_polygons(columns, rows)).unwrap()
}

/// One of its poles is moved through the ball and out on the other side.
fn pierced(columns: u32, rows: u32) -> PolygonMesh {
    ball(columns, rows, |vertex| match vertex {
        Vec3::Y => Vec3::new(0.3, -2.0, 0.2),
        vertex => vertex,
    })
}

/// A double cone whose tips are so far apart, one of them drawn in.
fn dented(apart: f32) -> PolygonMesh {
    ball(8, 2, |vertex| match vertex {
        Vec3::Y => Vec3::new(0.0, apart - 1.0, 0.0),
        vertex => vertex,
    })
}

#[test]
fn a_surface_that_keeps_away_from_itself_tells_sides() {
    for (columns, rows) in [(4, 2), (6, 3), (16, 12), (100, 50)] {
        let round = ball(columns, rows, |vertex| vertex);
        assert!(tells_sides(&round), "{columns} {rows}");
        let far = ball(columns, rows, |vertex| vertex * 3.0 + 1000.0);
        assert!(tells_sides(&far), "{columns} {rows}");
    }
    assert!(tells_sides(&dented(0.5)));
}

#[test]
fn a_surface_that_crosses_or_touches_itself_does_not() {
    for (columns, rows) in [(4, 3), (6, 3), (16, 12), (60, 30)] {
        let mesh = pierced(columns, rows);
        assert!(mesh.is_one_solid());
        assert!(!tells_sides(&mesh), "{columns} {rows}");
    }
    for apart in [1e-6, 0.0, -1e-6] {
        assert!(!tells_sides(&dented(apart)), "{apart}");
    }
    // A wedge as sharp as a knife.
    let [a, b] = [Vec3::new(-1.0, 0.0, -0.02), Vec3::new(1.0, 0.0, -0.02)];
    let corners = [a, b, Vec3::new(0.0, 0.05, 1.0), Vec3::new(0.0, -0.05, 1.0)];
    let knife = PolygonMesh::new(corners, [[0, 1, 2], [1, 0, 3], [1, 3, 2], [3, 0, 2]]).unwrap();
    assert!(knife.is_one_solid() && !tells_sides(&knife));
}

#[test]
fn polygons_of_more_corners_are_told_from_each_other() {
    let outline = |inner: f32| {
        let at = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [inner, 1.0],
            [inner, 2.0],
            [3.0, 2.0],
            [3.0, 3.0],
            [0.0, 3.0],
        ];
        let level = move |z: f32| at.into_iter().map(move |[x, y]| Vec3::new(x, y, z));
        let vertices: Vec<Vec3> = level(0.0).chain(level(1.0)).collect();
        let mut polygons = vec![vec![7, 6, 5, 4, 3, 2, 1, 0], (8..16).collect()];
        polygons.extend((0..8).map(|i| vec![i, (i + 1) % 8, (i + 1) % 8 + 8, i + 8]));
        PolygonMesh::new(vertices, &polygons).unwrap()
    };
    assert!(tells_sides(&outline(1.0)));
    // The notch reaches the wall behind it, and goes through it.
    for inner in [0.0, -1.0] {
        let mesh = outline(inner);
        assert!(mesh.is_one_solid() && !tells_sides(&mesh), "{inner}");
    }
}

/// A floor of four corners, from two of which, across it, two tents rise: their edge lies on it.
#[test]
fn what_touches_a_polygon_between_corners_that_it_shares_is_near_it() {
    let turn = Quat::from_scaled_axis(Vec3::new(0.37, 0.11, -0.23));
    let corners = [
        (-1, 0, -1),
        (1, 0, -1),
        (1, 0, 1),
        (-1, 0, 1),
        (1, 1, -1),
        (-1, 1, 1),
    ];
    let vertices = corners.map(|(x, y, z)| turn * IVec3::new(x, y, z).as_vec3());
    let tents = [
        [0, 4, 1],
        [1, 4, 2],
        [2, 4, 0],
        [0, 5, 2],
        [2, 5, 3],
        [3, 5, 0],
    ];
    let mut polygons = vec![vec![0, 1, 2, 3]];
    polygons.extend(tents.map(Vec::from));
    let mesh = PolygonMesh::new(vertices.to_vec(), &polygons).unwrap();
    assert!(mesh.has_inside() && !tells_sides(&mesh));
    let (shape, here) = (Shape::from(mesh), Transform::IDENTITY);
    let below = turn * Vec3::new(0.9, -0.01, 0.9);
    let tests = NarrowPhase::default();
    let closest = tests.closest_point(Placed::new(&shape, &here), below, &mut Workspace::default());
    assert!(closest.unwrap().distance(below) > 9e-3);
}

fn places(reach: f32) -> impl Iterator<Item = Vec3> {
    (0..2000).map(move |i| {
        let place = |step: f32| (i as f32 * step).fract() * 2.0 - 1.0;
        Vec3::new(place(0.754_88), place(0.569_84), place(0.329_93)) * reach
    })
}

#[test]
fn all_questions_agree_about_what_is_inside_of_a_surface_that_crosses_itself() {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let (mote, here) = (Shape::sphere(0.0), Transform::IDENTITY);
    for (columns, rows) in [(4, 3), (16, 12)] {
        let mesh = pierced(columns, rows);
        let shape = Shape::from(mesh.clone());
        let placed = Placed::new(&shape, &here);
        let surface = Shape::from(mesh.clone().surface_only());
        let surface = Placed::new(&surface, &here);
        let mut inside = 0;
        for place in places(1.5) {
            let on = tests.closest_point(surface, place, &mut workspace).unwrap();
            if on.distance(place) < 1e-3 {
                continue;
            }
            let at = Transform::from_translation(place);
            let there = Placed::new(&mote, &at);
            let closest = tests.closest_point(placed, place, &mut workspace).unwrap();
            let near = tests.closest_points(placed, there, &mut workspace).unwrap();
            let hit = tests.cast_ray(placed, place, Dir3::X, 10.0);
            let swept = tests.sweep(there, Dir3::X, 10.0, placed, &mut workspace);
            let starts = [hit.map(|hit| hit.distance), swept.map(|hit| hit.distance)];
            let answers = [
                closest == place,
                near.distance == 0.0,
                tests.intersects(placed, there, &mut workspace),
                tests.contact(placed, there, &mut workspace).is_some(),
                starts[0] == Some(0.0),
                starts[1] == Some(0.0),
            ];
            let is_inside = mesh.winds_around(DVec3::from(place));
            assert_eq!(answers, [is_inside; 6], "{place} {columns}");
            inside += u32::from(is_inside);
        }
        assert!(inside > 30, "{inside}");
    }
}

/// Where a ray passes along the outline of a solid, polygons around a corner are met at one place, some
/// of them from within.
#[test]
fn rays_along_the_outline_of_a_solid_start_where_they_do() {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let here = Transform::IDENTITY;
    let (mut inside, mut outside) = (0, 0);
    for seed in 0..12 {
        let shaken = |vertex: Vec3| {
            let shake = (vertex * 43.7 + seed as f32).map(|axis| (axis.sin() * 999.0).fract());
            (vertex + shake * 0.1) * Vec3::new(20.0, 0.5, 1.0)
        };
        let mesh = ball(12, 8, shaken);
        let shape = Shape::from(mesh.clone());
        let surface = Shape::from(mesh.clone().surface_only());
        for vertex in mesh.vertices() {
            for before in [1.5, 6.375] {
                let from = *vertex - Vec3::X * before;
                let surface = Placed::new(&surface, &here);
                let on = tests.closest_point(surface, from, &mut workspace).unwrap();
                if on.distance(from) < 1e-3 {
                    continue;
                }
                let hit = tests.cast_ray(Placed::new(&shape, &here), from, Dir3::X, 100.0);
                let is_inside = mesh.winds_around(DVec3::from(from));
                let starts = hit.is_some_and(|hit| hit.distance == 0.0);
                assert_eq!(starts, is_inside, "{seed} {from}");
                inside += u32::from(is_inside);
                outside += u32::from(!is_inside);
            }
        }
    }
    assert!(inside > 100 && outside > 100, "{inside} {outside}");
}
