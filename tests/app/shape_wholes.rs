//! What consists of parts is as these are by themselves, for all exact tests.

use bevy::{
    math::{Dir3, Isometry3d, Vec3A},
    prelude::*,
};
use bevy_octree::narrow_phase::{HeightField, NarrowPhase, Placed, Shape, Voxels, Workspace};
use fastrand::Rng;

use crate::shape_matrix::{ROUNDS, kinds, pose};

/// A shape that consists of others, and these, each in its place.
struct Whole {
    name: &'static str,
    shape: Shape,
    parts: Vec<(Isometry3d, Shape)>,
}

fn wholes(rng: &mut Rng) -> Vec<Whole> {
    let mut parts = vec![];
    for known in kinds(rng)
        .into_iter()
        .filter(|known| !["wall", "half-space"].contains(&known.name))
        .take(6)
    {
        let at = pose(rng, 2.0, false);
        parts.push((Isometry3d::new(at.translation, at.rotation), known.shape));
    }
    let compound = Shape::compound(parts.clone()).unwrap();
    let whole = |name, shape, parts| Whole { name, shape, parts };
    let mut all = vec![whole("compound", compound, parts)];
    let mut heights = || rng.f32() * 0.8;
    let field = HeightField::from_fn(7, 6, Vec2::new(0.7, 0.5), |_, _| heights()).unwrap();
    let field = field.with_holes([(2, 3)]).unwrap();
    let triangles = (0..).map_while(|number| (number < 60).then(|| field.triangle(number)));
    let triangles = triangles.flatten().map(|corners| {
        let [a, b, c] = corners.map(Vec3::from);
        (Isometry3d::IDENTITY, Shape::triangle(a, b, c).unwrap())
    });
    let parts: Vec<_> = triangles.collect();
    assert_eq!(parts.len(), 58);
    all.push(whole("height field", field.into(), parts));
    let mut voxels = Voxels::new(0.5).unwrap();
    for _ in 0..60 {
        voxels.set(IVec3::new(rng.i32(-3..3), rng.i32(-3..3), rng.i32(-3..3)));
    }
    let cells = voxels.iter().map(|cell| {
        let center = (cell.as_vec3() + 0.5) * 0.5;
        (
            Isometry3d::from_translation(center),
            Shape::cuboid(0.5, 0.5, 0.5),
        )
    });
    let parts = cells.collect();
    all.push(whole("voxels", voxels.into(), parts));
    all
}

#[test]
fn what_consists_of_parts_is_as_these_are() {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let mut rng = Rng::with_seed(14);
    let (mut touching, mut hits, mut sweeps) = (0, 0, 0);
    for round in 0..ROUNDS {
        for Whole { name, shape, parts } in wholes(&mut rng) {
            let mut at = pose(&mut rng, 1.0, false);
            at.scale = [
                Vec3::ONE,
                Vec3::splat(1.5),
                Vec3::splat(-0.7),
                Vec3::new(-1.2, 1.2, 1.2),
            ][round % 4];
            let placed = Placed::new(&shape, &at);
            let aabb = shape.world_aabb(&at).unwrap();
            let signs = at.scale.signum();
            let parts: Vec<_> = parts
                .iter()
                .map(|(pose, shape)| {
                    // A mirrored turn is one the other way about.
                    let turn = pose.rotation;
                    let odd = signs.x * signs.y * signs.z < 0.0;
                    let mirrored = if signs == Vec3::NEG_ONE || !odd {
                        turn
                    } else {
                        Quat::from_xyzw(turn.x, -turn.y, -turn.z, turn.w)
                    };
                    let there = Transform {
                        translation: at.transform_point(pose.translation.into()),
                        rotation: at.rotation * mirrored,
                        scale: at.scale,
                    };
                    (there, shape)
                })
                .collect();
            for (there, part) in &parts {
                let inner = part.world_aabb(there).unwrap();
                let slack = Vec3A::splat(1e-4);
                // That of a part that is turned in a whole that is turned is around a box.
                let is_in = (aabb.min - slack).cmple(inner.max).all()
                    && (aabb.max + slack).cmpge(inner.min).all();
                assert!(is_in, "{name}");
            }
            for known in kinds(&mut rng) {
                let mut start = pose(&mut rng, 3.0, false);
                if round % 2 == 0 {
                    start.translation *= 0.5;
                }
                let other = Placed::new(&known.shape, &start);
                let what = || format!("{name} {at:?}\n{} {start:?}", known.name);
                let each = || parts.iter().map(|(there, part)| Placed::new(part, there));
                let near = tests.closest_points(placed, other, &mut workspace).unwrap();
                let nearest = each()
                    .map(|part| {
                        tests
                            .closest_points(part, other, &mut workspace)
                            .unwrap()
                            .distance
                    })
                    .fold(f32::INFINITY, f32::min);
                let exact = 2e-4 * if known.name == "wall" { 10.0 } else { 1.0 };
                assert!(
                    (near.distance - nearest).abs() <= exact,
                    "{} {nearest}\n{}",
                    near.distance,
                    what()
                );
                let meets = tests.intersects(placed, other, &mut workspace);
                if nearest > exact || nearest == 0.0 {
                    assert_eq!(meets, nearest == 0.0, "{}", what());
                }
                let contact = tests.contact(other, placed, &mut workspace);
                assert_eq!(contact.is_some(), meets, "{}", what());
                if let Some(contact) = contact {
                    touching += 1;
                    assert!(contact.normal.is_normalized() && contact.depth.is_finite());
                    let deepest = each()
                        .filter_map(|part| tests.contact(other, part, &mut workspace))
                        .map(|contact| contact.depth)
                        .fold(0.0, f32::max);
                    if name != "voxels" {
                        let close = (contact.depth - deepest).abs() <= 0.02 + 0.02 * deepest;
                        assert!(close, "{} {deepest}\n{}", contact.depth, what());
                    }
                }
                let Ok(direction) = Dir3::new(
                    at.translation - start.translation + pose(&mut rng, 1.0, false).translation,
                ) else {
                    continue;
                };
                let ray = tests.cast_ray(placed, start.translation, direction, 20.0);
                let first = each()
                    .filter_map(|part| tests.cast_ray(part, start.translation, direction, 20.0))
                    .map(|hit| hit.distance)
                    .reduce(f32::min);
                hits += usize::from(ray.is_some());
                match (ray.map(|hit| hit.distance), first) {
                    (Some(found), Some(first)) => {
                        assert!((found - first).abs() < 1e-3, "{found} {first}\n{}", what());
                    }
                    (found, first) => assert_eq!(found, first, "{direction:?}\n{}", what()),
                }
                if meets {
                    continue;
                }
                let swept = tests.sweep(other, direction, 20.0, placed, &mut workspace);
                let first = each()
                    .filter_map(|part| tests.sweep(other, direction, 20.0, part, &mut workspace))
                    .map(|hit| hit.distance)
                    .reduce(f32::min);
                sweeps += usize::from(swept.is_some());
                match (swept.map(|hit| hit.distance), first) {
                    (Some(found), Some(first)) => {
                        assert!((found - first).abs() < 5e-3, "{found} {first}\n{}", what());
                    }
                    (found, first) => assert_eq!(found, first, "{direction:?}\n{}", what()),
                }
            }
        }
    }
    assert!(
        touching > 200 && hits > 200 && sweeps > 100,
        "{touching} {hits} {sweeps}"
    );
}

/// The search for what is closest stopped short of it where the first of the two has no end.
#[test]
fn what_is_small_is_as_far_from_a_plane_as_it_is() {
    let floor = Shape::half_space(Vec3::Y).unwrap();
    let cells = [IVec3::ZERO, IVec3::new(1, 2, 24)];
    let voxels = Shape::Voxels(Voxels::from_cells(0.0625, cells).unwrap().into());
    let ball = (
        Isometry3d::from_translation(Vec3::X * 0.1),
        Shape::sphere(0.05),
    );
    let compound = Shape::compound([ball]).unwrap();
    for (shape, lowest) in [(voxels, 0.0), (compound, -0.05)] {
        for height in [0.1, 1.0, 100.0] {
            let at = Transform::from_xyz(1.0, height, 2.0);
            let pair = [
                Placed::new(&shape, &at),
                Placed::new(&floor, &Transform::IDENTITY),
            ];
            for [a, b] in [pair, [pair[1], pair[0]]] {
                let near = NarrowPhase::default().closest_points(a, b, &mut Workspace::default());
                let distance = near.expect("both are something").distance;
                assert!(
                    (distance - height - lowest).abs() < 1e-5,
                    "{distance} {height}"
                );
            }
        }
    }
}
