use super::*;
use bevy::math::Vec3;

fn unit(x: f32) -> Aabb3d {
    Aabb3d::new(Vec3::new(x, 0.0, 0.0), Vec3::splat(0.5))
}

#[test]
fn bad_boxes_are_refused_by_name() {
    let mut proxies = Proxies::default();
    let nan = Aabb3d {
        min: Vec3::NAN.into(),
        max: Vec3::ONE.into(),
    };
    assert!(matches!(proxies.insert(nan), Err(BoxError::NotFinite(_))));
    let unbounded = Aabb3d {
        min: Vec3::ZERO.into(),
        max: Vec3::INFINITY.into(),
    };
    assert!(matches!(
        proxies.insert(unbounded),
        Err(BoxError::NotFinite(_))
    ));
    let inverted = Aabb3d {
        min: Vec3::ONE.into(),
        max: Vec3::ZERO.into(),
    };
    assert!(matches!(
        proxies.insert(inverted),
        Err(BoxError::Inverted(_))
    ));
    assert!(proxies.is_empty());
    let point = Aabb3d {
        min: Vec3::ONE.into(),
        max: Vec3::ONE.into(),
    };
    let id = proxies.insert(point).unwrap();
    assert!(matches!(proxies.set(id, &nan), Err(BoxError::NotFinite(_))));
    assert_eq!(proxies.get(id), Some(&point));
    assert_eq!(
        proxies.set(ProxyId::new(7), &point),
        Err(BoxError::UnknownProxy(ProxyId::new(7)))
    );
}

#[test]
fn a_foreign_handle_is_that_of_no_object() {
    let mut proxies = Proxies::default();
    let own = proxies.insert(unit(0.0)).unwrap();
    proxies.begin_update();
    for foreign in [ProxyId::new(1), ProxyId::new(u32::MAX)] {
        assert!(
            !proxies.contains(foreign)
                && !proxies.is_moved(foreign)
                && !proxies.is_resting(foreign)
        );
        assert_eq!(
            (proxies.get(foreign), proxies.filter(foreign)),
            (None, PairFilter::default())
        );
        assert!(proxies.admits(own, foreign));
        assert!(!proxies.touch(foreign) && !proxies.remove(foreign));
        let unknown = Err(BoxError::UnknownProxy(foreign));
        assert_eq!(proxies.set(foreign, &unit(1.0)), unknown);
        assert_eq!(proxies.set_unbounded(foreign, None), unknown);
        assert_eq!(proxies.set_filter(foreign, PairFilter::default()), unknown);
    }
    assert!(proxies.is_moved(own));
}

#[test]
fn a_handle_is_reused_only_after_two_updates() {
    let mut proxies = Proxies::default();
    let first = proxies.insert(unit(0.0)).unwrap();
    proxies.begin_update();
    assert!(proxies.remove(first));
    assert!(!proxies.remove(first));
    for _ in 0..2 {
        assert_ne!(proxies.insert(unit(1.0)).unwrap(), first);
        proxies.begin_update();
    }
    assert_eq!(proxies.insert(unit(2.0)).unwrap(), first);
}

#[test]
fn moved_lists_each_change_once_and_unchanged_boxes_never() {
    let mut proxies = Proxies::default();
    let [a, b, c] = [0.0, 1.0, 2.0].map(|x| proxies.insert(unit(x)).unwrap());
    proxies.begin_update();
    assert_eq!(proxies.moved(), [a, b, c]);
    proxies.set(b, &unit(5.0)).unwrap();
    proxies.set(b, &unit(6.0)).unwrap();
    proxies.set(a, &unit(0.0)).unwrap();
    proxies.touch(c);
    proxies.begin_update();
    assert_eq!(proxies.moved(), [b, c]);
    assert!(proxies.is_resting(a) && proxies.is_moved(b) && proxies.is_moved(c));
    proxies.begin_update();
    assert!(proxies.moved().is_empty() && proxies.is_resting(b));
}
