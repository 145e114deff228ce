//! Shapes of Rapier against references in 64-bit floats, which are as slow as they are plain.

use bevy::math::{DQuat, DVec3, Dir3, Quat, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::IVector;
use bevy_rapier3d::parry::shape::SharedShape;

use super::tests::{at, box_of, mesh_of};
use super::*;

struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.0.f32()
    }

    /// In the cube from −1 to 1.
    fn point(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    fn direction(&mut self) -> Vec3 {
        self.point().normalize_or(Vec3::X)
    }

    fn turn(&mut self) -> Quat {
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
fn distance(a: (&Shape, Transform), b: (&Shape, Transform)) -> Proximity {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let found = NarrowPhase::default().closest_points(one, two, &mut workspace).expect("the pair is known");
    let back = NarrowPhase::default().closest_points(two, one, &mut workspace).expect("the pair is known");
    assert_eq!((found.distance, found.offset), (back.distance, -back.offset));
    found
}

fn contact(a: (&Shape, Transform), b: (&Shape, Transform)) -> Option<Contact> {
    let (one, two) = (Placed::new(a.0, &a.1), Placed::new(b.0, &b.1));
    let mut workspace = Workspace::default();
    let tests = NarrowPhase::default();
    let found = tests.contact(one, two, &mut workspace);
    assert_eq!(found, tests.contact(two, one, &mut workspace).map(Contact::reversed));
    assert_eq!(found.is_some(), tests.intersects(one, two, &mut workspace));
    found
}

fn hull_of(half: Vec3) -> SharedShape {
    let corners: Vec<_> = (0..8).map(|i| half * Vec3::from(signs(i))).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<_> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    SharedShape::convex_mesh(corners, &triangles).expect("it has a volume")
}

fn signs(i: u8) -> [f32; 3] {
    [0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1.0 } else { 1.0 })
}

/// A box in all forms that there are.
fn boxes_of(half: Vec3) -> Vec<(&'static str, Shape)> {
    let mesh = mesh_of(half);
    let Shape::Mesh(polygons) = &mesh else { unreachable!() };
    let (vertices, quads) = (polygons.vertices().to_vec(), polygons.polygons().map(<[u32]>::to_vec));
    let quads: Vec<_> = quads.collect();
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let compound = vec![(bevy_rapier3d::parry::math::Pose::IDENTITY, SharedShape::cuboid(half.x, half.y, half.z))];
    vec![
        ("cuboid", box_of(half.x, half.y, half.z)),
        ("Rapier's cuboid", SharedShape::cuboid(half.x, half.y, half.z).into()),
        ("hull", hull_of(half).into()),
        ("convex mesh", Shape::convex(vertices.clone(), &quads).expect("it is convex")),
        ("mesh", mesh),
        ("triangles", SharedShape::trimesh(vertices, triangles).expect("they are fine").into()),
        ("compound", SharedShape::compound(compound).into()),
    ]
}

/// The distance of a segment from a box around the origin, by a search for the least of a convex function.
fn segment_to_box(ends: [DVec3; 2], half: DVec3) -> f64 {
    let at = |share: f64| {
        let point = ends[0].lerp(ends[1], share);
        (point - point.clamp(-half, half)).length()
    };
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for _ in 0..200 {
        let (one, two) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(one) <= at(two) { high = two } else { low = one }
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
                let at_box = Transform::from_translation(random.point() * 50.0).with_rotation(random.turn());
                let at_box = if random.0.bool() { at_box.with_rotation(Quat::from_rotation_y(0.2)) } else { at_box };
                // Over a face, an edge or a corner, from 4 cm deep to 3 cm away.
                let on_face = (random.point() * 1.1).clamp(Vec3::NEG_ONE, Vec3::ONE) * half;
                let axis = random.0.usize(0..3);
                let side = half[axis].copysign(random.between(-1.0, 1.0));
                let upright = random.0.bool();
                let turned = if upright { at_box.rotation } else { random.turn() };
                let mut center = on_face;
                center[axis] = side;
                let along = turned.inverse() * at_box.rotation * Vec3::AXES[axis];
                let support = half_length * along.y.abs() + radius;
                center[axis] += (support + random.between(-0.04, 0.03)) * side.signum();
                let at_capsule = Transform::from_translation(at_box * center).with_rotation(turned);
                let ends = [1.0, -1.0].map(|end| place(&at_capsule, DVec3::Y * f64::from(half_length) * end));
                let local = ends.map(|end| turn(&at_box).inverse() * (end - at_box.translation.as_dvec3()));
                let expected = segment_to_box(local, half.as_dvec3()) - f64::from(radius);
                let tolerance = f64::from(1e-4f32.max(16.0 * f32::EPSILON * (half.max_element() + 0.9)));
                let found = contact((&large, at_box), (&capsule, at_capsule));
                if expected > tolerance + 1e-5 {
                    apart += 1;
                    assert!(found.is_none(), "{name} {half}: {found:?} at a distance of {expected}");
                    let near = distance((&large, at_box), (&capsule, at_capsule));
                    assert!((f64::from(near.distance) - expected).abs() < 2e-5, "{name}: {near:?}, not {expected}");
                } else if expected < tolerance - 1e-5 {
                    touching += 1;
                    let Some(found) = found else { panic!("{name} {half}: apart at a distance of {expected}") };
                    // While its axis is outside, no other way out is shorter.
                    assert!(expected > -f64::from(radius));
                    let depth = (-expected).max(0.0);
                    let off = (f64::from(found.depth) - depth).abs();
                    let surface = matches!(name, "mesh" | "triangles");
                    assert!(off < 2e-5 || (surface && found.depth < 0.1), "{name}: {found:?}, not {depth}");
                }
            }
        }
    }
    assert!(apart > 1000 && touching > 1000, "{apart} apart, {touching} touching");
}

/// A convex shape and the point of it that is furthest along a direction, written anew here.
struct Solid {
    name: &'static str,
    shape: Shape,
    furthest: Box<dyn Fn(DVec3) -> DVec3>,
}

fn solids(size: f32, random: &mut Random) -> Vec<Solid> {
    let s = f64::from(size);
    let ring = |d: DVec3| d.with_y(0.0).normalize_or_zero();
    let boxed = move |d: DVec3| d.map(|x| 1f64.copysign(x)) * DVec3::new(s, 0.5 * s, 2.0 * s);
    let points: Vec<_> = (0..12).map(|_| random.direction() * size).collect();
    let hull = SharedShape::convex_hull(&points).expect("it has a volume");
    let corners: Vec<_> = hull.as_convex_polyhedron().expect("it is one").points().to_vec();
    let solid = |name, shape: SharedShape, furthest| Solid { name, shape: shape.into(), furthest };
    let outwards = |d: DVec3| d.normalize();
    let round = size * 0.25;
    vec![
        solid("ball", SharedShape::ball(size), Box::new(move |d| outwards(d) * s)),
        solid("cuboid", SharedShape::cuboid(size, 0.5 * size, 2.0 * size), Box::new(boxed)),
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
                if apex.dot(d) > base.dot(d) { apex } else { base }
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
                corners.max_by(|a, b| a.dot(d).total_cmp(&b.dot(d))).expect("there are some")
            }),
        ),
    ]
}

/// How far the second is beyond the first along a direction; less than zero if they overlap that way.
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
    for sizes in [[1.0, 1.0], [0.5, 60.0], [100.0, 0.3], [0.01, 0.02], [40.0, 90.0]] {
        let (ones, others) = (solids(sizes[0], &mut random), solids(sizes[1], &mut random));
        let reach = sizes[0] + sizes[1];
        for (a, b) in ones.iter().flat_map(|a| others.iter().map(move |b| (a, b))) {
            for _ in 0..12 {
                let at_a = Transform::from_translation(random.point() * 10.0).with_rotation(random.turn());
                let way = random.direction() * reach * random.between(0.0, 2.5);
                let at_b = Transform::from_translation(at_a.translation + way).with_rotation(random.turn());
                let rounding = f64::from(reach) * 1e-5;
                let names = (a.name, b.name, reach);
                let near = distance((&a.shape, at_a), (&b.shape, at_b));
                let found = contact((&a.shape, at_a), (&b.shape, at_b));
                if near.distance > 0.0 {
                    apart += 1;
                    // A plane between the two says that they are no nearer, the two points that they are no further.
                    let along = near.offset.as_dvec3().normalize();
                    let certain = separation((a, &at_a), (b, &at_b), along);
                    assert!((certain - f64::from(near.distance)).abs() < rounding, "{names:?}: {certain} {near:?}");
                    assert!(found.is_none() || near.distance < 1e-3, "{names:?}: {found:?} {near:?}");
                } else if let Some(found) = found {
                    let normal = found.normal.as_dvec3().normalize();
                    // What it says parts the two, and next to no direction does so with less.
                    let overlap = -separation((a, &at_a), (b, &at_b), normal);
                    assert!((overlap - f64::from(found.depth)).abs() < rounding, "{names:?}: {overlap} {found:?}");
                    let least = (0..2000)
                        .map(|_| random.direction().as_dvec3())
                        .map(|along| -separation((a, &at_a), (b, &at_b), along));
                    let least = least.fold(f64::INFINITY, f64::min);
                    assert!(overlap < least * 1.01 + rounding, "{names:?}: {overlap}, at least {least}");
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
    let (vertices, triangles) = collider.raw.as_heightfield().expect("it is one").to_trimesh();
    let trimesh = SharedShape::trimesh(vertices.clone(), triangles.clone()).expect("it is fine");
    [(&collider).into(), trimesh.into(), Shape::mesh(vertices, triangles).expect("it is fine")]
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
    ([voxels.into(), SharedShape::compound(parts.to_vec()).into()], alone.to_vec())
}

#[test]
fn height_fields_and_voxels_are_as_far_as_what_they_are_made_of() {
    let mut random = Random::new(3);
    let [field, trimesh, mesh] = hills();
    let ([voxels, compound], cuboids) = voxels();
    let probes: Vec<(Shape, Shape)> = vec![
        (Shape::sphere(0.4).unwrap(), SharedShape::ball(0.4).into()),
        (box_of(0.5, 0.3, 0.4), SharedShape::cuboid(0.5, 0.3, 0.4).into()),
        (mesh_of(Vec3::new(0.2, 0.6, 0.3)), hull_of(Vec3::new(0.2, 0.6, 0.3)).into()),
    ];
    let (mut near, mut touching) = (0, 0);
    for i in 0..600 {
        let at_field = Transform::from_translation(random.point() * 100.0).with_rotation(random.turn());
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
            for (shape, expected) in
                [(&field, expected), (&trimesh, expected), (&voxels, of_cuboids), (&compound, of_cuboids)]
            {
                let found = distance((shape, at_field), (probe, at_probe));
                let off = (found.distance - expected).abs();
                assert!(off < 1e-4 * (1.0 + far), "{:?} and {probe:?}: {found:?}, not {expected}", shape);
                let meets = contact((shape, at_field), (probe, at_probe));
                if (expected - 1e-4).abs() > 5e-5 {
                    assert_eq!(meets.is_some(), expected <= 1e-4, "{probe:?} at {expected}");
                }
                near += usize::from(expected > 0.0);
                touching += usize::from(meets.is_some_and(|meets| meets.depth < 2.0));
            }
        }
    }
    assert!(near > 1000 && touching > 300, "{near} near, {touching} touching");
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
            assert!(contact((a, at(0.1, 0.2, 0.0)), (b, at(0.3, 0.2, 0.4).with_rotation(turned))).is_some());
            let near = distance((a, at(0.0, 0.0, 0.0)), (b, at(2.0, 9.0, 1.0)));
            assert!((6.0..9.5).contains(&near.distance), "{near:?}");
        }
        let found = contact((&ground, at(0.0, 0.1, 0.0)), (a, at(0.0, 0.0, 0.0))).unwrap();
        assert!(found.normal == Vec3::Y && found.depth >= 0.1, "{found:?}");
        assert!(contact((&ground, at(0.0, -1.1, 0.0)), (a, at(0.0, 0.0, 0.0))).is_none());
    }
}

/// All kinds of shapes that a ray or something on its way can meet; each has the origin inside or on it, but no more than
/// two units around it.
fn targets() -> Vec<Shape> {
    let random = &mut Random::new(4);
    let flat = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 1.5)];
    let field = Collider::heightfield(vec![0.1, 0.2, 0.0, 0.1, 0.0, 0.2, 0.1, 0.0, 0.1], 3, 3, Vec3::ONE);
    let mut shapes: Vec<Shape> = solids(1.0, random).into_iter().map(|solid| solid.shape).collect();
    shapes.extend(boxes_of(Vec3::new(0.5, 1.0, 0.7)).into_iter().map(|(_, shape)| shape));
    shapes.extend([
        Shape::sphere(0.7).unwrap(),
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
    let probes = [box_of(0.2, 0.1, 0.3), SharedShape::capsule_y(0.2, 0.1).into(), mesh_of(Vec3::splat(0.2))];
    for shape in targets() {
        let (mut rays, mut sweeps) = (0, 0);
        for i in 0..40 {
            let here = Transform::from_translation(random.point()).with_rotation(random.turn());
            let target = Placed::new(&shape, &here);
            // Along a direction that 32-bit floats hold exactly, so that what is far is no other ray.
            let direction = [Dir3::X, Dir3::Y, Dir3::NEG_Z, Dir3::NEG_X][i % 4];
            let grid = |point: Vec3| (point * 1024.0).round() / 1024.0;
            let start = grid(here.translation + random.point() * 0.8) - direction * 8.0;
            let near = tests.cast_ray(target, start, direction, 100.0);
            let probe = &probes[i % 3];
            let from = Transform::from_translation(start).with_rotation(random.turn());
            let swept = tests.sweep(Placed::new(probe, &from), direction, 100.0, target, &mut workspace);
            for far in [256.0, 4096.0, 12_288.0] {
                let afar = start - direction * far;
                let hit = tests.cast_ray(target, afar, direction, 20_000.0);
                assert_eq!(hit.is_some(), near.is_some(), "{shape:?} from {far}: {hit:?} {near:?}");
                let from = from.with_translation(afar);
                let met = tests.sweep(Placed::new(probe, &from), direction, 20_000.0, target, &mut workspace);
                assert_eq!(met.is_some(), swept.is_some(), "{shape:?} and {probe:?} from {far}: {met:?} {swept:?}");
                for (hit, near) in [(hit, near), (met, swept)].into_iter().filter_map(|(a, b)| a.zip(b)) {
                    // As well as the distance can be held.
                    let off = (hit.distance - far - near.distance).abs();
                    assert!(off <= far * 2.5e-7 + 2e-5, "{shape:?} from {far}: {hit:?} {near:?}");
                    let closest = tests.closest_point(target, hit.point, &mut workspace).unwrap();
                    assert!(closest.distance(hit.point) < 1e-4, "{shape:?} from {far}: {hit:?}, closest {closest}");
                }
            }
            rays += usize::from(near.is_some());
            sweeps += usize::from(swept.is_some());
        }
        let is_thin = matches!(&shape, Shape::Rapier(shape) if shape.as_segment().is_some());
        assert!(is_thin || rays > 2, "{rays} rays hit {shape:?}");
        assert!(sweeps > 5, "{sweeps} sweeps hit {shape:?}");
    }
}

#[test]
fn a_mesh_is_converted_once_whatever_its_scales() {
    let mesh = mesh_of(Vec3::new(1.0, 0.5, 0.25));
    let capsule: Shape = SharedShape::capsule_y(0.5, 0.25).into();
    let before = parry::CONVERSIONS.get();
    let mut random = Random::new(6);
    let mut touching = 0;
    for i in 0..100 {
        let scale = random.point() * 3.0;
        let at_mesh = Transform::from_translation(random.point()).with_rotation(random.turn()).with_scale(scale);
        let at_capsule = Transform::from_translation(random.point() * 2.0).with_rotation(random.turn());
        let copy = mesh.clone();
        let found = distance((&copy, at_mesh), (&capsule, at_capsule)).distance;
        // The same mesh, made at that size.
        let Shape::Mesh(polygons) = &mesh else { unreachable!() };
        let ends = [0.5, -0.5].map(|end| place(&at_capsule, DVec3::Y * end));
        let local = ends.map(|end| turn(&at_mesh).inverse() * (end - at_mesh.translation.as_dvec3()));
        let half = (polygons.vertices()[0] * scale).abs().as_dvec3();
        let expected = (segment_to_box(local, half) - 0.25).max(0.0);
        assert!((f64::from(found) - expected).abs() < 1e-4, "{i}: {found}, not {expected} at {scale}");
        touching += usize::from(contact((&copy, at_mesh), (&capsule, at_capsule)).is_some());
    }
    assert!((10..90).contains(&touching), "{touching}");
    assert_eq!(parry::CONVERSIONS.get() - before, 1);
}

#[test]
fn a_ray_from_a_face_along_it_meets_the_shape_at_once() {
    let half = Vec3::splat(0.5);
    let mut flat: Vec<(&str, Shape, f32)> =
        boxes_of(half).into_iter().map(|(name, shape)| (name, shape, 0.5)).collect();
    let square =
        [Vec3::new(-0.5, 0.0, -0.5), Vec3::new(-0.5, 0.0, 0.5), Vec3::new(0.5, 0.0, 0.5), Vec3::new(0.5, 0.0, -0.5)];
    let field = Collider::heightfield(vec![0.0; 9], 3, 3, Vec3::ONE);
    flat.extend([
        ("open mesh", Shape::mesh(square, [[0u32, 1, 2, 3]]).unwrap(), 0.0),
        ("open triangles", SharedShape::trimesh(square.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap().into(), 0.0),
        ("height field", (&field).into(), 0.0),
        ("voxel", SharedShape::voxels(Vec3::ONE, &[IVector::new(0, 0, 0)]).into(), 1.0),
    ]);
    let round = [
        ("sphere", Shape::sphere(0.5).unwrap(), 0.5),
        ("ball", SharedShape::ball(0.5).into(), 0.5),
        ("capsule", SharedShape::capsule_x(0.3, 0.5).into(), 0.5),
        ("cylinder", SharedShape::cylinder(0.5, 0.3).into(), 0.5),
        ("cone", SharedShape::cone(0.5, 0.5).into(), -0.5),
        ("round cuboid", SharedShape::round_cuboid(0.3, 0.3, 0.3, 0.2).into(), 0.5),
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
            for direction in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.6, 0.0, 0.8), Vec3::Y, Vec3::NEG_Y] {
                let hit = tests.cast_ray(target, on_face, turned(direction), 10.0);
                assert_eq!(hit.map(|hit| hit.distance), Some(0.0), "{name} {direction} {here:?}");
            }
            // In the plane of the face, from outside: as it is alone, for rounding puts it over or under that plane.
            if i == 0 {
                let start = Vec3::new(x - 2.0, *top, x + 0.1);
                let hit = tests.cast_ray(target, start, Dir3::X, 10.0).unwrap_or_else(|| panic!("{name}"));
                assert!((hit.distance - 1.5).abs() < 1e-5 && hit.normal.x < -0.99, "{name}: {hit:?}");
                assert!(tests.cast_ray(target, start, Dir3::Z, 10.0).is_none(), "{name}");
                assert!(tests.cast_ray(target, start, Dir3::NEG_X, 10.0).is_none(), "{name}");
            }
            let over = here * Vec3::new(x + 0.2, top + 1e-3, x);
            assert!(tests.cast_ray(target, over, turned(Vec3::X), 10.0).is_none(), "{name} {here:?}");
        }
        for (name, shape, top) in &round {
            let (target, on_top) = (Placed::new(shape, &here), here * (Vec3::Y * *top));
            for direction in [Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::Y, Vec3::NEG_Y] {
                let hit = tests.cast_ray(target, on_top, turned(direction), 10.0);
                assert_eq!(hit.map(|hit| hit.distance), Some(0.0), "{name} {direction} {here:?}");
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
        let Shape::Mesh(polygons) = &mesh else { unreachable!() };
        let quads: Vec<_> = polygons.polygons().map(<[u32]>::to_vec).collect();
        let convex = Shape::convex(polygons.vertices().to_vec(), quads).unwrap();
        let mut boxes =
            vec![box_of(size, size, size), SharedShape::cuboid(size, size, size).into(), convex, mesh.clone()];
        // Larger ones, parry does not make.
        if power <= 33 {
            boxes.push(hull_of(Vec3::splat(size)).into());
        }
        // Wholly inside, of what is closed.
        let capsule: Shape = SharedShape::capsule_y(size * 0.2, size * 0.1).into();
        assert!(contact((&mesh, at(0.0, 0.0, 0.0)), (&capsule, at(0.0, size * 0.2, 0.0))).is_some(), "2^{power}");
        let balls: [Shape; 3] =
            [Shape::sphere(size).unwrap(), SharedShape::ball(size).into(), SharedShape::capsule_z(size, size).into()];
        for a in &boxes {
            for b in boxes.iter().chain(&balls) {
                for rotation in [Quat::IDENTITY, turned] {
                    let names = format!("{a:?} and {b:?}, {rotation}, at 2^{power}");
                    let here = at(0.0, 0.0, 0.0).with_rotation(rotation);
                    let there = |height: f32| at(0.0, height * size, 0.0).with_rotation(rotation);
                    let found = contact((a, here), (b, there(1.5))).unwrap_or_else(|| panic!("{names}"));
                    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_));
                    if !is_mesh(a) && !is_mesh(b) {
                        assert!(near(found.depth, 0.5) && found.normal.y > 0.999, "{names}: {found:?}");
                    }
                    assert!(found.point.is_finite() && found.depth.is_finite(), "{names}: {found:?}");
                    assert!(contact((a, here), (b, there(3.0))).is_none(), "{names}");
                    let apart = distance((a, here), (b, there(3.0)));
                    assert!(near(apart.distance, 1.0) && near(apart.offset.y, 1.0), "{names}: {apart:?}");
                    let (moving, at_moving) = (Placed::new(a, &here), there(4.0));
                    let target = Placed::new(b, &at_moving);
                    let met = tests.sweep(moving, Dir3::Y, f32::MAX, target, &mut workspace);
                    let met = met.unwrap_or_else(|| panic!("{names}"));
                    assert!(near(met.distance, 2.0) && met.normal.y < -0.999, "{names}: {met:?}");
                    let moved = Moving::new(a, &here, &there(4.0));
                    let met = tests.time_of_impact(&moved, &Moving::resting(target), &mut workspace);
                    let met = met.unwrap_or_else(|| panic!("{names}"));
                    assert!((met.time - 0.5).abs() < 1e-4 && met.contact.point.is_finite(), "{names}: {met:?}");
                }
            }
        }
        for shape in boxes.iter().chain(&balls) {
            let here = at(0.0, 0.0, 0.0).with_rotation(turned);
            let target = Placed::new(shape, &here);
            let hit = tests.cast_ray(target, Vec3::Y * (size * 3.0), Dir3::NEG_Y, f32::INFINITY);
            let hit = hit.unwrap_or_else(|| panic!("{shape:?} at 2^{power}"));
            assert!(near(hit.distance, 2.0) && hit.normal.y > 0.999, "{hit:?}, {shape:?} at 2^{power}");
            let inside = tests.cast_ray(target, Vec3::Y * (size * 0.5), Dir3::NEG_Y, f32::INFINITY);
            let is_surface = matches!(shape, Shape::Rapier(shape) if shape.as_trimesh().is_some());
            assert!(is_surface || inside.is_some_and(|hit| hit.distance == 0.0), "{shape:?} at 2^{power}");
            let closest = tests.closest_point(target, Vec3::Y * (size * 3.0), &mut workspace).unwrap();
            assert!(near(closest.y, 1.0), "{closest}, {shape:?} at 2^{power}");
            let inside = Vec3::Y * (size * 0.5);
            assert_eq!(tests.closest_point(target, inside, &mut workspace), Some(inside), "{shape:?} at 2^{power}");
            assert!(tests.world_aabb(target).is_ok() && shape.bounding_sphere(&here).is_ok());
        }
        // Small beside huge, and far away.
        let (unit, large) = (box_of(1.0, 1.0, 1.0), &boxes[0]);
        let here = at(0.0, 0.0, 0.0).with_rotation(turned);
        assert!(contact((large, here), (&unit, at(0.0, size * 0.5, 0.0))).is_some());
        if power > 1 {
            assert!(contact((large, here), (&unit, at(0.0, size * 4.0, 0.0))).is_none());
            let apart = distance((&unit, here), (&unit, at(0.0, size * 4.0, 0.0)));
            assert!((apart.distance - (size * 4.0 - 2.0)).abs() <= size * 1e-5, "{apart:?}");
            let capsule: Shape = SharedShape::capsule_y(1.0, 1.0).into();
            let apart = distance((&capsule, here), (&unit, at(0.0, size * 4.0, 0.0)));
            assert!((apart.distance - (size * 4.0 - 3.0)).abs() <= size * 1e-5, "{apart:?}");
        }
    }
    // Where even sums overflow, nothing is in contact, and there are no bounds.
    let huge = box_of(f32::MAX, f32::MAX, f32::MAX);
    let here = at(f32::MAX, 0.0, 0.0);
    assert_eq!(huge.world_aabb(&here), Err(BoundsError::NonFinite));
    assert!(contact((&huge, here), (&huge, at(-f32::MAX, 0.0, 0.0).with_rotation(turned))).is_none());
}

#[test]
#[ignore = "prints times"]
fn times() {
    use bevy_rapier3d::parry::{math::Pose, query};
    let mut random = Random::new(8);
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let shapes: Vec<SharedShape> = vec![
        SharedShape::ball(0.5), SharedShape::capsule_y(0.5, 0.4), SharedShape::cuboid(0.5, 0.4, 0.6), SharedShape::cylinder(0.5, 0.4), SharedShape::cone(0.5, 0.4), hull_of(Vec3::splat(0.5)),
    ];
    for a in &shapes { for b in &shapes {
        let places: Vec<_> = (0..2000).map(|_| {
            let p = |r: &mut Random| Transform::from_translation(r.point() * 0.8).with_rotation(r.turn());
            (p(&mut random), p(&mut random))
        }).collect();
        let (sa, sb) = (Shape::from(a.clone()), Shape::from(b.clone()));
        let pose = |t: &Transform| Pose::from_parts(t.translation, t.rotation);
        let start = std::time::Instant::now();
        let mut n = 0;
        for (x, y) in &places { n += usize::from(super::parry::intersects(Placed::new(&sa, x), Placed::new(&sb, y), 1e-4).unwrap()); }
        let ours = start.elapsed();
        let start = std::time::Instant::now();
        for (x, y) in &places { n += usize::from(query::intersection_test(&pose(x), &**a, &pose(y), &**b).unwrap() || query::distance(&pose(x), &**a, &pose(y), &**b).unwrap() <= 1e-4); }
        let theirs = start.elapsed();
        let start = std::time::Instant::now();
        for (x, y) in &places { n += usize::from(tests.contact(Placed::new(&sa, x), Placed::new(&sb, y), &mut workspace).is_some()); }
        let ours_c = start.elapsed();
        let start = std::time::Instant::now();
        for (x, y) in &places { n += usize::from(query::contact(&pose(x), &**a, &pose(y), &**b, 1e-4).unwrap().is_some()); }
        let theirs_c = start.elapsed();
        let start = std::time::Instant::now();
        for (x, y) in &places { n += usize::from(tests.cast_ray(Placed::new(&sa, x), y.translation * 4.0, Dir3::new(-y.translation).unwrap(), 10.0).is_some()); }
        let ours_r = start.elapsed();
        let start = std::time::Instant::now();
        for (x, y) in &places { n += usize::from(a.cast_ray_and_get_normal(&pose(x), &query::Ray::new(y.translation * 4.0, -y.translation.normalize()), 10.0, true).is_some()); }
        let theirs_r = start.elapsed();
        let ns = |d: std::time::Duration| d.as_nanos() / 2000;
        println!("{:?} {:?}: intersects {} / {} ns, contact {} / {}, ray {} / {} ({n})", a.shape_type(), b.shape_type(), ns(ours), ns(theirs), ns(ours_c), ns(theirs_c), ns(ours_r), ns(theirs_r));
    } }
}
