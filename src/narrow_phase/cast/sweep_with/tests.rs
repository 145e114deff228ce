//! Shapes that go on from what they touch.

use bevy::math::{Dir3, Quat, Vec3};
use bevy::transform::components::Transform;

use crate::narrow_phase::shape::Kind;
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

const IGNORE: ShapeCastOptions = ShapeCastOptions::DEFAULT.ignore_start();

/// A floor of `2 n²` triangles at y = 0, from -5 to 5, with a wall at x = 4; open, or with a
/// bottom and sides.
fn level(n: u32, solid: bool) -> Shape {
    let side = n + 1;
    let at = |i: u32| i as f32 * 10.0 / n as f32 - 5.0;
    let mut corners: Vec<_> = (0..side * side)
        .map(|i| Vec3::new(at(i % side), 0.0, at(i / side)))
        .collect();
    let mut polygons: Vec<Vec<u32>> = (0..n * n)
        .flat_map(|i| {
            let (x, z) = (i % n, i / n);
            let [a, b, c, d] =
                [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(k, l)| (z + l) * side + x + k);
            [vec![a, b, c], vec![a, c, d]]
        })
        .collect();
    let first = corners.len() as u32;
    if solid {
        // Below the floor, a box with the floor's border as its top.
        corners.extend(
            [(-5., -5.), (5., -5.), (5., 5.), (-5., 5.)].map(|(x, z)| Vec3::new(x, -1.0, z)),
        );
        let border =
            |from: u32, step: i64| (0..=n as i64).map(move |i| (i64::from(from) + i * step) as u32);
        let last = side * side - 1;
        let sides = [
            (border(0, 1).collect::<Vec<_>>(), [1, 0]),
            (border(n, i64::from(side)).collect(), [2, 1]),
            (border(last, -1).collect(), [3, 2]),
            (border(last - n, -i64::from(side)).collect(), [0, 3]),
        ];
        for (top, bottom) in sides {
            polygons.push(top.into_iter().chain(bottom.map(|i| first + i)).collect());
        }
        polygons.push(vec![first, first + 1, first + 2, first + 3]);
    } else {
        corners
            .extend([(0., -5.), (3., -5.), (3., 5.), (0., 5.)].map(|(y, z)| Vec3::new(4.0, y, z)));
        polygons.push(vec![first, first + 1, first + 2, first + 3]);
    }
    Shape::mesh(corners, polygons).unwrap()
}

/// What stands on y = 0 with its centre half a unit above.
fn movers() -> Vec<Shape> {
    let mut movers = vec![
        box_of(0.5, 0.5, 0.5),
        Shape::sphere(0.5),
        mesh_of(Vec3::splat(0.5)),
    ];
    let cube = mesh_of(Vec3::splat(0.5));
    let (mesh, _) = cube.polygons().unwrap();
    let polygons = mesh.polygons().map(<[u32]>::to_vec);
    movers.push(Shape::convex(mesh.vertices(), polygons).unwrap());
    #[cfg(feature = "rapier")]
    {
        use bevy_rapier3d::geometry::Collider;
        let capsule = Collider::capsule(Vec3::Y * -0.2, Vec3::Y * 0.2, 0.3);
        movers.push(Shape::from(&capsule));
        movers.push(Shape::from(&Collider::cylinder(0.5, 0.5)));
    }
    movers
}

fn is_near(hit: Option<Impact>, distance: f32) -> bool {
    hit.is_some_and(|hit| (hit.distance - distance).abs() < 2e-3)
}

#[test]
fn along_a_floor_to_its_wall() {
    let tests = NarrowPhase::default();
    let workspace = &mut Workspace::default();
    let turns = [
        Quat::IDENTITY,
        Quat::from_rotation_y(0.6) * Quat::from_rotation_x(0.4),
    ];
    for (n, turn) in [(1, turns[0]), (3, turns[1]), (20, turns[0]), (20, turns[1])] {
        let open = level(n, false);
        for mover in movers() {
            let reach = match &mover {
                #[cfg(feature = "rapier")]
                Shape::Rapier(shape) => shape.raw().compute_local_aabb().half_extents().x,
                _ => 0.5,
            };
            // Just touching, a little above, and a little too deep.
            for lift in [0.0, 5e-5, -1e-3] {
                let place = at(2.0, 1.0, -3.0).with_rotation(turn);
                let here = Vec3::new(0.3, 0.5 + lift, 0.17);
                let here = Transform::from_translation(place * here).with_rotation(turn);
                let (moving, target) = (Placed::new(&mover, &here), Placed::new(&open, &place));
                let mut cast = |way: Vec3| {
                    let way = Dir3::new(turn * way).unwrap();
                    tests.sweep_with(moving, way, 10.0, target, &IGNORE, workspace)
                };
                let text = format!("{n} {lift} {mover:?}");
                assert!(
                    is_near(cast(Vec3::X), 3.7 - reach),
                    "{:?} {text}",
                    cast(Vec3::X)
                );
                for way in [
                    Vec3::NEG_X,
                    Vec3::Z,
                    Vec3::NEG_Z,
                    Vec3::Y,
                    Vec3::new(-1.0, 0.2, 0.3),
                ] {
                    assert_eq!(cast(way), None, "{way} {text}");
                }
                for way in [Vec3::NEG_Y, Vec3::new(1.0, -0.1, 0.3)] {
                    let hit = cast(way).unwrap();
                    assert!(
                        hit.distance == 0.0 && hit.normal.distance(turn * Vec3::Y) < 2e-2,
                        "{hit:?} {text}"
                    );
                }
                // Up and towards the wall.
                let hit = cast(Vec3::new(1.0, 0.1, 0.0));
                assert!(
                    is_near(hit, (3.7 - reach) * 1.01f32.sqrt()),
                    "{hit:?} {text}"
                );
            }
        }
    }
}

#[test]
fn off_and_along_solids() {
    let tests = NarrowPhase::default();
    let workspace = &mut Workspace::default();
    let below = at(0.0, 0.0, 0.0);
    let brick = box_of(5.0, 1.0, 5.0);
    let under = at(0.0, -1.0, 0.0);
    let solid = level(8, true);
    for mover in movers()
        .into_iter()
        .filter(|mover| !matches!(mover, Shape::Mesh(_)))
    {
        for (target, place) in [
            (&solid, &below),
            (&brick, &under),
            (&mesh_of(Vec3::new(5.0, 1.0, 5.0)), &under),
        ] {
            for lift in [0.0, -1e-3] {
                let here = at(0.3, 0.5 + lift, 0.17);
                let (moving, target) = (Placed::new(&mover, &here), Placed::new(target, place));
                let mut cast = |way: Vec3, options| {
                    tests.sweep_with(
                        moving,
                        Dir3::new(way).unwrap(),
                        10.0,
                        target,
                        options,
                        workspace,
                    )
                };
                for way in [Vec3::X, Vec3::NEG_Z, Vec3::Y, Vec3::new(1.0, 0.2, 0.3)] {
                    assert_eq!(cast(way, &IGNORE), None, "{way} {lift} {moving:?}");
                    assert!(
                        cast(way, &ShapeCastOptions::DEFAULT)
                            .is_some_and(|hit| hit.distance == 0.0)
                    );
                }
                let down = cast(Vec3::NEG_Y, &IGNORE).unwrap();
                assert!(
                    down.distance == 0.0 && down.face_normal.distance(Vec3::Y) < 1e-2,
                    "{down:?}"
                );
                assert!((down.depth + lift).abs() < 1e-3, "{down:?}");
            }
        }
    }
}

#[test]
fn what_is_ahead_is_met_as_far_as_it_is() {
    // From one of two sheets to the other, straight up.
    let square =
        |y: f32| [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(|(x, z)| Vec3::new(x, y, z));
    let corners = [square(0.0), square(3.0)].concat();
    let sheets = Shape::mesh(corners, [[0, 1, 2, 3], [4, 5, 6, 7]]).unwrap();
    let (tests, here) = (NarrowPhase::default(), Transform::IDENTITY);
    let workspace = &mut Workspace::default();
    for mover in movers() {
        let start = at(0.1, 0.5, 0.0);
        let moving = Placed::new(&mover, &start);
        let options = IGNORE.find_polygon();
        let mut cast = |length| {
            tests.sweep_with(
                moving,
                Dir3::Y,
                length,
                Placed::new(&sheets, &here),
                &options,
                workspace,
            )
        };
        let hit = cast(9.0);
        assert!(
            hit.is_some_and(|hit| (hit.distance - 2.0).abs() < 1e-5),
            "{hit:?} {mover:?}"
        );
        if mover.kind() != Kind::Foreign {
            assert_eq!(hit.unwrap().polygon, Some(1));
        }
        assert_eq!(cast(1.99), None);
    }
}

#[test]
fn shapes_name_the_polygon_that_they_meet() {
    let tests = NarrowPhase::default();
    let workspace = &mut Workspace::default();
    for n in [2, 20] {
        let shape = level(n, false);
        let (mesh, _) = shape.polygons().unwrap();
        let place = at(1.0, 2.0, 3.0)
            .with_scale(Vec3::new(-1.5, 1.0, 0.5))
            .with_rotation(Quat::from_rotation_z(0.3));
        let target = Placed::new(&shape, &place);
        for (polygon, corners) in mesh.polygons().enumerate() {
            let middle = corners
                .iter()
                .map(|corner| mesh.vertices()[*corner as usize])
                .sum::<Vec3>()
                / corners.len() as f32;
            let normal = place.rotation * (mesh.normals()[polygon] / place.scale).normalize();
            let start = at(0.0, 0.0, 0.0).with_translation(place * middle + normal * 0.02);
            let ball = Shape::sphere(0.01);
            let way = Dir3::new(-normal).unwrap();
            let options = ShapeCastOptions::DEFAULT.find_polygon();
            let hit = tests
                .sweep_with(
                    Placed::new(&ball, &start),
                    way,
                    1.0,
                    target,
                    &options,
                    workspace,
                )
                .unwrap();
            assert_eq!(hit.polygon, Some(polygon as u32));
            assert!(hit.face_normal.distance(normal) < 1e-4 && !hit.is_back_face());
            let start = start.with_translation(place * middle - normal * 0.02);
            let behind = tests
                .sweep_with(
                    Placed::new(&ball, &start),
                    -way,
                    1.0,
                    target,
                    &options,
                    workspace,
                )
                .unwrap();
            assert!(behind.polygon == hit.polygon && behind.is_back_face());
        }
    }
}
