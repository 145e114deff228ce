//! What a tick takes, as Bevy's diagnostics.

use crate::common;

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore},
    ecs::schedule::ScheduleLabel,
    prelude::*,
};
use bevy_octree::{
    broad_phase::{BroadPhase, BroadPhaseStats, ObjectOctreeSettings, Pair, Proxies, Visitor},
    collision_index::CollisionIndex,
    diagnostics::{CollisionDiagnosticsPlugin as Paths, STAGES, StageTimes},
    prelude::*,
};
use common::{warnings::warnings, *};

fn value(app: &App, path: &DiagnosticPath) -> Option<f64> {
    app.world()
        .resource::<DiagnosticsStore>()
        .get(path)
        .expect("it is registered")
        .value()
}

#[test]
fn diagnostics_are_the_counters_of_the_last_tick() {
    for method in [
        BroadPhaseMethod::default(),
        BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings::with_max_objects(1)),
        BroadPhaseMethod::Exhaustive,
    ] {
        let mut app = app(method);
        app.add_plugins(Paths);
        assert_eq!(value(&app, &Paths::OBJECTS), None);
        for x in 0..40 {
            app.world_mut().spawn((
                CollisionShape::default(),
                Transform::from_xyz(0.9 * x as f32, 0.0, 0.0),
            ));
        }
        for (moved, events) in [(40.0, 39.0), (0.0, 0.0)] {
            tick(&mut app, 1);
            let stats = index(&app).stats();
            let expected = [
                (Paths::OBJECTS, 40.0),
                (Paths::MOVED, moved),
                (Paths::CANDIDATES, events),
                (Paths::CONTACTS, 39.0),
                (Paths::EVENTS, events),
                (Paths::NODES, stats.nodes as f64),
                (Paths::LEAVES, stats.leaves as f64),
                (Paths::DEPTH, f64::from(stats.depth)),
                (Paths::FILL, stats.fill()),
                (Paths::BYTES, stats.bytes as f64),
            ];
            for (path, expected) in expected {
                assert_eq!(value(&app, &path), Some(expected), "{path}");
            }
        }
    }
}

/// A system that takes its time is found in the stage in which it runs.
#[test]
fn time_goes_to_the_stage_that_took_it() {
    const NAP: Duration = Duration::from_millis(2);
    for (stage, path) in STAGES.into_iter().zip(Paths::STAGE_TIMES) {
        let mut app = app(BroadPhaseMethod::default());
        app.add_plugins(Paths);
        app.add_systems(FixedPostUpdate, (|| std::thread::sleep(NAP)).in_set(stage));
        tick(&mut app, 1);
        let times = app.world().resource::<StageTimes>();
        assert!(times.get(stage).unwrap() >= NAP, "{stage:?}: {times:?}");
        assert_eq!(
            times.iter().map(|(_, time)| time).sum::<Duration>(),
            times.sum()
        );
        let milliseconds = times.get(stage).unwrap().as_secs_f64() * 1e3;
        assert_eq!(value(&app, &path), Some(milliseconds), "{stage:?}");
        assert_eq!(times.get(CollisionSystems::Last), None);
    }
}

/// Eight cubes in the octants of the root, one to a leaf; a ninth between two of them is an entry
/// of both.
#[test]
fn fill_counts_an_object_once_for_each_leaf_that_lists_it() {
    let mut app = app(BroadPhaseMethod::ObjectOctree(
        ObjectOctreeSettings::with_max_objects(2),
    ));
    app.add_plugins(Paths);
    tick(&mut app, 1);
    assert_eq!(value(&app, &Paths::FILL), Some(0.0));
    let mut spawn = |at: Vec3| {
        app.world_mut()
            .spawn((CollisionShape::default(), Transform::from_translation(at)));
    };
    for octant in 0..8 {
        let side = |bit: u32| if octant & bit == 0 { -4.0 } else { 4.0 };
        spawn(Vec3::new(side(1), side(2), side(4)));
    }
    spawn(Vec3::new(0.0, 4.0, 4.0));
    tick(&mut app, 1);
    assert_eq!(
        (value(&app, &Paths::LEAVES), value(&app, &Paths::FILL)),
        (Some(8.0), Some(10.0 / 8.0))
    );
}

/// Finds nothing, and counts how often it is asked for its figures.
#[derive(Default)]
struct Asked(Arc<AtomicUsize>);

impl BroadPhase for Asked {
    fn name(&self) -> &'static str {
        "asked"
    }

    fn maintain(&mut self, _: &Proxies) {}

    fn find_pairs(&mut self, _: &Proxies, _: &mut Vec<Pair>) -> u64 {
        0
    }

    fn traverse(&self, _: &Proxies, _: &mut dyn Visitor) {}

    fn stats(&self) -> BroadPhaseStats {
        self.0.fetch_add(1, Ordering::Relaxed);
        BroadPhaseStats::default()
    }
}

/// The figures of the tree are asked for once a tick, and not at all if nobody wants them.
#[test]
fn figures_that_nobody_wants_cost_nothing() {
    const OF_THE_TREE: [DiagnosticPath; 5] = [
        Paths::NODES,
        Paths::LEAVES,
        Paths::DEPTH,
        Paths::FILL,
        Paths::BYTES,
    ];
    let mut app = app(BroadPhaseMethod::default());
    let engine = Asked::default();
    let asked = engine.0.clone();
    let times = || asked.swap(0, Ordering::Relaxed);
    app.world_mut()
        .resource_mut::<CollisionIndex>()
        .set_engine(Box::new(engine));
    tick(&mut app, 1);
    assert_eq!(times(), 0, "without the plugin");
    app.add_plugins(Paths);
    tick(&mut app, 1);
    assert_eq!(times(), 1);
    for (disabled, path) in (1..).zip(&OF_THE_TREE) {
        app.world_mut()
            .resource_mut::<DiagnosticsStore>()
            .get_mut(path)
            .unwrap()
            .is_enabled = false;
        tick(&mut app, 1);
        assert_eq!(
            times(),
            usize::from(disabled < OF_THE_TREE.len()),
            "{disabled} are disabled"
        );
    }
}

#[test]
fn a_disabled_diagnostic_is_not_measured() {
    let mut app = app(BroadPhaseMethod::default());
    app.add_plugins(Paths);
    let mut store = app.world_mut().resource_mut::<DiagnosticsStore>();
    store.get_mut(&Paths::NODES).unwrap().is_enabled = false;
    tick(&mut app, 3);
    assert_eq!(
        (value(&app, &Paths::NODES), value(&app, &Paths::OBJECTS)),
        (None, Some(0.0))
    );
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Elsewhere;

#[test]
fn the_plugin_may_be_added_first_and_goes_where_the_ticks_are() {
    let mut app = App::new();
    app.init_schedule(Elsewhere).add_plugins((
        Paths,
        MinimalPlugins,
        OctreePlugins::new(Elsewhere),
    ));
    assert_eq!(warnings(|| app.finish()), 0);
    app.world_mut().spawn(CollisionShape::default());
    for _ in 0..2 {
        app.world_mut().run_schedule(Elsewhere);
        // What is measured is taken up at the end of the frame.
        app.update();
    }
    assert_eq!(value(&app, &Paths::OBJECTS), Some(1.0));
    assert!(app.world().resource::<StageTimes>().sum() > Duration::ZERO);
}

#[test]
fn the_plugin_without_ticks_says_so() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, Paths));
    assert_eq!(warnings(|| app.finish()), 1);
    app.update();
    assert_eq!(value(&app, &Paths::OBJECTS), None);
}

/// An overlay shows what is measured anyway, each once, and all paths are those of registered
/// diagnostics.
#[test]
fn an_overlay_is_built_of_paths() {
    let mut app = app(BroadPhaseMethod::default());
    app.add_plugins(Paths);
    tick(&mut app, 1);
    let store = app.world().resource::<DiagnosticsStore>();
    let all: Vec<_> = Paths::paths().collect();
    assert_eq!(all.len(), store.iter().count());
    assert!(all.iter().all(|path| store.get(path).is_some()));
    let shown: Vec<DiagnosticPath> = Paths::overlay();
    assert_eq!(shown.len(), 5 + STAGES.len());
    assert!(shown.iter().all(|path| all.contains(path)));
    assert!(!shown.contains(&Paths::NODES));
    let suffix = |path: &DiagnosticPath| store.get(path).unwrap().suffix.clone();
    assert_eq!(suffix(&Paths::BYTES), " B");
    assert_eq!(suffix(&Paths::OBJECTS), "");
    assert!(Paths::STAGE_TIMES.iter().all(|path| suffix(path) == " ms"));
}
