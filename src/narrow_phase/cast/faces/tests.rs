//! What rays meet by their options, and what they pass through, against all faces one by one.

use bevy::math::{DVec3, Dir3, Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;

use crate::narrow_phase::cast::tests::{distance, large, placed, vectors};
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

const DEFAULT: RayCastOptions = RayCastOptions::DEFAULT;

fn all() -> impl Strategy<Value = (Shape, Transform)> {
    prop_oneof![
        placed(),
        (placed(), prop::sample::select(large().to_vec())).prop_map(|((_, at), shape)| (shape, at))
    ]
}

fn directions() -> impl Strategy<Value = Dir3> {
    vectors(1.0).prop_filter_map("no direction", |v| Dir3::new(v).ok())
}

/// A face that the line of a ray crosses.
#[derive(Clone, Copy, Debug)]
struct Crossed {
    distance: f64,
    polygon: u32,
    normal: DVec3,
    /// How surely its border is left to one side.
    surely: f64,
}

/// All of them, ahead and behind, by what the polygons are in the world.
fn crossed(shape: &Shape, transform: &Transform, origin: Vec3, direction: Dir3) -> Vec<Crossed> {
    let Some((mesh, size)) = shape.polygons() else {
        return vec![];
    };
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let scale = (Vec3::from(size) * transform.scale).as_dvec3();
    let turn = transform.rotation.as_dquat().normalize();
    let place = |vertex: &u32| {
        turn * (mesh.vertices()[*vertex as usize].as_dvec3() * scale)
            + transform.translation.as_dvec3()
    };
    let mirrored = scale.element_product().signum();
    let mut found = vec![];
    for (polygon, corners) in mesh.polygons().enumerate() {
        let corners: Vec<_> = corners.iter().map(place).collect();
        let area: DVec3 = corners[1..]
            .windows(2)
            .map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]))
            .sum();
        let normal = area.normalize() * mirrored;
        let distance = normal.dot(corners[0] - origin) / normal.dot(direction);
        let point = origin + direction * distance;
        // The angle by which the border is seen to go around it.
        let (mut angle, mut surely) = (0.0, f64::INFINITY);
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (u, v) = (*a - point, *b - point);
            angle += u.cross(v).dot(normal).atan2(u.dot(v));
            surely = surely.min(((*b - *a).cross(u).length() / (*b - *a).length()).abs());
        }
        if angle.abs() > std::f64::consts::PI && distance.is_finite() {
            found.push(Crossed {
                distance,
                polygon: polygon as u32,
                normal,
                surely,
            });
        }
    }
    found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    found
}

/// Is nothing near an edge, or the start?
fn is_sure(crossed: &[Crossed], direction: Dir3) -> bool {
    crossed.iter().all(|face| {
        let steep = face.normal.dot(direction.as_dvec3()).abs();
        face.distance.abs() > 1e-3 && face.surely > 1e-3 && steep > 1e-3
    })
}

fn is_solid(shape: &Shape) -> bool {
    match shape {
        Shape::Mesh(mesh) => mesh.has_inside(),
        _ => true,
    }
}

fn is_same(hit: Option<Impact>, face: Option<&Crossed>) -> bool {
    match (hit, face) {
        (None, None) => true,
        (Some(hit), Some(face)) => {
            let polygon = hit.polygon.is_none_or(|polygon| polygon == face.polygon);
            (f64::from(hit.distance) - face.distance).abs() < 1e-4
                && hit.face_normal.as_dvec3().distance(face.normal) < 1e-3
                && polygon
        }
        _ => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 2048, ..ProptestConfig::default() })]

    /// Front, back and hollow casts are those of all faces one by one.
    #[test]
    fn faces_are_those_of_brute_force((shape, transform) in all(), origin in vectors(2.5), direction in directions()) {
        let faces = crossed(&shape, &transform, origin, direction);
        prop_assume!(shape.polygons().is_some() && is_sure(&faces, direction));
        let (tests, target) = (NarrowPhase::default(), Placed::new(&shape, &transform));
        let cast = |options| tests.cast_ray_with(target, origin, direction, f32::MAX, &options);
        let steep = |face: &Crossed| face.normal.dot(direction.as_dvec3());
        let ahead = || faces.iter().filter(|face| face.distance > 0.0);
        let front = || ahead().find(|face| steep(face) < 0.0);
        let starts_inside = is_solid(&shape) && cast(DEFAULT).is_some_and(|hit| hit.distance == 0.0);
        for (options, expected) in [
            (DEFAULT.hollow(), ahead().next()),
            (DEFAULT.back_faces(), ahead().find(|face| steep(face) > 0.0)),
            (DEFAULT.hollow().front_faces(), front()),
            (DEFAULT.ignore_start().hollow(), ahead().next()),
        ] {
            let hit = cast(options);
            prop_assert!(is_same(hit, expected), "{options:?} {hit:?} {expected:?}");
            let is_back = expected.is_some_and(|face| steep(face) > 0.0);
            prop_assert_eq!(hit.is_some_and(|hit| hit.is_back_face()), is_back);
        }
        if starts_inside {
            let inside = cast(DEFAULT).unwrap();
            prop_assert_eq!(cast(DEFAULT.front_faces()), Some(inside));
            prop_assert_eq!(cast(DEFAULT.ignore_start()), Some(inside));
        } else {
            prop_assert!(is_same(cast(DEFAULT), ahead().next()));
            prop_assert!(is_same(cast(DEFAULT.front_faces()), front()));
            prop_assert!(is_same(cast(DEFAULT.ignore_start()), ahead().next()));
        }
    }

    /// A ray leaves a solid where the walls that it crosses have cancelled out.
    #[test]
    fn passages_are_those_of_brute_force((shape, transform) in all(), origin in vectors(2.5), direction in directions()) {
        let faces = crossed(&shape, &transform, origin, direction);
        prop_assume!(shape.polygons().is_some() && is_sure(&faces, direction));
        let (tests, target) = (NarrowPhase::default(), Placed::new(&shape, &transform));
        let passage = tests.cast_ray_through(target, origin, direction, f32::MAX);
        let ahead: Vec<_> = faces.iter().filter(|face| face.distance > 0.0).collect();
        let sign = |face: &Crossed| if face.normal.dot(direction.as_dvec3()) < 0.0 { 1 } else { -1 };
        let mut winding = -ahead.iter().map(|face| sign(face)).sum::<i32>();
        let (mut enter, mut leave) = (None, None);
        let is_inside = is_solid(&shape) && winding != 0;
        if is_solid(&shape) {
            for face in &ahead {
                let was = winding;
                winding += sign(face);
                if was == 0 && enter.is_none() {
                    enter = Some(*face);
                } else if winding == 0 && leave.is_none() {
                    leave = Some(*face);
                    break;
                }
            }
        } else {
            enter = ahead.first().copied();
        }
        if enter.is_none() && !is_inside {
            prop_assert_eq!(passage, None);
        } else {
            let passage = passage.unwrap();
            prop_assert!(is_same(passage.enter, enter), "{passage:?} {enter:?}");
            prop_assert!(is_same(passage.leave, leave), "{passage:?} {leave:?}");
        }
    }

    /// Convex shapes, Rapier's among them: inside between the two ends, and outside beyond.
    #[test]
    fn ends_of_passages_are_on_the_border((shape, transform) in placed(), origin in vectors(2.5), direction in directions()) {
        let is_one = matches!(shape.kind(), shape::Kind::Foreign | shape::Kind::Sphere);
        let (tests, target) = (NarrowPhase::default(), Placed::new(&shape, &transform));
        let Some(passage) = tests.cast_ray_through(target, origin, direction, 20.0).filter(|_| is_one) else {
            return Ok(());
        };
        let leave = passage.leave.unwrap();
        let start = passage.enter.map_or(0.0, |enter| enter.distance);
        prop_assert_eq!(passage.length(), Some(leave.distance - start));
        let away = |t: f32| distance(target, origin + direction * t);
        prop_assert!(away(leave.distance + 0.01) > 0.0 && away(leave.distance) < 1e-3, "{passage:?}");
        prop_assert!(away(start.midpoint(leave.distance)) < 1e-3);
        prop_assert!(leave.face_normal.dot(*direction) > -1e-3 && leave.is_back_face());
        let back = tests.cast_ray_with(target, origin, direction, 20.0, &DEFAULT.back_faces()).unwrap();
        prop_assert!((back.distance - leave.distance).abs() < 1e-4 && back.face_normal.distance(leave.face_normal) < 0.05);
        if passage.enter.is_none() {
            let hollow = tests.cast_ray_with(target, origin, direction, 20.0, &DEFAULT.hollow()).unwrap();
            prop_assert!((hollow.distance - leave.distance).abs() < 1e-4);
        }
    }

    /// From where a ray met something, reflected, it goes on to what is beyond, and not to where it
    /// is; along a flat face, too.
    #[test]
    fn reflected_rays_leave_what_they_met((shape, transform) in all(), origin in vectors(5.0), direction in directions()) {
        let (tests, target) = (NarrowPhase::default(), Placed::new(&shape, &transform));
        let Some(hit) = tests.cast_ray(target, origin, direction, 20.0).filter(|hit| hit.distance > 0.1) else {
            return Ok(());
        };
        let faces = crossed(&shape, &transform, origin, direction);
        prop_assume!(faces.iter().all(|face| face.surely > 1e-3 && face.normal.dot(direction.as_dvec3()).abs() > 1e-2));
        let from_there = |direction: Vec3, options| {
            tests.cast_ray_with(target, hit.point, Dir3::new(direction).unwrap(), 20.0, &options)
        };
        let reflected = direction.reflect(hit.normal);
        // What rounding leaves across is a large share of what is left of a steep direction: twice.
        let reject = |direction: Dir3| Dir3::new(direction.reject_from_normalized(hit.normal));
        let along = reject(direction).and_then(reject);
        for options in [DEFAULT, DEFAULT.hollow(), DEFAULT.front_faces()] {
            // From behind, loose polygons are gone into.
            if options == DEFAULT.front_faces() && hit.is_back_face() {
                continue;
            }
            let next = from_there(reflected, options.ignore_start());
            prop_assert!(next.is_none_or(|next| next.distance > 1e-3), "LOOK {next:?} {hit:?} line {}", line!());
        }
        if matches!(shape, Shape::Cuboid { .. } | Shape::Convex(_) | Shape::Sphere { .. }) {
            let next = from_there(reflected, DEFAULT.ignore_start());
            prop_assert_eq!(next, None);
        }
        if let Ok(along) = along && shape.polygons().is_some() {
            let next = from_there(*along, DEFAULT.ignore_start());
            prop_assert!(next.is_none_or(|next| next.distance > 1e-3), "LOOK {next:?} {hit:?} line {}", line!());
        }
        // Further in, it is there, if it is a solid.
        if is_solid(&shape) {
            let next = from_there(*direction, DEFAULT.ignore_start());
            prop_assert!(next.is_some_and(|next| next.distance < 1e-4), "{next:?}");
        }
        // A polygon that bounds none is behind.
        else {
            let next = from_there(*direction, DEFAULT.ignore_start());
            prop_assert!(next.is_none_or(|next| next.distance > 1e-3), "LOOK {next:?} {hit:?} line {}", line!());
        }
    }
}

/// In a room made of one box, of which floor and walls are.
#[test]
fn along_a_floor_to_the_wall() {
    // An L: what is under y = 0, and what is behind x = 0, wound both ways.
    let outline = [
        [-1., 1.],
        [-1., -1.],
        [2., -1.],
        [2., 0.],
        [0., 0.],
        [0., 1.],
    ];
    let level = |z: f32| outline.iter().map(move |&[x, y]| Vec3::new(x, y, z));
    let mut sides = vec![vec![5u32, 4, 3, 2, 1, 0], vec![6, 7, 8, 9, 10, 11]];
    sides.extend((0..6).map(|i| vec![i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6]));
    let corners: Vec<_> = level(-1.0).chain(level(1.0)).collect();
    let inverted = sides
        .iter()
        .map(|side| side.iter().rev().copied().collect());
    let (inverted, tests) = (inverted.collect::<Vec<Vec<_>>>(), NarrowPhase::default());
    let turns = [
        Quat::IDENTITY,
        Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.4),
    ];
    for (sides, turn) in [
        (&sides, turns[0]),
        (&sides, turns[1]),
        (&inverted, turns[1]),
    ] {
        let shape = Shape::mesh(corners.clone(), sides).unwrap();
        let place = at(3.0, -2.0, 1.0).with_rotation(turn);
        let cast = |from: Vec3, way: Vec3| {
            let direction = Dir3::new(turn * way).unwrap();
            let options = DEFAULT.ignore_start();
            let hit = tests.cast_ray_with(
                Placed::new(&shape, &place),
                place * from,
                direction,
                10.0,
                &options,
            );
            hit.map(|hit| (hit.distance, turn.inverse() * hit.face_normal))
        };
        let is = |hit: Option<(f32, Vec3)>, distance: f32| {
            assert!(
                hit.is_some_and(|hit| (hit.0 - distance).abs() < 1e-5),
                "{hit:?} not {distance}"
            );
        };
        // Along the floor: to the wall, or away; into it, at once; up, away.
        let floor = Vec3::new(1.0, 0.0, 0.1);
        is(cast(floor, Vec3::NEG_X), 1.0);
        assert_eq!(cast(floor, Vec3::X), None);
        assert_eq!(cast(floor, Vec3::new(1.0, 1.0, 0.2)), None);
        is(cast(floor, Vec3::new(1.0, -0.01, 0.0)), 0.0);
        is(cast(floor, Vec3::new(-1.0, 0.5, 0.0)), 1.25f32.sqrt());
        // In the corner, into one of the two, or along both.
        let corner = Vec3::ZERO;
        for way in [
            Vec3::NEG_X,
            Vec3::NEG_Y,
            Vec3::new(1.0, -0.1, 0.0),
            Vec3::new(-1.0, 0.1, 0.0),
        ] {
            is(cast(corner, way), 0.0);
        }
        for way in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE] {
            assert_eq!(cast(corner, way), None, "{way}");
        }
        // On the edge at the end of the floor: away, along either face, and in between.
        let edge = Vec3::new(2.0, 0.0, 0.0);
        for way in [
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
            Vec3::NEG_Y,
            Vec3::new(1.0, -1.0, 0.0),
        ] {
            assert_eq!(cast(edge, way), None, "{way}");
        }
        is(cast(edge, Vec3::NEG_X), 2.0);
        is(cast(edge, Vec3::new(-1.0, -1.0, 0.0)), 0.0);
        // Inside, all is met at once.
        is(cast(Vec3::new(1.0, -0.5, 0.0), Vec3::Y), 0.0);
    }
}

#[test]
fn loose_ground_is_left_on_either_side_or_met_from_above() {
    let [_, sheet] = large();
    let (tests, here) = (NarrowPhase::default(), Transform::IDENTITY);
    let target = Placed::new(&sheet, &here);
    let down = |from: Vec3, options| tests.cast_ray_with(target, from, Dir3::NEG_Y, 5.0, &options);
    let hit = down(Vec3::new(0.03, 2.0, 0.05), DEFAULT).unwrap();
    assert!(hit.face_normal.y > 0.0 && !hit.is_back_face());
    assert_eq!(down(hit.point, DEFAULT).map(|hit| hit.distance), Some(0.0));
    assert_eq!(down(hit.point, DEFAULT.ignore_start()), None);
    let from_above = down(hit.point, DEFAULT.ignore_start().front_faces()).unwrap();
    assert_eq!(
        (from_above.distance, from_above.polygon),
        (0.0, hit.polygon)
    );
    assert_eq!(down(hit.point, DEFAULT.ignore_start().back_faces()), None);
    // Mirrored, the same side is the front.
    let mirrored = Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let front = |options| {
        tests.cast_ray_with(
            Placed::new(&sheet, &mirrored),
            Vec3::Y,
            Dir3::NEG_Y,
            5.0,
            &options,
        )
    };
    assert!(front(DEFAULT.front_faces()).is_some_and(|hit| hit.face_normal.y > 0.0));
    assert_eq!(front(DEFAULT.back_faces()), None);
}

#[test]
fn shells_that_overlap_are_left_as_one() {
    let cubes = [0.0, 1.0].map(|x| {
        mesh_of(Vec3::ONE)
            .polygons()
            .map(|(mesh, _)| {
                let moved: Vec<_> = mesh
                    .vertices()
                    .iter()
                    .map(|corner| *corner + Vec3::X * x)
                    .collect();
                (
                    moved,
                    mesh.polygons().map(<[u32]>::to_vec).collect::<Vec<_>>(),
                )
            })
            .unwrap()
    });
    let corners: Vec<_> = cubes
        .iter()
        .flat_map(|(corners, _)| corners.clone())
        .collect();
    let polygons = cubes.iter().enumerate().flat_map(|(i, (_, polygons))| {
        polygons.iter().map(move |polygon| {
            polygon
                .iter()
                .map(|corner| corner + 8 * i as u32)
                .collect::<Vec<_>>()
        })
    });
    let both = Shape::mesh(corners, polygons).unwrap();
    let (tests, here) = (NarrowPhase::default(), Transform::IDENTITY);
    let target = Placed::new(&both, &here);
    let through = |x: f32| {
        tests
            .cast_ray_through(target, Vec3::new(x, 0.2, 0.1), Dir3::X, 100.0)
            .unwrap()
    };
    let ends =
        |passage: Passage| [passage.enter, passage.leave].map(|end| end.map(|end| end.distance));
    assert_eq!(ends(through(-5.0)), [Some(4.0), Some(7.0)]);
    assert_eq!(ends(through(0.5)), [None, Some(1.5)]);
    assert_eq!(ends(through(-1.0)), [Some(0.0), Some(3.0)]);
    assert_eq!(ends(through(2.0)), [Some(0.0), Some(0.0)]);
    // Through edges and corners.
    let along_edges = tests
        .cast_ray_through(target, Vec3::new(-5.0, 1.0, 1.0), Dir3::X, 100.0)
        .unwrap();
    assert_eq!(ends(along_edges)[0], Some(4.0));
    let diagonal = tests
        .cast_ray_through(
            target,
            Vec3::splat(-3.0),
            Dir3::new(Vec3::ONE).unwrap(),
            100.0,
        )
        .unwrap();
    assert!(
        diagonal
            .length()
            .is_some_and(|length| (length - 12f32.sqrt()).abs() < 1e-5)
    );
    // The wall inside is a wall to faces.
    let back = tests.cast_ray_with(
        target,
        Vec3::new(-5.0, 0.2, 0.1),
        Dir3::X,
        100.0,
        &DEFAULT.back_faces(),
    );
    assert_eq!(back.map(|hit| hit.distance), Some(6.0));
}

#[test]
fn solids_from_on_their_border() {
    let (tests, here) = (NarrowPhase::default(), at(1.0, 2.0, 3.0));
    for solid in [
        box_of(1.0, 1.0, 1.0),
        Shape::sphere(1.0),
        mesh_of(Vec3::ONE),
    ] {
        let target = Placed::new(&solid, &here);
        let cast = |way: Vec3, options| {
            let from = here.translation + Vec3::Y;
            tests
                .cast_ray_with(target, from, Dir3::new(way).unwrap(), 10.0, &options)
                .map(|hit| hit.distance)
        };
        for (way, options, expected) in [
            (Vec3::Y, DEFAULT, Some(0.0)),
            (Vec3::Y, DEFAULT.hollow(), Some(0.0)),
            (Vec3::Y, DEFAULT.ignore_start(), None),
            (Vec3::X, DEFAULT.ignore_start(), None),
            (Vec3::Y, DEFAULT.hollow().ignore_start(), None),
            (Vec3::Y, DEFAULT.hollow().front_faces(), None),
            (Vec3::Y, DEFAULT.back_faces(), Some(0.0)),
            (Vec3::Y, DEFAULT.back_faces().ignore_start(), None),
            (Vec3::NEG_Y, DEFAULT, Some(0.0)),
            (Vec3::NEG_Y, DEFAULT.hollow(), Some(0.0)),
            (Vec3::NEG_Y, DEFAULT.ignore_start(), Some(0.0)),
            (Vec3::NEG_Y, DEFAULT.front_faces(), Some(0.0)),
            (Vec3::NEG_Y, DEFAULT.back_faces(), Some(2.0)),
            (Vec3::NEG_Y, DEFAULT.back_faces().ignore_start(), Some(2.0)),
        ] {
            let hit = cast(way, options);
            let is_right = match (hit, expected) {
                (Some(hit), Some(expected)) => (hit - expected).abs() < 1e-5,
                (hit, expected) => hit == expected,
            };
            assert!(is_right, "{way} {options:?}: {hit:?} {solid:?}");
        }
    }
}

/// A Bevy mesh whose second triangle has no area.
#[test]
#[cfg(feature = "mesh")]
fn triangles_are_those_of_the_mesh_as_it_was_given() {
    use bevy::asset::RenderAssetUsages;
    use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
    let positions = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 0, 2, 0, 2, 3]));
    let mesh = PolygonMesh::from_mesh(&mesh).unwrap();
    assert_eq!(mesh.polygon_count(), 2);
    let (shape, here) = (Shape::Mesh(mesh.into()), Transform::IDENTITY);
    let hit = |x, y| {
        let target = Placed::new(&shape, &here);
        let hit = NarrowPhase::default().cast_ray(target, Vec3::new(x, y, 1.0), Dir3::NEG_Z, 2.0);
        hit.unwrap().polygon
    };
    assert_eq!([hit(0.7, 0.2), hit(0.2, 0.7)], [Some(0), Some(2)]);
}

/// A cube, and one loose triangle before it, and another inside.
#[test]
fn loose_polygons_beside_a_solid_are_mere_surfaces() {
    let cube = mesh_of(Vec3::ONE);
    let (mesh, _) = cube.polygons().unwrap();
    let mut corners = mesh.vertices().to_vec();
    let mut polygons: Vec<_> = mesh.polygons().map(<[u32]>::to_vec).collect();
    for x in [-3.0, 0.25] {
        let first = corners.len() as u32;
        corners.extend([[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]].map(|[y, z]| Vec3::new(x, y, z)));
        polygons.push(vec![first, first + 1, first + 2]);
    }
    let shape = Shape::mesh(corners, polygons).unwrap();
    let (tests, here) = (NarrowPhase::default(), Transform::IDENTITY);
    let target = Placed::new(&shape, &here);
    let ends = |x: f32| {
        let passage = tests
            .cast_ray_through(target, Vec3::X * x, Dir3::X, 10.0)
            .unwrap();
        [passage.enter, passage.leave].map(|end| end.map(|end| end.distance))
    };
    assert_eq!(ends(-4.0), [Some(1.0), None]);
    assert_eq!(ends(-2.0), [Some(1.0), Some(3.0)]);
    assert_eq!(ends(0.5), [None, Some(0.5)]);
    assert_eq!(ends(-1.0), [Some(0.0), Some(2.0)]);
    let cast = |x: f32, options| {
        let hit = tests.cast_ray_with(target, Vec3::X * x, Dir3::X, 10.0, &options);
        hit.map(|hit| hit.distance)
    };
    assert_eq!(cast(-3.0, DEFAULT.ignore_start()), Some(2.0));
    assert_eq!(cast(-1.0, DEFAULT.ignore_start()), Some(0.0));
    assert_eq!(cast(0.25, DEFAULT.ignore_start()), Some(0.0));
    assert_eq!(cast(1.0, DEFAULT.ignore_start()), None);
}
