//! All queries against brute force, by all methods.

use std::ops::ControlFlow;

use bevy::math::{
    Dir3, Vec3, Vec3A,
    bounding::{Aabb3d, AabbCast3d, BoundingSphere, RayCast3d},
    primitives::{HalfSpace, ViewFrustum},
};
use proptest::prelude::*;

use super::*;
use crate::broad_phase::{BroadPhaseMethod, ProxyId, SpatialIndex, overlap};

/// Places are in units of a quarter, so that sides are met exactly, and often.
pub fn place() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-24_i8..24).prop_map(|at| Vec3::from(at.map(f32::from)) * 0.25)
}

/// A box; flat ones and points among them.
pub fn a_box() -> impl Strategy<Value = Aabb3d> {
    let half = prop::array::uniform3(prop::sample::select(vec![
        0.0_f32, 0.25, 0.5, 0.5, 1.0, 4.0,
    ]));
    (place(), half).prop_map(|(at, half)| Aabb3d::new(at, Vec3::from(half)))
}

/// A direction, often along an axis or a diagonal.
pub fn direction() -> impl Strategy<Value = Dir3> {
    prop_oneof![
        prop::array::uniform3(-1_i8..=1).prop_map(|d| d.map(f32::from)),
        prop::array::uniform3(-1.0_f32..1.0),
    ]
    .prop_filter_map("a direction has a length", |d| {
        Dir3::new(Vec3::from(d)).ok()
    })
}

/// What happens to the boxes before they are queried, tick by tick.
#[derive(Clone, Debug)]
pub enum Change {
    Move(usize, Vec3),
    Drift(Vec3),
    Remove(usize),
    Tick,
}

pub fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => (any::<usize>(), place()).prop_map(|(which, to)| Change::Move(which, to)),
        2 => place().prop_map(|by| Change::Drift(by / 64.0)),
        2 => any::<usize>().prop_map(Change::Remove),
        3 => Just(Change::Tick),
    ]
}

/// The same boxes by all methods.
pub fn worlds(boxes: &[Aabb3d], changes: &[Change]) -> Vec<SpatialIndex> {
    let methods = ["auto", "linear", "object", "exhaustive"];
    let world = |name: &str| {
        let mut index = SpatialIndex::new(&name.parse::<BroadPhaseMethod>().unwrap());
        let mut ids: Vec<_> = boxes
            .iter()
            .map(|aabb| index.insert(*aabb).unwrap())
            .collect();
        for change in changes {
            let shift = |index: &mut SpatialIndex, id: ProxyId, by: Vec3A| {
                let aabb = *index.proxies().get(id).unwrap();
                index
                    .set(
                        id,
                        &Aabb3d {
                            min: aabb.min + by,
                            max: aabb.max + by,
                        },
                    )
                    .unwrap();
            };
            match change {
                Change::Move(which, by) if !ids.is_empty() => {
                    shift(&mut index, ids[which % ids.len()], (*by).into());
                }
                Change::Drift(by) => ids
                    .iter()
                    .step_by(2)
                    .for_each(|id| shift(&mut index, *id, (*by).into())),
                Change::Remove(which) if !ids.is_empty() => {
                    index.remove(ids.swap_remove(which % ids.len()));
                }
                Change::Tick => {
                    index.update();
                    index.find_pairs();
                }
                _ => {}
            }
        }
        index.update();
        index
    };
    methods.map(world).into()
}

fn found<R: Region + ?Sized>(index: &SpatialIndex, region: &R) -> Vec<ProxyId> {
    let mut ids = vec![];
    index.for_each_overlapping(region, |id| ids.push(id));
    ids.sort_unstable();
    ids
}

fn expected(index: &SpatialIndex, test: impl Fn(&Aabb3d) -> bool) -> Vec<ProxyId> {
    index
        .proxies()
        .iter()
        .filter(|(_, aabb)| test(aabb))
        .map(|(id, _)| id)
        .collect()
}

/// Objects by distance, as far as they have one.
pub fn by_distance(index: &SpatialIndex, distance: impl Fn(&Aabb3d) -> Option<f32>) -> Vec<Hit> {
    let hit = |(proxy, aabb)| distance(aabb).map(|distance| Hit { proxy, distance });
    let mut hits: Vec<Hit> = index.proxies().iter().filter_map(hit).collect();
    hits.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(a.proxy.cmp(&b.proxy))
    });
    hits
}

/// The interval of the way during which a box that moves is in another, axis by axis.
pub fn meets(cast: &AabbCast3d, aabb: &Aabb3d) -> Option<f32> {
    let (mut enter, mut leave) = (0.0_f32, cast.ray.max);
    for axis in 0..3 {
        let (origin, d) = (cast.ray.origin[axis], cast.ray.direction[axis]);
        let low = aabb.min[axis] - (origin + cast.aabb.max[axis]);
        let high = aabb.max[axis] - (origin + cast.aabb.min[axis]);
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
        } else {
            let (a, b) = (low * (1.0 / d), high * (1.0 / d));
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
    }
    (enter <= leave).then_some(enter)
}

pub fn distance(point: Vec3, aabb: &Aabb3d) -> f32 {
    let point = Vec3A::from(point);
    (point.clamp(aabb.min, aabb.max) - point)
        .as_dvec3()
        .length() as f32
}

/// The distance of a made-up shape within the box of an object; some are missed.
fn shape(id: ProxyId, bound: f32) -> Option<f32> {
    (!id.get().is_multiple_of(5)).then_some(bound + (id.get() % 7) as f32 * 0.25)
}

fn check_first_and_all(index: &SpatialIndex, cast: &impl Cast, expected: &[Hit]) {
    assert_eq!(index.cast(cast), expected.first().copied());
    let mut all = vec![];
    index.for_each_hit(cast, |hit| all.push(hit));
    all.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(a.proxy.cmp(&b.proxy))
    });
    assert_eq!(all, expected);
}

/// What [`shape`] makes of hits, by distance.
fn reshaped(hits: &[Hit], limit: f32) -> Vec<Hit> {
    let hit = |hit: &Hit| shape(hit.proxy, hit.distance).map(|distance| Hit { distance, ..*hit });
    let mut hits: Vec<Hit> = hits
        .iter()
        .filter_map(hit)
        .filter(|hit| hit.distance <= limit)
        .collect();
    hits.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(a.proxy.cmp(&b.proxy))
    });
    hits
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn regions_hold_what_brute_force_says(
        boxes in prop::collection::vec(a_box(), 0..150), changes in prop::collection::vec(change(), 0..30),
        region in a_box(), point in place(), radius in prop::sample::select(vec![0.0_f32, 0.25, 1.0, 1.7, 8.0]),
        planes in prop::collection::vec((direction(), -4.0_f32..4.0), 0..6),
    ) {
        let planes: Vec<HalfSpace> = planes.iter().map(|(n, d)| HalfSpace::new(n.extend(*d))).collect();
        let inside = |aabb: &Aabb3d| planes.iter().all(|plane| {
            let corner = |bits: u32| {
                let pick = |axis| if bits >> axis & 1 == 0 { aabb.min[axis] } else { aabb.max[axis] };
                let n = plane.normal();
                pick(0) * n.x + pick(1) * n.y + pick(2) * n.z + plane.d()
            };
            (0..8).any(|bits| corner(bits) >= 0.0)
        });
        for index in worlds(&boxes, &changes) {
            prop_assert_eq!(found(&index, &region), expected(&index, |aabb| overlap(aabb, &region)));
            let at = Aabb3d::new(point, Vec3::ZERO);
            prop_assert_eq!(found(&index, &point), expected(&index, |aabb| overlap(aabb, &at)));
            let ball = BoundingSphere::new(point, radius);
            prop_assert_eq!(found(&index, &ball), expected(&index, |aabb| distance(point, aabb) <= radius));
            prop_assert_eq!(found(&index, &planes[..]), expected(&index, inside));
            let mut some = 0;
            index.for_each_overlapping(&region, |_| { some += 1; ControlFlow::Break(()) });
            prop_assert_eq!(some, found(&index, &region).len().min(1));
        }
    }

    #[test]
    fn casts_meet_what_brute_force_says(
        boxes in prop::collection::vec(a_box(), 0..150), changes in prop::collection::vec(change(), 0..30),
        origin in place(), direction in direction(), mover in a_box(),
        max in prop::sample::select(vec![0.0_f32, 1.0, 5.25, 1e9, f32::INFINITY]),
    ) {
        let ray = RayCast3d::new(origin, direction, max);
        let point = AabbCast3d { ray: ray.clone(), aabb: Aabb3d { min: Vec3A::ZERO, max: Vec3A::ZERO } };
        let mover = AabbCast3d { ray: ray.clone(), aabb: mover };
        for index in worlds(&boxes, &changes) {
            let hits = by_distance(&index, |aabb| meets(&point, aabb));
            check_first_and_all(&index, &ray, &hits);
            prop_assert_eq!(index.cast_with(&ray, shape), reshaped(&hits, max).first().copied());
            let hits = by_distance(&index, |aabb| meets(&mover, aabb));
            check_first_and_all(&index, &mover, &hits);
            prop_assert_eq!(index.cast_with(&mover, shape), reshaped(&hits, max).first().copied());
        }
    }

    #[test]
    fn the_nearest_are_those_of_brute_force(
        boxes in prop::collection::vec(a_box(), 0..150), changes in prop::collection::vec(change(), 0..30),
        point in place(), k in 0_usize..12, max in prop::sample::select(vec![0.0_f32, 1.0, 2.5, f32::INFINITY]),
    ) {
        for index in worlds(&boxes, &changes) {
            let hits = by_distance(&index, |aabb| Some(distance(point, aabb)).filter(|distance| *distance <= max));
            prop_assert_eq!(index.nearest(point, max), hits.first().copied());
            let mut nearest = vec![Hit { proxy: ProxyId::new(0), distance: 0.0 }];
            index.k_nearest(point, k, max, &mut nearest);
            prop_assert_eq!(&nearest[..], &hits[..k.min(hits.len())]);
            let hits = reshaped(&hits, max);
            prop_assert_eq!(index.nearest_with(point, max, shape), hits.first().copied());
            index.k_nearest_with(point, k, max, &mut nearest, shape);
            prop_assert_eq!(&nearest[..], &hits[..k.min(hits.len())]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn pairs_within_a_distance_are_those_of_brute_force(
        boxes in prop::collection::vec(a_box(), 0..100), changes in prop::collection::vec(change(), 0..30),
        first in 1_u32..6, second in 1_u32..6, far in prop::sample::select(vec![0.0_f32, 1e7]),
        limit in prop::sample::select(vec![0.0_f32, 0.25, 1.0, 1.7, 8.0, f32::INFINITY, -1.0, f32::NAN]),
    ) {
        let boxes: Vec<_> = boxes.iter().map(|aabb| Aabb3d { min: aabb.min + far, max: aabb.max + far }).collect();
        for index in worlds(&boxes, &changes) {
            let (is_first, is_second) =
                (|id: ProxyId| id.get() % 7 <= first, |id: ProxyId| (id.get() + 2) % 7 >= second);
            let mut expected = vec![];
            for (a, aabb) in index.proxies().iter() {
                for (b, other) in index.proxies().iter().filter(|(b, _)| *b > a) {
                    let gap = (0..3).map(|i| f64::from((other.min[i] - aabb.max[i]).max(aabb.min[i] - other.max[i]).max(0.0)));
                    let apart = gap.map(|gap| gap * gap).sum::<f64>().sqrt() as f32;
                    if apart <= limit && is_first(a) && is_second(b) {
                        expected.push((a, b, apart));
                    } else if apart <= limit && is_first(b) && is_second(a) {
                        expected.push((b, a, apart));
                    }
                }
            }
            let (mut found, mut some) = (vec![], 0);
            index.for_each_pair_within(limit, is_first, is_second, |a, b, apart| found.push((a, b, apart)));
            prop_assert!(found.is_sorted_by_key(|(a, ..)| *a));
            expected.sort_by_key(|(a, b, _)| (*a, *b));
            found.sort_by_key(|(a, b, _)| (*a, *b));
            prop_assert_eq!(&found, &expected);
            index.for_each_pair_within(limit, is_first, is_second, |_, _, _| { some += 1; ControlFlow::Break(()) });
            prop_assert_eq!(some, found.len().min(1));
        }
    }
}

/// A heap of equal boxes, each listed in many cells of the octree.
fn heap() -> Vec<SpatialIndex> {
    let mut boxes = vec![Aabb3d::new(Vec3::X * 4.0, Vec3::ONE); 100];
    boxes.extend(
        (0..300).map(|x| Aabb3d::new(Vec3::new(x as f32 * 0.1, 9.0, 0.0), Vec3::splat(3.0))),
    );
    worlds(&boxes, &[])
}

#[test]
fn of_equals_the_lowest_handle_wins() {
    for index in heap() {
        let hit = Hit {
            proxy: ProxyId::new(0),
            distance: 3.0,
        };
        assert_eq!(
            index.cast(&RayCast3d::new(Vec3::ZERO, Dir3::X, 10.0)),
            Some(hit)
        );
        assert_eq!(index.nearest(Vec3::ZERO, 10.0), Some(hit));
        let mut nearest = vec![];
        index.k_nearest(Vec3::ZERO, 3, 10.0, &mut nearest);
        assert_eq!(
            nearest
                .iter()
                .map(|hit| hit.proxy.get())
                .collect::<Vec<_>>(),
            [0, 1, 2]
        );
    }
}

#[test]
fn callbacks_may_stop() {
    for index in heap() {
        let mut count = 0;
        index.for_each_hit(&RayCast3d::new(Vec3::ZERO, Dir3::X, 10.0), |_| {
            count += 1;
            if count == 7 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        assert_eq!(count, 7);
    }
}

#[test]
fn bad_input_finds_nothing() {
    let nan = Vec3::NAN;
    let inverted = Aabb3d {
        min: Vec3A::X * 5.0,
        max: Vec3A::X * 3.0,
    };
    let mut cases = heap();
    cases.extend(worlds(&[], &[]));
    for index in cases {
        assert_eq!(found(&index, &nan), []);
        assert_eq!(found(&index, &Vec3A::INFINITY), []);
        assert_eq!(found(&index, &inverted), []);
        assert_eq!(
            found(
                &index,
                &Aabb3d {
                    min: nan.into(),
                    max: Vec3A::ONE
                }
            ),
            []
        );
        for (center, radius) in [
            (nan, 1.0),
            (Vec3::INFINITY, 1.0),
            (Vec3::ZERO, -1.0),
            (Vec3::ZERO, f32::NAN),
        ] {
            let mut ball = BoundingSphere::new(center, 0.0);
            ball.sphere.radius = radius;
            assert_eq!(found(&index, &ball), []);
        }
        assert_eq!(found(&index, &[HalfSpace::new(nan.extend(0.0))][..]), []);
        assert_eq!(
            found(&index, &[][..]).len(),
            index.proxies().len(),
            "no planes are all of space"
        );
        let mut frustum = ViewFrustum::default();
        frustum
            .half_spaces
            .fill(HalfSpace::new(Vec3::X.extend(f32::NAN)));
        assert_eq!(found(&index, &frustum), []);
        let unit = Aabb3d::new(Vec3::ZERO, Vec3::ONE);
        let bad_rays = [
            RayCast3d::new(Vec3::ZERO, Dir3::X, -1.0),
            RayCast3d::new(Vec3::ZERO, Dir3::X, f32::NAN),
            RayCast3d::new(nan, Dir3::X, 9.0),
            RayCast3d::new(Vec3::NEG_INFINITY, Dir3::X, f32::INFINITY),
        ];
        for ray in bad_rays {
            assert_eq!(index.cast(&ray), None, "{ray:?}");
            assert_eq!(index.cast(&AabbCast3d { ray, aabb: unit }), None);
        }
        let ray = RayCast3d::new(Vec3::ZERO, Dir3::X, 9.0);
        for aabb in [
            inverted,
            Aabb3d {
                min: Vec3A::NEG_INFINITY,
                max: Vec3A::ONE,
            },
        ] {
            assert_eq!(
                index.cast(&AabbCast3d {
                    ray: ray.clone(),
                    aabb
                }),
                None
            );
        }
        assert_eq!(index.cast_with(&ray, |_, _| Some(f32::NAN)), None);
        for (point, max) in [
            (nan, 1.0),
            (Vec3::INFINITY, f32::INFINITY),
            (Vec3::ZERO, -1.0),
            (Vec3::ZERO, f32::NAN),
        ] {
            assert_eq!(index.nearest(point, max), None);
            let mut hits = vec![Hit {
                proxy: ProxyId::new(0),
                distance: 0.0,
            }];
            index.k_nearest(point, 3, max, &mut hits);
            assert_eq!(hits, []);
        }
        assert_eq!(
            index.nearest_with(Vec3::ZERO, 9.0, |_, _| Some(f32::NAN)),
            None
        );
    }
}

#[test]
fn the_ends_of_the_number_range_are_queried_too() {
    let at = |x: f32| Aabb3d {
        min: Vec3A::splat(x),
        max: Vec3A::splat(x),
    };
    for index in worlds(&[at(f32::MIN), at(-1e30), at(1e30), at(f32::MAX)], &[]) {
        assert_eq!(
            index
                .nearest(Vec3::splat(2e30), f32::INFINITY)
                .unwrap()
                .proxy,
            ProxyId::new(2)
        );
        assert_eq!(index.nearest(Vec3::ZERO, 1e20), None);
        let ray = RayCast3d::new(Vec3::splat(1e30), Dir3::X, f32::INFINITY);
        assert_eq!(
            index.cast(&ray),
            Some(Hit {
                proxy: ProxyId::new(2),
                distance: 0.0
            })
        );
        assert_eq!(
            found(
                &index,
                &Aabb3d {
                    min: Vec3A::NEG_INFINITY,
                    max: Vec3A::INFINITY
                }
            )
            .len(),
            4
        );
    }
}
