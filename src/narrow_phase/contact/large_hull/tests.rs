//! Convex meshes of many faces on polygons, against all of their faces.

use bevy::math::{EulerRot, Quat, Vec3};
use bevy::transform::components::Transform;

use super::*;
use crate::narrow_phase::contact::{around::Around, body::Body, hull::Hull, support::visited};
use crate::narrow_phase::*;

/// A sphere of radius 1, off the origin, of triangles at the poles and quadrangles.
pub fn sphere(rings: u32, around: u32) -> ConvexMesh {
    use std::f32::consts::{PI, TAU};
    let off = Vec3::new(0.3, -0.2, 0.1);
    let mut vertices = vec![off + Vec3::Y, off - Vec3::Y];
    for ring in 1..rings {
        let (height, width) = {
            let angle = PI * ring as f32 / rings as f32;
            (angle.cos(), angle.sin())
        };
        for step in 0..around {
            let (sin, cos) = (TAU * step as f32 / around as f32).sin_cos();
            vertices.push(off + Vec3::new(width * cos, height, width * sin));
        }
    }
    let at = |ring: u32, step: u32| 2 + (ring - 1) * around + step % around;
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    for step in 0..around {
        polygons.push(vec![0, at(1, step + 1), at(1, step)]);
        polygons.push(vec![1, at(rings - 1, step), at(rings - 1, step + 1)]);
        for ring in 1..rings - 1 {
            let [a, b] = [ring, ring + 1];
            polygons.push(vec![
                at(a, step),
                at(a, step + 1),
                at(b, step + 1),
                at(b, step),
            ]);
        }
    }
    ConvexMesh::new(PolygonMesh::new(vertices, polygons).unwrap()).unwrap()
}

fn random_point(random: &mut fastrand::Rng, reach: f32) -> Vec3A {
    let mut unit = || (random.f32() * 2.0 - 1.0) * reach;
    Vec3A::new(unit(), unit(), unit())
}

#[test]
fn polygons_meet_the_faces_near_them_as_they_meet_all() {
    let mut random = fastrand::Rng::with_seed(3);
    let (mut room, mut hull) = (Room::default(), Hull::default());
    let (mut met, mut shallow) = (0, 0);
    // A triangle alone, and on top of others.
    let vertices = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::new(0.3, -1.0, 0.3)];
    let polygons = [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]];
    let shapes = [1, 4].map(|count| PolygonMesh::new(vertices, &polygons[..count]).unwrap());
    for (rings, around) in [(6, 14), (12, 16), (24, 40)] {
        let mesh = sphere(rings, around);
        for _ in 0..400 {
            let scale = Vec3A::new(1.0, 0.5, -0.7) * (0.5 + random.f32());
            let large = LargeHull::searched(&mesh, scale, &mut room).unwrap();
            hull.fill(&mesh, scale);
            let (all, near) = (Body::Hull(&hull), Body::Large(&large));
            let size = scale.length();

            let direction = random_point(&mut random, 1.0).normalize_or(Vec3A::Y);
            let (low, found) = (all.lowest(direction), near.lowest(direction));
            assert!((low - found).abs() <= 1e-5 * size, "{low} {found}");

            let reach = if random.bool() { 0.2 } else { 1.5 };
            let middle = random_point(&mut random, 1.0);
            let corners = [0; 3].map(|_| middle + random_point(&mut random, reach));
            let normal = (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or_zero();
            // Not where rounding decides.
            let touches = [-1e-4, 1e-4].map(|more| all.touches(&corners, normal, more));
            let found = near.touches(&corners, normal, 0.0);
            if touches[0] == touches[1] {
                assert_eq!(found, touches[0], "{corners:?} {scale}");
            }
            if !found {
                room = large.into_room();
                continue;
            }
            met += 1;
            // Alone, and with neighbours below.
            let below = corners.iter().sum::<Vec3A>() / 3.0 - normal;
            let [a, b, c] = corners;
            let places = [a, b, c, below];
            for mesh in &shapes {
                for is_solid in [false, true] {
                    let facet = Facet {
                        corners: &corners,
                        normal,
                        around: Around {
                            mesh,
                            polygon: 0,
                            place: &|vertex| places[vertex as usize],
                            clip: &|line| line,
                            others: &|_, _| false,
                            reach: 0.0,
                        },
                        is_solid,
                    };
                    let one = all.way_out(&facet, 1e-5 * size).unwrap();
                    let other = near.way_out(&facet, 1e-5 * size).unwrap();
                    shallow += usize::from(one.depth < 0.1 * size);
                    assert!(
                        (one.depth - other.depth).abs() <= 1e-4 * size,
                        "{one:?} {other:?} {corners:?} {scale} {is_solid}"
                    );
                }
            }
            room = large.into_room();
        }
    }
    assert!(met > 300 && shallow > 300, "{met} {shallow}");
}

/// A floor of so many cells along each side, from -2 to 2.
fn floor(cells: u32) -> Shape {
    let corner = |i: u32| i as f32 / cells as f32 * 4.0 - 2.0;
    let mut vertices = Vec::new();
    for z in 0..=cells {
        vertices.extend((0..=cells).map(|x| Vec3::new(corner(x), 0.0, corner(z))));
    }
    let mut list = Vec::new();
    for z in 0..cells {
        for x in 0..cells {
            let a = z * (cells + 1) + x;
            let b = a + cells + 1;
            list.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
        }
    }
    Shape::mesh(vertices, list).unwrap()
}

#[test]
fn few_faces_are_looked_at_for_each_polygon_of_a_floor() {
    let floor = floor(40);
    let mut counts = Vec::new();
    for rings in [10, 20, 40, 80] {
        let ball = sphere(rings, 2 * rings);
        let faces = ball.polygon_count();
        let ball = Shape::from(ball);
        let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.4, 0.5);
        let center = turn * Vec3::new(0.3, -0.2, 0.1);
        let at = Transform::from_translation(Vec3::Y * 0.97 - center).with_rotation(turn);
        let here = Transform::IDENTITY;
        let (one, two) = (Placed::new(&ball, &at), Placed::new(&floor, &here));
        let mut workspace = Workspace::default();
        visited::take();
        let found = NarrowPhase::default()
            .contact(one, two, &mut workspace)
            .unwrap();
        counts.push((faces, visited::take()));
        assert!(
            found.normal.distance(-Vec3::Y) < 1e-3 && (found.depth - 0.03).abs() < 0.015,
            "{found:?}"
        );
    }
    let [(few, least), .., (many, most)] = counts[..] else {
        unreachable!()
    };
    // All polygons of the floor near the ball times all faces would be many more.
    assert!(most * few < 2 * least * many, "{counts:?}");
    assert!(
        counts
            .iter()
            .all(|(faces, count)| *count < 20 * faces + 40_000),
        "{counts:?}"
    );
}
