//! Times of impact, checked against a look at many moments.

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;
use proptest::prelude::*;

use crate::narrow_phase::cast::tests::{placed, shapes, vectors};
use crate::narrow_phase::tests::{at, box_of, mesh_of};
use crate::{broad_phase::overlap, narrow_phase::*};

const MOMENTS: usize = 512;

fn intersect(tests: &NarrowPhase, a: &Moving, b: &Moving, time: f32) -> bool {
    let (shape_a, shape_b, at_a, at_b) = (a.shape(), b.shape(), a.at(time), b.at(time));
    tests.intersects(
        Placed::new(shape_a, &at_a),
        Placed::new(shape_b, &at_b),
        &mut Workspace::default(),
    )
}

fn met(a: &Moving, b: &Moving) -> Option<TimedContact> {
    NarrowPhase::default().time_of_impact(a, b, &mut Workspace::default())
}

fn turned(axis: Vec3, angle: f32) -> Quat {
    axis.try_normalize()
        .map_or(Quat::IDENTITY, |axis| Quat::from_axis_angle(axis, angle))
}

fn moved_end(start: &Transform, way: Vec3) -> Transform {
    start.with_translation(start.translation + way)
}

fn turned_end(start: &Transform, way: Vec3, axis: Vec3, angle: f32) -> Transform {
    moved_end(start, way).with_rotation(turned(axis, angle) * start.rotation)
}

/// As a look at all moments has it: whether the two meet at all, and not before or after the time
/// that is found. Contacts that last for less than `shortest` moments may be missed, and those by
/// tolerance alone.
fn check(a: &Moving, b: &Moving, shortest: usize) -> Result<(), TestCaseError> {
    // As strict as rounding lets be: what only grazes may be missed.
    let [strict, loose] =
        [f32::MIN_POSITIVE, 4e-3].map(|tolerance| NarrowPhase::new(tolerance).unwrap());
    let (found, back) = (met(a, b), met(b, a));
    let time = |moment: usize| moment as f32 / MOMENTS as f32;
    let touching: Vec<_> = (0..=MOMENTS)
        .map(|moment| intersect(&strict, a, b, time(moment)))
        .collect();
    // Two that start in contact may part, for a while; what comes after that counts.
    let gap = if touching[0] { MOMENTS / 16 + 1 } else { 1 };
    let free = touching
        .windows(gap)
        .position(|gap| gap.iter().all(|touching| !touching));
    let lasts = |moment: &usize| {
        touching[*moment..]
            .iter()
            .take(shortest)
            .all(|touching| *touching)
    };
    let first = free.and_then(|free| (free..=MOMENTS).find(lasts)).map(time);
    if let Some(found) = found {
        prop_assert!(
            intersect(&loose, a, b, found.time),
            "not in contact at {}",
            found.time
        );
        prop_assert!(found.contact.normal.is_normalized());
        prop_assert!((0.0..=1.0).contains(&found.time));
        if let Some(first) = first {
            // Nor are those whose time is less exact: what turns in passing, and Rapier's.
            let margin = if shortest > 1 || is_rapiers(a) || is_rapiers(b) {
                2e-2
            } else {
                1e-3
            };
            prop_assert!(
                found.time <= first + margin,
                "found {}, met at {first}",
                found.time
            );
            prop_assert!(back.is_some());
        }
    } else {
        prop_assert!(first.is_none(), "met at {first:?}");
        prop_assert!(touching.contains(&false));
    }
    let [box_a, box_b] = [a, b].map(|moving| NarrowPhase::default().swept_aabb(moving).unwrap());
    prop_assert!(
        overlap(&box_a, &box_b) || (found.is_none() && first.is_none()),
        "a broad phase would miss it"
    );
    Ok(())
}

fn is_rapiers(moving: &Moving) -> bool {
    !matches!(
        moving.shape(),
        Shape::Cuboid { .. } | Shape::Sphere { .. } | Shape::Convex(_) | Shape::Mesh(_)
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 384, ..ProptestConfig::default() })]

    #[test]
    fn shapes_that_do_not_turn((one, at_one) in placed(), (two, at_two) in placed(), way in vectors(6.0), other in vectors(6.0)) {
        let (end, end_two) = (moved_end(&at_one, way), moved_end(&at_two, other));
        check(&Moving::new(&one, &at_one, &end), &Moving::new(&two, &at_two, &end_two), 1)?;
    }

    #[test]
    fn shapes_that_turn(
        (one, at_one) in placed(),
        (two, at_two) in placed(),
        (way, other) in (vectors(6.0), vectors(1.0)),
        (axis, angle) in (vectors(1.0), -3f32..3.0),
    ) {
        let (end, end_two) = (turned_end(&at_one, way, axis, angle), moved_end(&at_two, other));
        check(&Moving::new(&one, &at_one, &end), &Moving::new(&two, &at_two, &end_two), MOMENTS / 64 + 1)?;
    }
}

/// A turning way of one shape of [`shapes`] and a straight one of another, as `shapes_that_turn`
/// draws them: each shape and where it starts, how far they go, and an axis and the angle.
type Ways = (
    (usize, Transform),
    (usize, Transform),
    ([f32; 3], [f32; 3]),
    ([f32; 3], f32),
);

fn place(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> Transform {
    Transform {
        translation: translation.into(),
        rotation: Quat::from_array(rotation),
        scale: scale.into(),
    }
}

/// Checks ways that were drawn once.
fn check_ways(ways: impl IntoIterator<Item = Ways>) {
    let shapes = shapes();
    for (i, ((one, at_one), (two, at_two), (way, other), (axis, angle))) in
        ways.into_iter().enumerate()
    {
        let (Some(one), Some(two)) = (shapes.get(one), shapes.get(two)) else {
            // One of Rapier's.
            continue;
        };
        let end = turned_end(&at_one, way.into(), axis.into(), angle);
        let end_two = moved_end(&at_two, other.into());
        let (a, b) = (
            Moving::new(one, &at_one, &end),
            Moving::new(two, &at_two, &end_two),
        );
        if let Err(error) = check(&a, &b, MOMENTS / 64 + 1) {
            panic!("{i}: {error}");
        }
    }
}

/// They overlap, turn out of each other and meet again: on their own way, not on that of one that
/// was lifted out of the overlap.
#[test]
fn those_that_turn_out_of_an_overlap_meet_when_they_come_back() {
    check_ways([
        (
            (
                3,
                place(
                    [-1.9670136, 1.1906096, 0.4800968],
                    [0.0, 0.0, -0.10152768, 0.9948327],
                    [0.5, -1.3706671, 1.1017991],
                ),
            ),
            (
                3,
                place(
                    [-1.7967938, 0.0, 1.4263235],
                    [0.0, 0.0, -0.92132163, 0.38880134],
                    [1.1421741, -0.5, 0.5],
                ),
            ),
            ([2.932413, -3.2199576, -0.60795707], [0.0, 0.0, 0.0]),
            ([0.0, 0.23651762, -0.58176553], 2.614169),
        ),
        (
            (
                4,
                place(
                    [1.2576108, 0.948693, 1.2916499],
                    [0.17470235, 0.0, 0.4939456, 0.85176104],
                    [0.5, 1.4559028, 0.5],
                ),
            ),
            (
                6,
                place(
                    [1.4361638, 0.66724896, 1.5181978],
                    [0.0, -0.0, 0.0, 1.0],
                    [0.5, 0.5, 0.5],
                ),
            ),
            ([-0.467518, 0.0, 0.0], [0.63391435, -0.8557379, 0.0]),
            ([-0.22530246, -0.5877111, 0.0], -2.721279),
        ),
        (
            (
                4,
                place(
                    [1.6038061, 0.9311557, -1.0549666],
                    [0.38133758, -0.2369745, 0.0, 0.89354616],
                    [-0.63728005, 0.5, 0.5],
                ),
            ),
            (
                0,
                place(
                    [0.5106828, 0.23748608, -1.3244611],
                    [0.0, -0.0, 0.0, 1.0],
                    [1.493708, 0.98148525, 0.5],
                ),
            ),
            ([0.0, 0.0, -1.4922221], [0.0, -0.43448597, 0.0]),
            ([-0.86735064, 0.44894233, 0.32050347], -2.2464714),
        ),
        (
            (
                3,
                place(
                    [0.095842615, -1.10878, -0.04916443],
                    [-0.05539128, 0.64932203, -0.7508575, 0.10735711],
                    [1.014004, -1.1793251, 0.5],
                ),
            ),
            (
                6,
                place(
                    [-1.2192522, -1.2364047, 1.9018836],
                    [0.0, 0.0, 0.0, 1.0],
                    [0.5, 0.5, 0.5],
                ),
            ),
            (
                [1.1053097, 0.0, 1.8482326],
                [-5.1417074, -3.3901792, -3.703336],
            ),
            ([0.0, 0.0, 0.0], 0.0),
        ),
        (
            (
                5,
                place(
                    [-0.46026844, 1.5981482, -1.3065714],
                    [0.12007246, 0.0, 0.0, 0.9927651],
                    [0.5, 0.5, 0.5],
                ),
            ),
            (
                3,
                place(
                    [-0.69111055, 0.0, 1.2107003],
                    [-0.2623882, 0.30893478, 0.2040784, 0.89110255],
                    [1.1596518, 1.2591803, -1.284967],
                ),
            ),
            ([-5.182185, 0.0, 0.9145015], [-3.7999988, -4.0362406, 0.0]),
            ([0.0, 0.0, 0.0], 0.0),
        ),
    ]);
}

/// A ball and a box that come closer than the tolerance, and no closer.
#[test]
fn a_graze_may_be_missed() {
    let (ball, brick) = (Shape::sphere(0.75), box_of(1.0, 0.5, 0.25));
    let at_ball = place(
        [-1.3885272, 1.2292303, -1.2839282],
        [0.0, 0.0, 0.0, 1.0],
        [-0.5, -1.4375931, -0.5],
    );
    let at_brick = place(
        [0.9497261, 0.21431264, -1.4005888],
        [-0.42286503, 0.022505028, 0.61010635, 0.66966325],
        [1.4297633, 1.0568267, -1.3555522],
    );
    let end = moved_end(&at_ball, Vec3::new(5.6466465, 3.1109443, 5.967403));
    let end_brick = moved_end(&at_brick, Vec3::new(-4.2042394, -1.2481349, 4.9880123));
    let (a, b) = (
        Moving::new(&ball, &at_ball, &end),
        Moving::new(&brick, &at_brick, &end_brick),
    );
    check(&a, &b, 1).unwrap();
}

/// Edges of meshes and of open polygons, of which the contact knows no normal that parts the two.
#[test]
fn edges_of_meshes_that_meet_are_no_graze() {
    check_ways([
        (
            (
                3,
                place(
                    [0.0, -0.48757866, -1.6820976],
                    [0.5290742, 0.15336718, 0.60735345, 0.5724342],
                    [1.1408917, 0.75461286, -0.5],
                ),
            ),
            (
                4,
                place(
                    [-0.33120257, 0.11345094, 0.38558006],
                    [0.07257906, 0.69813144, 0.6686237, 0.24553427],
                    [0.6790871, -0.679003, 0.5],
                ),
            ),
            ([0.16147827, 0.0, 4.4165454], [0.0, 0.0, 0.0]),
            ([0.4492811, 0.6813818, 0.0], -2.47189),
        ),
        (
            (
                4,
                place(
                    [-0.77979517, 1.0630068, -1.5306907],
                    [0.0, -0.32427463, 0.62172294, 0.71295625],
                    [-1.0476084, 1.0324782, 0.5],
                ),
            ),
            (
                3,
                place(
                    [1.3443557, -0.11742384, 0.4798216],
                    [0.11638512, -0.31341943, -0.7684995, 0.54555595],
                    [-0.7759843, -1.2237542, 0.5],
                ),
            ),
            ([0.0, -3.5107725, -1.5733491], [0.0, 0.0, -0.4235391]),
            ([0.9564385, 0.0, -0.88058394], 2.5101418),
        ),
    ]);
}

/// A blade of length 2 that turns by a third of a turn hits a ball beside it with its end.
#[test]
fn a_blade_hits_what_it_turns_through() {
    let (blade, ball) = (box_of(1.0, 0.01, 0.2), Shape::sphere(0.1));
    let start = at(0.0, 0.0, 0.0);
    let blade = Moving::new(
        &blade,
        &start,
        &start.with_rotation(Quat::from_rotation_z(2.0)),
    );
    let placed = at(0.0, 0.8, 0.0);
    let found = met(&blade, &Moving::resting(Placed::new(&ball, &placed))).unwrap();
    // The angle at which the face of the blade is a radius and half a thickness away from the
    // ball's centre.
    let expected = (std::f32::consts::FRAC_PI_2 - (0.11f32 / 0.8).asin()) / 2.0;
    assert!(
        (found.time - expected).abs() < 1e-3,
        "{found:?}, expected {expected}"
    );
    // Upright by then, it comes from the right.
    assert!(found.contact.normal.x < -0.98, "{found:?}");
    // One that is out of reach is not hit, though it is in the box.
    let corner = at(0.95, 0.95, 0.0);
    assert_eq!(
        met(&blade, &Moving::resting(Placed::new(&ball, &corner))),
        None
    );
}

/// A bar that spins while it flies at a thousand times its length per tick.
#[test]
fn a_spinning_bullet_does_not_pass_through_paper() {
    let (bar, paper) = (box_of(0.1, 0.02, 0.02), box_of(0.001, 10.0, 10.0));
    let start = at(-70.0, 0.0, 0.0);
    let end = at(130.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(3.0));
    let (bar, place) = (Moving::new(&bar, &start, &end), at(0.0, 0.0, 0.0));
    let found = met(&bar, &Moving::resting(Placed::new(&paper, &place))).unwrap();
    assert!((found.time - 0.35).abs() < 1e-3, "{found:?}");
    assert!(found.contact.normal.x > 0.999);
}

#[test]
fn those_that_part_meet_when_they_come_back() {
    // A wall with another behind it, as one mesh.
    let sheet = |x: f32| [[x, -1., -1.], [x, 1., -1.], [x, 1., 1.], [x, -1., 1.]].map(Vec3::from);
    let walls = Shape::mesh(
        [sheet(0.0), sheet(4.0)].concat(),
        [[0, 1, 2, 3], [4, 5, 6, 7]],
    )
    .unwrap();
    let (ball, here) = (Shape::sphere(0.5), at(0.0, 0.0, 0.0));
    let walls = Moving::resting(Placed::new(&walls, &here));
    // Touching the first, on its way to the second.
    let found = met(
        &Moving::new(&ball, &at(0.5, 0.0, 0.0), &at(8.5, 0.0, 0.0)),
        &walls,
    )
    .unwrap();
    assert!((found.time - 3.0 / 8.0).abs() < 1e-3, "{found:?}");
    // Away from both.
    assert_eq!(
        met(
            &Moving::new(&ball, &at(-0.5, 0.0, 0.0), &at(-8.5, 0.0, 0.0)),
            &walls
        ),
        None
    );
    // Into the first, at once; along it, all the time.
    let found = met(
        &Moving::new(&ball, &at(0.5, 0.0, 0.0), &at(-8.5, 0.0, 0.0)),
        &walls,
    )
    .unwrap();
    assert_eq!(found.time, 0.0);
    let found = met(
        &Moving::new(&ball, &at(0.5, 0.0, 0.0), &at(0.5, 0.7, 0.0)),
        &walls,
    )
    .unwrap();
    assert_eq!(found.time, 0.0);
}

#[test]
fn what_is_not_finite_meets_nothing() {
    let (cube, here) = (box_of(1.0, 1.0, 1.0), at(0.0, 0.0, 0.0));
    let resting = Moving::resting(Placed::new(&cube, &here));
    for bad in [f32::NAN, f32::INFINITY] {
        let moving = Moving::new(&cube, &at(-5.0, 0.0, 0.0), &at(bad, 0.0, 0.0));
        assert_eq!(met(&moving, &resting), None);
        assert!(NarrowPhase::default().swept_aabb(&moving).is_err());
        let turning = Moving::new(
            &cube,
            &here,
            &here.with_rotation(Quat::from_xyzw(bad, 0.0, 0.0, 1.0)),
        );
        let _ = met(&turning, &resting);
        assert!(NarrowPhase::default().swept_aabb(&turning).is_err());
    }
}

/// Asks on a thread of its own, so that a search without an end is a failure and not a test without
/// one.
fn met_in_time(
    name: &str,
    search: impl FnOnce() -> Option<TimedContact> + Send + 'static,
) -> Option<TimedContact> {
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(search()));
    receiver
        .recv_timeout(std::time::Duration::from_secs(20))
        .unwrap_or_else(|_| panic!("{name} has no end"))
}

/// From the end of the world, turning, to where they touch, or nearly so.
#[test]
fn every_search_has_an_end() {
    let sizes = [1e-30, 1e-3, 0.5, 1e4, 1e10, 1e19, 1e30, 1e37, 1e38];
    let shapes = |size: f32| {
        [
            Shape::sphere(size),
            box_of(size, size, size),
            mesh_of(Vec3::splat(size)),
        ]
    };
    for (size, far) in sizes
        .into_iter()
        .flat_map(|size| sizes.map(|far| (size, far)))
    {
        for (one, other) in shapes(size)
            .into_iter()
            .flat_map(|one| shapes(0.5).map(|other| (one.clone(), other)))
        {
            for (angle, gap) in [0.0, 0.3, 3.0]
                .into_iter()
                .flat_map(|angle| [0.0, 2e-4, 1.0].map(|gap| (angle, gap)))
            {
                let name =
                    format!("{size} from {far}, turned by {angle}, gap {gap}, {one:?} {other:?}");
                let (start, here) = (at(0.3, -far, 0.0), at(0.0, 0.0, 0.0));
                let end =
                    at(0.3, size + 0.5 + gap, 0.0).with_rotation(Quat::from_rotation_z(angle));
                let (one, other) = (one.clone(), other.clone());
                met_in_time(&name, move || {
                    let resting = Moving::resting(Placed::new(&other, &here));
                    let forth = met(&Moving::new(&one, &start, &end), &resting);
                    let back = met(&Moving::new(&one, &end, &start), &resting);
                    forth.or(back)
                });
            }
        }
    }
}

/// Up through a half-space, turning, to where it just has no contact any more.
#[cfg(feature = "rapier")]
#[test]
fn the_search_above_a_half_space_has_an_end() {
    use bevy_rapier3d::geometry::Collider;
    for radius in [0.4995, 0.5, 0.5005] {
        for (way, gap) in [4e2, 4e3, 4e4]
            .into_iter()
            .flat_map(|way| [0.0, 1e-4, 1.5e-4, 2e-4, 3e-4, 1e-3].map(|gap| (way, gap)))
        {
            for angle in [0.003, 0.3, 1.0, 3.0] {
                met_in_time(
                    &format!("{radius} from {way} to {gap}, turned by {angle}"),
                    move || {
                        let ground = Shape::from(&Collider::halfspace(Vec3::Y).unwrap());
                        let (ball, here) =
                            (Shape::from(&Collider::ball(radius)), at(0.0, 0.0, 0.0));
                        let end =
                            at(0.0, radius + gap, 0.0).with_rotation(Quat::from_rotation_z(angle));
                        let resting = Moving::resting(Placed::new(&ground, &here));
                        let own = Shape::sphere(radius);
                        met(&Moving::new(&own, &at(0.0, -way, 0.0), &end), &resting);
                        met(&Moving::new(&ball, &at(0.0, -way, 0.0), &end), &resting)
                    },
                );
            }
        }
    }
}
