use super::*;

#[test]
fn counts_are_the_reports() {
    let expected = [2, 18, 50, 98, 162, 242, 338, 450, 578, 722, 882];
    for (rings, count) in expected.into_iter().enumerate() {
        let set = TestSet::new(rings as u32);
        assert_eq!(set.object_count(), count);
        assert_eq!(set.cubes().count(), count);
        assert_eq!(set.name(), format!("t{rings}"));
    }
    assert_eq!(TestSet::new(110).cubes().count(), 97_682);
    let beyond = TestSet::new(u32::MAX);
    assert!(beyond.check().is_err() && beyond.object_count() > TestSet::new(1000).object_count());
}

#[test]
fn ring_k_has_8k_cubes_at_distance_k() {
    assert_eq!(ring_places(0).collect::<Vec<_>>(), [IVec2::ZERO]);
    for ring in 1..20 {
        let places: std::collections::HashSet<_> = ring_places(ring).collect();
        assert_eq!(places.len(), 8 * ring as usize);
        assert!(
            places
                .iter()
                .all(|place| place.abs().max_element() == ring as i32)
        );
    }
}

#[test]
fn cubes_of_a_plane_never_touch() {
    let set = TestSet::new(4);
    let left: Vec<_> = set
        .cubes()
        .filter(|cube| cube.plane == Plane::Left)
        .collect();
    for (i, a) in left.iter().enumerate() {
        for b in &left[..i] {
            let distance = (a.position - b.position).abs();
            assert!(distance.y > set.side || distance.z > set.side);
        }
    }
}

#[test]
fn opposite_cubes_are_aligned_and_approach() {
    let set = TestSet::new(5);
    let cubes: Vec<_> = set.cubes().collect();
    let (left, right) = cubes.split_at(cubes.len() / 2);
    for (index, (a, b)) in left.iter().zip(right).enumerate() {
        assert_eq!((a.plane, b.plane), (Plane::Left, Plane::Right));
        assert_eq!((a.index, b.index, a.ring), (index, index, b.ring));
        assert_eq!(a.position * Vec3::new(-1.0, 1.0, 1.0), b.position);
        assert_eq!(a.velocity, Vec3::X * set.speed);
        assert_eq!(b.velocity, Vec3::NEG_X * set.speed);
        let gap = b.position.x - a.position.x - set.side;
        assert_eq!(gap, set.gap + 2.0 * a.ring as f32 * set.setback);
    }
}

#[test]
fn each_ring_is_set_back_from_the_one_inside() {
    let set = TestSet::new(6);
    for cube in set.cubes() {
        assert_eq!(
            cube.position.x.abs(),
            (set.gap + set.side) / 2.0 + set.setback * cube.ring as f32
        );
        let place = cube.position.yz().abs() / set.spacing;
        assert_eq!(place.max_element(), cube.ring as f32);
    }
}

/// Steps each ring's facing sides in `f32` as motion does, and asks for exact half-step overlaps.
#[test]
fn first_overlap_is_half_a_step_deep_for_any_ring() {
    let set = TestSet::new(200);
    let delta_seconds = 1.0_f32 / 64.0;
    let velocity = 64.0 * set.speed;
    for ring in 0..=set.rings {
        let first = set.first_contact_tick(ring);
        let mut x = set.center_x(ring);
        for _ in 1..first {
            x -= velocity * delta_seconds;
            assert!(2.0 * x - set.side >= set.speed);
        }
        x -= velocity * delta_seconds;
        assert_eq!(2.0 * x - set.side, -set.speed);
        x += velocity * delta_seconds;
        assert_eq!(2.0 * x - set.side, set.speed);
    }
}

#[test]
fn bad_parameters_are_named() {
    let good = TestSet::default();
    assert_eq!(good.check(), Ok(()));
    assert_eq!(TestSet::new(TestSet::MAX_RINGS).check(), Ok(()));
    assert_eq!(TestSet::new(0).check(), Ok(()));
    let bad = [
        (TestSet::new(1001), "rings is 1001, expected at most 1000"),
        (
            TestSet { side: 0.0, ..good },
            "side is 0, expected a positive number",
        ),
        (
            TestSet { gap: -1.0, ..good },
            "gap is -1, expected a positive number",
        ),
        (
            TestSet {
                speed: f32::NAN,
                ..good
            },
            "speed is NaN, expected a positive number",
        ),
        (
            TestSet {
                setback: -0.5,
                ..good
            },
            "setback is -0.5, expected 0 or a positive number",
        ),
        (
            TestSet {
                spacing: 1.0,
                ..good
            },
            "spacing is 1, expected more than side",
        ),
        (
            TestSet {
                setback: 3e38,
                ..good
            },
            "expected rings at a finite distance",
        ),
        (
            TestSet {
                spacing: 3e38,
                ..good
            },
            "expected cubes at a finite distance",
        ),
    ];
    for (set, message) in bad {
        let error = set.check().unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
