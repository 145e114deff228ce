//! The order of the systems: of two that touch the same data, one is said to be the first.

use bevy::{
    ecs::{
        message::signal_message_update_system,
        schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel},
        system::SystemParam,
    },
    prelude::*,
};
use bevy_octree::{diagnostics::CollisionDiagnosticsPlugin, prelude::*};

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
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        OctreePlugins::new(schedule),
        CollisionDiagnosticsPlugin,
        PairHookPlugin::<NoGhosts>::default(),
        PairHookPlugin::<Nobody>::default(),
    ));
    app
}

/// Builds a schedule, and fails if there are two systems of which either may run first, to another
/// effect.
fn assert_in_order(app: &mut App, schedule: impl ScheduleLabel) {
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
        if let Err(error) = schedule.initialize(world) {
            panic!("{}", error.to_string(schedule.graph(), world));
        }
    });
}

#[test]
fn the_tick_is_in_order_in_whatever_schedule_it_runs() {
    assert_in_order(&mut app_in(Update), Update);
    assert_in_order(&mut app_in(PostUpdate), PostUpdate);
    assert_in_order(&mut app_in(FixedUpdate), FixedUpdate);
    assert_in_order(&mut app_in(FixedPostUpdate), FixedPostUpdate);
}

/// With Rapier in front, in another schedule: its own systems are its own affair.
#[cfg(feature = "rapier")]
#[test]
fn with_rapier_too() {
    use bevy_rapier3d::plugin::RapierPhysicsPlugin;

    for schedule in [PostUpdate.intern(), FixedPostUpdate.intern()] {
        let mut app = app_in(schedule);
        app.add_plugins((
            RapierPhysicsPlugin::<()>::default().in_schedule(FixedUpdate),
            RapierInteropPlugin::default(),
        ));
        assert_in_order(&mut app, schedule);
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
