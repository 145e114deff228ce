//! The order of the systems: of two that touch the same data, one is said to be the first.

use std::{any::TypeId, collections::HashSet};

use bevy::{
    app::PluginGroupBuilder,
    ecs::{
        message::signal_message_update_system,
        schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel},
        system::SystemParam,
    },
    prelude::*,
};
use bevy_octree::{
    diagnostics::CollisionDiagnosticsPlugin,
    plugins::{
        BouncePlugin, BoundsPlugin, BroadPhasePlugin, CasterPlugin, FilterPlugin, MotionPlugin,
        NarrowPhasePlugin, ReportPlugin, ScenePlugin, SweptPlugin,
    },
    prelude::*,
    rollback::RollbackPlugin,
};

use crate::{common::SETS, hook::NoGhosts};

/// A second hook.
#[derive(SystemParam)]
struct Nobody;

impl PairHook for Nobody {
    fn admits(_: &Self, _: Entity, _: Entity) -> bool {
        false
    }
}

/// An app with all that runs in a tick, in `schedule`.
fn app_in(schedule: impl ScheduleLabel) -> App {
    app_with(OctreePlugins::new(schedule).build())
}

/// An app with these plugins of the group, and all that is not in it.
fn app_with(group: PluginGroupBuilder) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        group,
        CollisionDiagnosticsPlugin,
        RollbackPlugin,
        PairHookPlugin::<NoGhosts>::default(),
        PairHookPlugin::<Nobody>::default(),
    ));
    app
}

/// Builds a schedule, and fails if there are two systems of which either may run first, to another
/// effect.
fn assert_in_order(app: &mut App, schedule: impl ScheduleLabel) {
    assert_in_order_with(app, schedule, &HashSet::new());
}

/// The same, but for what systems of others do to each other.
fn assert_in_order_with(app: &mut App, schedule: impl ScheduleLabel, others: &HashSet<TypeId>) {
    app.finish();
    app.cleanup();
    // Bevy's own, in no set: it lets messages age, and touches nothing else. What has the world to
    // itself may run before it or after it.
    for set in SETS {
        app.ignore_ambiguity(FixedPostUpdate, signal_message_update_system, set);
    }
    let settings = ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        hierarchy_detection: LogLevel::Error,
        ..default()
    };
    app.world_mut().schedule_scope(schedule, |world, schedule| {
        schedule.set_build_settings(settings);
        let Err(error) = schedule.initialize(world) else {
            return;
        };
        let graph = schedule.graph();
        let is_other = |key| others.contains(&graph.systems[key].system().system_type());
        let conflicts = graph.conflicting_systems();
        let are_others = |(a, b, _): &(_, _, _)| is_other(*a) && is_other(*b);
        if conflicts.is_empty() || !conflicts.iter().all(are_others) {
            panic!("{}", error.to_string(graph, world));
        }
    });
}

type Without = fn(PluginGroupBuilder) -> PluginGroupBuilder;

/// The group without each of the stages.
const STAGES: [Without; 10] = [
    |group| group.disable::<MotionPlugin>(),
    |group| group.disable::<BoundsPlugin>(),
    |group| group.disable::<BroadPhasePlugin>(),
    |group| group.disable::<FilterPlugin>(),
    |group| group.disable::<SweptPlugin>(),
    |group| group.disable::<NarrowPhasePlugin>(),
    |group| group.disable::<BouncePlugin>(),
    |group| group.disable::<CasterPlugin>(),
    |group| group.disable::<ReportPlugin>(),
    |group| group.disable::<ScenePlugin>(),
];

/// Apps with ticks in `schedule` in which stages are disabled: none, any one, any two, and all but
/// one.
fn apps_with_some_stages(schedule: impl ScheduleLabel) -> impl Iterator<Item = App> {
    let schedule = schedule.intern();
    let all = 0..1_u32 << STAGES.len();
    let some = all.filter(|disabled| {
        let count = disabled.count_ones() as usize;
        count <= 2 || count + 1 >= STAGES.len()
    });
    some.map(move |disabled| {
        let without = STAGES
            .iter()
            .enumerate()
            .filter(|(stage, _)| disabled >> stage & 1 == 1);
        let group = OctreePlugins::new(schedule).build();
        app_with(without.fold(group, |group, (_, without)| without(group)))
    })
}

#[test]
fn the_tick_is_in_order_in_whatever_schedule_it_runs() {
    assert_in_order(&mut app_in(Update), Update);
    assert_in_order(&mut app_in(PostUpdate), PostUpdate);
    assert_in_order(&mut app_in(FixedUpdate), FixedUpdate);
    assert_in_order(&mut app_in(FixedPostUpdate), FixedPostUpdate);
}

#[test]
fn whichever_stages_are_disabled_the_others_are_in_order() {
    for mut app in apps_with_some_stages(Update) {
        assert_in_order(&mut app, Update);
    }
}

/// With Rapier in front, in the same schedule or in another: what its own systems do to each other
/// is its own affair.
#[cfg(feature = "rapier")]
#[test]
fn with_rapier_too() {
    use bevy_rapier3d::plugin::RapierPhysicsPlugin;

    let [fixed, post] = [FixedUpdate.intern(), PostUpdate.intern()];
    let fixed_post = FixedPostUpdate.intern();
    for (steps, ticks) in [
        (fixed, fixed),
        (fixed, fixed_post),
        (fixed, post),
        (fixed_post, fixed_post),
        (post, post),
        (post, fixed),
    ] {
        let rapier = || RapierPhysicsPlugin::<()>::default().in_schedule(steps);
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, rapier()));
        let schedules = app.world().resource::<Schedules>();
        let systems = schedules.get(ticks).map(|own| own.graph().systems.iter());
        let others: HashSet<_> = systems
            .into_iter()
            .flatten()
            .map(|(_, system, _)| system.system_type())
            .collect();
        for mut app in apps_with_some_stages(ticks) {
            app.add_plugins((rapier(), RapierInteropPlugin::default()));
            assert_in_order_with(&mut app, ticks, &others);
        }
    }
}

#[cfg(feature = "debug_draw")]
#[test]
fn what_is_drawn_is_that_of_the_tick() {
    use bevy::{gizmos::GizmoPlugin, mesh::MeshPlugin};

    let mut app = app_in(Update);
    app.add_plugins((
        AssetPlugin::default(),
        MeshPlugin,
        GizmoPlugin,
        CollisionDebugPlugin,
    ));
    assert_in_order(&mut app, Last);
}

#[test]
#[should_panic(expected = "pairs of systems with conflicting data access")]
fn a_system_that_may_run_at_two_moments_is_noticed() {
    let mut app = app_in(Update);
    app.add_systems(
        Update,
        (|_: ResMut<Contacts>| ()).after(CollisionSystems::NarrowPhase),
    );
    assert_in_order(&mut app, Update);
}
