//! What is near, whether anything is met, and many queries at once: against brute force, and against
//! single queries.

use std::ops::ControlFlow;

use bevy::math::{
    Vec3, Vec3A,
    bounding::{Aabb3d, AabbCast3d, RayCast3d},
};
use proptest::prelude::*;

use super::{
    tests::{a_box, by_distance, change, direction, distance, meets, place, worlds},
    *,
};
use crate::broad_phase::{ProxyId, SpatialIndex};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn what_is_within_a_distance_is_what_brute_force_says(
        boxes in prop::collection::vec(a_box(), 0..150), changes in prop::collection::vec(change(), 0..30),
        point in place(), max in prop::sample::select(vec![0.0_f32, 0.25, 1.0, 2.5, f32::INFINITY, -1.0, f32::NAN]),
    ) {
        for index in worlds(&boxes, &changes) {
            let expected = by_distance(&index, |aabb| Some(distance(point, aabb)).filter(|distance| *distance <= max));
            let (mut within, mut some) = (vec![], 0);
            index.for_each_within(point, max, |hit| within.push(hit));
            within.sort_by(|a: &Hit, b| a.distance.total_cmp(&b.distance).then(a.proxy.cmp(&b.proxy)));
            prop_assert_eq!(&within, &expected);
            index.for_each_within(point, max, |_| { some += 1; ControlFlow::Break(()) });
            prop_assert_eq!(some, expected.len().min(1));
        }
    }

    #[test]
    fn a_ray_meets_any_if_it_meets_one(
        boxes in prop::collection::vec(a_box(), 0..100), changes in prop::collection::vec(change(), 0..20),
        origin in place(), direction in direction(), least in 0_u32..60,
        max in prop::sample::select(vec![0.0_f32, 1.0, 5.25, f32::INFINITY, -1.0, f32::NAN]),
    ) {
        let ray = RayCast3d::new(origin, direction, max);
        let point = AabbCast3d { ray: ray.clone(), aabb: Aabb3d { min: Vec3A::ZERO, max: Vec3A::ZERO } };
        for index in worlds(&boxes, &changes) {
            let hits = by_distance(&index, |aabb| meets(&point, aabb).filter(|_| max >= 0.0));
            prop_assert_eq!(index.meets_any(&ray, |_, _| true), !hits.is_empty());
            let is_one = |id: ProxyId, _| id.get() >= least;
            prop_assert_eq!(index.meets_any(&ray, is_one), hits.iter().any(|hit| is_one(hit.proxy, 0.0)));
        }
    }

    #[test]
    fn pairs_of_a_group_are_those_of_brute_force(
        boxes in prop::collection::vec(a_box(), 0..150), changes in prop::collection::vec(change(), 0..30),
        members in 0_u32..60, far in prop::sample::select(vec![0.0_f32, 1e7]),
        limit in prop::sample::select(vec![0.0_f32, 0.25, 1.0, 1.7, 8.0, 1e29, f32::MAX, f32::INFINITY, -1.0, f32::NAN]),
    ) {
        let boxes: Vec<_> = boxes.iter().map(|aabb| Aabb3d { min: aabb.min + far, max: aabb.max + far }).collect();
        for index in worlds(&boxes, &changes) {
            // All of them, or fewer and fewer.
            let is_member = |id: ProxyId| id.get() % 61 >= members;
            let (mut expected, mut found, mut some) = (vec![], vec![], 0);
            index.for_each_pair_within(limit, is_member, is_member, |a, b, apart| expected.push((a, b, apart)));
            index.for_each_pair_among(limit, is_member, |a, b, apart| found.push((a, b, apart)));
            expected.sort_by_key(|(a, b, _)| (*a, *b));
            found.sort_by_key(|(a, b, _)| (*a, *b));
            prop_assert_eq!(&found, &expected);
            index.for_each_pair_among(limit, is_member, |_, _, _| { some += 1; ControlFlow::Break(()) });
            prop_assert_eq!(some, found.len().min(1));
        }
    }

    #[test]
    fn a_batch_has_the_answers_of_its_queries(
        boxes in prop::collection::vec(a_box(), 0..100), changes in prop::collection::vec(change(), 0..20),
        points in prop::collection::vec(place(), 0..200), k in 0_usize..5, direction in direction(),
        max in prop::sample::select(vec![1.0_f32, 2.5, f32::INFINITY, f32::NAN]),
    ) {
        let casts: Vec<_> = points.iter().map(|point| RayCast3d::new(*point, direction, max)).collect();
        for index in worlds(&boxes, &changes) {
            let (mut hits, mut few) = (vec![None; 3], vec![]);
            index.cast_each(&casts, &mut hits);
            prop_assert!(hits.iter().copied().eq(casts.iter().map(|cast| index.cast(cast))));
            index.nearest_of_each(&points, max, &mut hits);
            prop_assert!(hits.iter().copied().eq(points.iter().map(|point| index.nearest(*point, max))));
            let mut lists = HitLists::default();
            for _ in 0..2 {
                index.k_nearest_of_each(&points, k, max, &mut lists);
                prop_assert_eq!((lists.len(), lists.iter().len()), (points.len(), points.len()));
                for (point, hits) in points.iter().zip(lists.iter()) {
                    index.k_nearest(*point, k, max, &mut few);
                    prop_assert_eq!(hits, &few[..]);
                }
                prop_assert_eq!(lists.hits().len(), lists.iter().map(<[Hit]>::len).sum::<usize>());
            }
            prop_assert_eq!(lists.get(points.len()), None);
        }
    }
}

#[test]
fn many_pairs_are_found_by_one_join_wherever_boxes_are_in_their_skins() {
    let mut random = fastrand::Rng::with_seed(9);
    let mut index = SpatialIndex::default();
    let mut vector =
        |reach: f32| Vec3A::from_array(std::array::from_fn(|_| (random.f32() * 2.0 - 1.0) * reach));
    let mut boxes: Vec<_> = (0..3000)
        .map(|number| {
            let half = if number == 7 { 40.0 } else { 0.5 };
            let aabb = Aabb3d::new(vector(12.0), Vec3A::splat(half));
            (index.insert(aabb).unwrap(), aabb, vector(0.05))
        })
        .collect();
    for tick in 0..8 {
        for (id, aabb, step) in &mut boxes {
            (aabb.min, aabb.max) = (aabb.min + *step, aabb.max + *step);
            index.set(*id, aabb).unwrap();
        }
        index.update();
        if tick % 3 == 0 {
            index.find_pairs();
        }
        for (limit, share) in [(0.0, 1), (0.3, 1), (0.3, 3), (0.3, 20)] {
            let is_member = |id: ProxyId| id.get().is_multiple_of(share);
            let (mut expected, mut found) = (vec![], vec![]);
            index.for_each_pair_within(limit, is_member, is_member, |a, b, apart| {
                expected.push((a, b, apart));
            });
            index.for_each_pair_among(limit, is_member, |a, b, apart| found.push((a, b, apart)));
            expected.sort_by_key(|(a, b, _)| (*a, *b));
            found.sort_by_key(|(a, b, _)| (*a, *b));
            assert!(expected.len() > 5, "{}", expected.len());
            assert_eq!(found, expected, "{tick}, {limit}");
        }
    }
}

#[test]
fn a_query_in_the_callback_of_another_is_answered() {
    let mut index = SpatialIndex::default();
    let mut cube = |x: f32| index.insert(Aabb3d::new(Vec3::X * x, Vec3::splat(0.5)));
    let ids = [cube(0.0), cube(1.5), cube(3.0)].map(Result::unwrap);
    index.update();
    let mut found = vec![];
    index.for_each_pair_among(
        0.6,
        |id| {
            let mut near = 0;
            index.for_each_pair_among(
                0.6,
                |_| true,
                |a, b, _| near += u32::from(a == id || b == id),
            );
            near > 0
        },
        |a, b, _| {
            index.for_each_pair_among(0.6, |_| true, |c, d, _| found.push((a, b, c, d)));
        },
    );
    assert_eq!(found.len(), 4);
    assert!(
        found
            .iter()
            .all(|(a, b, c, d)| [a, b, c, d].iter().all(|id| ids.contains(id)))
    );
}
