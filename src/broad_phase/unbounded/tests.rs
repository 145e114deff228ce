use bevy::math::{DVec3, Dir3, Vec3, Vec4, bounding::RayCast3d};

use super::*;
use crate::broad_phase::{BoxError, BroadPhaseMethod, EVERYWHERE, Pair, SpatialIndex};

fn unit(y: f32) -> Aabb3d {
    Aabb3d::new(Vec3::new(1e3, y, 0.0), Vec3::splat(0.5))
}

/// All that is below a height.
fn below(height: f32) -> Option<HalfSpace> {
    Some(HalfSpace::new(Vec4::new(0.0, -1.0, 0.0, height)))
}

fn index() -> SpatialIndex {
    SpatialIndex::new(&BroadPhaseMethod::default())
}

#[test]
fn pairs_live_and_rest_like_others() {
    let mut index = index();
    let [low, high] = [0.4, 3.0].map(|y| index.insert(unit(y)).unwrap());
    let ground = index.insert_unbounded(below(0.0)).unwrap();
    let pairs = |index: &mut SpatialIndex| {
        index.update();
        let pairs = index.find_pairs();
        (pairs.moving().to_vec(), pairs.resting().to_vec())
    };
    let pair = Pair::new(ground, low);
    assert_eq!(pairs(&mut index), (vec![pair], vec![]));
    assert_eq!(pairs(&mut index), (vec![], vec![pair]));
    assert_eq!(pairs(&mut index), (vec![], vec![pair]));
    // Each of the two moves.
    index.set(low, &unit(0.2)).unwrap();
    assert_eq!(pairs(&mut index), (vec![pair], vec![]));
    index.set_unbounded(ground, below(2.6)).unwrap();
    assert_eq!(
        pairs(&mut index),
        (vec![pair, Pair::new(ground, high)], vec![])
    );
    index.set_unbounded(ground, below(2.6)).unwrap();
    assert_eq!(
        pairs(&mut index),
        (vec![], vec![pair, Pair::new(ground, high)])
    );
    index.set(low, &unit(9.0)).unwrap();
    assert_eq!(pairs(&mut index), (vec![], vec![Pair::new(ground, high)]));
    // Without a side, it is everywhere.
    index.set_unbounded(ground, None).unwrap();
    assert_eq!(pairs(&mut index).0.len(), 2);
    assert!(index.remove(ground) && !index.remove(ground));
    assert_eq!(pairs(&mut index), (vec![], vec![]));
}

#[test]
fn a_handle_is_that_of_a_box_or_of_an_unbounded_object() {
    let mut index = index();
    let ground = index.insert_unbounded(None).unwrap();
    let cube = index.insert(unit(0.0)).unwrap();
    let unknown = ProxyId::new(7);
    assert_eq!(
        index.set(ground, &unit(0.0)),
        Err(BoxError::UnknownProxy(ground))
    );
    assert!(index.set(ground, &EVERYWHERE).is_err());
    for id in [cube, unknown] {
        assert_eq!(
            index.set_unbounded(id, None),
            Err(BoxError::UnknownProxy(id))
        );
    }
    assert!(index.proxies().contains(ground) && index.proxies().get(ground).is_none());
    assert_eq!(
        (index.proxies().len(), index.proxies().unbounded().count()),
        (1, 1)
    );
    // Its handle is not reused for two updates either.
    index.remove(ground);
    for y in [10.0, 20.0] {
        assert_ne!(index.insert(unit(y)).unwrap(), ground);
        index.update();
    }
    assert_eq!(index.insert(unit(0.5)).unwrap(), ground);
    assert_eq!(
        index.set_unbounded(ground, None),
        Err(BoxError::UnknownProxy(ground))
    );
    assert_eq!(
        index.find_pairs().iter().collect::<Vec<_>>(),
        [Pair::new(ground, cube)]
    );
}

#[test]
fn every_query_finds_an_unbounded_object_once() {
    for method in ["auto", "linear", "object", "exhaustive"] {
        let mut index = SpatialIndex::new(&method.parse().unwrap());
        let cube = index.insert(unit(0.0)).unwrap();
        let ground = index.insert_unbounded(below(-9.0)).unwrap();
        let gone = index.insert_unbounded(None).unwrap();
        index.update();
        index.remove(gone);
        let region = |region: &Aabb3d| {
            let mut found = vec![];
            index.for_each_overlapping(region, |id| found.push(id));
            found
        };
        assert_eq!(region(&unit(0.0)), [ground, cube]);
        assert_eq!(region(&unit(2.0)), [ground]);
        assert_eq!(
            region(&Aabb3d {
                min: Vec3A::ONE,
                max: Vec3A::ZERO
            }),
            []
        );
        let ray = |max| RayCast3d::new(Vec3::ZERO, Dir3::X, max);
        let mut hits = vec![];
        index.for_each_hit(&ray(1e4), |hit| hits.push((hit.proxy, hit.distance)));
        assert_eq!(hits, [(ground, 0.0), (cube, 999.5)]);
        index.for_each_hit(&ray(-1.0), |hit| {
            assert_eq!(hit.distance, f32::NAN, "it goes nowhere");
        });
        // What it is at a distance of, the caller says.
        let own = |id, bound| if id == ground { Some(9.0) } else { Some(bound) };
        assert_eq!(
            index.cast_with(&ray(1e4), own).map(|hit| hit.proxy),
            Some(ground)
        );
        assert_eq!(index.cast_with(&ray(8.0), own), None);
        let mut hits = vec![];
        index.k_nearest_with(Vec3::X * 990.0, 9, 1e4, &mut hits, |id, bound| {
            own(id, bound).map(|far| far + 1.0)
        });
        assert_eq!(
            hits.iter().map(|hit| hit.proxy).collect::<Vec<_>>(),
            [ground, cube]
        );
        let mut count = 0;
        index.for_each_overlapping(&unit(0.0), |_| {
            count += 1;
            std::ops::ControlFlow::Break(())
        });
        assert_eq!(count, 1);
    }
}

#[test]
fn no_box_that_reaches_a_plane_is_left_out() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..10_000 {
        let mut unit = || Vec3::from_array(std::array::from_fn(|_| random.f32() * 2.0 - 1.0));
        let (normal, at, half) = (unit().normalize(), unit(), unit().abs());
        let far = 10_f32.powi(random.i32(0..6));
        let side = HalfSpace::new(normal.extend(random.f32() * far));
        // A corner on the plane, in double precision.
        let normal = side.normal().as_dvec3();
        let at = at.as_dvec3() * f64::from(far);
        let corner = at - normal * (at.dot(normal) + f64::from(side.d()));
        let outwards = DVec3::select(normal.cmpge(DVec3::ZERO), -DVec3::ONE, DVec3::ONE);
        let opposite = corner + outwards * half.as_dvec3();
        let (corner, opposite) = (corner.as_vec3a(), opposite.as_vec3a());
        let aabb = Aabb3d {
            min: corner.min(opposite),
            max: corner.max(opposite),
        };
        let unbounded = Unbounded {
            id: ProxyId::new(0),
            side: Some(side),
        };
        assert!(unbounded.may_meet(&aabb));
        let apart = (outwards * f64::from(far) * 1e-3).as_vec3a();
        let apart = Aabb3d {
            min: aabb.min + apart,
            max: aabb.max + apart,
        };
        assert!(!unbounded.may_meet(&apart) || normal.abs().max_element() < 0.1);
    }
}
