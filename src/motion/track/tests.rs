use super::*;

fn corner() -> PositionTrack {
    PositionTrack::new([
        (10, Vec3::ZERO),
        (14, Vec3::new(4.0, 0.0, 0.0)),
        (22, Vec3::new(4.0, 16.0, 0.0)),
    ])
    .unwrap()
}

#[test]
fn linear_holds_outside_and_is_exact_at_keys() {
    let track = corner();
    for (tick, expected) in [
        (0, (0.0, 0.0)),
        (10, (0.0, 0.0)),
        (11, (1.0, 0.0)),
        (14, (4.0, 0.0)),
        (15, (4.0, 2.0)),
        (22, (4.0, 16.0)),
        (u64::MAX, (4.0, 16.0)),
    ] {
        assert_eq!(track.position(tick).xy(), expected.into(), "tick {tick}");
    }
}

#[test]
fn a_start_is_where_ticks_are_counted_from() {
    for track in [
        corner(),
        corner().with_outside(Outside::Loop),
        corner().with_interpolation(Interpolation::Smooth),
    ] {
        let later = track.clone().starting_at(1000);
        for tick in 0..100 {
            assert_eq!(later.position(1000 + tick), track.position(tick), "{tick}");
        }
        // Before, it waits where it starts.
        for tick in [0, 500, 999] {
            assert_eq!(later.position(tick), track.position(0));
        }
        let latest = track.clone().starting_at(u64::MAX);
        assert_eq!(latest.position(u64::MAX), track.position(0));
        let now = track.clone().starting_now();
        assert_eq!(now.position(77), track.position(0));
        assert_eq!(track.start(), TrackStart::At(0));
    }
}

#[test]
fn who_starts_now_starts_in_its_first_tick() {
    let mut world = World::new();
    world.init_resource::<CollisionClock>();
    world.resource_mut::<CollisionClock>().set_tick(40);
    let line = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::X * 10.0)]).unwrap();
    let spawn = |world: &mut World| {
        world
            .spawn(line.clone().with_outside(Outside::Loop).starting_now())
            .id()
    };
    let x = |world: &World, entity| world.get::<Transform>(entity).unwrap().translation.x;
    let first = spawn(&mut world);
    let mut second = first;
    for tick in 40..75 {
        if tick == 43 {
            second = spawn(&mut world);
        }
        world.resource_mut::<CollisionClock>().set_tick(tick);
        world.run_system_cached(follow_tracks).unwrap();
        assert_eq!(x(&world, first), ((tick - 40) % 10) as f32);
        if tick >= 43 {
            assert_eq!(x(&world, second), ((tick - 43) % 10) as f32);
        }
    }
    let start = world.get::<PositionTrack>(second).unwrap().start();
    assert_eq!(start, TrackStart::At(43));
}

#[test]
fn step_waits_for_the_next_key() {
    let track = corner().with_interpolation(Interpolation::Step);
    assert_eq!(track.position(13), Vec3::ZERO);
    assert_eq!(track.position(14), Vec3::new(4.0, 0.0, 0.0));
    assert_eq!(track.position(21), Vec3::new(4.0, 0.0, 0.0));
    assert_eq!(track.position(22), Vec3::new(4.0, 16.0, 0.0));
}

#[test]
fn ease_follows_the_function_between_keys() {
    let track = corner().with_interpolation(Interpolation::Ease(EaseFunction::QuadraticIn));
    assert_eq!(track.position(12), Vec3::X);
    assert_eq!(track.position(14), Vec3::X * 4.0);
}

#[test]
fn loop_repeats_in_both_directions() {
    let track = corner().with_outside(Outside::Loop);
    for tick in 10..22 {
        for period in 1..5 {
            assert_eq!(track.position(tick), track.position(tick + 12 * period));
        }
    }
    // The end of the loop is its start again.
    assert_eq!(track.position(22), Vec3::ZERO);
    assert_eq!(track.position(9), track.position(21));
    assert_eq!(track.position(0), track.position(12));
}

#[test]
fn smooth_passes_through_keys_and_keeps_straight_lines_straight() {
    let smooth = corner().with_interpolation(Interpolation::Smooth);
    for &(tick, position) in corner().keyframes() {
        assert_eq!(smooth.position(tick), position);
    }
    let line = PositionTrack::new([(0, Vec3::ZERO), (3, Vec3::X * 3.0), (9, Vec3::X * 9.0)])
        .unwrap()
        .with_interpolation(Interpolation::Smooth);
    for tick in 0..=9 {
        assert!((line.position(tick) - Vec3::X * tick as f32).length() < 1e-5);
    }
}

/// Dense ticks make differences of successive positions approximate velocities.
#[test]
fn smooth_has_no_sudden_turns_and_linear_does() {
    let keyframes = [
        (0, Vec3::ZERO),
        (1000, Vec3::X),
        (3000, Vec3::Y),
        (4000, Vec3::ZERO),
    ];
    let track = PositionTrack::new(keyframes)
        .unwrap()
        .with_outside(Outside::Loop);
    let turn = |track: &PositionTrack, tick: u64| {
        let at = |tick| track.position(tick);
        ((at(tick + 1) - at(tick)) - (at(tick) - at(tick - 1))).length() * 1000.0
    };
    let smooth = track.clone().with_interpolation(Interpolation::Smooth);
    for tick in [1000, 3000, 4000] {
        assert!(turn(&track, tick) > 0.5);
        assert!(turn(&smooth, tick) < 0.05, "{}", turn(&smooth, tick));
    }
}

#[test]
fn positions_are_finite_whatever_the_keyframes() {
    let eases = [
        EaseFunction::ElasticInOut,
        EaseFunction::BackOut,
        EaseFunction::Linear,
    ]
    .map(Interpolation::Ease);
    let ends = [Vec3::MIN, Vec3::MAX, Vec3::ZERO, Vec3::MAX, Vec3::MIN];
    for outside in [Outside::Hold, Outside::Loop] {
        for interpolation in [Interpolation::Linear, Interpolation::Smooth]
            .into_iter()
            .chain(eases)
        {
            let keyframes = ends
                .into_iter()
                .enumerate()
                .map(|(place, at)| (10 * place as u64, at));
            let track = PositionTrack::new(keyframes).unwrap();
            let track = track
                .with_interpolation(interpolation)
                .with_outside(outside);
            for tick in 0..50 {
                let position = track.position(tick);
                assert!(
                    position.is_finite(),
                    "{interpolation:?} {outside:?} {tick}: {position}"
                );
            }
            assert_eq!(track.position(10), Vec3::MAX);
        }
    }
}

#[test]
fn a_single_key_is_a_place() {
    assert_eq!(PositionTrack::default().position(9), Vec3::ZERO);
    for outside in [Outside::Hold, Outside::Loop] {
        let track = PositionTrack::new([(7, Vec3::ONE)])
            .unwrap()
            .with_outside(outside);
        assert_eq!([0, 7, 8].map(|tick| track.position(tick)), [Vec3::ONE; 3]);
    }
}

#[test]
fn late_ticks_stay_exact() {
    let start = 1 << 40;
    let track = PositionTrack::new([(start, Vec3::ZERO), (start + 4, Vec3::X)]).unwrap();
    assert_eq!(track.position(start + 1), Vec3::X * 0.25);
}

#[test]
fn bad_keyframes_are_refused() {
    assert_eq!(PositionTrack::new([]), Err(TrackError::Empty));
    let error = PositionTrack::new([(0, Vec3::ZERO), (5, Vec3::X), (5, Vec3::Y)]).unwrap_err();
    let message = "keyframe 2 is at tick 5, expected a tick after 5";
    assert_eq!(error.to_string(), message);
    let error = PositionTrack::new([(0, Vec3::NAN)]).unwrap_err();
    assert!(matches!(error, TrackError::NotFinite { index: 0, .. }));
}

#[test]
fn an_emptied_track_does_not_panic() {
    for outside in [Outside::Hold, Outside::Loop] {
        let track = PositionTrack {
            keyframes: Vec::new(),
            ..corner().with_outside(outside)
        };
        assert_eq!(track.position(3), Vec3::ZERO);
    }
}
