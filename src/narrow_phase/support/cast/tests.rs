//! Rays, sweeps and what is huge, for all kinds of shapes.

use bevy::math::{Dir3, Isometry3d, Quat, Vec2, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::IVector;
use bevy_rapier3d::parry::shape::SharedShape;

use crate::narrow_phase::support::query::tests::{
    Random, boxes_of, contact, distance, hull_of, solids,
};
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

/// All kinds of shapes that a ray or something on its way can meet; each has the origin inside or
/// on it, but no more than two units around it.
fn targets() -> Vec<Shape> {
    let random = &mut Random::new(4);
    let flat = [
        Vec3::new(-1.0, 0.0, -1.0),
        Vec3::new(1.0, 0.0, -1.0),
        Vec3::new(0.0, 0.0, 1.5),
    ];
    let field = Collider::heightfield(
        vec![0.1, 0.2, 0.0, 0.1, 0.0, 0.2, 0.1, 0.0, 0.1],
        3,
        3,
        Vec3::ONE,
    );
    let mut shapes: Vec<Shape> = solids(1.0, random)
        .into_iter()
        .map(|solid| solid.shape)
        .collect();
    shapes.extend(
        boxes_of(Vec3::new(0.5, 1.0, 0.7))
            .into_iter()
            .map(|(_, shape)| shape),
    );
    shapes.extend([
        Shape::sphere(0.7),
        SharedShape::triangle(flat[0], flat[1], flat[2]).into(),
        SharedShape::segment(Vec3::NEG_Y, Vec3::Y).into(),
        (&field).into(),
        SharedShape::voxels(Vec3::ONE, &[IVector::new(0, 0, 0), IVector::new(-1, 0, 0)]).into(),
    ]);
    shapes
}

#[test]
fn rays_and_sweeps_from_afar_are_those_from_nearby() {
    let mut random = Random::new(5);
    let mut workspace = Workspace::default();
    let tests = NarrowPhase::default();
    let probes = [
        box_of(0.2, 0.1, 0.3),
        SharedShape::capsule_y(0.2, 0.1).into(),
        mesh_of(Vec3::splat(0.2)),
    ];
    for shape in targets() {
        let (mut rays, mut sweeps) = (0, 0);
        for i in 0..40 {
            let here = Transform::from_translation(random.point()).with_rotation(random.turn());
            let target = Placed::new(&shape, &here);
            // Along a direction that 32-bit floats hold exactly, so that what is far is no other
            // ray.
            let direction = [Dir3::X, Dir3::Y, Dir3::NEG_Z, Dir3::NEG_X][i % 4];
            let grid = |point: Vec3| (point * 1024.0).round() / 1024.0;
            let start = grid(here.translation + random.point() * 0.8) - direction * 8.0;
            let near = tests.cast_ray(target, start, direction, 100.0);
            let probe = &probes[i % 3];
            let from = Transform::from_translation(start).with_rotation(random.turn());
            let swept = tests.sweep(
                Placed::new(probe, &from),
                direction,
                100.0,
                target,
                &mut workspace,
            );
            for far in [256.0, 4096.0, 12_288.0] {
                let afar = start - direction * far;
                let hit = tests.cast_ray(target, afar, direction, 20_000.0);
                assert_eq!(
                    hit.is_some(),
                    near.is_some(),
                    "{shape:?} from {far}: {hit:?} {near:?}"
                );
                let from = from.with_translation(afar);
                let met = tests.sweep(
                    Placed::new(probe, &from),
                    direction,
                    20_000.0,
                    target,
                    &mut workspace,
                );
                assert_eq!(
                    met.is_some(),
                    swept.is_some(),
                    "{shape:?} and {probe:?} from {far}: {met:?} {swept:?}"
                );
                for (hit, near) in [(hit, near), (met, swept)]
                    .into_iter()
                    .filter_map(|(a, b)| a.zip(b))
                {
                    // As well as the distance can be held.
                    let off = (hit.distance - far - near.distance).abs();
                    assert!(
                        off <= far * 2.5e-7 + 2e-5,
                        "{shape:?} from {far}: {hit:?} {near:?}"
                    );
                    let closest = tests
                        .closest_point(target, hit.point, &mut workspace)
                        .unwrap();
                    assert!(
                        closest.distance(hit.point) < 1e-4,
                        "{shape:?} from {far}: {hit:?}, closest {closest}"
                    );
                }
            }
            rays += usize::from(near.is_some());
            sweeps += usize::from(swept.is_some());
        }
        let is_thin = matches!(&shape, Shape::Rapier(shape) if shape.raw().as_segment().is_some());
        assert!(is_thin || rays > 2, "{rays} rays hit {shape:?}");
        assert!(sweeps > 5, "{sweeps} sweeps hit {shape:?}");
    }
}

#[test]
fn a_ray_from_inside_meets_the_shape_where_it_starts() {
    let mut random = Random::new(7);
    let tests = NarrowPhase::default();
    let mut inside = 0;
    for solid in solids(1.0, &mut random) {
        let here = at(1.0, -2.0, 3.0);
        let target = Placed::new(&solid.shape, &here);
        for _ in 0..200 {
            let origin = here.translation + random.point();
            let closest = tests
                .closest_point(target, origin, &mut Workspace::default())
                .unwrap();
            if closest.distance(origin) > 0.0 {
                continue;
            }
            inside += 1;
            let direction = Dir3::new(origin - here.translation + Vec3::X * 0.01).unwrap();
            let impact = tests.cast_ray(target, origin, direction, 10.0).unwrap();
            assert_eq!(
                (impact.distance, impact.normal),
                (0.0, -*direction),
                "{:?}",
                solid.shape
            );
            assert!(
                impact.point.distance(origin) < 1e-5,
                "{:?}: {impact:?} from {origin}",
                solid.shape
            );
        }
    }
    assert!(inside > 200, "{inside}");
}

#[test]
fn a_ray_from_a_face_along_it_meets_the_shape_at_once() {
    let half = Vec3::splat(0.5);
    let mut flat: Vec<(&str, Shape, f32)> = boxes_of(half)
        .into_iter()
        .map(|(name, shape)| (name, shape, 0.5))
        .collect();
    let square = [
        Vec3::new(-0.5, 0.0, -0.5),
        Vec3::new(-0.5, 0.0, 0.5),
        Vec3::new(0.5, 0.0, 0.5),
        Vec3::new(0.5, 0.0, -0.5),
    ];
    let field = Collider::heightfield(vec![0.0; 9], 3, 3, Vec3::ONE);
    flat.extend([
        (
            "open mesh",
            Shape::mesh(square, [[0u32, 1, 2, 3]]).unwrap(),
            0.0,
        ),
        (
            "open triangles",
            SharedShape::trimesh(square.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
                .unwrap()
                .into(),
            0.0,
        ),
        ("height field", (&field).into(), 0.0),
        (
            "voxel",
            SharedShape::voxels(Vec3::ONE, &[IVector::new(0, 0, 0)]).into(),
            1.0,
        ),
    ]);
    let round = [
        ("sphere", Shape::sphere(0.5), 0.5),
        ("ball", SharedShape::ball(0.5).into(), 0.5),
        ("capsule", SharedShape::capsule_x(0.3, 0.5).into(), 0.5),
        ("cylinder", SharedShape::cylinder(0.5, 0.3).into(), 0.5),
        ("cone", SharedShape::cone(0.5, 0.5).into(), -0.5),
        (
            "round cuboid",
            SharedShape::round_cuboid(0.3, 0.3, 0.3, 0.2).into(),
            0.5,
        ),
    ];
    let mut random = Random::new(7);
    let tests = NarrowPhase::default();
    for i in 0..200 {
        // As it is, and anywhere.
        let here = match i {
            0 => Transform::IDENTITY,
            _ => Transform::from_translation(random.point() * 100.0).with_rotation(random.turn()),
        };
        let turned = |direction: Vec3| Dir3::new(here.rotation * direction).unwrap();
        for (name, shape, top) in &flat {
            let target = Placed::new(shape, &here);
            let x = if *name == "voxel" { 0.5 } else { 0.0 };
            let on_face = here * (Vec3::new(x, *top, x) + Vec3::new(0.2, 0.0, -0.1));
            for direction in [
                Vec3::X,
                Vec3::NEG_Z,
                Vec3::new(0.6, 0.0, 0.8),
                Vec3::Y,
                Vec3::NEG_Y,
            ] {
                let hit = tests.cast_ray(target, on_face, turned(direction), 10.0);
                assert_eq!(
                    hit.map(|hit| hit.distance),
                    Some(0.0),
                    "{name} {direction} {here:?}"
                );
            }
            // In the plane of the face, from outside: as it is alone, for rounding puts it over or
            // under that plane.
            if i == 0 {
                let start = Vec3::new(x - 2.0, *top, x + 0.1);
                let hit = tests
                    .cast_ray(target, start, Dir3::X, 10.0)
                    .unwrap_or_else(|| panic!("{name}"));
                assert!(
                    (hit.distance - 1.5).abs() < 1e-5 && hit.normal.x < -0.99,
                    "{name}: {hit:?}"
                );
                assert!(
                    tests.cast_ray(target, start, Dir3::Z, 10.0).is_none(),
                    "{name}"
                );
                assert!(
                    tests.cast_ray(target, start, Dir3::NEG_X, 10.0).is_none(),
                    "{name}"
                );
            }
            let over = here * Vec3::new(x + 0.2, top + 1e-3, x);
            assert!(
                tests
                    .cast_ray(target, over, turned(Vec3::X), 10.0)
                    .is_none(),
                "{name} {here:?}"
            );
        }
        for (name, shape, top) in &round {
            let (target, on_top) = (Placed::new(shape, &here), here * (Vec3::Y * *top));
            for direction in [Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::Y, Vec3::NEG_Y] {
                let hit = tests.cast_ray(target, on_top, turned(direction), 10.0);
                assert_eq!(
                    hit.map(|hit| hit.distance),
                    Some(0.0),
                    "{name} {direction} {here:?}"
                );
            }
        }
    }
}

/// Rules that hold at any size, checked at all of them: right up to where 32-bit floats end.
#[test]
fn what_is_huge_is_as_right_as_what_is_not() {
    let mut workspace = Workspace::default();
    let tests = NarrowPhase::default();
    let turned = Quat::from_rotation_y(0.5);
    for power in [0, 10, 33, 50, 62, 66, 80, 100, 120] {
        let size = 2f32.powi(power);
        let near = |found: f32, expected: f32| (found / size - expected).abs() < 1e-4;
        let mesh = mesh_of(Vec3::splat(size));
        let Shape::Mesh(polygons) = &mesh else {
            unreachable!()
        };
        let quads: Vec<_> = polygons.polygons().map(<[u32]>::to_vec).collect();
        let convex = Shape::convex(polygons.vertices().to_vec(), quads).unwrap();
        let mut boxes = vec![
            box_of(size, size, size),
            SharedShape::cuboid(size, size, size).into(),
            convex,
            mesh.clone(),
        ];
        // Larger ones, parry does not make.
        if power <= 33 {
            boxes.push(hull_of(Vec3::splat(size)).into());
        }
        // Wholly inside, of what is closed.
        let capsule: Shape = SharedShape::capsule_y(size * 0.2, size * 0.1).into();
        assert!(
            contact(
                (&mesh, at(0.0, 0.0, 0.0)),
                (&capsule, at(0.0, size * 0.2, 0.0))
            )
            .is_some(),
            "2^{power}"
        );
        let balls: [Shape; 3] = [
            Shape::sphere(size),
            SharedShape::ball(size).into(),
            SharedShape::capsule_z(size, size).into(),
        ];
        for a in &boxes {
            for b in boxes.iter().chain(&balls) {
                for rotation in [Quat::IDENTITY, turned] {
                    let names = format!("{a:?} and {b:?}, {rotation}, at 2^{power}");
                    let here = at(0.0, 0.0, 0.0).with_rotation(rotation);
                    let there = |height: f32| at(0.0, height * size, 0.0).with_rotation(rotation);
                    let found =
                        contact((a, here), (b, there(1.5))).unwrap_or_else(|| panic!("{names}"));
                    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_));
                    if !is_mesh(a) && !is_mesh(b) {
                        assert!(
                            near(found.depth, 0.5) && found.normal.y > 0.999,
                            "{names}: {found:?}"
                        );
                    }
                    assert!(
                        found.point.is_finite() && found.depth.is_finite(),
                        "{names}: {found:?}"
                    );
                    assert!(contact((a, here), (b, there(3.0))).is_none(), "{names}");
                    let apart = distance((a, here), (b, there(3.0)));
                    assert!(
                        near(apart.distance, 1.0) && near(apart.offset.y, 1.0),
                        "{names}: {apart:?}"
                    );
                    let (moving, at_moving) = (Placed::new(a, &here), there(4.0));
                    let target = Placed::new(b, &at_moving);
                    let met = tests.sweep(moving, Dir3::Y, f32::MAX, target, &mut workspace);
                    let met = met.unwrap_or_else(|| panic!("{names}"));
                    assert!(
                        near(met.distance, 2.0) && met.normal.y < -0.999,
                        "{names}: {met:?}"
                    );
                    let moved = Moving::new(a, &here, &there(4.0));
                    let met =
                        tests.time_of_impact(&moved, &Moving::resting(target), &mut workspace);
                    let met = met.unwrap_or_else(|| panic!("{names}"));
                    assert!(
                        (met.time - 0.5).abs() < 1e-4 && met.contact.point.is_finite(),
                        "{names}: {met:?}"
                    );
                }
            }
        }
        for shape in boxes.iter().chain(&balls) {
            let here = at(0.0, 0.0, 0.0).with_rotation(turned);
            let target = Placed::new(shape, &here);
            let hit = tests.cast_ray(target, Vec3::Y * (size * 3.0), Dir3::NEG_Y, f32::INFINITY);
            let hit = hit.unwrap_or_else(|| panic!("{shape:?} at 2^{power}"));
            assert!(
                near(hit.distance, 2.0) && hit.normal.y > 0.999,
                "{hit:?}, {shape:?} at 2^{power}"
            );
            let inside = tests.cast_ray(target, Vec3::Y * (size * 0.5), Dir3::NEG_Y, f32::INFINITY);
            let is_surface =
                matches!(shape, Shape::Rapier(shape) if shape.raw().as_trimesh().is_some());
            assert!(
                is_surface || inside.is_some_and(|hit| hit.distance == 0.0),
                "{shape:?} at 2^{power}"
            );
            let closest = tests
                .closest_point(target, Vec3::Y * (size * 3.0), &mut workspace)
                .unwrap();
            assert!(near(closest.y, 1.0), "{closest}, {shape:?} at 2^{power}");
            let inside = Vec3::Y * (size * 0.5);
            assert_eq!(
                tests.closest_point(target, inside, &mut workspace),
                Some(inside),
                "{shape:?} at 2^{power}"
            );
            assert!(tests.world_aabb(target).is_ok() && shape.bounding_sphere(&here).is_ok());
        }
        // Small beside huge, and far away.
        let (unit, large) = (box_of(1.0, 1.0, 1.0), &boxes[0]);
        let here = at(0.0, 0.0, 0.0).with_rotation(turned);
        assert!(contact((large, here), (&unit, at(0.0, size * 0.5, 0.0))).is_some());
        if power > 1 {
            assert!(contact((large, here), (&unit, at(0.0, size * 4.0, 0.0))).is_none());
            let apart = distance((&unit, here), (&unit, at(0.0, size * 4.0, 0.0)));
            assert!(
                (apart.distance - (size * 4.0 - 2.0)).abs() <= size * 1e-5,
                "{apart:?}"
            );
            let capsule: Shape = SharedShape::capsule_y(1.0, 1.0).into();
            let apart = distance((&capsule, here), (&unit, at(0.0, size * 4.0, 0.0)));
            assert!(
                (apart.distance - (size * 4.0 - 3.0)).abs() <= size * 1e-5,
                "{apart:?}"
            );
        }
    }
    // Where even sums overflow, nothing is in contact, and there are no bounds.
    let huge = box_of(f32::MAX, f32::MAX, f32::MAX);
    let here = at(f32::MAX, 0.0, 0.0);
    assert_eq!(huge.world_aabb(&here), Err(BoundsError::NonFinite));
    assert!(
        contact(
            (&huge, here),
            (&huge, at(-f32::MAX, 0.0, 0.0).with_rotation(turned))
        )
        .is_none()
    );
}

/// Rays that aim at an end of what has no thickness: there, any normal will do.
#[test]
fn ends_without_thickness_are_met_where_they_are() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut vector = |size: f32| Vec3::from([0; 3].map(|_| (random.f32() * 2.0 - 1.0) * size));
    let mut worst = 0.0f32;
    for _ in 0..3_000 {
        let (a, b, c) = (vector(3.0), vector(3.0), vector(3.0));
        let scale = vector(4.0).abs() + 0.1;
        let at = Transform {
            translation: vector(5.0),
            rotation: Quat::from_scaled_axis(vector(3.0)),
            scale,
        };
        let shapes = [
            (Shape::segment(a, b), vec![a, b]),
            (Shape::segment(Vec3::ZERO, b), vec![Vec3::ZERO]),
            (Shape::triangle(a, b, c), vec![a, b, c]),
            (Shape::convex_hull(vec![a, b, c, -a]), vec![a, c, -a]),
            (Shape::convex_hull(vec![a, b]), vec![a, b]),
        ];
        for (shape, ends) in shapes {
            let Ok(shape) = shape else {
                continue;
            };
            let placed = Placed::new(&shape, &at);
            for end in ends {
                let (origin, end) = (vector(8.0), at.transform_point(end));
                let far = origin.distance(end);
                let Ok(direction) = Dir3::new(end - origin) else {
                    continue;
                };
                let hit = NarrowPhase::default().cast_ray(placed, origin, direction, 100.0);
                // It may pass by, by rounding.
                if let Some(hit) = hit {
                    let met = origin + direction * hit.distance;
                    assert!(hit.distance <= far + 1e-4, "{hit:?} {far} {shape:?} {at:?}");
                    worst = worst.max(met.distance(hit.point));
                }
            }
        }
    }
    assert!(worst < 1e-4, "{worst}");
}

/// What arrives at a level floor touches it where it arrives, and its normal is that of the floor.
#[test]
fn what_goes_aslant_meets_where_it_arrives() {
    let mut random = fastrand::Rng::with_seed(12);
    let mut vector = |size: f32| Vec3::from([0; 3].map(|_| (random.f32() * 2.0 - 1.0) * size));
    let corner = |x: f32, z: f32| Vec3::new(x, 0.25, z);
    let triangle = Shape::triangle(
        corner(-600.0, -600.0),
        corner(0.0, 900.0),
        corner(600.0, -600.0),
    );
    let triangle = triangle.unwrap();
    let field = HeightField::from_fn(9, 9, Vec2::splat(100.0), |_, _| 0.25).unwrap();
    let corners = [
        (-600.0, -600.0),
        (-600.0, 600.0),
        (600.0, 600.0),
        (600.0, -600.0),
    ];
    let square = corners.map(|(x, z)| corner(x, z)).to_vec();
    let targets = [
        (Shape::half_space(Vec3::Y).unwrap(), 0.0),
        (Shape::cuboid(600.0, 0.5, 600.0), 0.25),
        (Shape::cylinder(300.0, 0.5), 0.25),
        (
            Shape::compound([(Isometry3d::IDENTITY, triangle.clone())]).unwrap(),
            0.25,
        ),
        (triangle, 0.25),
        (Shape::from(field), 0.25),
        (Shape::mesh(square, [[0_u32, 1, 2, 3]]).unwrap(), 0.25),
    ];
    let shapes = [
        Shape::sphere(0.5),
        Shape::capsule(0.5, 1.0),
        Shape::cuboid(0.5, 0.25, 1.0),
        Shape::cylinder(0.5, 0.5),
        Shape::cone(0.5, 1.0),
        Shape::convex_hull((0..12).map(|_| vector(0.7))).unwrap(),
    ];
    for (target, top) in targets {
        let floor = Placed::new(&target, &Transform::IDENTITY);
        for number in 0..300 {
            // Every other one is level, and meets the floor with a face.
            let turn = vector(3.0) * Vec3::new((number % 2) as f32, 1.0, (number % 2) as f32);
            let moving = Transform {
                translation: vector(3.0) + Vec3::Y * 6.0,
                rotation: Quat::from_scaled_axis(turn),
                ..Transform::IDENTITY
            };
            let way = vector(1.0).with_y(if number % 3 == 0 { -1e3 } else { -0.2 });
            let direction = Dir3::new(way).unwrap();
            for shape in &shapes {
                let mut workspace = Workspace::default();
                let (placed, tests) = (Placed::new(shape, &moving), NarrowPhase::default());
                let hit = tests.sweep(placed, direction, 300.0, floor, &mut workspace);
                let hit = hit.expect("the floor is large");
                let what = || format!("{hit:?} {moving:?} {direction:?} {shape:?} {target:?}");
                let reach = hit.point - (moving.translation + direction * hit.distance);
                assert!(reach.abs().max_element() < 1.1, "{}", what());
                assert!((hit.point.y - top).abs() < 1e-3, "{}", what());
                assert!(hit.normal.distance(Vec3::Y) < 1e-3, "{}", what());
                let end = Transform {
                    translation: moving.translation + direction * (hit.distance + 1.0),
                    ..moving
                };
                let there = Moving::new(shape, &moving, &end);
                let met = tests.time_of_impact(&there, &Moving::resting(floor), &mut workspace);
                let met = met.expect("as the sweep does");
                assert!(
                    met.contact.normal.distance(Vec3::NEG_Y) < 1e-3,
                    "{met:?} {}",
                    what()
                );
            }
        }
    }
}

/// Surfaces without thickness that meet flat are on the side from which they came.
#[test]
fn plates_meet_on_the_side_from_which_they_come() {
    let square = |half: f32| {
        let corners = [(-half, -half), (-half, half), (half, half), (half, -half)];
        let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec();
        Shape::mesh(corners, [[0_u32, 1, 2, 3]]).unwrap()
    };
    let floors = [
        square(3.0),
        Shape::cuboid(6.0, 0.0, 6.0),
        Shape::cylinder(3.0, 0.0),
        HeightField::from_fn(3, 3, Vec2::splat(3.0), |_, _| 0.0)
            .unwrap()
            .into(),
    ];
    let (plate, mut workspace) = (square(0.5), Workspace::default());
    for floor in &floors {
        for side in [1.0, -1.0] {
            let from = Transform::from_xyz(0.1, 5.0 * side, 0.2);
            let to = Transform::from_xyz(0.1, -2.0 * side, 0.2);
            let (moving, here) = (Moving::new(&plate, &from, &to), Transform::IDENTITY);
            let resting = Moving::resting(Placed::new(floor, &here));
            let met = NarrowPhase::default().time_of_impact(&moving, &resting, &mut workspace);
            let met = met.expect("it goes through");
            assert_eq!(met.contact.normal, Vec3::NEG_Y * side, "{met:?} {floor:?}");
        }
    }
}
