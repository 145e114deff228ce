//! Rays by faces, and through: of all kinds of parts.

use bevy::math::{Dir3, IVec3, Quat, Vec3};
use bevy_rapier3d::geometry::Collider;

use crate::narrow_phase::cast::tests::distance;
use crate::narrow_phase::tests::at;
use crate::narrow_phase::*;

const DEFAULT: RayCastOptions = RayCastOptions::DEFAULT;

fn vector(random: &mut fastrand::Rng, reach: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * reach))
}

#[test]
fn solids_are_left_where_they_end() {
    let corners: Vec<_> = (0..8u8)
        .map(|i| Vec3::new(f32::from(i & 1), f32::from(i >> 1 & 1), f32::from(i >> 2)) * 1.5)
        .collect();
    let solids = [
        Collider::capsule_y(0.5, 0.5),
        Collider::cylinder(0.7, 0.5),
        Collider::cone(0.7, 0.5),
        Collider::round_cuboid(0.5, 0.3, 0.2, 0.1),
        Collider::convex_hull(&corners).unwrap(),
    ];
    let (tests, mut random) = (NarrowPhase::default(), fastrand::Rng::with_seed(7));
    let mut met = 0;
    for solid in &solids {
        let shape = Shape::from(solid);
        for _ in 0..300 {
            let place =
                at(0.3, -0.2, 0.1).with_rotation(Quat::from_scaled_axis(vector(&mut random, 2.0)));
            let target = Placed::new(&shape, &place);
            let (origin, goal) = (
                vector(&mut random, 2.0),
                place.translation + vector(&mut random, 0.7),
            );
            let Ok(direction) = Dir3::new(goal - origin) else {
                continue;
            };
            let cast = |options| tests.cast_ray_with(target, origin, direction, 20.0, &options);
            let Some(passage) = tests.cast_ray_through(target, origin, direction, 20.0) else {
                assert_eq!(
                    [
                        cast(DEFAULT),
                        cast(DEFAULT.back_faces()),
                        cast(DEFAULT.hollow())
                    ],
                    [None; 3]
                );
                continue;
            };
            let leave = passage.leave.unwrap();
            let start = passage.enter.map_or(0.0, |enter| enter.distance);
            if leave.distance - start < 1e-2 {
                continue;
            }
            met += 1;
            let away = |t: f32| distance(target, origin + direction * t);
            assert!(
                away(leave.distance) < 1e-4 && away(leave.distance + 1e-2) > 0.0,
                "{passage:?}"
            );
            assert_eq!(away(start.midpoint(leave.distance)), 0.0, "{passage:?}");
            assert!(
                leave.is_back_face() && passage.enter.is_none_or(|enter| !enter.is_back_face()),
                "{passage:?} {direction:?} {shape:?}"
            );
            let is_same = |hit: Option<Impact>, end: Option<Impact>| match (hit, end) {
                (Some(hit), Some(end)) => (hit.distance - end.distance).abs() < 1e-4,
                (hit, end) => hit.is_none() && end.is_none(),
            };
            assert!(is_same(cast(DEFAULT.back_faces()), Some(leave)));
            assert!(is_same(
                cast(DEFAULT.hollow()),
                passage.enter.or(Some(leave))
            ));
            assert!(is_same(cast(DEFAULT.hollow().front_faces()), passage.enter));
        }
    }
    assert!(met > 700, "{met}");
}

#[test]
fn parts_that_hang_together_are_left_as_one() {
    let row: Vec<_> = [0, 1, 2, 5].map(|x| IVec3::new(x, 0, 0)).to_vec();
    let voxels = Collider::voxels(Vec3::ONE, &row);
    let half_space = Collider::halfspace(Vec3::Y).unwrap();
    let (tests, here) = (NarrowPhase::default(), at(0.0, 0.0, 0.0));
    let ends = |collider: &Collider, origin: Vec3, way: Vec3| {
        let shape = Shape::from(collider);
        let passage = tests.cast_ray_through(
            Placed::new(&shape, &here),
            origin,
            Dir3::new(way).unwrap(),
            100.0,
        )?;
        let end = |end: Option<Impact>| end.map(|end| (end.distance * 1e3).round() / 1e3);
        Some([end(passage.enter), end(passage.leave)])
    };
    let from = |x: f32| ends(&voxels, Vec3::new(x, 0.4, 0.6), Vec3::X);
    let first = from(-3.0).unwrap();
    let [Some(enter), Some(leave)] = first else {
        panic!("{first:?}");
    };
    assert!((leave - enter - 3.0).abs() < 1e-3, "{first:?}");
    let inside = -3.0 + enter + 1.5;
    assert_eq!(from(inside), Some([None, Some(1.5)]));
    assert!(from(inside + 2.0).is_some_and(|[enter, leave]| enter.is_some() && leave.is_some()));
    assert_eq!(
        ends(&half_space, Vec3::Y * -2.0, Vec3::Y),
        Some([None, Some(2.0)])
    );
    assert_eq!(
        ends(&half_space, Vec3::Y * 2.0, Vec3::NEG_Y),
        Some([Some(2.0), None])
    );
    assert_eq!(ends(&half_space, Vec3::Y * 2.0, Vec3::Y), None);
    let ground = Shape::from(&half_space);
    let cast = |y: f32, way: Dir3, options| {
        let hit = tests.cast_ray_with(Placed::new(&ground, &here), Vec3::Y * y, way, 9.0, &options);
        hit.map(|hit| hit.distance)
    };
    assert_eq!(cast(0.0, Dir3::X, DEFAULT.ignore_start()), None);
    assert_eq!(cast(0.0, Dir3::Y, DEFAULT.ignore_start()), None);
    assert_eq!(cast(0.0, Dir3::NEG_Y, DEFAULT.ignore_start()), Some(0.0));
    assert_eq!(cast(-1.0, Dir3::Y, DEFAULT.back_faces()), Some(1.0));
    assert_eq!(cast(-1.0, Dir3::X, DEFAULT.hollow()), None);
}
