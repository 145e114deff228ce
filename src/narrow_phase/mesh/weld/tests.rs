use bevy::{
    math::{Dir3, Quat},
    transform::components::Transform,
};

use super::*;
use crate::narrow_phase::mesh::cube::SIDES;
use crate::narrow_phase::{Contact, ConvexMesh, NarrowPhase, Placed, Shape, Workspace};

fn welded(positions: &[[f32; 3]]) -> Welded {
    Welded::of(positions).unwrap()
}

/// A mesh of listed triangles.
fn listed(positions: &[Vec3]) -> PolygonMesh {
    let positions: Vec<_> = positions.iter().map(Vec3::to_array).collect();
    let triangles = (0..positions.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    PolygonMesh::from_triangles(&positions, triangles).unwrap()
}

/// The twelve triangles of a box, listed; by their corners from 0 to 7.
fn cuboid(min: Vec3, max: Vec3) -> Vec<Vec3> {
    let corner = |i: u32| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 1 {
                max[axis]
            } else {
                min[axis]
            }
        };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let triangles = SIDES.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
    triangles.map(corner).collect()
}

fn ball_at(mesh: &PolygonMesh, radius: f32, at: Vec3) -> Option<Contact> {
    let (mesh, ball) = (Shape::from(mesh.clone()), Shape::sphere(radius));
    let (here, there) = (Transform::IDENTITY, Transform::from_translation(at));
    let (mesh, ball) = (Placed::new(&mesh, &here), Placed::new(&ball, &there));
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let contact = tests.contact(mesh, ball, &mut workspace);
    assert_eq!(
        tests.intersects(ball, mesh, &mut workspace),
        contact.is_some()
    );
    contact
}

/// With a floor far below that makes it a mesh with a tree.
fn with_tree(triangles: &[Vec3]) -> Vec<Vec3> {
    let mut all = triangles.to_vec();
    for i in 0..40 {
        let corner = Vec3::new(i as f32, -20.0, 0.0);
        all.extend([corner, corner + Vec3::Z * 0.7, corner + Vec3::X * 0.7]);
    }
    all
}

/// A ball is in contact in the middle of each box, and not beside them; whether there is a tree or
/// not.
fn assert_solid(triangles: &[Vec3], inside: &[Vec3], outside: &[Vec3]) {
    for (mesh, name) in [
        (listed(triangles), "few"),
        (listed(&with_tree(triangles)), "many"),
    ] {
        for at in inside {
            assert!(ball_at(&mesh, 0.1, *at).is_some(), "{name}: inside at {at}");
        }
        for at in outside {
            assert!(
                ball_at(&mesh, 0.1, *at).is_none(),
                "{name}: outside at {at}"
            );
        }
    }
}

const MIDDLE: Vec3 = Vec3::splat(0.5);

#[test]
fn boxes_that_share_an_edge_are_closed() {
    let second = cuboid(Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 2.0, 1.0));
    let both = [cuboid(Vec3::ZERO, Vec3::ONE), second].concat();
    assert!(listed(&both).is_closed());
    let inside = [MIDDLE, MIDDLE.with_x(1.5).with_y(1.5)];
    assert_solid(&both, &inside, &[MIDDLE.with_x(1.5), MIDDLE.with_y(1.5)]);
}

#[test]
fn bricks_face_to_face_are_closed() {
    // With the wall between them cut along one diagonal, and along both.
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
    ] {
        let mut second = cuboid(Vec3::X, Vec3::new(2.0, 1.0, 1.0));
        for corner in &mut second {
            *corner = (turn * (*corner - MIDDLE) + MIDDLE).round();
        }
        let both = [cuboid(Vec3::ZERO, Vec3::ONE), second].concat();
        assert!(listed(&both).is_closed(), "{turn}");
        let inside = [
            MIDDLE,
            MIDDLE.with_x(1.5),
            MIDDLE.with_x(0.7),
            MIDDLE.with_x(1.2),
        ];
        assert_solid(&both, &inside, &[MIDDLE.with_x(2.2), MIDDLE.with_x(-0.2)]);
    }
}

/// A cube of which the top knows a vertex in the middle of its edge, and the back does not.
fn cube_with_a_vertex_on_its_edge(with_sliver: bool) -> Vec<Vec3> {
    let cube = cuboid(Vec3::ZERO, Vec3::ONE);
    let is_top = |triangle: &[Vec3]| triangle.iter().all(|corner| corner.y == 1.0);
    let mut all: Vec<Vec3> = cube
        .chunks(3)
        .filter(|triangle| !is_top(triangle))
        .flatten()
        .copied()
        .collect();
    let [a, b, c, d] =
        [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, z]| Vec3::new(x, 1.0, z));
    let m = Vec3::new(0.5, 1.0, 0.0);
    all.extend([a, b, m, b, c, m, c, d, m]);
    if with_sliver {
        all.extend([a, m, d]);
    }
    all
}

#[test]
fn a_vertex_on_an_edge_leaves_no_gap() {
    for with_sliver in [false, true] {
        let cube = cube_with_a_vertex_on_its_edge(with_sliver);
        assert!(listed(&cube).is_closed());
        let outside = [MIDDLE.with_y(1.2), MIDDLE.with_x(1.2), MIDDLE.with_z(-0.2)];
        assert_solid(&cube, &[MIDDLE, Vec3::splat(0.2)], &outside);
        // Wherever it is, and whichever way it is turned; and nothing slips through.
        let mut rng = fastrand::Rng::with_seed(3);
        let mut random = || Vec3::from([(); 3].map(|()| rng.f32()));
        for _ in 0..50 {
            let turn = Quat::from_scaled_axis(random() * 3.0);
            let (scale, offset) = (0.1 + 10.0 * random().x, (random() - 0.5) * 100.0);
            let place = |at: Vec3| turn * (at - MIDDLE) * scale + offset;
            let moved: Vec<_> = cube.iter().map(|corner| place(*corner)).collect();
            let mesh = listed(&with_tree(&moved));
            assert!(mesh.has_inside() && !mesh.is_closed());
            for _ in 0..50 {
                let inside = place(random() * 0.9 + 0.05).as_dvec3();
                assert!(mesh.winds_around(inside));
                let outside = place(random() * 0.9 + 0.05 + Vec3::Y).as_dvec3();
                assert!(!mesh.winds_around(outside));
            }
            // In the very plane of the edge, where rays along x pass it.
            for i in 1..100 {
                let near = place(Vec3::new(i as f32 / 100.0, 1.0 + 1e-3, 0.0));
                assert!(!mesh.winds_around(near.as_dvec3()));
            }
        }
    }
}

#[test]
fn a_solid_is_solid_whatever_is_beside_it() {
    let far = Vec3::X * 5.0;
    let mut all = cuboid(Vec3::ZERO, Vec3::ONE);
    all.extend([far, far + Vec3::X, far + Vec3::Y]);
    let mesh = listed(&all);
    assert!(mesh.has_inside() && !mesh.is_closed());
    let edge = mesh
        .open_edge()
        .unwrap()
        .map(|end| mesh.vertices()[end as usize]);
    assert!(edge.iter().all(|end| end.x >= 5.0), "{edge:?}");
    assert_solid(&all, &[MIDDLE], &[MIDDLE + Vec3::X, far + 0.2 + Vec3::Z]);
    assert!(ball_at(&mesh.surface_only(), 0.1, MIDDLE).is_none());
}

#[test]
fn a_box_turned_inside_out_is_solid_unless_it_is_a_surface_only() {
    let mut all = cuboid(Vec3::NEG_ONE, Vec3::ONE);
    all.chunks_mut(3).for_each(|triangle| triangle.swap(0, 1));
    for all in [all.clone(), with_tree(&all)] {
        let solid = listed(&all);
        assert!(ball_at(&solid, 0.1, Vec3::new(0.2, 0.1, -0.3)).is_some());
        assert!(ball_at(&solid, 0.1, Vec3::new(1.2, 0.1, -0.3)).is_none());
        let room = solid.surface_only();
        assert!(room.is_surface_only() && !room.has_inside());
        assert!(ball_at(&room, 0.1, Vec3::new(0.2, 0.1, -0.3)).is_none());
        assert!(ball_at(&room, 0.1, Vec3::new(0.95, 0.1, -0.3)).is_some());
    }
}

#[test]
fn equal_positions_are_one_vertex() {
    let p = Vec3::new(0.53843, 0.0, 1.0);
    let mesh = listed(&[p, Vec3::Y, Vec3::ZERO, p, Vec3::ZERO, Vec3::NEG_Y]);
    assert_eq!(mesh.vertices().len(), 4);
    let mut rng = fastrand::Rng::with_seed(1);
    for _ in 0..20_000 {
        let scale = 10f32.powi(rng.i32(-30..30));
        let one = [(); 3].map(|()| (rng.f32() - 0.5) * scale);
        let other = [(); 3].map(|()| (rng.f32() - 0.5) * scale);
        let found = welded(&[one, other, one, other, one]);
        let same = u32::from(found.vertices.len() > 1);
        assert_eq!(found.indices, [0, same, 0, same, 0]);
    }
    assert_eq!(
        welded(&[[f32::MAX; 3], [f32::MIN; 3], [f32::MAX; 3]]).indices,
        [0, 1, 0]
    );
    assert_eq!(welded(&[[0.0; 3], [-0.0; 3]]).indices, [0, 0]);
}

#[test]
fn small_things_far_from_the_origin_stay() {
    for (far, side) in [(1000.0, 0.02), (10_000.0, 0.2), (10_000.0, 0.05)] {
        let min = Vec3::X * far;
        let crate_alone = cuboid(min, min + side);
        let mesh = listed(&crate_alone);
        assert_eq!(
            (mesh.polygon_count(), mesh.is_closed()),
            (12, true),
            "{side} at {far}"
        );
        // In a level as large as it is far away.
        let floor = cuboid(Vec3::new(0.0, -1.0, -1.0), Vec3::new(far, 0.0, 1.0));
        let raised = crate_alone.iter().map(|corner| corner + Vec3::Y * 0.5);
        let mesh = listed(&floor.into_iter().chain(raised).collect::<Vec<_>>());
        assert_eq!(
            (mesh.polygon_count(), mesh.is_closed()),
            (24, true),
            "{side} at {far}"
        );
    }
    for scale in [1e-6, 1e6, 1e-25, 1e25] {
        let mesh = listed(&cuboid(Vec3::splat(-scale), Vec3::splat(scale)));
        assert_eq!(
            (mesh.polygon_count(), mesh.is_closed()),
            (12, true),
            "{scale}"
        );
    }
}

#[test]
fn seams_of_a_full_turn_close() {
    // A cylinder whose last corner is at the sine of a full turn.
    let mut rng = fastrand::Rng::with_seed(5);
    for count in [8_u16, 33, 100, 400] {
        let (radius, height) = (0.2 + 2.0 * rng.f32(), 0.2 + 2.0 * rng.f32());
        let step = std::f32::consts::TAU / f32::from(count);
        let at = |i: u16, y: f32| {
            let (sin, cos) = (f32::from(i) * step).sin_cos();
            Vec3::new(cos * radius, y, sin * radius)
        };
        let mut all = Vec::new();
        for i in 0..count {
            let [a, b, c, d] = [at(i, 0.0), at(i, height), at(i + 1, height), at(i + 1, 0.0)];
            all.extend([a, b, c, a, c, d, a, d, Vec3::ZERO, c, b, Vec3::Y * height]);
        }
        let mesh = listed(&all);
        assert!(mesh.is_closed(), "{count}");
        assert_eq!(mesh.vertices().len(), 2 * usize::from(count) + 2);
    }
}

#[test]
fn what_is_not_finite_is_named_as_given() {
    let positions = [[0.0; 3], [0.0; 3], [1.0, f32::NAN, 0.0]];
    let error = PolygonMesh::from_triangles(&positions, [[0, 1, 2]]).unwrap_err();
    assert!(
        matches!(error, ShapeError::NonFiniteVertex { vertex: 2, .. }),
        "{error}"
    );
}

#[test]
fn polygons_that_are_there_twice_or_inside_out_do_no_harm() {
    let cube = cuboid(Vec3::ZERO, Vec3::ONE);
    let mut inside_out = cube.clone();
    inside_out[..6]
        .chunks_mut(3)
        .for_each(|triangle| triangle.swap(0, 1));
    let twice = [cube.clone(), cube.clone()].concat();
    let some_twice = [&cube[..], &cube[6..15]].concat();
    for triangles in [inside_out, twice, some_twice] {
        let mesh = listed(&triangles);
        assert!(mesh.is_closed() && mesh.has_inside());
        for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
            let out = mesh.vertices()[corners[0] as usize] - MIDDLE;
            assert!(normal.dot(out) > 0.0);
        }
        assert_solid(&triangles, &[MIDDLE], &[MIDDLE + Vec3::Y]);
    }
    // Each triangle once each way: a solid; with one missing, nothing but surface.
    let back = cube
        .chunks(3)
        .flat_map(|corners| [corners[1], corners[0], corners[2]]);
    let both: Vec<_> = cube.iter().copied().chain(back).collect();
    let mesh = listed(&both);
    assert!(mesh.has_inside() && mesh.is_closed());
    for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
        let out = mesh.vertices()[corners[0] as usize] - MIDDLE;
        assert!(normal.dot(out) > 0.0);
    }
    assert_solid(&both, &[MIDDLE], &[MIDDLE + Vec3::Y]);
    // As a surface, its sides face both ways, as given.
    let hollow = mesh.surface_only();
    let sum: Vec3 = hollow.normals().iter().sum();
    let [front, back] = [0, 12].map(|polygon| hollow.normals()[polygon]);
    assert!(sum.length() < 1e-6 && front == -back);
    // With a vertex on an edge, too.
    let notched = cube_with_a_vertex_on_its_edge(false);
    let back = notched
        .chunks(3)
        .flat_map(|corners| [corners[1], corners[0], corners[2]]);
    let with_vertex: Vec<_> = notched.iter().copied().chain(back).collect();
    assert!(listed(&with_vertex).is_closed());
    assert_solid(&with_vertex, &[MIDDLE], &[MIDDLE + Vec3::Y]);
    let open = [&both[3..36], &both[39..]].concat();
    let mesh = listed(&open);
    assert!(!mesh.has_inside() && !mesh.is_closed());
    assert!(ball_at(&mesh, 0.1, MIDDLE).is_none());
    assert!(ball_at(&mesh, 0.1, Vec3::new(0.5, 1.05, 0.5)).is_some());
    // A flag on an edge, and a membrane across the cube.
    let flag = [Vec3::ZERO, Vec3::Y, Vec3::new(-1.0, 0.5, -1.0)];
    let membrane = [Vec3::ZERO, Vec3::ONE.with_z(0.0), Vec3::ONE];
    let more = [membrane[0], membrane[2], Vec3::Z];
    let with_more = [&cube[..], &flag, &membrane, &more].concat();
    assert_solid(&with_more, &[MIDDLE.with_x(0.8)], &[MIDDLE + Vec3::Y]);
}

/// A box of triangles with one without an area before, one amidst, and one after the others.
fn dirty() -> (PolygonMesh, [u32; 3]) {
    let mut triangles = cuboid(Vec3::ZERO, Vec3::ONE);
    let nothing = [Vec3::ZERO, Vec3::X, Vec3::X];
    triangles.extend(nothing);
    triangles.splice(15..15, nothing);
    triangles.splice(0..0, nothing);
    (listed(&triangles), [0, 6, 14])
}

#[test]
fn numbers_of_what_was_left_out_have_no_index() {
    let (mesh, left_out) = dirty();
    assert_eq!(mesh.polygon_count(), 12);
    for number in 0..16 {
        let index = mesh.polygon_index(number);
        let is_kept = number < 15 && !left_out.contains(&number);
        assert_eq!(index.is_some(), is_kept, "{number}");
        if let Some(index) = index {
            assert_eq!(mesh.polygon_number(index), number);
            assert!(mesh.bounds_solid(index));
        }
    }
    let clean = listed(&cuboid(Vec3::ZERO, Vec3::ONE));
    assert_eq!([11, 12].map(|n| clean.polygon_index(n)), [Some(11), None]);
    assert_eq!(clean.polygon_number(11), 11);
    // What keeps the numbers takes memory, too.
    assert!(mesh.memory_bytes() >= clean.memory_bytes() + 12 * size_of::<u32>());
}

#[test]
fn a_polygon_that_is_met_is_found_by_its_number() {
    let (mesh, _) = dirty();
    let (shape, here) = (Shape::from(mesh.clone()), Transform::IDENTITY);
    for axis in 0..6 {
        let mut normal = Vec3::ZERO;
        normal[axis / 2] = if axis % 2 == 0 { 1.0 } else { -1.0 };
        let start = Vec3::new(0.5, 0.45, 0.52) + normal * 2.0;
        let hit = NarrowPhase::default()
            .cast_ray(
                Placed::new(&shape, &here),
                start,
                Dir3::new(-normal).unwrap(),
                9.0,
            )
            .unwrap();
        let index = mesh.polygon_index(hit.polygon.unwrap()).unwrap();
        assert_eq!(mesh.normals()[index], normal);
    }
}

#[test]
fn what_is_not_convex_is_named_by_the_input() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(0.1)];
    // The second is nothing; the tip is pushed in.
    let faces: [[usize; 3]; 7] = [
        [0, 2, 1],
        [0, 0, 1],
        [0, 1, 3],
        [2, 0, 3],
        [1, 2, 4],
        [2, 3, 4],
        [3, 1, 4],
    ];
    let list = |faces: &[[usize; 3]]| -> Vec<Vec3> {
        faces.iter().flatten().map(|i| corners[*i]).collect()
    };
    let refused = |faces: &[[usize; 3]]| ConvexMesh::new(listed(&list(faces))).unwrap_err();
    let error = refused(&faces);
    let ShapeError::NotConvex {
        polygon, position, ..
    } = error
    else {
        panic!("{error}")
    };
    let [a, b, c] = faces[polygon].map(|i| corners[i]);
    let outwards = (b - a).cross(c - a);
    assert!(outwards.dot(position - a) > 0.0, "{polygon}, {position}");
    assert!(corners.contains(&position));
    assert!(error.to_string().contains(&position.to_string()), "{error}");

    let ShapeError::NotClosed { positions, .. } = refused(&faces[..6]) else {
        panic!("it is open")
    };
    let around = [3, 1, 4].map(|i: usize| corners[i]);
    assert!(positions.iter().all(|at| around.contains(at)));
}
