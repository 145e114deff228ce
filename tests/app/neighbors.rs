//! What is near: within a distance, of many points, of one group; and whether a ray meets anything.
//! Against brute force over the exact shapes, and against single queries.

use std::ops::ControlFlow;

use bevy::prelude::*;
use bevy_octree::{
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
    scene::Cube,
};
use fastrand::Rng;

use crate::{
    common::*,
    spatial_query::{ALL, ask, direction, everything, methods, random_app, vector},
};

#[test]
fn what_is_within_a_distance_is_what_brute_force_says() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed as u64 + 20);
        let mut app = random_app(&mut rng, method, 300);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        let points: Vec<_> = (0..150).map(|_| vector(&mut rng, 12.0)).collect();
        ask(&mut app, move |spatial| {
            let mut workspace = Workspace::default();
            let (mut hits, mut lists, mut few) = (vec![], HitLists::default(), vec![]);
            let (mut nearest, mut all) = (vec![], 0);
            for limit in [0.0, 1.5, 4.0, f32::INFINITY] {
                spatial.within_of_each(&points, limit, &ALL, &mut lists);
                for (number, point) in points.iter().enumerate() {
                    let mut expected: Vec<_> = objects
                        .iter()
                        .filter_map(|(entity, shape, at)| {
                            let placed = Placed::new(shape, at);
                            let closest = tests.closest_point(placed, *point, &mut workspace)?;
                            let distance = closest.distance(*point);
                            (distance <= limit).then_some(PointHit {
                                entity: *entity,
                                distance,
                                point: closest,
                            })
                        })
                        .collect();
                    expected.sort_by(|a, b| {
                        a.distance
                            .total_cmp(&b.distance)
                            .then(a.entity.cmp(&b.entity))
                    });
                    spatial.within(*point, limit, &ALL, &mut hits);
                    assert_eq!(hits, expected);
                    assert_eq!(&lists[number], &hits[..]);
                    all += hits.len();
                    let mut some = 0;
                    spatial.for_each_within(*point, limit, &ALL, |_| {
                        some += 1;
                        ControlFlow::Break(())
                    });
                    assert_eq!(some, hits.len().min(1));
                }
                spatial.k_nearest_of_each(&points, 3, limit, &ALL, &mut lists);
                spatial.nearest_of_each(&points, limit, &ALL, &mut nearest);
                for ((point, near), first) in points.iter().zip(lists.iter()).zip(&nearest) {
                    spatial.k_nearest(*point, 3, limit, &ALL, &mut few);
                    assert_eq!(near, &few[..]);
                    assert_eq!(*first, spatial.nearest(*point, limit, &ALL));
                }
            }
            assert!(all > 1000, "{all}");
            for (point, limit) in [
                (Vec3::NAN, 1.0),
                (Vec3::INFINITY, f32::INFINITY),
                (Vec3::ZERO, -1.0),
                (Vec3::ZERO, f32::NAN),
            ] {
                spatial.within(point, limit, &ALL, &mut hits);
                assert_eq!(hits, []);
            }
        });
    }
}

#[test]
fn pairs_of_a_group_are_those_of_brute_force() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed as u64 + 90);
        let mut app = random_app(&mut rng, method, 150);
        let (objects, tests) = (everything(&mut app), *app.world().resource::<NarrowPhase>());
        ask(&mut app, move |spatial| {
            let mut workspace = Workspace::default();
            let is_member = |entity: Entity| !entity.index_u32().is_multiple_of(3);
            let members = ALL.only(&is_member);
            for limit in [0.0, 0.3, 2.0, f32::INFINITY] {
                let mut expected = vec![];
                for (i, (a, shape_a, at_a)) in objects.iter().enumerate() {
                    for (b, shape_b, at_b) in &objects[i + 1..] {
                        let (one, two) = (Placed::new(shape_a, at_a), Placed::new(shape_b, at_b));
                        let found = tests.closest_points(one, two, &mut workspace).unwrap();
                        let between = spatial.distance_between(*a, *b).unwrap();
                        assert_eq!(between.distance, found.distance);
                        assert_eq!(
                            (between.a, between.b, between.points),
                            (*a, *b, found.points)
                        );
                        if found.distance <= limit && is_member(*a) && is_member(*b) {
                            expected.push((pair(*a, *b), found.distance));
                        }
                    }
                }
                let (mut found, mut some, mut sorted) = (vec![], 0, vec![]);
                spatial.for_each_pair_among(limit, &members, |near| {
                    found.push((pair(near.a, near.b), near.distance));
                });
                expected.sort_by_key(|(pair, _)| *pair);
                found.sort_by_key(|(pair, _)| *pair);
                assert_eq!(found, expected, "{limit}");
                spatial.for_each_pair_among(limit, &members, |_| {
                    some += 1;
                    ControlFlow::Break(())
                });
                assert_eq!(some, found.len().min(1));
                spatial.pairs_among(limit, &members, &mut sorted);
                assert_eq!(sorted.len(), found.len());
                assert!(sorted.is_sorted_by_key(|near| near.distance));
            }
            let none = |near| -> () { panic!("{near:?}") };
            spatial.for_each_pair_among(-1.0, &ALL, none);
            spatial.for_each_pair_among(f32::NAN, &ALL, none);
            spatial.for_each_pair_among(9.0, &ALL.only(&|_| false), none);
        });
    }
}

#[test]
fn thousands_of_units_have_the_neighbours_of_single_queries() {
    let mut rng = Rng::with_seed(4);
    let mut app = app(BroadPhaseMethod::default());
    for number in 0..3000 {
        let at = Transform::from_translation(vector(&mut rng, 20.0));
        let shape = if number % 5 == 0 {
            CollisionShape::cuboid(1.0, 1.0, 1.0)
        } else {
            CollisionShape::sphere(0.5)
        };
        let velocity = Velocity(vector(&mut rng, 3.0));
        app.world_mut().spawn((shape, at, velocity));
    }
    tick(&mut app, 5);
    ask(&mut app, |spatial| {
        let (mut among, mut within) = (vec![], vec![]);
        spatial.pairs_among(0.4, &ALL, &mut among);
        spatial.pairs_within(0.4, &ALL, &ALL, &mut within);
        assert!(within.len() > 300, "{}", within.len());
        assert_eq!(among, within);
    });
}

#[test]
fn a_ray_meets_any_if_it_meets_a_first_one() {
    for (seed, method) in methods().into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed as u64 + 40);
        let mut app = random_app(&mut rng, method, 300);
        let rays: Vec<_> = (0..300)
            .map(|number| {
                let ray = Ray3d::new(vector(&mut rng, 12.0), direction(&mut rng));
                let length = [0.0, 1.0, 5.0, 40.0, f32::INFINITY, f32::NAN, -1.0][number % 7];
                (ray, length)
            })
            .collect();
        ask(&mut app, move |spatial| {
            let is_one = |entity: Entity| entity.index_u32().is_multiple_of(2);
            let some = ALL.only(&is_one);
            let mut met = [0; 2];
            for (ray, length) in &rays {
                let any = spatial.ray_meets_any(*ray, *length, &some);
                assert_eq!(any, spatial.cast_ray(*ray, *length, &some).is_some());
                met[usize::from(any)] += 1;
                let options = RayCastOptions::DEFAULT.ignore_start();
                let onward = spatial.cast_ray_with(*ray, *length, &some, &options);
                assert_eq!(
                    spatial.ray_meets_any_with(*ray, *length, &some, &options),
                    onward.is_some()
                );
            }
            assert!(met[0] > 10 && met[1] > 10, "{met:?}");
            let (mut hits, mut are_met) = (vec![], vec![]);
            for most in [3.0, f32::INFINITY, f32::NAN] {
                spatial.cast_rays(&rays, most, &some, &mut hits);
                spatial.rays_meet_any(&rays, most, &some, &mut are_met);
                assert_eq!((hits.len(), are_met.len()), (rays.len(), rays.len()));
                for (((ray, length), hit), is_met) in rays.iter().zip(&hits).zip(&are_met) {
                    let is_nan = length.is_nan() || most.is_nan();
                    let length = if is_nan { f32::NAN } else { length.min(most) };
                    assert_eq!(*hit, spatial.cast_ray(*ray, length, &some));
                    assert_eq!(*is_met, hit.is_some());
                }
            }
        });
    }
}

#[test]
fn sensors_are_seen_unless_they_are_left_out() {
    let mut app = app(BroadPhaseMethod::default());
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let trigger = app.world_mut().spawn((Cube, Sensor, at(2.0))).id();
    let wall = app.world_mut().spawn((Cube, at(4.0))).id();
    tick(&mut app, 1);
    let first = move |app: &mut App| {
        ask(app, |spatial| {
            let solid = ALL.without_sensors();
            let ray = Ray3d::new(Vec3::ZERO, Dir3::X);
            let first = |filter| spatial.cast_ray(ray, 9.0, &filter).map(|hit| hit.entity);
            assert_eq!(
                first(solid),
                spatial
                    .nearest(Vec3::ZERO, 9.0, &solid)
                    .map(|hit| hit.entity)
            );
            let mut pairs = 0;
            spatial.for_each_pair_among(9.0, &solid, |_| pairs += 1);
            (first(ALL), first(solid), pairs)
        })
    };
    assert_eq!(first(&mut app), (Some(trigger), Some(wall), 0));
    // As of now, whatever the index knows.
    app.world_mut().entity_mut(trigger).remove::<Sensor>();
    assert_eq!(first(&mut app), (Some(trigger), Some(trigger), 1));
    app.world_mut().entity_mut(wall).insert(Sensor);
    assert_eq!(first(&mut app), (Some(trigger), Some(trigger), 0));
}

#[test]
fn two_entities_are_as_far_apart_as_their_shapes() {
    let mut app = app(BroadPhaseMethod::default());
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let cube = app.world_mut().spawn((Cube, at(2.0))).id();
    let ball = app
        .world_mut()
        .spawn((CollisionShape::sphere(1.0), at(6.0)))
        .id();
    let nothing = app.world_mut().spawn(at(3.0)).id();
    let between =
        move |app: &mut App, a, b| ask(app, move |spatial| spatial.distance_between(a, b));
    assert_eq!(
        between(&mut app, cube, ball),
        None,
        "neither is in the index yet"
    );
    tick(&mut app, 1);
    let near = between(&mut app, cube, ball).unwrap();
    assert_eq!((near.a, near.b, near.distance), (cube, ball, 2.5));
    assert_eq!(near.points, [Vec3::X * 2.5, Vec3::X * 5.0]);
    assert_eq!(
        between(&mut app, ball, ball).map(|near| near.distance),
        Some(0.0)
    );
    assert_eq!(between(&mut app, cube, nothing), None);
    app.world_mut().despawn(ball);
    assert_eq!(between(&mut app, cube, ball), None);
}
