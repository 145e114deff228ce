//! The planes that may part two solids, checked by what looks at all corners, edges and faces, and
//! by verdicts on single moments.

use bevy::math::{Dir3, Quat, Vec3, Vec3A};
use bevy::transform::components::Transform;
use fastrand::Rng;

use super::{Answer, first_impact};
use crate::narrow_phase::{
    cast::first_impact::FirstImpact,
    frame::placed::PlacedPair,
    tests::box_of,
    {NarrowPhase, Placed, Shape, Workspace},
};

fn solids() -> Vec<Shape> {
    let octahedron: Vec<_> = Vec3::AXES
        .into_iter()
        .flat_map(|axis| [axis, -axis])
        .collect();
    let around = [[2, 4], [4, 3], [3, 5], [5, 2]];
    let sides = around.map(|[a, b]| [0, a, b]).into_iter();
    let sides: Vec<_> = sides.chain(around.map(|[a, b]| [1, b, a])).collect();
    let corners = (0..7u16).map(|corner| Quat::from_rotation_y(0.9 * f32::from(corner)) * Vec3::X);
    let ring: Vec<_> = corners
        .clone()
        .chain(corners.map(|corner| corner + Vec3::Y))
        .collect();
    let mut prism: Vec<Vec<u32>> = vec![(0..7).collect(), (7..14).rev().collect()];
    prism.extend((0..7).map(|side| vec![side, side + 7, (side + 1) % 7 + 7, (side + 1) % 7]));
    let pyramid = [
        Vec3::new(-1., 0., -1.),
        Vec3::new(1., 0., -1.),
        Vec3::Z,
        Vec3::Y,
    ];
    vec![
        box_of(0.5, 1.0, 0.7),
        box_of(1.0, 0.1, 0.7),
        Shape::convex(octahedron, sides).unwrap(),
        Shape::convex(ring, prism).unwrap(),
        Shape::convex(pyramid, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]).unwrap(),
    ]
}

fn vector(rng: &mut Rng, reach: f32) -> Vec3 {
    Vec3::from([(); 3].map(|()| (2.0 * rng.f32() - 1.0) * reach))
}

/// Turned any way, hardly turned, or by quarters.
fn rotation(rng: &mut Rng) -> Quat {
    let axis = vector(rng, 1.0).try_normalize().unwrap_or(Vec3::X);
    match rng.u8(0..4) {
        0 => Quat::IDENTITY,
        1 => Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
        2 => Quat::from_axis_angle(axis, 10f32.powf(-6.0 * rng.f32())),
        _ => Quat::from_axis_angle(axis, 3.0 * rng.f32()),
    }
}

#[test]
fn planes_say_what_corners_edges_and_faces_say() {
    let (tests, loose) = (NarrowPhase::default(), NarrowPhase::new(1e-3).unwrap());
    let (solids, mut rng) = (solids(), Rng::with_seed(12));
    let workspace = &mut Workspace::default();
    let (mut met, mut unknown, mut rounds) = (0, 0, 0);
    while rounds < 20_000 {
        let [one, other] = [(); 2].map(|()| &solids[rng.usize(0..solids.len())]);
        let mut scale = || Vec3::from([(); 3].map(|()| if rng.bool() { 1.0 } else { -0.7 }));
        let scales = [scale(), scale()];
        let mut turn = rotation(&mut rng);
        let here = Transform::from_rotation(turn).with_scale(scales[0]);
        if rng.bool() {
            turn = rotation(&mut rng);
        }
        let there = Transform::from_translation(vector(&mut rng, 4.0))
            .with_rotation(turn)
            .with_scale(scales[1]);
        let aim = there.translation + vector(&mut rng, 1.5);
        let aim = if rng.bool() { turn * Vec3::X } else { aim };
        let Ok(direction) = Dir3::new(aim) else {
            continue;
        };
        let (a, b) = (Placed::new(one, &here), Placed::new(other, &there));
        if tests.intersects(a, b, workspace) {
            continue;
        }
        rounds += 1;
        let pair = PlacedPair::new(a, b, tests.tolerance()).unwrap();
        let way = Vec3A::from(*direction);
        let expected = FirstImpact::new(way, 6.0).of_polygons(&pair, workspace);
        let mut at = |tests: &NarrowPhase, distance: f32| {
            let moved = here.with_translation(direction * distance);
            tests.contact(Placed::new(one, &moved), b, workspace)
        };
        match first_impact(&pair, way, 6.0, &mut Workspace::default()) {
            Answer::Unknown => unknown += 1,
            Answer::Apart => {
                // A graze is none for one of them, perhaps.
                let depth = expected
                    .and_then(|met| at(&loose, met.distance + 0.01))
                    .map_or(0.0, |met| met.depth);
                assert!(
                    depth < 5e-3,
                    "{depth} {expected:?} {a:?} {b:?} {direction:?}"
                );
            }
            Answer::Met(found) => {
                met += 1;
                let there = at(&loose, found.distance).expect("they touch where they meet");
                // Of depths that are hardly more than the least, that along a face is preferred.
                assert!(there.depth < 5e-3, "{there:?} {found:?}");
                assert!(found.normal.is_normalized() && found.normal.dot(way) < 0.0);
                let point = Vec3::from(found.point);
                for placed in [
                    b,
                    Placed::new(one, &here.with_translation(direction * found.distance)),
                ] {
                    let closest = tests
                        .closest_point(placed, point, &mut Workspace::default())
                        .unwrap();
                    assert!(
                        closest.distance(point) < 5e-4,
                        "{point} {found:?} is not on {placed:?}: {closest} {here:?} {one:?} {direction:?}"
                    );
                }
                if let Some(expected) = expected {
                    // Of what grazes, neither is wrong.
                    let slow = 3e-4 / found.normal.dot(way).abs().max(1e-3);
                    let off = (found.distance - expected.distance).abs();
                    assert!(
                        off < slow,
                        "{off} {found:?} {expected:?} {a:?} {b:?} {direction:?}"
                    );
                } else {
                    let deep = at(&loose, found.distance + 0.01).map_or(0.0, |met| met.depth);
                    assert!(deep < 5e-3, "{deep} {found:?} is missed");
                }
            }
        }
    }
    assert!(
        met > 4_000 && unknown < 20,
        "{met} met, {unknown} unknown of {rounds}"
    );
}

#[test]
fn faces_meet_in_the_middle_of_what_they_share() {
    let (brick, workspace) = (box_of(1.0, 1.0, 1.0), &mut Workspace::default());
    let turn = Quat::from_rotation_z(0.4) * Quat::from_rotation_x(1.0);
    for turn in [Quat::IDENTITY, turn] {
        let here = Transform::from_rotation(turn);
        let there = here.with_translation(turn * Vec3::new(5.0, 0.5, 1.0));
        let pair = PlacedPair::new(
            Placed::new(&brick, &here),
            Placed::new(&brick, &there),
            1e-6,
        )
        .unwrap();
        let Answer::Met(found) = first_impact(&pair, Vec3A::from(turn * Vec3::X), 9.0, workspace)
        else {
            panic!("they meet");
        };
        let expected = turn * Vec3::new(4.0, 0.25, 0.5);
        assert!(
            Vec3::from(found.point).distance(expected) < 3e-4,
            "{found:?}"
        );
        assert!(
            (found.distance - 3.0).abs() < 1e-5
                && found.normal.distance((turn * Vec3::NEG_X).into()) < 1e-5
        );
    }
}
