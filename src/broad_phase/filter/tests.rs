use bevy::math::{Vec3A, bounding::Aabb3d};

use super::*;
use crate::broad_phase::{
    BroadPhase, BroadPhaseStats, Exhaustive, Pair, Proxies, SpatialIndex, Visitor,
    checked::Checked, overlap,
};

/// A broad phase that knows nothing of filters.
struct Unfiltered;

impl BroadPhase for Unfiltered {
    fn name(&self) -> &'static str {
        "unfiltered"
    }

    fn maintain(&mut self, _: &Proxies) {}

    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        for (a, box_a) in proxies.iter() {
            let after = proxies
                .iter()
                .filter(|(b, box_b)| *b > a && overlap(box_a, box_b));
            let moving = after.filter(|(b, _)| proxies.is_moved(a) || proxies.is_moved(*b));
            pairs.extend(moving.map(|(b, _)| Pair::new(a, b)));
        }
        0
    }

    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        Exhaustive::default().traverse(proxies, visitor);
    }

    fn stats(&self) -> BroadPhaseStats {
        BroadPhaseStats::default()
    }
}

#[test]
fn a_broad_phase_need_not_ask_filters() {
    let mut rng = fastrand::Rng::with_seed(4);
    let mut index = SpatialIndex::with_engine(Box::new(Unfiltered));
    for _ in 0..60 {
        let min = Vec3A::from_array(std::array::from_fn(|_| rng.f32() * 4.0));
        let id = index
            .insert(Aabb3d {
                min,
                max: min + 1.0,
            })
            .unwrap();
        let (memberships, filters) = (1 << rng.u32(0..3), rng.u32(0..8));
        let filter = PairFilter {
            memberships,
            filters,
            is_static: rng.bool(),
            is_detector: rng.bool(),
            world: rng.u32(0..2),
            body: *rng.choice(&[0, 1, PairFilter::NO_BODY]).unwrap(),
        };
        index.set_filter(id, filter).unwrap();
    }
    let mut checked = Checked { index };
    checked.step();
    assert!(!checked.index.pairs().is_empty());
}

#[test]
fn both_must_admit() {
    let any = PairFilter::default();
    let on = |memberships, filters| PairFilter {
        memberships,
        filters,
        ..any
    };
    assert!(any.admits(&any));
    assert!(on(2, 4).admits(&on(4, 2)));
    assert!(!on(2, 4).admits(&on(4, 1)));
    assert!(!on(2, 1).admits(&on(4, 2)));
    assert!(
        !on(0, u32::MAX).admits(&any),
        "an object on no layer meets nothing"
    );
    let detector = PairFilter {
        is_detector: true,
        ..on(0, 4)
    };
    assert!(detector.admits(&on(4, 0)) && on(4, 0).admits(&detector));
    assert!(!detector.admits(&on(2, u32::MAX)) && !on(2, u32::MAX).admits(&detector));
    assert!(!detector.admits(&detector));
    assert_eq!(size_of::<PairFilter>(), 20, "detectors take no room");
    let of_body = |body| PairFilter { body, ..any };
    assert!(!of_body(3).admits(&of_body(3)) && of_body(3).admits(&of_body(4)));
    assert!(of_body(3).admits(&any) && any.admits(&of_body(3)));
    let elsewhere = PairFilter { world: 7, ..any };
    assert!(elsewhere.admits(&elsewhere) && !elsewhere.admits(&any) && !any.admits(&elsewhere));
}

#[test]
fn each_kind_can_be_had_alone() {
    let moving = PairFilter::default();
    let fixed = PairFilter {
        is_static: true,
        ..moving
    };
    let included = |kinds: PairKinds| {
        [
            (moving, moving),
            (moving, fixed),
            (fixed, moving),
            (fixed, fixed),
        ]
        .map(|(a, b)| kinds.include(&a, &b))
    };
    assert_eq!(included(PairKinds::default()), [true, true, true, false]);
    let none = PairKinds {
        moving_moving: false,
        moving_static: false,
        static_static: false,
    };
    assert_eq!(included(none), [false; 4]);
    assert_eq!(
        included(PairKinds {
            moving_moving: true,
            ..none
        }),
        [true, false, false, false]
    );
    assert_eq!(
        included(PairKinds {
            moving_static: true,
            ..none
        }),
        [false, true, true, false]
    );
    assert_eq!(
        included(PairKinds {
            static_static: true,
            ..none
        }),
        [false, false, false, true]
    );
}
