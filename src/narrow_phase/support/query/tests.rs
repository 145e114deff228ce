//! Shapes of Rapier against references in 64-bit floats, which are as slow as they are plain.

use bevy::math::{DQuat, DVec3, Quat, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::IVector;
use bevy_rapier3d::parry::shape::SharedShape;

use crate::narrow_phase::mesh::cube::SIDES;
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::narrow_phase::*;

pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.0.f32()
    }

    /// In the cube from −1 to 1.
    pub fn point(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    pub fn direction(&mut self) -> Vec3 {
        self.point().normalize_or(Vec3::X)
    }

    pub fn turn(&mut self) -> Quat {
        Quat::from_scaled_axis(self.point() * 3.0)
    }
}

/// The place of a point of a placed shape.
fn place(at: &Transform, point: DVec3) -> DVec3 {
    at.translation.as_dvec3() + turn(at) * point
}

fn turn(at: &Transform) -> DQuat {
    at.rotation.as_dquat().normalize()
}

/// Asked both ways round, which is to make no difference.
pub fn distance(a: (&Shape, Transform), b: (&Shape, Transform)) -> Proximity {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let found = NarrowPhase::default()
        .closest_points(one, two, &mut workspace)
        .expect("the pair is known");
    let back = NarrowPhase::default()
        .closest_points(two, one, &mut workspace)
        .expect("the pair is known");
    assert_eq!(
        (found.distance, found.offset),
        (back.distance, -back.offset)
    );
    found
}

pub fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Option<Contact> {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let tests = NarrowPhase::default();
    let found = tests.contact(one, two, &mut workspace);
    assert_eq!(
        found,
        tests
            .contact(two, one, &mut workspace)
            .map(Contact::reversed)
    );
    assert_eq!(found.is_some(), tests.intersects(one, two, &mut workspace));
    found
}

pub fn hull_of(half: Vec3) -> SharedShape {
    let corners: Vec<_> = (0..8).map(|i| half * Vec3::from(signs(i))).collect();
    let faces = SIDES;
    let triangles: Vec<_> = faces
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
        .collect();
    SharedShape::convex_mesh(corners, &triangles).expect("it has a volume")
}

fn signs(i: u8) -> [f32; 3] {
    [0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1.0 } else { 1.0 })
}

/// A box in all forms that there are.
pub fn boxes_of(half: Vec3) -> Vec<(&'static str, Shape)> {
    let mesh = mesh_of(half);
    let Shape::Mesh(polygons) = &mesh else {
        unreachable!()
    };
    let (vertices, quads) = (
        polygons.vertices().to_vec(),
        polygons.polygons().map(<[u32]>::to_vec),
    );
    let quads: Vec<_> = quads.collect();
    let triangles = quads
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
        .collect();
    let compound = vec![(
        bevy_rapier3d::parry::math::Pose::IDENTITY,
        SharedShape::cuboid(half.x, half.y, half.z),
    )];
    vec![
        ("cuboid", box_of(half.x, half.y, half.z)),
        (
            "Rapier's cuboid",
            SharedShape::cuboid(half.x, half.y, half.z).into(),
        ),
        ("hull", hull_of(half).into()),
        (
            "convex mesh",
            Shape::convex(vertices.clone(), &quads).expect("it is convex"),
        ),
        ("mesh", mesh),
        (
            "triangles",
            SharedShape::trimesh(vertices, triangles)
                .expect("they are fine")
                .into(),
        ),
        ("compound", SharedShape::compound(compound).into()),
    ]
}

/// The distance of a segment from a box around the origin, by a search for the least of a convex
/// function.
fn segment_to_box(ends: [DVec3; 2], half: DVec3) -> f64 {
    let at = |share: f64| {
        let point = ends[0].lerp(ends[1], share);
        (point - point.clamp(-half, half)).length()
    };
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for _ in 0..200 {
        let (one, two) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(one) <= at(two) {
            high = two;
        } else {
            low = one;
        }
    }
    at(low.midpoint(high)).min(at(0.0)).min(at(1.0))
}

#[test]
fn capsules_near_large_boxes_are_as_far_as_they_are() {
    let mut random = Random::new(1);
    let (half_length, radius) = (0.5, 0.4);
    let capsule: Shape = SharedShape::capsule_y(half_length, radius).into();
    let (mut apart, mut touching) = (0, 0);
    let halves = (0..12).map(|i| match i % 3 {
        0 => Vec3::new(0.5, 30.0, 100.0),
        1 => Vec3::from_array([30.0, 60.0, 100.0].map(|half: f32| half)),
        _ => Vec3::new(100.0, 0.5, 100.0),
    });
    for half in halves {
        for (name, large) in boxes_of(half) {
            for _ in 0..60 {
                let at_box =
                    Transform::from_translation(random.point() * 50.0).with_rotation(random.turn());
                let at_box = if random.0.bool() {
                    at_box.with_rotation(Quat::from_rotation_y(0.2))
                } else {
                    at_box
                };
                // Over a face, an edge or a corner, from 4 cm deep to 3 cm away.
                let on_face = (random.point() * 1.1).clamp(Vec3::NEG_ONE, Vec3::ONE) * half;
                let axis = random.0.usize(0..3);
                let side = half[axis].copysign(random.between(-1.0, 1.0));
                let upright = random.0.bool();
                let turned = if upright {
                    at_box.rotation
                } else {
                    random.turn()
                };
                let mut center = on_face;
                center[axis] = side;
                let along = turned.inverse() * at_box.rotation * Vec3::AXES[axis];
                let support = half_length * along.y.abs() + radius;
                center[axis] += (support + random.between(-0.04, 0.03)) * side.signum();
                let at_capsule = Transform::from_translation(at_box * center).with_rotation(turned);
                let ends = [1.0, -1.0]
                    .map(|end| place(&at_capsule, DVec3::Y * f64::from(half_length) * end));
                let local =
                    ends.map(|end| turn(&at_box).inverse() * (end - at_box.translation.as_dvec3()));
                let expected = segment_to_box(local, half.as_dvec3()) - f64::from(radius);
                let tolerance =
                    f64::from(1e-4f32.max(16.0 * f32::EPSILON * (half.max_element() + 0.9)));
                let found = contact((&large, at_box), (&capsule, at_capsule));
                if expected > tolerance + 1e-5 {
                    apart += 1;
                    assert!(
                        found.is_none(),
                        "{name} {half}: {found:?} at a distance of {expected}"
                    );
                    let near = distance((&large, at_box), (&capsule, at_capsule));
                    assert!(
                        (f64::from(near.distance) - expected).abs() < 2e-5,
                        "{name}: {near:?}, not {expected}"
                    );
                } else if expected < tolerance - 1e-5 {
                    touching += 1;
                    let Some(found) = found else {
                        panic!("{name} {half}: apart at a distance of {expected}")
                    };
                    // While its axis is outside, no other way out is shorter.
                    assert!(expected > -f64::from(radius));
                    let depth = (-expected).max(0.0);
                    let off = (f64::from(found.depth) - depth).abs();
                    let surface = matches!(name, "mesh" | "triangles");
                    assert!(
                        off < 2e-5 || (surface && found.depth < 0.1),
                        "{name}: {found:?}, not {depth}"
                    );
                }
            }
        }
    }
    assert!(
        apart > 1000 && touching > 1000,
        "{apart} apart, {touching} touching"
    );
}

/// A convex shape and the point of it that is furthest along a direction, written anew here.
pub struct Solid {
    name: &'static str,
    pub shape: Shape,
    furthest: Box<dyn Fn(DVec3) -> DVec3>,
}

pub fn solids(size: f32, random: &mut Random) -> Vec<Solid> {
    let s = f64::from(size);
    let ring = |d: DVec3| d.with_y(0.0).normalize_or_zero();
    let boxed = move |d: DVec3| d.map(|x| 1f64.copysign(x)) * DVec3::new(s, 0.5 * s, 2.0 * s);
    let points: Vec<_> = (0..12).map(|_| random.direction() * size).collect();
    let hull = SharedShape::convex_hull(&points).expect("it has a volume");
    let corners: Vec<_> = hull
        .as_convex_polyhedron()
        .expect("it is one")
        .points()
        .to_vec();
    let solid = |name, shape: SharedShape, furthest| Solid {
        name,
        shape: shape.into(),
        furthest,
    };
    let outwards = |d: DVec3| d.normalize();
    let round = size * 0.25;
    vec![
        solid(
            "ball",
            SharedShape::ball(size),
            Box::new(move |d| outwards(d) * s),
        ),
        solid(
            "cuboid",
            SharedShape::cuboid(size, 0.5 * size, 2.0 * size),
            Box::new(boxed),
        ),
        solid(
            "capsule",
            SharedShape::capsule_x(size, 0.5 * size),
            Box::new(move |d| DVec3::X * s.copysign(d.x) + outwards(d) * 0.5 * s),
        ),
        solid(
            "cylinder",
            SharedShape::cylinder(size, 0.5 * size),
            Box::new(move |d| ring(d) * 0.5 * s + DVec3::Y * s.copysign(d.y)),
        ),
        solid(
            "cone",
            SharedShape::cone(size, 0.5 * size),
            Box::new(move |d| {
                let (apex, base) = (DVec3::Y * s, ring(d) * 0.5 * s - DVec3::Y * s);
                if apex.dot(d) > base.dot(d) {
                    apex
                } else {
                    base
                }
            }),
        ),
        solid(
            "round cuboid",
            SharedShape::round_cuboid(size, 0.5 * size, 2.0 * size, round),
            Box::new(move |d| boxed(d) + outwards(d) * f64::from(round)),
        ),
        solid(
            "hull",
            hull,
            Box::new(move |d| {
                let corners = corners.iter().map(|corner| corner.as_dvec3());
                corners
                    .max_by(|a, b| a.dot(d).total_cmp(&b.dot(d)))
                    .expect("there are some")
            }),
        ),
    ]
}

/// How far the second is beyond the first along a direction; less than zero if they overlap that
/// way.
fn separation(a: (&Solid, &Transform), b: (&Solid, &Transform), along: DVec3) -> f64 {
    let furthest = |(solid, at): (&Solid, &Transform), along: DVec3| {
        place(at, (solid.furthest)(turn(at).inverse() * along)).dot(along)
    };
    -furthest(b, -along) - furthest(a, along)
}

#[test]
fn distances_and_depths_are_certain_for_all_convex_shapes() {
    let mut random = Random::new(2);
    let (mut apart, mut deep) = (0, 0);
    for sizes in [
        [1.0, 1.0],
        [0.5, 60.0],
        [100.0, 0.3],
        [0.01, 0.02],
        [40.0, 90.0],
    ] {
        let (ones, others) = (solids(sizes[0], &mut random), solids(sizes[1], &mut random));
        let reach = sizes[0] + sizes[1];
        for (a, b) in ones.iter().flat_map(|a| others.iter().map(move |b| (a, b))) {
            for _ in 0..12 {
                let at_a =
                    Transform::from_translation(random.point() * 10.0).with_rotation(random.turn());
                let way = random.direction() * reach * random.between(0.0, 2.5);
                let at_b = Transform::from_translation(at_a.translation + way)
                    .with_rotation(random.turn());
                let rounding = f64::from(reach) * 1e-5;
                let names = (a.name, b.name, reach);
                let near = distance((&a.shape, at_a), (&b.shape, at_b));
                let found = contact((&a.shape, at_a), (&b.shape, at_b));
                if near.distance > 0.0 {
                    apart += 1;
                    // A plane between the two says that they are no nearer, the two points that
                    // they are no further.
                    let along = near.offset.as_dvec3().normalize();
                    let certain = separation((a, &at_a), (b, &at_b), along);
                    assert!(
                        (certain - f64::from(near.distance)).abs() < rounding,
                        "{names:?}: {certain} {near:?}"
                    );
                    assert!(
                        found.is_none() || near.distance < 1e-3,
                        "{names:?}: {found:?} {near:?}"
                    );
                } else if let Some(found) = found {
                    let normal = found.normal.as_dvec3().normalize();
                    // What it says parts the two, and next to no direction does so with less.
                    let overlap = -separation((a, &at_a), (b, &at_b), normal);
                    assert!(
                        (overlap - f64::from(found.depth)).abs() < rounding,
                        "{names:?}: {overlap} {found:?}"
                    );
                    let least = (0..2000)
                        .map(|_| random.direction().as_dvec3())
                        .map(|along| -separation((a, &at_a), (b, &at_b), along));
                    let least = least.fold(f64::INFINITY, f64::min);
                    assert!(
                        overlap < least * 1.01 + rounding,
                        "{names:?}: {overlap}, at least {least}"
                    );
                    deep += usize::from(found.depth > 0.0);
                } else {
                    panic!("{names:?}: no contact at a distance of zero");
                }
            }
        }
    }
    assert!(apart > 1000 && deep > 500, "{apart} apart, {deep} deep");
}

/// Hills, as a height field, as its triangles, and as a mesh of ours.
fn hills() -> [Shape; 3] {
    let heights: Vec<_> = (0..49).map(|i| ((i * 13) % 7) as f32 * 0.15).collect();
    let collider = Collider::heightfield(heights, 7, 7, Vec3::new(12.0, 1.5, 9.0));
    let (vertices, triangles) = collider
        .raw
        .as_heightfield()
        .expect("it is one")
        .to_trimesh();
    let trimesh = SharedShape::trimesh(vertices.clone(), triangles.clone()).expect("it is fine");
    [
        (&collider).into(),
        trimesh.into(),
        Shape::mesh(vertices, triangles).expect("it is fine"),
    ]
}

/// Some voxels, and the same as cuboids.
fn voxels() -> ([Shape; 2], Vec<(Shape, Vec3)>) {
    let filled = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [-3, 2, 1], [4, 0, -2]];
    let size = Vec3::new(1.0, 0.5, 2.0);
    let cells = filled.map(|[x, y, z]| IVector::new(x, y, z));
    let voxels = SharedShape::voxels(size, &cells);
    let half = size * 0.5;
    let cuboids = filled.map(|cell| (Vec3::from(cell.map(|i: i32| i as f32 + 0.5)) * size, half));
    let parts = cuboids.map(|(center, half)| {
        let pose = bevy_rapier3d::parry::math::Pose::from_parts(center, Quat::IDENTITY);
        (pose, SharedShape::cuboid(half.x, half.y, half.z))
    });
    let alone = cuboids.map(|(center, half)| (box_of(half.x, half.y, half.z), center));
    (
        [voxels.into(), SharedShape::compound(parts.to_vec()).into()],
        alone.to_vec(),
    )
}

#[test]
fn height_fields_and_voxels_are_as_far_as_what_they_are_made_of() {
    let mut random = Random::new(3);
    let [field, trimesh, mesh] = hills();
    let ([voxels, compound], cuboids) = voxels();
    let probes: Vec<(Shape, Shape)> = vec![
        (Shape::sphere(0.4), SharedShape::ball(0.4).into()),
        (
            box_of(0.5, 0.3, 0.4),
            SharedShape::cuboid(0.5, 0.3, 0.4).into(),
        ),
        (
            mesh_of(Vec3::new(0.2, 0.6, 0.3)),
            hull_of(Vec3::new(0.2, 0.6, 0.3)).into(),
        ),
    ];
    let (mut near, mut touching) = (0, 0);
    for i in 0..600 {
        let at_field =
            Transform::from_translation(random.point() * 100.0).with_rotation(random.turn());
        let far = if i % 3 == 0 { 10.0 } else { 1.0 };
        let local = random.point() * Vec3::new(7.0, 1.5, 6.0) * far;
        let at_probe = Transform::from_translation(at_field * local).with_rotation(random.turn());
        let (own, theirs) = &probes[i % 3];
        // Our polygons against our own, edge by edge, in another way than with shapes of Rapier.
        let expected = distance((&mesh, at_field), (own, at_probe)).distance;
        let mut at_cuboid = at_field;
        let of_cuboids = cuboids.iter().map(|(cuboid, center)| {
            at_cuboid.translation = at_field * *center;
            distance((cuboid, at_cuboid), (own, at_probe)).distance
        });
        let of_cuboids = of_cuboids.fold(f32::INFINITY, f32::min);
        for probe in [own, theirs] {
            for (shape, expected) in [
                (&field, expected),
                (&trimesh, expected),
                (&voxels, of_cuboids),
                (&compound, of_cuboids),
            ] {
                let found = distance((shape, at_field), (probe, at_probe));
                let off = (found.distance - expected).abs();
                assert!(
                    off < 1e-4 * (1.0 + far),
                    "{shape:?} and {probe:?}: {found:?}, not {expected}"
                );
                let meets = contact((shape, at_field), (probe, at_probe));
                if (expected - 1e-4).abs() > 5e-5 {
                    assert_eq!(meets.is_some(), expected <= 1e-4, "{probe:?} at {expected}");
                }
                near += usize::from(expected > 0.0);
                touching += usize::from(meets.is_some_and(|meets| meets.depth < 2.0));
            }
        }
    }
    assert!(
        near > 1000 && touching > 300,
        "{near} near, {touching} touching"
    );
}

#[test]
fn rapier_shapes_meet_each_other_whatever_they_consist_of() {
    let [field, trimesh, mesh] = hills();
    let ([voxels, compound], _) = voxels();
    let ground: Shape = SharedShape::halfspace(Vec3::Y).into();
    let shapes = [&field, &trimesh, &mesh, &voxels, &compound];
    for (i, a) in shapes.into_iter().enumerate() {
        for b in &shapes[i..] {
            if matches!((a, b), (Shape::Mesh(_), Shape::Mesh(_))) {
                continue;
            }
            let turned = Quat::from_rotation_x(0.4);
            assert!(
                contact(
                    (a, at(0.1, 0.2, 0.0)),
                    (b, at(0.3, 0.2, 0.4).with_rotation(turned))
                )
                .is_some()
            );
            let near = distance((a, at(0.0, 0.0, 0.0)), (b, at(2.0, 9.0, 1.0)));
            assert!((6.0..9.5).contains(&near.distance), "{near:?}");
        }
        let found = contact((&ground, at(0.0, 0.1, 0.0)), (a, at(0.0, 0.0, 0.0))).unwrap();
        assert!(found.normal == Vec3::Y && found.depth >= 0.1, "{found:?}");
        assert!(contact((&ground, at(0.0, -1.1, 0.0)), (a, at(0.0, 0.0, 0.0))).is_none());
    }
}

#[test]
fn a_mesh_meets_a_capsule_at_any_scale() {
    let mesh = mesh_of(Vec3::new(1.0, 0.5, 0.25));
    let capsule: Shape = SharedShape::capsule_y(0.5, 0.25).into();
    let mut random = Random::new(6);
    let mut touching = 0;
    for i in 0..100 {
        let scale = random.point() * 3.0;
        let at_mesh = Transform::from_translation(random.point())
            .with_rotation(random.turn())
            .with_scale(scale);
        let at_capsule =
            Transform::from_translation(random.point() * 2.0).with_rotation(random.turn());
        let copy = mesh.clone();
        let found = distance((&copy, at_mesh), (&capsule, at_capsule)).distance;
        // The same mesh, made at that size.
        let Shape::Mesh(polygons) = &mesh else {
            unreachable!()
        };
        let ends = [0.5, -0.5].map(|end| place(&at_capsule, DVec3::Y * end));
        let local =
            ends.map(|end| turn(&at_mesh).inverse() * (end - at_mesh.translation.as_dvec3()));
        let half = (polygons.vertices()[0] * scale).abs().as_dvec3();
        let expected = (segment_to_box(local, half) - 0.25).max(0.0);
        assert!(
            (f64::from(found) - expected).abs() < 1e-4,
            "{i}: {found}, not {expected} at {scale}"
        );
        touching += usize::from(contact((&copy, at_mesh), (&capsule, at_capsule)).is_some());
    }
    assert!((10..90).contains(&touching), "{touching}");
}
