//! Shapes that a scaled parent shears, against brute force in 64 bits.

use crate::common;

use std::f32::consts::FRAC_PI_4;

use bevy::{
    ecs::system::RunSystemOnce,
    math::{DAffine3, DVec3, Isometry3d},
    prelude::*,
};
use bevy_octree::{
    components::WorldAabb,
    narrow_phase::{HeightField, Shape, Voxels},
    prelude::*,
};
use common::{
    warnings::{on_this_thread, told, warnings},
    *,
};
use fastrand::Rng;

const ALL: SpatialQueryFilter = SpatialQueryFilter::DEFAULT;

fn ask<T: 'static>(
    app: &mut App,
    question: impl FnMut(SpatialQuery) -> T + Send + Sync + 'static,
) -> T {
    app.world_mut()
        .run_system_once(question)
        .expect("the plugins are there")
}

fn found_at(app: &mut App, point: Vec3) -> Vec<Entity> {
    ask(app, move |spatial| {
        let mut found = Vec::new();
        spatial.for_each_point_intersection(point, &ALL, |entity| found.push(entity));
        found.sort();
        found
    })
}

fn vector(rng: &mut Rng, reach: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| (rng.f32() * 2.0 - 1.0) * reach))
}

fn turn(rng: &mut Rng) -> Quat {
    Quat::from_euler(
        EulerRot::XYZ,
        rng.f32() * 6.0,
        rng.f32() * 6.0,
        rng.f32() * 6.0,
    )
}

/// Scaled by axis, and mirrored one time in two.
fn scale(rng: &mut Rng) -> Vec3 {
    let sign = |rng: &mut Rng| if rng.u8(0..4) == 0 { -1.0 } else { 1.0 };
    Vec3::from_array(std::array::from_fn(|_| (0.3 + rng.f32() * 2.0) * sign(rng)))
}

fn local(transform: &Transform) -> DAffine3 {
    let Transform {
        translation,
        rotation,
        scale,
    } = *transform;
    let rotation = rotation.as_dquat().normalize();
    DAffine3::from_scale_rotation_translation(scale.as_dvec3(), rotation, translation.as_dvec3())
}

fn place(world: &World, entity: Entity) -> DAffine3 {
    let own = local(world.get::<Transform>(entity).unwrap());
    world
        .get::<ChildOf>(entity)
        .map_or(own, |parent| place(world, parent.parent()) * own)
}

#[test]
fn a_turned_cube_under_a_scaled_parent_is_what_it_is() {
    for mirror in [1.0, -1.0] {
        let mut app = app(BroadPhaseMethod::default());
        let parent = app
            .world_mut()
            .spawn(Transform::from_scale(Vec3::new(4.0 * mirror, 1.0, 1.0)))
            .id();
        let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
        let cube = app
            .world_mut()
            .spawn((CollisionShape::default(), turned, ChildOf(parent)))
            .id();
        tick(&mut app, 1);
        // A lozenge of half diagonals 4 / √2 and 1 / √2.
        assert_eq!(found_at(&mut app, Vec3::new(2.5, 0.0, 0.0)), [cube]);
        assert_eq!(found_at(&mut app, Vec3::new(-1.4, 0.34, 0.4)), [cube]);
        assert_eq!(found_at(&mut app, Vec3::new(1.5, 0.36, 0.0)), []);
        assert_eq!(found_at(&mut app, Vec3::new(0.0, 0.75, 0.0)), []);
        let aabb = get::<WorldAabb>(&app, cube).0;
        let half = Vec3::new(8f32.sqrt(), 0.5f32.sqrt(), 0.5);
        assert!(
            (Vec3::from(aabb.max) - half).abs().max_element() < 1e-3,
            "{aabb:?}"
        );
        // It is one no more when its parent is not scaled, or gone; and once more.
        for round in 0..2 {
            *get_mut::<Transform>(&mut app, parent) = Transform::IDENTITY;
            if round == 1 {
                app.world_mut().entity_mut(cube).remove::<ChildOf>();
            }
            tick(&mut app, 1);
            assert_eq!(found_at(&mut app, Vec3::new(2.5, 0.0, 0.0)), []);
            assert_eq!(found_at(&mut app, Vec3::new(0.0, 0.7, 0.0)), [cube]);
            get_mut::<Transform>(&mut app, parent).scale = Vec3::new(4.0, 1.0, 1.0);
            app.world_mut().entity_mut(cube).insert(ChildOf(parent));
            tick(&mut app, 1);
            assert_eq!(found_at(&mut app, Vec3::new(2.5, 0.0, 0.0)), [cube]);
        }
        // Another shape, in the same tick.
        *get_mut(&mut app, cube) = CollisionShape::from_half_size(Vec3::splat(0.25));
        tick(&mut app, 1);
        assert_eq!(found_at(&mut app, Vec3::new(2.5, 0.0, 0.0)), []);
        assert_eq!(found_at(&mut app, Vec3::new(1.25, 0.0, 0.0)), [cube]);
    }
}

/// The eight corners of a cuboid, wherever it is.
fn corners(half: DVec3, place: &DAffine3) -> [DVec3; 8] {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    std::array::from_fn(|i| {
        place.transform_point3(half * DVec3::new(sign(i & 1), sign(i >> 1 & 1), sign(i >> 2 & 1)))
    })
}

/// How far two parallelepipeds are apart along the axis that parts them best; negative if none
/// does.
fn gap(a: &(DVec3, DAffine3), b: &(DVec3, DAffine3)) -> f64 {
    let edges = [a, b].map(|(_, place)| place.matrix3.to_cols_array_2d().map(DVec3::from));
    let faces = edges
        .iter()
        .flat_map(|[x, y, z]| [x.cross(*y), y.cross(*z), z.cross(*x)]);
    let across = edges[0]
        .iter()
        .flat_map(|one| edges[1].iter().map(|other| one.cross(*other)));
    let [a, b] = [a, b].map(|(half, place)| corners(*half, place));
    let range = |corners: &[DVec3; 8], axis: DVec3| {
        corners
            .iter()
            .map(|corner| corner.dot(axis))
            .fold((f64::MAX, f64::MIN), |(low, high), at| {
                (low.min(at), high.max(at))
            })
    };
    let gaps = faces
        .chain(across)
        .filter_map(DVec3::try_normalize)
        .map(|axis| {
            let ((low_a, high_a), (low_b, high_b)) = (range(&a, axis), range(&b, axis));
            (low_b - high_a).max(low_a - high_b)
        });
    gaps.fold(f64::MIN, f64::max)
}

/// Where a ray enters a cuboid, in shares of its direction.
fn entry(origin: DVec3, direction: DVec3, half: DVec3, place: &DAffine3) -> Option<f64> {
    let back = place.inverse();
    let (from, along) = (
        back.transform_point3(origin),
        back.transform_vector3(direction),
    );
    let (one, other) = ((-half - from) / along, (half - from) / along);
    let (first, last) = (one.min(other).max_element(), one.max(other).min_element());
    (first <= last && last >= 0.0).then_some(first.max(0.0))
}

/// A cuboid, or the same as a mesh, convex or not.
fn cuboid(half: Vec3, which: u8) -> CollisionShape {
    let corners: Vec<Vec3> = corners(half.as_dvec3(), &DAffine3::IDENTITY)
        .map(DVec3::as_vec3)
        .to_vec();
    let sides = SIDES;
    match which {
        0 => CollisionShape::from_half_size(half),
        1 => CollisionShape(Shape::convex(corners, sides).unwrap()),
        _ => CollisionShape(Shape::mesh(corners, sides).unwrap()),
    }
}

#[test]
fn random_hierarchies_agree_with_brute_force() {
    for seed in 0..40 {
        let mut rng = Rng::with_seed(seed);
        let mut app = app(BroadPhaseMethod::default());
        let mut halves: Vec<(Entity, Vec3)> = Vec::new();
        let mut parents = Vec::new();
        for _ in 0..5 {
            let at = |rng: &mut Rng| {
                Transform::from_translation(vector(rng, 2.0)).with_rotation(turn(rng))
            };
            let parent = app
                .world_mut()
                .spawn(at(&mut rng).with_scale(scale(&mut rng)))
                .id();
            let inner = (at(&mut rng).with_scale(scale(&mut rng)), ChildOf(parent));
            let inner = app.world_mut().spawn(inner).id();
            parents.extend([parent, inner]);
            for parent in [parent, inner] {
                let half = vector(&mut rng, 0.4).abs() + 0.1;
                let shape = (
                    cuboid(half, rng.u8(0..3)),
                    at(&mut rng).with_scale(scale(&mut rng)),
                    ChildOf(parent),
                );
                halves.push((app.world_mut().spawn(shape).id(), half));
            }
        }
        for time in 0..6 {
            // Ancestors move, turn, or change the shear.
            for &parent in &parents {
                let mut transform = get_mut::<Transform>(&mut app, parent);
                match (time, rng.u8(0..3)) {
                    (0, _) => {}
                    (_, 0) => transform.translation += vector(&mut rng, 0.5),
                    (_, 1) => transform.rotation = turn(&mut rng),
                    _ => transform.scale *= 0.9 + 0.2 * rng.f32(),
                }
            }
            tick(&mut app, 1);
            let placed: Vec<_> = halves
                .iter()
                .map(|(entity, half)| (half.as_dvec3(), place(app.world(), *entity)))
                .collect();

            for ((entity, _), (half, place)) in halves.iter().zip(&placed) {
                let aabb = get::<WorldAabb>(&app, *entity).0;
                let inside = |corner: &DVec3| {
                    corner.cmpge(aabb.min.as_dvec3()).all()
                        && corner.cmple(aabb.max.as_dvec3()).all()
                };
                assert!(
                    corners(*half, place).iter().all(inside),
                    "seed {seed}: {aabb:?}"
                );
            }

            let found = contacts(&app);
            for (i, a) in placed.iter().enumerate() {
                for (j, b) in placed.iter().enumerate().skip(i + 1) {
                    let gap = gap(a, b);
                    if gap.abs() > 1e-3 {
                        let met = found.contains(&pair(halves[i].0, halves[j].0));
                        assert_eq!(
                            met,
                            gap < 0.0,
                            "seed {seed}, tick {time}: {i} and {j}, gap {gap}"
                        );
                    }
                }
            }

            for _ in 0..40 {
                let which = rng.usize(..placed.len());
                let (half, at) = &placed[which];
                let point = at.transform_point3(*half * vector(&mut rng, 1.2).as_dvec3());
                let found = found_at(&mut app, point.as_vec3());
                for ((entity, _), (half, place)) in halves.iter().zip(&placed) {
                    let beyond =
                        (place.inverse().transform_point3(point).abs() / *half).max_element() - 1.0;
                    if beyond.abs() > 5e-3 {
                        assert_eq!(
                            found.contains(entity),
                            beyond < 0.0,
                            "seed {seed}: {point} is {beyond} beyond {which}"
                        );
                    }
                }

                let (origin, to) = (vector(&mut rng, 9.0), point.as_vec3());
                let Ok(direction) = Dir3::new(to - origin) else {
                    continue;
                };
                let hit = ask(&mut app, move |spatial| {
                    spatial.cast_ray(Ray3d::new(origin, direction), 100.0, &ALL)
                });
                let entries = placed.iter().filter_map(|(half, place)| {
                    entry(
                        origin.as_dvec3(),
                        direction.as_vec3().as_dvec3(),
                        *half,
                        place,
                    )
                });
                let first = entries.fold(f64::INFINITY, f64::min);
                let distance = hit.map_or(f64::INFINITY, |hit| hit.distance.into());
                // A ray that grazes may do so for one and not for the other.
                let graze = placed.iter().any(|(half, place)| {
                    let [thin, thick] = [0.998, 1.002].map(|share| {
                        entry(
                            origin.as_dvec3(),
                            direction.as_vec3().as_dvec3(),
                            *half * share,
                            place,
                        )
                        .is_some()
                    });
                    thin != thick
                });
                assert!(
                    graze || distance == first || (distance - first).abs() < 2e-3,
                    "seed {seed}: {distance}, {first}"
                );
            }
        }
    }
}

/// A ball is as large as its largest stretch, however its ancestors turn.
#[test]
fn a_ball_stays_one() {
    let mut app = app(BroadPhaseMethod::default());
    let parent = app
        .world_mut()
        .spawn(Transform::from_scale(Vec3::new(4.0, 1.0, 1.0)))
        .id();
    let inner = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4))
        .with_scale(Vec3::new(1.0, 3.0, 1.0));
    let inner = app.world_mut().spawn((inner, ChildOf(parent))).id();
    let ball = app
        .world_mut()
        .spawn((CollisionShape::sphere(0.5), ChildOf(inner)))
        .id();
    for (round, angle) in [0.0, 1.0, 2.0].into_iter().enumerate() {
        get_mut::<Transform>(&mut app, parent).rotation = Quat::from_rotation_x(angle);
        // That it should be an ellipsoid is said once.
        assert_eq!(warnings(|| tick(&mut app, 1)), usize::from(round == 0));
        // The largest eigenvalue of M Mᵀ, with M = diag(4, 1) · R(45°) · diag(1, 3).
        let place = place(app.world(), ball).matrix3;
        let stretches = place * place.transpose();
        let mut axis = DVec3::ONE;
        for _ in 0..200 {
            axis = (stretches * axis).normalize();
        }
        let radius = 0.5 * (stretches * axis).length().sqrt();
        let aabb = get::<WorldAabb>(&app, ball).0;
        assert!(
            (f64::from(aabb.max.x) - radius).abs() < 1e-3,
            "{aabb:?}, {radius}"
        );
        assert!((aabb.max + aabb.min).abs().max_element() < 1e-6);
        assert!((aabb.max - aabb.max.x).abs().max_element() < 1e-3);
    }
}

/// Whatever a scale of zero leaves of a shape, it is there.
#[test]
fn flattened_shapes_are_what_is_left_of_them() {
    let flat = Vec3::new(4.0, 0.0, 1.0);
    for which in 0..3 {
        let mut app = app(BroadPhaseMethod::default());
        let parent = app.world_mut().spawn(Transform::from_scale(flat)).id();
        for (turn, reach) in [(0.0, 2.0), (FRAC_PI_4, 8f32.sqrt())] {
            let turned = Transform::from_rotation(Quat::from_rotation_z(turn));
            let shape = (cuboid(Vec3::splat(0.5), which), turned, ChildOf(parent));
            let shape = app.world_mut().spawn(shape).id();
            tick(&mut app, 1);
            assert_eq!(
                found_at(&mut app, Vec3::new(reach - 0.1, 0.0, 0.3)),
                [shape]
            );
            assert_eq!(found_at(&mut app, Vec3::new(reach + 0.1, 0.0, 0.3)), []);
            assert_eq!(found_at(&mut app, Vec3::new(reach - 0.1, 0.01, 0.3)), []);
            app.world_mut().despawn(shape);
        }
    }
}

/// On its way, a sheared shape is as wide as it is at the end of it.
#[test]
fn a_sheared_shape_is_swept() {
    let mut app = app(BroadPhaseMethod::default());
    let parent = Transform::from_xyz(0.0, -10.0, 0.0).with_scale(Vec3::new(4.0, 1.0, 1.0));
    let parent = app.world_mut().spawn(parent).id();
    let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
    let cube = (
        CollisionShape::default(),
        turned,
        Swept::default(),
        ChildOf(parent),
    );
    let cube = app.world_mut().spawn(cube).id();
    let thin = CollisionShape::from_half_size(Vec3::new(0.1, 0.01, 0.1));
    let at = |x: f32| (thin.clone(), Transform::from_xyz(x, 0.0, 0.0));
    let [near, _far] = [2.6, 3.0].map(|x| app.world_mut().spawn(at(x)).id());
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
    get_mut::<Transform>(&mut app, parent).translation.y = 10.0;
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [pair(cube, near)]);
    tick(&mut app, 1);
    assert!(contacts(&app).is_empty());
}

/// A Rapier collider is where Rapier itself has it, which knows no shear.
#[cfg(feature = "rapier")]
#[test]
fn a_rapier_collider_is_not_sheared() {
    let mut app = app(BroadPhaseMethod::default());
    let parent = app
        .world_mut()
        .spawn(Transform::from_scale(Vec3::new(4.0, 1.0, -1.0)))
        .id();
    let shape = CollisionShape((&bevy_rapier3d::prelude::Collider::cuboid(1.0, 0.5, 0.25)).into());
    let turned = Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(FRAC_PI_4));
    let child = app
        .world_mut()
        .spawn((shape.clone(), turned, ChildOf(parent)))
        .id();
    assert_eq!(warnings(|| tick(&mut app, 1)), 1);
    let at = GlobalTransform::from(place(app.world(), child).as_affine3a()).compute_transform();
    let tests = *app
        .world()
        .resource::<bevy_octree::narrow_phase::NarrowPhase>();
    let expected = tests.world_aabb(Placed::new(&shape, &at)).unwrap();
    let found = get::<WorldAabb>(&app, child).0;
    assert!(
        (found.min - expected.min).abs().max_element() < 1e-5,
        "{found:?} {expected:?}"
    );
    get_mut::<Transform>(&mut app, parent).translation.y = 1.0;
    assert_eq!(warnings(|| tick(&mut app, 1)), 0);
}

/// What of a shape does not follow a scale is told once, when it gets the shape or the scale.
#[test]
fn what_does_not_follow_a_scale_is_told_once() {
    let hull = Shape::convex_hull([Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).unwrap();
    let turned = (
        Isometry3d::from_rotation(Quat::from_rotation_z(0.5)),
        Shape::cuboid(1.0, 1.0, 1.0),
    );
    let upright = (Isometry3d::IDENTITY, Shape::cuboid(1.0, 1.0, 1.0));
    let round = (Isometry3d::IDENTITY, Shape::sphere(1.0));
    let nothing: &[&str] = &[];
    let cases = [
        (Shape::sphere(1.0), &["the ball"][..]),
        (Shape::capsule(0.5, 1.0), &["the capsule"]),
        (Shape::rounded(&hull, 0.1).unwrap(), &["the radius"]),
        (Shape::compound([turned]).unwrap(), &["parts"]),
        (Shape::compound([round]).unwrap(), &["parts"]),
        // All of these follow it.
        (Shape::compound([upright]).unwrap(), nothing),
        (Shape::cuboid(1.0, 2.0, 3.0), nothing),
        (Shape::cone(1.0, 2.0), nothing),
        (Shape::half_space(Vec3::ONE).unwrap(), nothing),
        (Shape::segment(Vec3::ZERO, Vec3::ONE).unwrap(), nothing),
        (
            HeightField::new(2, 2, vec![0.0; 4], Vec2::ONE)
                .unwrap()
                .into(),
            nothing,
        ),
        (
            Voxels::from_cells(1.0, [IVec3::ZERO]).unwrap().into(),
            nothing,
        ),
        (hull, nothing),
    ];
    let uneven = Transform::from_scale(Vec3::new(1.0, 2.0, -3.0));
    for (shape, expected) in cases {
        for is_child in [false, true] {
            let mut app = app(BroadPhaseMethod::default());
            on_this_thread(&mut app, FixedPostUpdate);
            let shape = CollisionShape(shape.clone());
            let entity = app.world_mut().spawn((shape.clone(), uneven)).id();
            if is_child {
                let parent = app.world_mut().spawn(Transform::default()).id();
                app.world_mut().entity_mut(entity).insert(ChildOf(parent));
            }
            let lines = told(|| tick(&mut app, 2));
            let is_told = |lines: &[String]| {
                lines.len() == expected.len()
                    && lines.iter().zip(expected).all(|(line, expected)| {
                        line.starts_with(&format!("{entity} has a scale"))
                            && line.contains(expected)
                    })
            };
            assert!(is_told(&lines), "{lines:?} {shape:?}");
            // While it moves, and is scaled in another way, nothing is said again.
            for step in 1..4 {
                let mut at = app.world_mut().get_mut::<Transform>(entity).unwrap();
                at.translation.x += 1.0;
                at.scale.y = 3.0 + step as f32;
                assert_eq!(told(|| tick(&mut app, 1)), [""; 0]);
            }
            // Of another shape, it is.
            app.world_mut().entity_mut(entity).insert(shape);
            let lines = told(|| tick(&mut app, 1));
            assert!(is_told(&lines), "{lines:?}");
        }
    }
    // What a capsule can do is no matter.
    let mut app = app(BroadPhaseMethod::default());
    on_this_thread(&mut app, FixedPostUpdate);
    let tall = Transform::from_scale(Vec3::new(2.0, 5.0, -2.0));
    app.world_mut()
        .spawn((CollisionShape(Shape::capsule(0.5, 1.0)), tall));
    assert_eq!(told(|| tick(&mut app, 1)), [""; 0]);
}

/// What cannot be sheared is turned as is nearest, and as long along its axes as it would be.
#[test]
fn what_is_along_axes_of_its_own_is_not_sheared() {
    for mirror in [1.0, -1.0] {
        let mut app = app(BroadPhaseMethod::default());
        // Hardly a shear: so everything is where it would be without.
        let parent = Transform::from_scale(Vec3::new(2.0, 2.002 * mirror, 2.0));
        let parent = app.world_mut().spawn(parent).id();
        let turned = Transform::from_rotation(Quat::from_rotation_z(0.6)).with_translation(Vec3::X);
        let core = Shape::cuboid(0.4, 1.0, 0.4);
        let [a, b] = [Vec3::NEG_Y, Vec3::Y].map(|end| end * 0.5);
        let field = HeightField::new(2, 2, vec![0.0; 4], Vec2::splat(0.5)).unwrap();
        let shapes = [
            Shape::capsule(0.2, 1.0),
            Shape::cylinder(0.2, 1.0),
            Shape::rounded(&core, 0.1).unwrap(),
            Shape::compound([(Isometry3d::IDENTITY, core)]).unwrap(),
            field.into(),
            Voxels::from_cells(0.5, [IVec3::NEG_Y, IVec3::ZERO])
                .unwrap()
                .into(),
            // These are: without a word.
            Shape::capsule_between(a, b, 0.2).unwrap(),
            Shape::segment(a, b).unwrap(),
            Shape::half_space(Vec3::Y).unwrap(),
        ];
        for (number, shape) in shapes.into_iter().enumerate() {
            let bounds = shape.world_aabb(&Transform::IDENTITY);
            let shape = CollisionShape(shape);
            let entity = app
                .world_mut()
                .spawn((shape.clone(), turned, ChildOf(parent)))
                .id();
            let lines = told(|| tick(&mut app, 2));
            let is_told = lines.len() == 1 && lines[0].contains("is sheared");
            assert_eq!(is_told, number < 6, "{lines:?}");
            let Ok(bounds) = bounds else {
                // A point that is just behind the plane, and one that is just before.
                let at = |y: f32| {
                    let map = DAffine3::from_scale(DVec3::new(2.0, 2.002 * f64::from(mirror), 2.0));
                    (map * local(&turned))
                        .transform_point3(DVec3::new(0.3, y.into(), 0.2))
                        .as_vec3()
                };
                assert_eq!(found_at(&mut app, at(-0.01)), [entity]);
                assert_eq!(found_at(&mut app, at(0.01)), []);
                continue;
            };
            // The corners of its own box, as the hierarchy has them.
            let map = place(app.world(), entity);
            let [low, high] = [bounds.min, bounds.max].map(|corner| Vec3::from(corner).as_dvec3());
            let middle = map.transform_point3((low + high) * 0.5);
            let aabb = get::<WorldAabb>(&app, entity).0;
            let center = Vec3::from((aabb.min + aabb.max) * 0.5).as_dvec3();
            assert!(
                center.distance(middle) < 0.01,
                "{shape:?} {center} {middle}"
            );
            // Its long axis, still the way that the child is turned.
            let long = map.transform_vector3(DVec3::Y).normalize() * (high.y - low.y);
            let tall = f64::from((aabb.max - aabb.min).y);
            assert!(tall > 2.0 * long.y.abs() - 0.02, "{shape:?} {tall} {long}");
            app.world_mut().despawn(entity);
            tick(&mut app, 1);
        }
    }
}
