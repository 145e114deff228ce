//! The plugin group: sets, schedules, stages, settings, reflection.

use crate::common;

use std::time::Duration;

use bevy::{
    app::PluginGroupBuilder,
    ecs::{
        reflect::ReflectResource,
        schedule::{InternedScheduleLabel, ScheduleLabel},
    },
    prelude::*,
    time::TimePlugin,
};
use bevy_octree::{
    broad_phase::{
        BroadPhase, BroadPhaseStats, Exhaustive, ObjectOctreeSettings, Pair, Proxies, RootPolicy,
        Visitor,
    },
    collision_index::{CandidatePairs, CollisionIndex},
    components::WorldAabb,
    diagnostics::CollisionDiagnosticsPlugin,
    motion::{CollisionClock, MotionSettings, PositionTrack, Step},
    narrow_phase::NarrowPhase,
    plugins::{
        BouncePlugin, BoundsPlugin, BroadPhasePlugin, MotionPlugin, NarrowPhasePlugin, ReportPlugin,
    },
    prelude::*,
    scene::Cube,
};
use common::*;

/// A cube that moves 1/4 per tick along x, and at tick 4 meets a wall.
fn toward_a_wall(app: &mut App) -> EntityPair {
    let velocity = Velocity(Vec3::X * 0.25 * TICKS_PER_SECOND);
    let cube = app.world_mut().spawn((Cube, velocity)).id();
    let wall = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(1.875, 0.0, 0.0),
        ))
        .id();
    [cube, wall]
}

fn assert_bounced(app: &App, cubes: EntityPair) {
    assert_eq!(messages_about(app, cubes), (1, 1));
    assert_eq!(
        get::<Velocity>(app, cubes[0]).0,
        Vec3::NEG_X * 0.25 * TICKS_PER_SECOND
    );
}

/// What a user's system can see, by the names of the table of [`CollisionSystems`].
#[derive(Resource, Clone, Default)]
struct Snapshots(Vec<[(&'static str, f32); 7]>);

fn look(world: &mut World) {
    let (cube, aabb, transform, velocity) = world
        .query_filtered::<(Entity, &WorldAabb, &Transform, &Velocity), With<Cube>>()
        .iter(world)
        .map(|(entity, aabb, transform, velocity)| {
            (entity, aabb.max.x, transform.translation.x, velocity.x)
        })
        .next()
        .unwrap();
    let index = world.resource::<CollisionIndex>();
    let indexed = index
        .index()
        .proxies()
        .iter()
        .find(|(id, _)| index.entity(*id) == Some(cube));
    let started = world.resource::<Messages<CollisionStarted>>();
    let snapshot = [
        ("Transform", transform),
        ("WorldAabb", aabb),
        (
            "CollisionIndex",
            indexed.map_or(0.0, |(_, aabb)| aabb.max.x),
        ),
        (
            "CandidatePairs",
            world.resource::<CandidatePairs>().len() as f32,
        ),
        ("Contacts", world.resource::<Contacts>().len() as f32),
        ("Velocity", velocity),
        (
            "messages",
            started.iter_current_update_messages().count() as f32,
        ),
    ];
    world.resource_mut::<Snapshots>().0.push(snapshot);
}

/// At the tick of the contact everything changes, and each set changes what its documentation says.
#[test]
fn systems_between_the_sets_see_what_the_sets_promise() {
    let mut app = app(BroadPhaseMethod::default());
    app.init_resource::<Snapshots>()
        .add_systems(FixedPostUpdate, look.before(SETS[0]));
    for sets in SETS.windows(2) {
        app.add_systems(FixedPostUpdate, look.after(sets[0]).before(sets[1]));
    }
    app.add_systems(FixedPostUpdate, look.after(SETS[8]));
    toward_a_wall(&mut app);
    tick(&mut app, 3);
    app.world_mut().resource_mut::<Snapshots>().0.clear();
    tick(&mut app, 1);
    let snapshots = &app.world().resource::<Snapshots>().0;
    assert_eq!(snapshots.len(), SETS.len() + 1);
    let expected = [
        None,
        Some("Transform"),
        Some("WorldAabb"),
        Some("CollisionIndex"),
        Some("CandidatePairs"),
        Some("Contacts"),
        Some("Velocity"),
        Some("messages"),
        None,
    ];
    for ((set, expected), around) in SETS.into_iter().zip(expected).zip(snapshots.windows(2)) {
        let changed = around[0]
            .iter()
            .zip(&around[1])
            .filter(|(before, after)| before.1 != after.1);
        let changed: Vec<_> = changed.map(|(before, _)| before.0).collect();
        assert_eq!(changed, expected.into_iter().collect::<Vec<_>>(), "{set:?}");
    }
}

#[test]
fn a_pair_that_a_system_takes_out_is_not_in_contact() {
    let mut app = app(BroadPhaseMethod::default());
    let veto = |mut pairs: ResMut<CandidatePairs>| pairs.clear();
    let between = (CollisionSystems::BroadPhase, CollisionSystems::NarrowPhase);
    app.add_systems(FixedPostUpdate, veto.after(between.0).before(between.1));
    let cubes = toward_a_wall(&mut app);
    tick(&mut app, 20);
    assert_eq!(get::<Transform>(&app, cubes[0]).translation.x, 5.0);
    assert_eq!(messages_about(&app, cubes), (0, 0));
    assert!(app.world().resource::<CollisionCounters>().total.candidates > 0);
}

/// Enlarged boxes make more candidates, and no contacts.
#[test]
fn a_system_may_enlarge_boxes() {
    let mut app = app(BroadPhaseMethod::default());
    let enlarge = |mut boxes: Query<&mut WorldAabb, Changed<WorldAabb>>| {
        for mut aabb in &mut boxes {
            aabb.0.min -= 5.0;
            aabb.0.max += 5.0;
        }
    };
    let between = (CollisionSystems::Bounds, CollisionSystems::Maintenance);
    app.add_systems(FixedPostUpdate, enlarge.after(between.0).before(between.1));
    toward_a_wall(&mut app);
    tick(&mut app, 1);
    assert_eq!((counters(&app).candidates, counters(&app).contacts), (1, 0));
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct OfMyOwn;

#[test]
fn the_group_runs_in_any_schedule() {
    let schedules: [InternedScheduleLabel; 6] = [
        FixedPostUpdate.intern(),
        FixedUpdate.intern(),
        PreUpdate.intern(),
        Update.intern(),
        PostUpdate.intern(),
        OfMyOwn.intern(),
    ];
    for schedule in schedules {
        let mut app = app_with(OctreePlugins::new(schedule), schedule);
        app.init_schedule(OfMyOwn)
            .add_systems(Update, |world: &mut World| world.run_schedule(OfMyOwn));
        let cubes = toward_a_wall(&mut app);
        tick(&mut app, 8);
        assert_eq!(
            app.world().resource::<CollisionClock>().tick(),
            8,
            "{schedule:?}"
        );
        assert_eq!(
            get::<Transform>(&app, cubes[0]).translation.x,
            0.0,
            "{schedule:?}"
        );
        assert_bounced(&app, cubes);
    }
}

#[test]
fn transforms_are_propagated_after_the_sets() {
    let mut app = app_with(
        (TransformPlugin, OctreePlugins::new(PostUpdate)),
        PostUpdate,
    );
    let [cube, _] = toward_a_wall(&mut app);
    for number in 1..=3 {
        tick(&mut app, 1);
        assert_eq!(
            get::<GlobalTransform>(&app, cube).translation().x,
            0.25 * number as f32
        );
    }
}

/// Without a stage the others still run: where the cube is after 8 ticks, its contacts and the
/// messages about them.
#[test]
fn each_stage_can_be_left_out() {
    type Without = fn(PluginGroupBuilder) -> PluginGroupBuilder;
    let cases: [(&str, Without, f32, u64, usize); 7] = [
        ("nothing", |group| group, 0.0, 1, 1),
        ("motion", |group| group.disable::<MotionPlugin>(), 0.0, 0, 0),
        ("bounds", |group| group.disable::<BoundsPlugin>(), 2.0, 0, 0),
        (
            "broad phase",
            |group| group.disable::<BroadPhasePlugin>(),
            2.0,
            0,
            0,
        ),
        (
            "narrow phase",
            |group| group.disable::<NarrowPhasePlugin>(),
            2.0,
            0,
            0,
        ),
        ("bounce", |group| group.disable::<BouncePlugin>(), 2.0, 5, 1),
        ("report", |group| group.disable::<ReportPlugin>(), 0.0, 1, 0),
    ];
    for (stage, without, x, contacts, messages) in cases {
        let mut app = app_with(without(OctreePlugins::default().build()), FixedPostUpdate);
        let [cube, wall] = toward_a_wall(&mut app);
        tick(&mut app, 8);
        assert_eq!(
            get::<Transform>(&app, cube).translation.x,
            x,
            "without {stage}"
        );
        let total = app.world().resource::<CollisionCounters>().total;
        assert_eq!(
            (total.contacts, messages_about(&app, [cube, wall]).0),
            (contacts, messages),
            "without {stage}"
        );
        assert_eq!(app.world().resource::<CollisionClock>().tick(), 8);
        app.world_mut().despawn(wall);
        tick(&mut app, 2);
    }
}

#[test]
fn settings_out_of_range_do_no_harm() {
    let good = ObjectOctreeSettings::default();
    let cube = |half_size| RootPolicy::Cube {
        center: Vec3::ZERO,
        half_size,
    };
    let bad = [
        ObjectOctreeSettings {
            max_objects: 0,
            ..good
        },
        ObjectOctreeSettings {
            max_objects: u32::MAX,
            ..good
        },
        ObjectOctreeSettings {
            max_depth: 0,
            ..good
        },
        ObjectOctreeSettings {
            max_depth: 99,
            max_objects: 1,
            ..good
        },
        ObjectOctreeSettings {
            merge_slack: u32::MAX,
            ..good
        },
        ObjectOctreeSettings {
            max_doublings: u32::MAX,
            ..good
        },
        ObjectOctreeSettings {
            root: RootPolicy::Fit { scale: f32::NAN },
            ..good
        },
        ObjectOctreeSettings {
            root: RootPolicy::Fit { scale: -1.0 },
            ..good
        },
        ObjectOctreeSettings {
            root: cube(f32::NAN),
            ..good
        },
        ObjectOctreeSettings {
            root: cube(0.0),
            ..good
        },
        ObjectOctreeSettings {
            root: cube(f32::MAX),
            max_objects: 1,
            ..good
        },
    ];
    for settings in bad {
        let mut app = app(BroadPhaseMethod::ObjectOctree(settings));
        let cubes = toward_a_wall(&mut app);
        tick(&mut app, 8);
        assert_bounced(&app, cubes);
    }
}

#[test]
fn the_step_can_be_set_and_a_bad_one_lets_no_time_pass() {
    let cases = [
        (2.0 / TICKS_PER_SECOND, 1.0),
        (0.0, 0.0),
        (-1.0, 0.0),
        (f32::NAN, 0.0),
        (f32::INFINITY, 0.0),
    ];
    for (seconds, expected) in cases {
        let mut app = app(BroadPhaseMethod::default());
        app.world_mut().resource_mut::<MotionSettings>().step = Step::Seconds(seconds);
        let [cube, wall] = toward_a_wall(&mut app);
        app.world_mut().despawn(wall);
        tick(&mut app, 2);
        assert_eq!(
            get::<Transform>(&app, cube).translation.x,
            expected,
            "{seconds} s"
        );
        app.world_mut().resource_mut::<MotionSettings>().step = Step::Time;
        tick(&mut app, 1);
        assert_eq!(
            get::<Transform>(&app, cube).translation.x,
            expected + 0.25,
            "{seconds} s"
        );
    }
}

#[test]
fn without_a_time_plugin_only_a_set_step_moves() {
    for (step, expected) in [
        (Step::Time, 0.0),
        (Step::Seconds(1.0 / TICKS_PER_SECOND), 0.75),
    ] {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins.build().disable::<TimePlugin>(),
            OctreePlugins::new(Update),
        ))
        .insert_resource(MotionSettings { step });
        let [cube, _] = toward_a_wall(&mut app);
        tick(&mut app, 3);
        assert_eq!(get::<Transform>(&app, cube).translation.x, expected);
        assert_eq!(app.world().resource::<CollisionClock>().tick(), 3);
    }
}

#[test]
fn a_paused_app_rests() {
    let mut app = app_with(OctreePlugins::new(Update), Update);
    let cubes = toward_a_wall(&mut app);
    tick(&mut app, 1);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    tick(&mut app, 5);
    assert_eq!(
        (
            get::<Transform>(&app, cubes[0]).translation.x,
            counters(&app).moved
        ),
        (0.25, 0)
    );
    app.world_mut().resource_mut::<Time<Virtual>>().unpause();
    tick(&mut app, 7);
    assert_bounced(&app, cubes);
}

#[test]
fn several_ticks_in_one_frame_are_several_ticks() {
    let mut app = app(BroadPhaseMethod::default());
    let cubes = toward_a_wall(&mut app);
    let frame = Duration::from_secs(8) / TICKS_PER_SECOND as u32;
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(frame));
    app.update();
    assert_eq!(app.world().resource::<CollisionClock>().tick(), 8);
    assert_bounced(&app, cubes);
}

#[test]
fn a_changed_tolerance_counts_for_all_pairs_at_once() {
    let mut app = app(BroadPhaseMethod::default());
    let row = [0.0, 1.05, 2.1].map(|x| {
        app.world_mut()
            .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)))
            .id()
    });
    tick(&mut app, 2);
    for (tolerance, expected) in [
        (0.1, vec![[row[0], row[1]], [row[1], row[2]]]),
        (0.01, vec![]),
    ] {
        app.insert_resource(NarrowPhase::new(tolerance).unwrap());
        tick(&mut app, 1);
        assert_eq!(contacts(&app), expected);
        tick(&mut app, 1);
        assert_eq!(counters(&app).moved, 0);
    }
}

/// The track is at 0 in tick 0, and at 3 in tick 6: inside the wall from tick 2 to 5.
#[test]
fn tracks_drive_entities_whatever_their_velocity() {
    let mut app = app(BroadPhaseMethod::default());
    let track = PositionTrack::new([(0, Vec3::ZERO), (6, Vec3::X * 3.0)]).unwrap();
    let track = (Cube, track, Velocity(Vec3::splat(100.0)));
    let follower = app.world_mut().spawn(track).id();
    let wall = app
        .world_mut()
        .spawn((
            CollisionShape::default(),
            Transform::from_xyz(1.75, 0.0, 0.0),
        ))
        .id();
    for number in 0..10 {
        assert_eq!(app.world().resource::<CollisionClock>().tick(), number);
        tick(&mut app, 1);
        let x = (number as f32 * 0.5).min(3.0);
        assert_eq!(get::<Transform>(&app, follower).translation, Vec3::X * x);
        assert_eq!(
            contacts(&app).len(),
            usize::from((2..=5).contains(&number)),
            "tick {number}"
        );
    }
    assert_eq!(counters(&app).moved, 0, "it has come to rest");
    assert_eq!(messages_about(&app, [follower, wall]), (1, 1));
    app.world_mut().resource_mut::<CollisionClock>().set_tick(3);
    tick(&mut app, 1);
    assert_eq!(get::<Transform>(&app, follower).translation, Vec3::X * 1.5);
}

#[test]
fn counters_sum_up_ticks() {
    let mut app = app(BroadPhaseMethod::default());
    toward_a_wall(&mut app);
    tick(&mut app, 8);
    let total = app.world().resource::<CollisionCounters>().total;
    assert_eq!(
        (total.objects, total.moved),
        (16, 9),
        "two objects that come, and one that moves"
    );
    assert_eq!(
        (total.contacts, total.started, total.ended, total.bounces),
        (1, 1, 1, 1)
    );
    assert_eq!(total.stages.accepted(), 1);
}

#[test]
fn everything_is_registered_for_reflection() {
    let app = app(BroadPhaseMethod::default());
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let components = [
        "CollisionShape",
        "ShapeDescription",
        "ShapeDescriptionError",
        "WorldAabb",
        "BroadPhaseProxy",
        "Cube",
        "Velocity",
        "PositionTrack",
        "Bounce",
        "CollisionEventsEnabled",
        "CollidingEntities",
    ];
    // All but the index, which makes no sense without the entities behind it.
    let resources = [
        "BroadPhaseSettings",
        "CandidatePairs",
        "Contacts",
        "CollisionEventSettings",
        "CollisionCounters",
        "CollisionClock",
        "MotionSettings",
        "NarrowPhase",
    ];
    // The index is not made from reflected values: it makes no sense without the entities behind
    // it.
    let others = ["CollisionIndex", "CollisionStarted", "CollisionEnded"];
    let find = |name: &str| registry.get_with_type_path(&format!("bevy_octree::{name}"));
    let component = |name: &&str| {
        find(name)
            .and_then(|found| found.data::<ReflectComponent>())
            .is_some()
    };
    let resource = |name: &&str| {
        find(name)
            .and_then(|found| found.data::<ReflectResource>())
            .is_some()
    };
    let mut missing: Vec<&str> = Vec::new();
    missing.extend(components.iter().filter(|name| !component(name)));
    missing.extend(resources.iter().filter(|name| !resource(name)));
    missing.extend(others.iter().filter(|name| find(name).is_none()));
    assert!(missing.is_empty(), "{missing:?}");
}

/// What a scene calls a type stays as it is, though files move.
#[test]
fn no_path_of_a_type_spells_a_file() {
    let mut app = app(BroadPhaseMethod::default());
    #[cfg(feature = "rapier")]
    app.add_plugins(RapierInteropPlugin::default());
    #[cfg(feature = "picking")]
    app.add_plugins(CollisionPickingPlugin);
    #[cfg(feature = "debug_draw")]
    app.register_type::<CollisionGizmos>()
        .register_type::<DebugDraw>();
    app.add_plugins(CollisionDiagnosticsPlugin);
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let mut ours: Vec<_> = registry
        .iter()
        .map(|found| found.type_info().type_path())
        .filter(|path| path.contains("bevy_octree::"))
        .collect();
    ours.sort_unstable();
    assert!(ours.len() > 40, "{ours:#?}");
    assert!(
        ours.windows(2).all(|pair| pair[0] != pair[1]),
        "two types share a path: {ours:#?}"
    );
    let spells_a_file = |path: &&str| {
        path.split("bevy_octree::").skip(1).any(|rest| {
            let end = rest
                .find(|c: char| !(c.is_alphanumeric() || c == '_'))
                .unwrap_or(rest.len());
            rest[end..].starts_with("::")
        })
    };
    let left: Vec<_> = ours.into_iter().filter(spells_a_file).collect();
    assert_eq!(left, [""; 0]);
}

#[test]
fn components_can_be_built_from_templates() {
    fn assert_template<C: Component + FromTemplate>() {}
    assert_template::<Bounce>();
    assert_template::<CollidingEntities>();
    assert_template::<CollisionEventsEnabled>();
    assert_template::<CollisionLayers>();
    assert_template::<CollisionShape>();
    assert_template::<Cube>();
    assert_template::<IgnoreCollisions>();
    assert_template::<InCollisionWorld>();
    assert_template::<MovedElsewhere>();
    assert_template::<PositionTrack>();
    assert_template::<Sensor>();
    assert_template::<StaticShape>();
    assert_template::<Swept>();
    assert_template::<Velocity>();
}

#[test]
fn after_the_last_tick_of_the_clock_comes_the_first() {
    let mut app = app(BroadPhaseMethod::default());
    let track = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::X)]).unwrap();
    let rider = app
        .world_mut()
        .spawn((CollisionShape::default(), track))
        .id();
    app.world_mut()
        .resource_mut::<CollisionClock>()
        .set_tick(u64::MAX);
    for (x, next) in [(1.0, 0), (0.0, 1), (0.1, 2)] {
        tick(&mut app, 1);
        assert_eq!(get::<Transform>(&app, rider).translation.x, x);
        assert_eq!(app.world().resource::<CollisionClock>().tick(), next);
    }
}

#[test]
fn settings_that_stay_out_of_range_do_not_lay_the_octree_anew() {
    let nan = ObjectOctreeSettings {
        root: RootPolicy::Fit { scale: f32::NAN },
        ..default()
    };
    let cube = RootPolicy::Cube {
        center: Vec3::NAN,
        half_size: f32::NAN,
    };
    let zero = ObjectOctreeSettings {
        max_objects: 0,
        max_depth: 99,
        merge_slack: 70,
        ..default()
    };
    for settings in [
        nan,
        ObjectOctreeSettings {
            root: cube,
            ..default()
        },
        zero,
    ] {
        let mut app = app(BroadPhaseMethod::ObjectOctree(settings));
        for x in [0.0, 0.9] {
            app.world_mut()
                .spawn((CollisionShape::default(), Transform::from_xyz(x, 0.0, 0.0)));
        }
        tick(&mut app, 2);
        for _ in 0..3 {
            tick(&mut app, 1);
            assert_eq!(
                (counters(&app).moved, contacts(&app).len()),
                (0, 1),
                "{settings:?}"
            );
        }
    }
}

/// Exhaustive search under another name.
#[derive(Default)]
struct MyOwn(Exhaustive);

impl BroadPhase for MyOwn {
    fn name(&self) -> &'static str {
        "my own"
    }
    fn maintain(&mut self, proxies: &Proxies) {
        self.0.maintain(proxies);
    }
    fn find_pairs(&mut self, proxies: &Proxies, pairs: &mut Vec<Pair>) -> u64 {
        self.0.find_pairs(proxies, pairs)
    }
    fn traverse(&self, proxies: &Proxies, visitor: &mut dyn Visitor) {
        self.0.traverse(proxies, visitor);
    }
    fn stats(&self) -> BroadPhaseStats {
        self.0.stats()
    }
}

#[test]
fn a_broad_phase_of_ones_own_stays_until_another_method_is_chosen() {
    let mut app = app(BroadPhaseMethod::default());
    app.world_mut().spawn(Cube);
    app.world_mut()
        .spawn((Cube, Transform::from_xyz(0.9, 0.0, 0.0)));
    app.world_mut()
        .resource_mut::<CollisionIndex>()
        .set_engine(Box::new(MyOwn::default()));
    tick(&mut app, 2);
    let name = |app: &App| {
        app.world()
            .resource::<CollisionIndex>()
            .index()
            .engine()
            .name()
    };
    assert_eq!((name(&app), contacts(&app).len()), ("my own", 1));
    app.world_mut().resource_mut::<BroadPhaseSettings>().method = BroadPhaseMethod::Exhaustive;
    tick(&mut app, 1);
    assert_eq!((name(&app), contacts(&app).len()), ("exhaustive", 1));
}
