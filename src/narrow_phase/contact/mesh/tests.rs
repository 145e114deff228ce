//! Solids on floors, fans and folds of polygons.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;

use crate::narrow_phase::mesh::cube::SIDES;
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

/// As seen from the first, whichever is asked first.
#[track_caller]
pub(super) fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Contact {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let found = tests.contact(one, two, &mut workspace).unwrap();
    let back = tests.contact(two, one, &mut workspace).unwrap();
    assert_eq!(found, back.reversed());
    assert!(tests.intersects(one, two, &mut workspace) && found.depth >= 0.0);
    found
}

#[track_caller]
fn assert_close(found: Contact, normal: Vec3, depth: f32, what: &str) {
    assert!(
        found.normal.distance(normal) < 1e-4 && (found.depth - depth).abs() < 1e-4,
        "{what}: {found:?}, expected {normal} {depth}"
    );
}

fn triangles(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Shape {
    let vertices: Vec<_> = vertices.iter().copied().map(Vec3::from).collect();
    Shape::mesh(vertices, triangles).unwrap()
}

/// Two triangles with normals upwards, from (0, 0, 0) to (8, 0, 8).
fn square() -> Shape {
    let corners = [[0., 0., 0.], [0., 0., 8.], [8., 0., 8.], [8., 0., 0.]];
    triangles(&corners, &[[0, 1, 2], [0, 2, 3]])
}

fn square_downwards() -> Shape {
    let corners = [[0., 0., 0.], [0., 0., 8.], [8., 0., 8.], [8., 0., 0.]];
    triangles(&corners, &[[0, 2, 1], [0, 3, 2]])
}

/// A fan around a vertex off the middle, as triangulators make them.
fn fan() -> Shape {
    let corners = [
        [3.9, 0., 4.1],
        [0., 0., 0.],
        [0., 0., 8.],
        [8., 0., 8.],
        [8., 0., 0.],
    ];
    triangles(&corners, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
}

pub(super) fn grid(n: u32, height: impl Fn(f32, f32) -> f32) -> Shape {
    let mut vertices = Vec::new();
    for z in 0..=n {
        for x in 0..=n {
            let [x, z] = [x as f32, z as f32];
            vertices.push([x, height(x, z), z]);
        }
    }
    let corner = |x: u32, z: u32| z * (n + 1) + x;
    let squares = (0..n).flat_map(|z| (0..n).map(move |x| (x, z)));
    let list: Vec<_> = squares
        .flat_map(|(x, z)| {
            let [a, b, c, d] = [
                corner(x, z),
                corner(x, z + 1),
                corner(x + 1, z),
                corner(x + 1, z + 1),
            ];
            [[a, b, c], [c, b, d]]
        })
        .collect();
    triangles(&vertices, &list)
}

/// A box of 12 triangles.
fn slab() -> Shape {
    let corner = |bits: u32| {
        [
            8.0 * (bits & 1) as f32,
            (bits >> 1 & 1) as f32 - 1.0,
            8.0 * (bits >> 2) as f32,
        ]
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let halves = SIDES.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    triangles(&corners, halves.as_flattened())
}

/// The cube as a convex mesh.
fn convex_cube(half: f32) -> Shape {
    let Shape::Mesh(mesh) = mesh_of(Vec3::splat(half)) else {
        unreachable!()
    };
    ConvexMesh::new((*mesh).clone()).unwrap().into()
}

#[test]
fn up_is_the_way_off_a_floor_whichever_way_it_is_wound() {
    let solids = [
        box_of(0.5, 0.5, 0.5),
        convex_cube(0.5),
        mesh_of(Vec3::splat(0.5)),
        Shape::sphere(0.5),
    ];
    let mirrored = at(0.0, 0.0, 0.0).with_scale(Vec3::new(1.0, -1.0, 1.0));
    for (name, floor, place) in [
        ("upwards", square(), at(0.0, 0.0, 0.0)),
        ("downwards", square_downwards(), at(0.0, 0.0, 0.0)),
        ("mirrored", square(), mirrored),
        ("fan", fan(), at(0.0, 0.0, 0.0)),
    ] {
        for solid in &solids {
            for (x, z) in [(3.0, 3.0), (4.3, 4.1), (6.0, 1.0)] {
                let found = contact((&floor, place), (solid, at(x, 0.45, z)));
                assert_close(found, Vec3::Y, 0.05, name);
                let found = contact((&floor, place), (solid, at(x, -0.45, z)));
                assert_close(found, Vec3::NEG_Y, 0.05, name);
            }
        }
    }
}

#[test]
fn wherever_a_flat_floor_is_joined() {
    let floors = [
        ("grid", grid(8, |_, _| 0.0)),
        ("fan", fan()),
        ("square", square()),
        ("slab", slab()),
    ];
    let solids = [
        ("cuboid", box_of(0.5, 0.5, 0.5)),
        ("convex", convex_cube(0.5)),
        ("mesh", mesh_of(Vec3::splat(0.5))),
        ("ball", Shape::sphere(0.5)),
    ];
    let places = [
        (4., 4.),
        (4.3, 4.1),
        (3.5, 4.5),
        (2.2, 5.9),
        (1.0, 1.0),
        (7.1, 3.3),
        (4.0, 2.7),
    ];
    for (floor_name, floor) in &floors {
        for (name, solid) in &solids {
            for (x, z) in places {
                for turn in [0.0f32, 0.3] {
                    let place = at(x, 0.45, z).with_rotation(Quat::from_rotation_y(turn));
                    let found = contact((floor, at(0.0, 0.0, 0.0)), (solid, place));
                    let what = format!("{name} on {floor_name} at ({x}, {z}), turned {turn}");
                    assert_close(found, Vec3::Y, 0.05, &what);
                    let middle = Vec3::new(x, -0.025, z);
                    let near = if *name == "mesh" { 0.5 } else { 0.03 };
                    assert!(found.point.distance(middle) < near, "{what}: {found:?}");
                }
            }
        }
    }
}

#[test]
fn a_solid_sinks_into_a_closed_mesh_and_comes_out_where_it_went_in() {
    let solids = [
        box_of(0.5, 0.5, 0.5),
        convex_cube(0.5),
        mesh_of(Vec3::splat(0.5)),
    ];
    for solid in &solids {
        // Deeper than half of it: the other way is through the slab.
        for depth in [0.05, 0.3, 0.6, 0.9] {
            let found = contact(
                (&slab(), at(0.0, 0.0, 0.0)),
                (solid, at(3.0, 0.5 - depth, 4.2)),
            );
            assert_close(found, Vec3::Y, depth, "sunk");
        }
        // A thin plate, which it reaches through.
        let thin = at(0.0, 0.0, 0.0).with_scale(Vec3::new(1.0, 0.1, 1.0));
        let found = contact((&slab(), thin), (solid, at(3.0, 0.2, 4.2)));
        assert_close(found, Vec3::Y, 0.3, "through");
        // Within, it touches no polygon.
        let small = Transform::from_xyz(3.0, -0.3, 4.2).with_scale(Vec3::splat(0.1));
        let found = contact((&slab(), at(0.0, 0.0, 0.0)), (solid, small));
        assert_close(found, Vec3::Y, 0.35, "within");
    }
}

/// A roof, and the same upside down: a valley.
#[test]
fn folds_have_normals_on_their_outer_side() {
    let corners = [
        [-4., -4., -4.],
        [-4., -4., 4.],
        [0., 0., -4.],
        [0., 0., 4.],
        [4., -4., -4.],
        [4., -4., 4.],
    ];
    let list = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
    let roof = triangles(&corners, &list);
    let backwards = triangles(&corners, &list.map(|[a, b, c]| [a, c, b]));
    for solid in [box_of(0.5, 0.5, 0.5), convex_cube(0.5)] {
        for roof in [&roof, &backwards] {
            let here = at(0.0, 0.0, 0.0);
            let found = contact((roof, here), (&solid, at(0.1, 0.45, 0.3)));
            assert_close(found, Vec3::Y, 0.05, "on the ridge");
            // Turned a little further than the ridge's normals go, were it flatter.
            let turned = Quat::from_rotation_z(0.3);
            let found = contact(
                (roof, here),
                (&solid, at(0.0, 0.45, 0.3).with_rotation(turned)),
            );
            let up = turned * Vec3::Y;
            assert_close(found, up, 0.5 - 0.45 * 0.3f32.cos(), "tilted");
            // Flat on one side, beyond the ridge.
            let side = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_4);
            let normal = side * Vec3::Y;
            let place = Transform::from_translation(normal * 0.45).with_rotation(side);
            assert_close(contact((roof, here), (&solid, place)), normal, 0.05, "flat");
            // In the valley, with its edge down, and beside its middle.
            let valley = here.with_scale(Vec3::new(1.0, -1.0, 1.0));
            let place = at(0.3, 0.7 + 0.2, 0.0);
            let found = contact((roof, valley), (&solid, place));
            let normal = Vec3::new(-1.0, 1.0, 0.0).normalize();
            let depth = -(Vec3::new(0.8, 0.4, 0.0).dot(normal));
            assert_close(found, normal, depth, "in the valley");
        }
    }
}

#[test]
fn a_cube_of_triangles_is_as_good_as_a_cuboid() {
    let cuboid = box_of(0.5, 0.5, 0.5);
    let cube = Transform::from_xyz(-4.0, 0.5, -4.0);
    let mut random = fastrand::Rng::with_seed(7);
    let mut unit = || random.f32() * 2.0 - 1.0;
    let (mut all, mut same) = (0, 0);
    for _ in 0..2000 {
        let turn = Quat::from_euler(
            bevy::math::EulerRot::XYZ,
            unit() * 3.0,
            unit() * 3.0,
            unit() * 3.0,
        );
        let place = Transform::from_xyz(unit() * 4.6, unit(), unit() * 4.6).with_rotation(turn);
        let whole = box_of(4.0, 0.5, 4.0);
        let tests = NarrowPhase::default();
        let (a, b) = (
            Placed::new(&whole, &Transform::IDENTITY),
            Placed::new(&cuboid, &place),
        );
        let Some(exact) = tests.contact(a, b, &mut Workspace::default()) else {
            continue;
        };
        for solid in [&cuboid, &convex_cube(0.5)] {
            let found = contact((&slab(), cube), (solid, place));
            all += 1;
            // The deepest ways out are those of polygons that are not in touch.
            if exact.depth < 0.5 {
                // Two cuboids prefer normals of faces by more.
                let off = exact.depth - found.depth;
                assert!(-1e-3 < off && off < 7e-3, "{place:?}: {found:?}, {exact:?}");
                same += 1;
            }
        }
    }
    assert!(same > all / 3, "{same} of {all}");
}

/// A ball of triangles, of which those in touch are a ring around the contact.
#[test]
fn a_mesh_of_small_triangles_is_as_deep_as_it_reaches() {
    let (vertices, list) = globe(16, 24, 1.0);
    let ball = Shape::mesh(vertices, list).unwrap();
    let here = at(0.0, 0.0, 0.0);
    for (name, floor) in [
        ("square", square()),
        ("downwards", square_downwards()),
        ("fan", fan()),
        ("slab", slab()),
        ("grid", grid(8, |_, _| 0.0)),
    ] {
        for depth in [0.01, 0.3] {
            let found = contact((&floor, here), (&ball, at(3.1, 1.0 - depth, 4.7)));
            assert_close(found, Vec3::Y, depth, name);
        }
    }
}

/// Which side is outside does not depend on how a shell is wound, nor on the others.
#[test]
fn shells_that_face_differently_each_know_their_outside() {
    let corner = |bits: u32| {
        [
            (bits & 1) as f32,
            (bits >> 1 & 1) as f32,
            (bits >> 2) as f32,
        ]
    };
    let sides = SIDES;
    let (mut vertices, mut list) = (Vec::new(), Vec::new());
    for (shell, backwards) in [(0u32, false), (1, true), (2, false)] {
        let first = vertices.len() as u32;
        vertices.extend((0..8).map(|bits| {
            let [x, y, z] = corner(bits);
            Vec3::new(x + 3.0 * shell as f32, y, z)
        }));
        for mut side in sides {
            if backwards {
                side.reverse();
            }
            list.push(side.map(|corner| corner + first));
        }
    }
    // A flag, which bounds nothing.
    let first = vertices.len() as u32;
    vertices.extend([
        Vec3::new(9.0, 1.0, 0.0),
        Vec3::new(11.0, 1.0, 0.0),
        Vec3::new(9.0, 1.0, 2.0),
    ]);
    let mut list: Vec<Vec<u32>> = list.iter().map(|side| side.to_vec()).collect();
    list.push(vec![first, first + 1, first + 2]);
    let mesh = Shape::mesh(vertices, list).unwrap();
    for solid in [
        box_of(0.2, 0.2, 0.2),
        convex_cube(0.2),
        mesh_of(Vec3::splat(0.2)),
    ] {
        for x in [0.4, 3.4, 6.4, 9.4] {
            // Deeper than half of it, where that is a way into a solid.
            let (y, depth) = if x > 9.0 { (1.1, 0.1) } else { (0.9, 0.3) };
            let found = contact((&mesh, at(0.0, 0.0, 0.0)), (&solid, at(x, y, 0.4)));
            assert_close(found, Vec3::Y, depth, &format!("at {x}"));
        }
    }
}

/// As small as rounding is at the size of the ground: the centre is as good as on it.
#[test]
fn a_ball_with_its_centre_on_the_surface_leaves_to_its_side() {
    let large = at(0.0, 0.0, 0.0).with_scale(Vec3::splat(1000.0));
    let ball = Shape::sphere(1e-3);
    for floor in [square(), square_downwards()] {
        for side in [1.0, -1.0] {
            let found = contact((&floor, large), (&ball, at(3000.0, side * 5e-4, 2000.0)));
            assert_eq!(found.normal, Vec3::Y * side);
        }
    }
    // Wound inwards: outwards is out all the same.
    let corner = |bits: u32| {
        [
            (bits & 1) as f32,
            (bits >> 1 & 1) as f32,
            (bits >> 2) as f32,
        ]
    };
    let corners: Vec<_> = (0..8).map(corner).map(Vec3::from).collect();
    let sides = [
        [1, 3, 2, 0],
        [6, 7, 5, 4],
        [4, 5, 1, 0],
        [3, 7, 6, 2],
        [2, 6, 4, 0],
        [5, 7, 3, 1],
    ];
    let inside_out = Shape::mesh(corners, sides).unwrap();
    let found = contact(
        (&inside_out, at(0.0, 0.0, 0.0)),
        (&Shape::sphere(0.1), at(0.4, 1.0, 0.6)),
    );
    assert_eq!(found.normal, Vec3::Y);
}

/// Polygons, each with vertices of its own.
fn unwelded(polygons: &[Vec<[f32; 3]>]) -> Shape {
    let vertices: Vec<_> = polygons.iter().flatten().copied().map(Vec3::from).collect();
    let mut next = 0;
    let number = |polygon: &Vec<[f32; 3]>| {
        next += polygon.len() as u32;
        (next - polygon.len() as u32..next).collect::<Vec<_>>()
    };
    let lists: Vec<_> = polygons.iter().map(number).collect();
    Shape::mesh(vertices, lists).unwrap()
}

/// From one x to another, with normals upwards.
fn tile([from, to]: [f32; 2], [near, far]: [f32; 2]) -> Vec<[f32; 3]> {
    let corners = [[from, near], [from, far], [to, far], [to, near]];
    corners.map(|[x, z]| [x, 0.0, z]).to_vec()
}

/// Two cuboids of polygons side by side.
fn bricks() -> Shape {
    let mut vertices = Vec::new();
    let mut lists = Vec::new();
    for from in [-2.0, 0.0] {
        let first = vertices.len() as u32;
        vertices.extend((0..8).map(|bits: u32| {
            let [x, y, z] = [bits & 1, bits >> 1 & 1, bits >> 2].map(|bit| bit as f32);
            Vec3::new(from + 2.0 * x, y - 1.0, 4.0 * z - 2.0)
        }));
        lists.extend(SIDES.map(|side| side.map(|vertex| vertex + first)));
    }
    Shape::mesh(vertices, lists).unwrap()
}

#[test]
fn a_floor_goes_on_over_seams_that_share_no_vertices() {
    let (wide, narrow) = ([-2.0, 2.0], [-2.0, 0.13]);
    let floors = [
        (
            "tiles",
            unwelded(&[tile([-2., 0.], wide), tile([0., 2.], wide)]),
        ),
        (
            "a long side against two",
            unwelded(&[
                tile([-2., 0.], wide),
                tile([0., 2.], narrow),
                tile([0., 2.], [0.13, 2.0]),
            ]),
        ),
        ("bricks", bricks()),
    ];
    let solids = [
        ("cuboid", box_of(0.5, 0.5, 0.5)),
        ("convex", convex_cube(0.5)),
        ("mesh", mesh_of(Vec3::splat(0.5))),
    ];
    let height = 0.5f32.sqrt() - 0.001;
    for (name, floor) in &floors {
        for (solid_name, solid) in &solids {
            for (x, z, yaw) in [
                (0.0, 0.2, 0.0),
                (0.0, 0.2, 0.3),
                (0.0, 0.5, 1.2),
                (0.0003, -0.4, 0.0),
                (-0.0003, 0.0, 0.0),
            ] {
                let turn =
                    Quat::from_rotation_y(yaw) * Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
                let place = at(x, height, z).with_rotation(turn);
                let found = contact((floor, at(0.0, 0.0, 0.0)), (solid, place));
                assert_close(
                    found,
                    Vec3::Y,
                    0.001,
                    &format!("{solid_name} on {name}, {x} {yaw}"),
                );
            }
        }
    }
}

/// A ball of triangles, by latitude and longitude.
fn globe(bands: u32, around: u32, radius: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices = vec![Vec3::Y * radius];
    for band in 1..bands {
        for step in 0..around {
            let t = band as f32 / bands as f32 * std::f32::consts::PI;
            let p = step as f32 / around as f32 * std::f32::consts::TAU;
            vertices.push(Vec3::new(t.sin() * p.cos(), t.cos(), t.sin() * p.sin()) * radius);
        }
    }
    vertices.push(Vec3::NEG_Y * radius);
    let last = vertices.len() as u32 - 1;
    let vertex = |band: u32, step: u32| 1 + (band - 1) * around + step % around;
    let mut list = Vec::new();
    for step in 0..around {
        list.push([0, vertex(1, step + 1), vertex(1, step)]);
        list.push([last, vertex(bands - 1, step), vertex(bands - 1, step + 1)]);
        for band in 1..bands - 1 {
            let [a, b] = [vertex(band, step), vertex(band, step + 1)];
            let [c, d] = [vertex(band + 1, step), vertex(band + 1, step + 1)];
            list.extend([[a, b, c], [b, d, c]]);
        }
    }
    (vertices, list)
}

#[test]
fn nothing_around_a_corner_is_higher() {
    let flat = grid(12, |_, _| 0.0);
    let (vertices, list) = globe(5, 10, 0.5);
    let ball = Shape::convex(vertices, list).unwrap();
    let mirrored = Vec3::new(0.83, -1.0, 0.83);
    for scale in [mirrored, Vec3::new(0.83, 1.0, 0.83)] {
        for step in 0..200 {
            let [x, z] = [0.37, 0.53].map(|by| 2.0 + (step as f32 * by) % 5.0);
            let floor = at(0.0, 0.0, 0.0).with_scale(scale);
            let found = contact((&flat, floor), (&ball, at(x, -0.1, z)));
            assert_close(found, Vec3::NEG_Y, 0.4, &format!("{scale} {x} {z}"));
        }
    }
}

#[test]
fn what_only_just_touches_is_hardly_deep() {
    // Far from the middle of a wide floor, where rounding is as much as a share of the tolerance.
    let hills = grid(60, |x, z| 0.4 * (x * 1.3).sin() * (z * 0.9).cos());
    let wide = at(0.0, 0.0, 0.0).with_scale(Vec3::new(4.0, 1.0, 4.0));
    let brick = box_of(1.0, 0.6, 0.8);
    let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
    let mut met = 0;
    for step in 0..4000 {
        let [x, z, turn] = [0.37, 0.53, 0.71].map(|by| (step as f32 * by).fract());
        let above = at(180.0 + 50.0 * x, 2.0, 180.0 + 50.0 * z)
            .with_rotation(Quat::from_scaled_axis(Vec3::new(turn, x, -z) * 3.0));
        let ground = Placed::new(&hills, &wide);
        let down = bevy::math::Dir3::NEG_Y;
        let fall = tests.sweep(
            Placed::new(&brick, &above),
            down,
            9.0,
            ground,
            &mut workspace,
        );
        let Some(fall) = fall else { continue };
        // Higher than where it comes to lie, by about the tolerance.
        let height = 1e-4 + 2e-4 * turn;
        let mut there = above;
        there.translation.y -= fall.distance - height;
        let touching = tests.contact(Placed::new(&brick, &there), ground, &mut workspace);
        if let Some(contact) = touching {
            met += 1;
            assert!(contact.depth < 1e-3, "{there:?} {contact:?}");
        }
    }
    assert!(met > 400, "{met}");
}
