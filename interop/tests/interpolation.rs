//! Interpolation by `bevy_transform_interpolation`: what is drawn between ticks changes nothing in
//! them, however many frames there are for a tick.

use std::{collections::BTreeMap, time::Duration};

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_octree::{
    motion::{CollisionClock, Outside},
    prelude::*,
};
use bevy_transform_interpolation::{TranslationEasingState, prelude::*};

/// How long the app is looked at.
const TICKS: u64 = 400;
/// What is said of a tick: what, of whom, and its numbers.
type Line = (&'static str, [u64; 2], Vec<u64>);
type Story = Vec<Line>;

/// What an entity is known by in every app.
#[derive(Component, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Number(u64);

#[derive(Resource, Default)]
struct Record(BTreeMap<u64, Story>);

/// How often a transform was seen somewhere else than at the end of a tick.
#[derive(Resource, Default)]
struct Between(u64);

/// How the same scene is shown.
#[derive(Clone, Copy, Debug)]
struct Show {
    /// The lengths of frames, in turn, as shares of a tick.
    frames: &'static [f64],
    interpolated: bool,
    /// Is it asked, in each frame, where things are seen?
    asked: bool,
}

/// A frame for each tick, as each of them ends.
const PLAIN: Show = Show {
    frames: &[1.0],
    interpolated: false,
    asked: false,
};

fn record(
    entities: Query<(&Number, &Transform, Option<&Velocity>)>,
    numbers: Query<&Number>,
    (contacts, counters, clock): (Res<Contacts>, Res<CollisionCounters>, Res<CollisionClock>),
    (mut started, mut ended): (
        MessageReader<CollisionStarted>,
        MessageReader<CollisionEnded>,
    ),
    mut record: ResMut<Record>,
) {
    let bits = |v: Vec3| v.to_array().map(|x| u64::from(x.to_bits()));
    let who = |a, b| {
        numbers
            .get_many([a, b])
            .map_or([0; 2], |both| both.map(|number| number.0))
    };
    let mut story = Story::new();
    for (number, place, velocity) in entities.iter().sort::<&Number>() {
        let mut numbers = bits(place.translation).to_vec();
        numbers.extend(place.rotation.to_array().map(|x| u64::from(x.to_bits())));
        numbers.extend(velocity.into_iter().flat_map(|velocity| bits(velocity.0)));
        story.push(("place", [number.0, 0], numbers));
    }
    let of_contacts = contacts.iter().map(|collision| {
        let normal = collision
            .contact
            .map_or(Vec3::ZERO, |contact| contact.normal);
        let mut numbers = bits(normal).to_vec();
        numbers.push(u64::from(collision.time.to_bits()));
        ("contact", who(collision.a, collision.b), numbers)
    });
    story.extend(of_contacts);
    story.extend(
        started
            .read()
            .map(|start| ("started", who(start.a, start.b), Vec::new())),
    );
    story.extend(
        ended
            .read()
            .map(|end| ("ended", who(end.a, end.b), Vec::new())),
    );
    // What was looked at: whoever rests is not.
    let tick = counters.tick;
    let counts = [
        tick.objects,
        tick.moved,
        tick.candidates,
        tick.resting_pairs,
        tick.bounces,
    ];
    story.push(("counts", [0; 2], counts.to_vec()));
    record.0.insert(clock.tick(), story);
}

fn count_between(
    entities: Query<(&Transform, &TranslationEasingState)>,
    mut between: ResMut<Between>,
) {
    let elsewhere = entities.iter().filter(|(place, easing)| {
        easing
            .end
            .is_some_and(|end| end.distance(place.translation) > 1e-4)
    });
    between.0 += elsewhere.count() as u64;
}

fn spawn(mut commands: Commands) {
    let mut next = 0;
    let mut number = || {
        next += 1;
        Number(next)
    };
    let reflect = Bounce::Reflect { restitution: 1.0 };
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-5.5, 5.5] {
            let size = Vec3::splat(12.0) * (Vec3::ONE - axis) + axis;
            let wall = CollisionShape::cuboid(size.x, size.y, size.z);
            let place = Transform::from_translation(axis * side);
            commands.spawn((number(), wall, StaticShape, place));
        }
    }
    // A pile at rest, turned in all ways, in contact with each other.
    for step in 0..12_u8 {
        let height = f32::from(step).mul_add(0.45, -4.6);
        let turn = Quat::from_scaled_axis(Vec3::new(0.3, 0.7, 0.1) * f32::from(step));
        let place = Transform::from_xyz(-3.1, height, -3.3).with_rotation(turn);
        commands.spawn((number(), CollisionShape::cuboid(1.0, 0.5, 0.7), place));
    }
    for step in 0..12_u8 {
        let share = f32::from(step);
        let way = Vec3::new(
            (share * 2.4).sin(),
            (share * 1.7).cos(),
            (share * 0.9).sin(),
        );
        let ball = (CollisionShape::sphere(0.3), Velocity(way * 6.0), reflect);
        let place = Transform::from_translation(way * 2.5);
        let ball = commands.spawn((number(), ball, place)).id();
        match step % 4 {
            // One that is fast.
            0 => {
                let fast = (Velocity(way * 90.0), Swept::default());
                commands.entity(ball).insert(fast);
            }
            // One with a child that goes with it, turned.
            1 => {
                let place =
                    Transform::from_xyz(0.0, 0.6, 0.0).with_rotation(Quat::from_rotation_x(0.4));
                let child = (CollisionShape::cuboid(0.2, 0.6, 0.2), ChildOf(ball), place);
                commands.spawn((number(), child));
                let body = (CollisionBody::default(), Swept::default());
                commands.entity(ball).insert(body);
            }
            _ => {}
        }
    }
    let [left, right] = [-2.0, 3.0].map(|x| Vec3::new(x, -4.8, 3.0));
    let track = PositionTrack::new([(0, left), (90, right), (180, left)]).unwrap();
    let platform = CollisionShape::cuboid(2.0, 0.2, 2.0);
    commands.spawn((number(), platform, track.with_outside(Outside::Loop)));
    let character = (
        CollisionShape::capsule(0.3, 0.8),
        KinematicCharacter::default(),
    );
    commands.spawn((number(), character, Transform::from_xyz(-2.0, -3.5, 3.0)));
}

fn walk(
    mut characters: Query<&mut KinematicCharacter>,
    clock: Res<CollisionClock>,
    time: Res<Time>,
) {
    for mut character in &mut characters {
        let turn = Quat::from_rotation_y(clock.tick() as f32 * 0.02);
        let fall = character.velocity.y - 9.8 * time.delta_secs();
        character.velocity = turn * Vec3::X * 3.0 + Vec3::Y * fall;
    }
}

/// What happens in each tick, and how often a transform was between two.
fn watch(show: Show) -> (BTreeMap<u64, Story>, u64) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::default()));
    if show.interpolated {
        app.add_plugins(TransformInterpolationPlugin::interpolate_all())
            .add_systems(Update, count_between);
    }
    if show.asked {
        app.add_systems(Update, update_spatial_index);
    }
    app.init_resource::<Record>()
        .init_resource::<Between>()
        .insert_resource(CollisionEventSettings {
            geometry: EventScope::All,
            ..default()
        })
        .add_systems(Startup, spawn)
        .add_systems(FixedPostUpdate, walk.before(CollisionSystems::First))
        .add_systems(FixedPostUpdate, record.in_set(CollisionSystems::Last));
    app.finish();
    app.cleanup();
    let tick = app.world().resource::<Time<Fixed>>().timestep();
    let mut frames = show.frames.iter().cycle();
    while app.world().resource::<CollisionClock>().tick() < TICKS {
        let length = tick.mul_f64(*frames.next().unwrap());
        app.insert_resource(TimeUpdateStrategy::ManualDuration(
            length.max(Duration::from_nanos(1)),
        ));
        app.update();
    }
    let mut record = app.world_mut().remove_resource::<Record>().unwrap().0;
    record.retain(|tick, _| *tick < TICKS);
    (record, app.world().resource::<Between>().0)
}

#[track_caller]
fn assert_same(show: Show) {
    let (plain, _) = watch(PLAIN);
    let (shown, between) = watch(show);
    assert_eq!(
        between > 0,
        show.interpolated,
        "{show:?}: {between} were seen between ticks"
    );
    assert_eq!(plain.len(), TICKS as usize);
    for (tick, story) in &plain {
        // Who is found where it is seen has been there, and has to be put back.
        let counts = |line: &&Line| !show.asked || line.0 != "counts";
        let story: Vec<_> = story.iter().filter(counts).collect();
        let shown: Vec<_> = shown[tick].iter().filter(counts).collect();
        let differing = story.iter().zip(&shown).find(|(a, b)| a != b);
        assert!(
            story == shown,
            "{show:?}, tick {tick}: {differing:?}, of {} and {} lines",
            story.len(),
            shown.len()
        );
    }
}

/// Frames that are shorter and longer than ticks, and of no steady length.
const RATES: [&[f64]; 5] = [
    &[0.26],
    &[0.44],
    &[1.07],
    &[2.6],
    &[0.03, 0.9, 0.2, 3.7, 0.01, 0.5],
];

#[test]
fn the_scene_has_all_that_could_change() {
    let (plain, _) = watch(PLAIN);
    let all = || plain.values().flatten();
    for what in ["contact", "started", "ended"] {
        assert!(all().filter(|line| line.0 == what).count() > 50, "{what}");
    }
    // The pile rests, so that its contacts are not looked at.
    let counts = all().filter(|line| line.0 == "counts");
    assert!(counts.skip(2).all(|line| line.2[3] >= 11));
}

#[test]
fn frames_of_any_rate_are_the_same() {
    for frames in RATES {
        assert_same(Show { frames, ..PLAIN });
    }
}

#[test]
fn what_is_interpolated_neither_wakes_nor_touches() {
    for frames in RATES {
        let interpolated = true;
        assert_same(Show {
            frames,
            interpolated,
            ..PLAIN
        });
    }
}

#[test]
fn nor_if_it_is_asked_for_where_it_is_seen() {
    for frames in RATES {
        let (interpolated, asked) = (true, true);
        assert_same(Show {
            frames,
            interpolated,
            asked,
        });
    }
}
