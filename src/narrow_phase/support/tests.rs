//! Verdicts and contacts against those of parry, and Rapier shapes.

use bevy::math::{Dir3, IVec3, Isometry3d, Quat, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::query;
use bevy_rapier3d::parry::shape::{self, SharedShape};
use proptest::prelude::*;

use crate::narrow_phase::tests::{at, box_of, boxes, meets, mesh_of};
use crate::narrow_phase::*;

/// How close two shapes may be for their verdicts to differ, by the rounding of parry's iterations.
const MARGIN: f32 = 1e-3;

fn pose(at: Transform) -> Pose {
    Pose::from_parts(at.translation, at.rotation)
}

/// The distance that parry finds, zero if the two overlap.
fn distance(a: (&dyn shape::Shape, Transform), b: (&dyn shape::Shape, Transform)) -> f32 {
    let between = pose(a.1).inv_mul(&pose(b.1));
    // The same iterations for all shapes: those for two cuboids assert that they round well.
    let (one, two) = (a.0.as_support_map().unwrap(), b.0.as_support_map().unwrap());
    if query::details::intersection_test_support_map_support_map(&between, one, two) {
        0.0
    } else {
        query::details::distance_support_map_support_map(&between, one, two)
    }
}

/// Checks our verdict against a distance, and returns it.
#[track_caller]
fn agree(a: (&Shape, Transform), b: (&Shape, Transform), distance: f32) -> bool {
    let found = meets(a, b);
    if found {
        assert!(distance <= MARGIN, "in contact at a distance of {distance}");
    } else if distance == 0.0 {
        let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
        let loose = NarrowPhase::new(MARGIN).unwrap();
        assert!(
            loose.intersects(one, two, &mut Workspace::default()),
            "apart, but overlap"
        );
    }
    found
}

fn cuboid_of(shape: &Shape, transform: Transform) -> shape::Cuboid {
    let &Shape::Cuboid { half_size } = shape else {
        unreachable!("only boxes come here");
    };
    shape::Cuboid::new((half_size * transform.scale).abs())
}

/// A convex hull, as parry has it and as a mesh.
fn hulls() -> impl Strategy<Value = (SharedShape, Shape)> {
    let point = prop::array::uniform3(-1f32..1.0).prop_map(Vec3::from);
    prop::collection::vec(point, 6..16).prop_filter_map("flat", |points| {
        let hull = SharedShape::convex_hull(&points)?;
        let (vertices, triangles) = hull.as_convex_polyhedron()?.to_trimesh();
        // Parry's hulls may hold slivers, which are no polygons.
        Some((hull.clone(), Shape::convex(vertices, triangles).ok()?))
    })
}

fn placed() -> impl Strategy<Value = Transform> {
    let three = |range: f32| prop::array::uniform3(-range..range).prop_map(Vec3::from);
    (three(1.2), three(3.0)).prop_map(|(translation, turn)| {
        Transform::from_translation(translation).with_rotation(Quat::from_scaled_axis(turn))
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1000,
        max_global_rejects: 20_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn cuboids_agree_with_parry(a in boxes(), b in boxes()) {
        let (one, two) = (cuboid_of(&a.0, a.1), cuboid_of(&b.0, b.1));
        agree((&a.0, a.1), (&b.0, b.1), distance((&one, a.1), (&two, b.1)));
    }

    #[test]
    fn hulls_agree_with_parry(
        a in hulls(),
        at_a in placed(),
        b in hulls(),
        at_b in placed(),
        scale in prop::array::uniform3(prop_oneof![-0.5f32..-0.1, 0.1f32..0.5]),
    ) {
        agree((&a.1, at_a), (&b.1, at_b), distance((&*a.0, at_a), (&*b.0, at_b)));
        // A smaller one, often inside.
        let small = at_b.with_scale(scale.into());
        let points = b.0.as_convex_polyhedron().unwrap().points();
        let points: Vec<_> = points.iter().map(|point| point * small.scale).collect();
        if let Some(scaled) = SharedShape::convex_hull(&points) {
            agree((&a.1, at_a), (&b.1, small), distance((&*a.0, at_a), (&*scaled, small)));
        }
    }

    #[test]
    fn rapier_shapes_agree_with_ours(a in boxes(), b in boxes(), hull in hulls()) {
        // Rapier shapes have no scale.
        let (at_a, at_b) = (a.1.with_scale(Vec3::ONE), b.1.with_scale(Vec3::ONE));
        let (one, two) = (cuboid_of(&a.0, at_a), cuboid_of(&b.0, at_b));
        let rapier: Shape = SharedShape::new(two).into();
        let apart = distance((&one, at_a), (&two, at_b));
        let Shape::Cuboid { half_size } = a.0 else { unreachable!() };
        agree((&a.0, at_a), (&rapier, at_b), apart);
        agree((&mesh_of(half_size), at_a), (&rapier, at_b), apart);
        agree((&hull.1, at_a), (&rapier, at_b), distance((&*hull.0, at_a), (&two, at_b)));
        let rapier: Shape = hull.0.clone().into();
        agree((&a.0, at_a), (&rapier, at_b), distance((&one, at_a), (&*hull.0, at_b)));
    }

    #[test]
    fn depths_are_those_of_parry(a in boxes(), at_hull in placed(), hull in hulls()) {
        let mut workspace = Workspace::default();
        let (one, two) = (Placed::new(&a.0, &a.1), Placed::new(&hull.1, &at_hull));
        let found = NarrowPhase::default().contact(one, two, &mut workspace);
        prop_assume!(found.is_some());
        let found = found.unwrap();
        let cuboid = cuboid_of(&a.0, a.1);
        let theirs = query::contact(&pose(a.1), &cuboid, &pose(at_hull), &*hull.0, 1e-3).unwrap();
        prop_assume!(theirs.is_some());
        let theirs = theirs.unwrap();
        // Parry's depth is now and then less than what parts the two by its own normal.
        let mut parted = at_hull;
        parted.translation += theirs.normal1 * (1e-3 - theirs.dist);
        prop_assume!(distance((&cuboid, a.1), (&*hull.0, parted)) > 0.0);
        // Both find the least overlap, we within a share of the size of the pair.
        let deep = (-theirs.dist).max(0.0);
        prop_assert!((found.depth - deep).abs() < 0.02, "{} {}", found.depth, deep);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn distances_are_those_of_parry(
        cuboid in boxes(),
        a in hulls(),
        at_a in placed(),
        b in hulls(),
        at_b in placed(),
        away in prop::array::uniform3(-3f32..3.0),
    ) {
        let at_b = Transform { translation: at_b.translation + Vec3::from(away), ..at_b };
        let found = apart((&a.1, at_a), (&b.1, at_b));
        let theirs = distance((&*a.0, at_a), (&*b.0, at_b));
        prop_assert!(is_near(found, theirs), "hulls: {found} {theirs}");
        let own = cuboid_of(&cuboid.0, cuboid.1);
        let (found, theirs) = (apart((&cuboid.0, cuboid.1), (&b.1, at_b)), distance((&own, cuboid.1), (&*b.0, at_b)));
        prop_assert!(is_near(found, theirs), "cuboid and hull: {found} {theirs}");
        // Parry's surfaces have no inside.
        let Shape::Convex(mesh) = &a.1 else { unreachable!() };
        let (mesh, hull): (Shape, Shape) = (mesh.as_ref().clone().into_inner().into(), b.0.clone().into());
        let (own, rapier) = (apart((&mesh, at_a), (&b.1, at_b)), apart((&mesh, at_a), (&hull, at_b)));
        prop_assert!(is_near(own, rapier), "mesh and collider: {own} {rapier}");
    }

    #[test]
    fn distances_of_cuboids_are_those_of_parry(a in boxes(), b in boxes(), away in prop::array::uniform3(-3f32..3.0)) {
        let at_b = Transform { translation: b.1.translation + Vec3::from(away), ..b.1 };
        let theirs = distance((&cuboid_of(&a.0, a.1), a.1), (&cuboid_of(&b.0, at_b), at_b));
        let found = apart((&a.0, a.1), (&b.0, at_b));
        prop_assert!(is_near(found, theirs) && found < theirs + MARGIN, "{found} {theirs}");
    }
}

/// Whether our distance is theirs: parry's iterations end early, and its hulls keep points that
/// their faces leave out.
fn is_near(ours: f32, theirs: f32) -> bool {
    (ours - theirs).abs() < 2e-2
}

/// The distance that we find.
fn apart(a: (&Shape, Transform), b: (&Shape, Transform)) -> f32 {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    NarrowPhase::default()
        .closest_points(one, two, &mut Workspace::default())
        .unwrap()
        .distance
}

#[test]
fn half_space_has_distances_too() {
    let ground = Shape::from(SharedShape::halfspace(Vec3::Y));
    let here = at(0.0, 0.0, 0.0);
    for other in [
        box_of(0.5, 0.5, 0.5),
        mesh_of(Vec3::splat(0.5)),
        Shape::sphere(0.5),
    ] {
        for (height, expected) in [(1.75, 1.25), (0.5, 0.0), (0.25, 0.0)] {
            let found = apart((&ground, here), (&other, at(1e3, height, 0.0)));
            assert!(
                (found - expected).abs() < 1e-5,
                "{found} {expected} {other:?}"
            );
            assert_eq!(
                found,
                apart((&other, at(1e3, height, 0.0)), (&ground, here))
            );
        }
    }
    let (one, two) = (Placed::new(&ground, &here), Placed::new(&ground, &here));
    assert_eq!(
        NarrowPhase::default().closest_points(one, two, &mut Workspace::default()),
        None
    );
    let nowhere = at(0.0, f32::NAN, 0.0);
    let two = Placed::new(&ground, &nowhere);
    assert_eq!(
        NarrowPhase::default().closest_points(one, two, &mut Workspace::default()),
        None
    );
}

#[test]
fn touching_aligned_nested_and_coplanar_cuboids_agree_with_parry() {
    let large = box_of(1.0, 1.0, 1.0);
    let here = at(0.0, 0.0, 0.0);
    for size in [1.0, 0.5, 0.25] {
        let small = box_of(size, size, size);
        for x in [0.0, 0.5, 1.0, 1.25, 1.5, 2.0, 2.5] {
            for (y, z) in [
                (0.0, 0.0),
                (0.5, 0.0),
                (0.75, 0.75),
                (1.25, 0.0),
                (2.0, 2.0),
            ] {
                let there = at(x, y, z);
                let parry = distance(
                    (&cuboid_of(&large, here), here),
                    (&cuboid_of(&small, there), there),
                );
                let expected = parry < 1e-6;
                assert_eq!(
                    meets((&large, here), (&small, there)),
                    expected,
                    "{size} {there:?}"
                );
                let mesh = mesh_of(Vec3::splat(size));
                assert_eq!(
                    meets((&large, here), (&mesh, there)),
                    expected,
                    "{size} {there:?}"
                );
            }
        }
    }
}

#[test]
fn half_space_has_no_bounds_but_contacts() {
    let ground = Shape::from(&Collider::halfspace(Vec3::Y).unwrap());
    let here = at(0.0, 0.0, 0.0);
    assert_eq!(ground.world_aabb(&here), Err(BoundsError::Unbounded));
    let cube = box_of(0.5, 0.5, 0.5);
    for other in [cube.clone(), mesh_of(Vec3::splat(0.5)), Shape::sphere(0.5)] {
        assert!(meets((&ground, here), (&other, at(1e3, 0.4, 0.0))));
        assert!(meets((&ground, here), (&other, at(0.0, 0.5, 0.0))));
        assert!(!meets((&ground, here), (&other, at(0.0, 0.6, 0.0))));
    }
    assert!(!meets((&ground, here), (&cube, at(0.0, f32::NAN, 0.0))));
    assert!(!meets(
        (&ground, at(f32::INFINITY, 0.0, 0.0)),
        (&cube, here)
    ));

    let sunk = at(3.0, 0.4, 0.0);
    let (ground, cube) = (Placed::new(&ground, &here), Placed::new(&cube, &sunk));
    let contact = NarrowPhase::default().contact(ground, cube, &mut Workspace::default());
    let contact = contact.unwrap();
    assert!((contact.normal - Vec3::Y).length() < 1e-5 && (contact.depth - 0.1).abs() < 1e-5);
}

#[test]
fn contacts_of_a_half_space_are_where_a_shape_is_deepest() {
    let parts = [-1.0, 1.0].map(|x| {
        (
            Pose::translation(x, -0.5 * x, 0.0),
            SharedShape::cuboid(0.5, 0.5, 0.5),
        )
    });
    // Each of them, where its lowest point is, and how low.
    let shapes = [
        (Shape::sphere(0.5), 0.0, 0.5),
        (SharedShape::ball(0.5).into(), 0.0, 0.5),
        (SharedShape::cone(0.5, 0.5).into(), 0.0, 0.5),
        (SharedShape::compound(parts.into()).into(), 1.0, 1.0),
        (mesh_of(Vec3::splat(0.5)), 0.0, 0.5),
        (box_of(0.5, 0.5, 0.5), 0.0, 0.5),
    ];
    let ground = Shape::from(SharedShape::halfspace(Vec3::Y));
    for turn in [
        Quat::IDENTITY,
        Quat::from_rotation_z(0.5),
        Quat::from_rotation_x(2.0),
    ] {
        let at_ground = Transform::from_xyz(3.0, -2.0, 1.0).with_rotation(turn);
        for (shape, aside, low) in &shapes {
            // Which of the two comes first, is up to their places.
            for x in [-4.0, 4.0] {
                let at = at_ground * Transform::from_xyz(x, low - 0.1, 0.0);
                let (ground, shape) = (Placed::new(&ground, &at_ground), Placed::new(shape, &at));
                let found = NarrowPhase::default()
                    .contact(ground, shape, &mut Workspace::default())
                    .unwrap();
                assert!((found.normal - turn * Vec3::Y).length() < 1e-5, "{found:?}");
                assert!((found.depth - 0.1).abs() < 1e-5, "{found:?}");
                let off =
                    turn.inverse() * (found.point - at_ground.translation) - Vec3::X * (x + aside);
                assert!(
                    (off.y + 0.05).abs() < 0.05 + 1e-5 && off.x.abs() < 0.51 && off.z.abs() < 0.51,
                    "{found:?}"
                );
            }
        }
    }
}

#[test]
fn unsupported_pairs_are_apart() {
    let ground = Shape::from(SharedShape::halfspace(Vec3::Y));
    let here = at(0.0, 0.0, 0.0);
    assert!(!meets((&ground, here), (&ground, here)));
}

#[test]
fn capsule_inside_a_mesh_is_found() {
    let capsule = Shape::from(&Collider::capsule_y(0.2, 0.1));
    let around = mesh_of(Vec3::ONE);
    let here = at(0.0, 0.0, 0.0);
    assert!(meets((&around, here), (&capsule, at(0.3, 0.3, 0.3))));
    assert!(meets((&around, here), (&capsule, at(1.05, 0.0, 0.0))));
    assert!(!meets((&around, here), (&capsule, at(1.15, 0.0, 0.0))));
    let doubled = here.with_scale(Vec3::new(-2.0, 2.0, 2.0));
    assert!(meets((&around, doubled), (&capsule, at(1.7, 0.0, 0.0))));
    let flat = here.with_scale(Vec3::new(1.0, 1.0, 0.0));
    assert!(meets((&around, flat), (&capsule, here)));
    assert!(!meets((&around, flat), (&capsule, at(0.0, 0.0, 0.2))));
}

/// Rays in the plane of a face, which graze the edges of what is behind it.
#[test]
fn rays_that_graze_an_edge_are_as_long_as_to_it() {
    let mut voxels = Voxels::new(2.6).unwrap();
    for cell in [IVec3::NEG_ONE, IVec3::new(0, 2, -1), IVec3::new(-1, -1, 0)] {
        voxels.set(cell);
    }
    let edge = Shape::compound([(Isometry3d::IDENTITY, Shape::cylinder(2.0, 3.0))]).unwrap();
    let turned = Transform {
        translation: Vec3::new(2.0, 2.0, 6.0625),
        rotation: Quat::from_xyzw(0.0, 0.0, 1.0, -4.371_139e-8),
        ..Transform::IDENTITY
    };
    let mut random = fastrand::Rng::with_seed(3);
    let mut met = 0;
    for (shape, plane) in [(Shape::from(voxels), 2.0), (edge, 3.5)] {
        let target = Placed::new(&shape, &turned);
        for _ in 0..4000 {
            let height = plane + (random.f32() - 0.5) * [0.0, 1e-6][random.usize(0..2)];
            let [x, z] = [(); 2].map(|()| f32::from(random.i8(-100..100)) / 16.0);
            let [along, across] = [(); 2].map(|()| random.f32() - 0.5);
            let Ok(direction) = Dir3::new(Vec3::new(along, 0.0, across)) else {
                continue;
            };
            let origin = Vec3::new(x, height, z);
            let hit = NarrowPhase::default().cast_ray(target, origin, direction, 30.0);
            if let Some(hit) = hit {
                let off = hit.point.distance(origin + direction * hit.distance);
                assert!(off < 1e-4, "{off}: {origin} {direction:?} {hit:?}");
                met += 1;
            }
        }
    }
    assert!(met > 100, "{met}");
}
