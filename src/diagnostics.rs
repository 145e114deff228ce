//! Counters and times per stage for Bevy's
//! [`DiagnosticsStore`](bevy::diagnostic::DiagnosticsStore).

use std::time::{Duration, Instant};

use bevy::{
    diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic},
    prelude::*,
};

use crate::{
    collision_index::CollisionIndex,
    counters::{CollisionCounters, TickCounters},
    schedule::{CollisionSystems, add_to_tick, expect_ticks},
};

/// Measures what a tick takes, and hands it to Bevy's diagnostics, once per tick: the times of the
/// stages as the resource [`StageTimes`] too. Not part of [`OctreePlugins`](crate::OctreePlugins):
/// add it beside them, in any order.
///
/// ```
/// use bevy::{diagnostic::{DiagnosticsStore, LogDiagnosticsPlugin}, prelude::*};
/// use bevy_octree::{diagnostics::CollisionDiagnosticsPlugin, prelude::*};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update), CollisionDiagnosticsPlugin))
///     .add_plugins(LogDiagnosticsPlugin::default());
/// app.update();
/// let store = app.world().resource::<DiagnosticsStore>();
/// assert_eq!(store.get(&CollisionDiagnosticsPlugin::OBJECTS).and_then(|objects| objects.value()), Some(0.0));
/// ```
///
/// Bevy's own overlay (`bevy::dev_tools::diagnostics_overlay`, feature `bevy_dev_tools` of Bevy) shows
/// them on the screen: see [`overlay`](Self::overlay).
///
/// A diagnostic that is disabled is not measured. Any of [`NODES`](Self::NODES),
/// [`LEAVES`](Self::LEAVES), [`DEPTH`](Self::DEPTH), [`FILL`](Self::FILL) and
/// [`BYTES`](Self::BYTES) takes a walk over all nodes of the N-objects octree, one per tick for all
/// of them; for other broad phases they cost next to nothing.
#[doc(alias("profiling", "fps overlay"))]
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionDiagnosticsPlugin;

impl CollisionDiagnosticsPlugin {
    /// The number of entities in the index.
    pub const OBJECTS: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/objects");
    /// The number of entities that moved, came or went.
    pub const MOVED: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/moved");
    /// The number of pairs given to the exact tests.
    pub const CANDIDATES: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/candidates");
    /// The number of pairs in contact.
    pub const CONTACTS: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/contacts");
    /// The number of contacts that began, and contacts that ended, together.
    pub const EVENTS: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/events");
    /// The number of nodes of the broad phase's tree.
    pub const NODES: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/nodes");
    /// The number of leaves of that tree.
    pub const LEAVES: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/leaves");
    /// The largest generation of a node.
    pub const DEPTH: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/depth");
    /// The mean number of entries per leaf: an object counts once for each leaf that lists it. 0
    /// where there are no leaves.
    pub const FILL: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/fill");
    /// The memory that the broad phase takes, in bytes.
    pub const BYTES: DiagnosticPath = DiagnosticPath::const_new("bevy_octree/bytes");

    /// The time of each stage, in milliseconds, in the order in which they run.
    pub const STAGE_TIMES: [DiagnosticPath; STAGES.len()] = [
        DiagnosticPath::const_new("bevy_octree/time/motion"),
        DiagnosticPath::const_new("bevy_octree/time/bounds"),
        DiagnosticPath::const_new("bevy_octree/time/maintenance"),
        DiagnosticPath::const_new("bevy_octree/time/broad_phase"),
        DiagnosticPath::const_new("bevy_octree/time/narrow_phase"),
        DiagnosticPath::const_new("bevy_octree/time/response"),
        DiagnosticPath::const_new("bevy_octree/time/report"),
    ];
}

impl CollisionDiagnosticsPlugin {
    /// What is counted anyway.
    const COUNTS: [DiagnosticPath; 5] = [
        Self::OBJECTS,
        Self::MOVED,
        Self::CANDIDATES,
        Self::CONTACTS,
        Self::EVENTS,
    ];
    /// What the tree is like.
    const TREE: [DiagnosticPath; 5] = [
        Self::NODES,
        Self::LEAVES,
        Self::DEPTH,
        Self::FILL,
        Self::BYTES,
    ];

    /// Returns the paths of all diagnostics: what is counted, and then the times of the stages, in
    /// the order in which they run.
    pub fn paths() -> impl Iterator<Item = DiagnosticPath> {
        let [counts, tree] = [Self::COUNTS, Self::TREE].map(IntoIterator::into_iter);
        counts.chain(tree).chain(Self::STAGE_TIMES)
    }

    /// Returns the items of an overlay that shows what a game looks at: how many entities there are
    /// and move, how many pairs are tested and in contact, and how long each stage takes. Not the
    /// figures of the tree, some of which take a walk over it.
    ///
    /// For Bevy's `DiagnosticsOverlay`, whose items are made from paths; so are those of others, and
    /// nothing that draws is needed to build this crate. The overlay needs Bevy's feature
    /// `bevy_dev_tools`, its user interface, as `DefaultPlugins` have it, and a camera; this plugin
    /// and Bevy's `DiagnosticsOverlayPlugin` are both to be added.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::diagnostics::CollisionDiagnosticsPlugin;
    /// # mod dev_tools {
    /// #     use bevy::{diagnostic::DiagnosticPath, prelude::*};
    /// #     pub struct DiagnosticsOverlayItem(pub DiagnosticPath);
    /// #     impl From<DiagnosticPath> for DiagnosticsOverlayItem {
    /// #         fn from(path: DiagnosticPath) -> Self { Self(path) }
    /// #     }
    /// #     #[derive(Component)]
    /// #     pub struct DiagnosticsOverlay(pub &'static str, pub Vec<DiagnosticsOverlayItem>);
    /// #     impl DiagnosticsOverlay {
    /// #         pub fn new(title: &'static str, items: Vec<DiagnosticsOverlayItem>) -> Self { Self(title, items) }
    /// #     }
    /// # }
    /// # use dev_tools::DiagnosticsOverlay;
    ///
    /// // `DiagnosticsOverlay` and `DiagnosticsOverlayPlugin` are in `bevy::dev_tools::diagnostics_overlay`;
    /// // in `main`: `app.add_plugins((CollisionDiagnosticsPlugin, DiagnosticsOverlayPlugin))`.
    /// fn show(mut commands: Commands) {
    ///     commands.spawn(DiagnosticsOverlay::new("Collisions", CollisionDiagnosticsPlugin::overlay()));
    /// }
    /// # bevy::ecs::system::assert_is_system(show);
    /// ```
    #[must_use]
    #[doc(alias("DiagnosticsOverlay", "hud"))]
    pub fn overlay<Item: From<DiagnosticPath>>() -> Vec<Item> {
        let items = Self::COUNTS.into_iter().chain(Self::STAGE_TIMES);
        items.map(Item::from).collect()
    }
}

impl Plugin for CollisionDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in Self::paths() {
            let suffix = if path == Self::BYTES {
                " B"
            } else if Self::STAGE_TIMES.contains(&path) {
                " ms"
            } else {
                ""
            };
            app.register_diagnostic(Diagnostic::new(path).with_suffix(suffix));
        }
        app.init_resource::<StageTimes>()
            .register_type::<StageTimes>();
        add_to_tick(app, |app, schedule| {
            app.add_systems(schedule, begin.in_set(CollisionSystems::First));
            let ends = STAGES.into_iter().skip(1).chain([CollisionSystems::Last]);
            for (stage, (set, next)) in STAGES.into_iter().zip(ends).enumerate() {
                let end = move |mut times: ResMut<StageTimes>| times.end(stage);
                app.add_systems(schedule, end.after(set).before(next));
            }
            app.add_systems(
                schedule,
                measure
                    .after(CollisionSystems::Last)
                    .before(CollisionCounters::end_tick),
            );
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "CollisionDiagnosticsPlugin");
    }
}

/// The stages that are timed, in the order in which they run.
pub const STAGES: [CollisionSystems; 7] = [
    CollisionSystems::Motion,
    CollisionSystems::Bounds,
    CollisionSystems::Maintenance,
    CollisionSystems::BroadPhase,
    CollisionSystems::NarrowPhase,
    CollisionSystems::Response,
    CollisionSystems::Report,
];

/// The times that the stages of the last tick took, wall-clock: whatever runs between the end of a
/// stage and that of the one before it counts.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Debug, Default)]
#[type_path = "bevy_octree"]
pub struct StageTimes {
    times: [Duration; STAGES.len()],
    /// The end of the stage before.
    #[reflect(ignore)]
    last: Option<Instant>,
}

impl StageTimes {
    /// Returns the stages and their times, in the order in which they run.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (CollisionSystems, Duration)> {
        STAGES.into_iter().zip(self.times)
    }

    /// Returns the time of one stage; `None` for a set that is not one of the [`STAGES`].
    #[must_use]
    pub fn get(&self, stage: CollisionSystems) -> Option<Duration> {
        self.iter()
            .find(|(other, _)| *other == stage)
            .map(|(_, time)| time)
    }

    /// Returns the time of all stages together.
    #[must_use]
    pub fn sum(&self) -> Duration {
        self.times.iter().sum()
    }

    fn end(&mut self, stage: usize) {
        let now = Instant::now();
        self.times[stage] = self
            .last
            .replace(now)
            .map_or(Duration::ZERO, |last| now - last);
    }
}

fn begin(mut times: ResMut<StageTimes>) {
    times.last = Some(Instant::now());
}

fn measure(
    index: Res<CollisionIndex>,
    counters: Res<CollisionCounters>,
    times: Res<StageTimes>,
    mut diagnostics: Diagnostics,
) {
    use CollisionDiagnosticsPlugin as Paths;
    let TickCounters {
        objects,
        moved,
        candidates,
        contacts,
        started,
        ended,
        ..
    } = counters.tick;
    let events = started + ended;
    for (path, count) in [
        (Paths::OBJECTS, objects),
        (Paths::MOVED, moved),
        (Paths::CANDIDATES, candidates),
        (Paths::CONTACTS, contacts),
        (Paths::EVENTS, events),
    ] {
        diagnostics.add_measurement(&path, || count as f64);
    }
    let mut known = None;
    let mut stats = || *known.get_or_insert_with(|| index.index().stats());
    diagnostics.add_measurement(&Paths::NODES, || stats().nodes as f64);
    diagnostics.add_measurement(&Paths::LEAVES, || stats().leaves as f64);
    diagnostics.add_measurement(&Paths::DEPTH, || f64::from(stats().depth));
    diagnostics.add_measurement(&Paths::FILL, || stats().fill());
    diagnostics.add_measurement(&Paths::BYTES, || stats().bytes as f64);
    for (path, (_, time)) in Paths::STAGE_TIMES.iter().zip(times.iter()) {
        diagnostics.add_measurement(path, || time.as_secs_f64() * 1e3);
    }
}
