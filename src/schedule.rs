//! The sets of systems that make a tick, and the schedule in which they run.

use bevy::{
    ecs::schedule::{InternedScheduleLabel, ScheduleLabel},
    prelude::*,
};

/// The sets of systems, in the order in which they run. Systems of one's own go before or after any
/// of them, in the schedule that the plugins are in: [`FixedPostUpdate`], unless
/// [`OctreePlugins::new`](crate::OctreePlugins::new) was given another. In any other schedule there
/// are no such sets, and to be ordered by them means nothing, without a word of it; systems that
/// just read messages may be in any.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// fn fall(mut falling: Query<&mut Velocity>, time: Res<Time>) {
///     for mut velocity in &mut falling {
///         velocity.y -= 9.8 * time.delta_secs();
///     }
/// }
///
/// App::new()
///     .add_plugins((MinimalPlugins, OctreePlugins::default()))
///     .add_systems(FixedPostUpdate, fall.before(CollisionSystems::Motion));
/// ```
///
/// | set | reads → writes |
/// |---|---|
/// | `First` | nothing of ours: a place for systems that must run before all others |
/// | `Motion` | `Velocity` or `PositionTrack` → `Transform` |
/// | `Bounds` | changed `Transform`s and shapes → `WorldAabb` |
/// | `Maintenance` | changed `WorldAabb`s → `CollisionIndex` |
/// | `BroadPhase` | `CollisionIndex` → `CandidatePairs` |
/// | `NarrowPhase` | `CandidatePairs` → `Contacts` |
/// | `Response` | `Contacts` → `Velocity`; the `Transform` of what bounces on its way (`Swept`) |
/// | `Report` | `Contacts` → `CollisionStarted`, `CollisionEnded`, `CollidingEntities`; observers of these run here |
/// | `Last` | a place for systems that must run after all others |
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CollisionSystems {
    /// Before everything.
    First,
    /// Entities move.
    Motion,
    /// World boxes follow them.
    Bounds,
    /// The broad phase follows the boxes that changed.
    Maintenance,
    /// Pairs of overlapping boxes are searched for.
    BroadPhase,
    /// Exact tests decide which of them are in contact.
    NarrowPhase,
    /// Velocities answer to contacts.
    Response,
    /// Contacts that started or ended are reported.
    Report,
    /// After everything.
    Last,
}

/// Systems that take pairs out of the [`CandidatePairs`](crate::collision_index::CandidatePairs):
/// after [`BroadPhase`](CollisionSystems::BroadPhase), before
/// [`NarrowPhase`](CollisionSystems::NarrowPhase).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PairFilterSystems;

/// Impacts on the way are answered here: in [`NarrowPhase`](CollisionSystems::NarrowPhase), once
/// the exact tests have found them, before they become contacts.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ImpactSystems;

/// The resource that names the schedule of the ticks: what runs in them asks it.
#[derive(Resource, Clone, Copy, Debug)]
pub struct CollisionSchedule(InternedScheduleLabel);

impl CollisionSchedule {
    /// Returns the label of the schedule that the ticks run in.
    #[must_use]
    pub const fn label(&self) -> InternedScheduleLabel {
        self.0
    }
}

/// The plugin that says in which schedule ticks run, and puts the sets of [`CollisionSystems`] in
/// order there.
///
/// All other plugins of the crate ask it; those that are added before it wait for it.
#[derive(Clone, Debug)]
pub struct CollisionSchedulePlugin(InternedScheduleLabel);

impl CollisionSchedulePlugin {
    /// Makes the plugin for ticks that are runs of `schedule`.
    #[must_use]
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self(schedule.intern())
    }
}

impl Plugin for CollisionSchedulePlugin {
    fn build(&self, app: &mut App) {
        use CollisionSystems as Set;
        app.insert_resource(CollisionSchedule(self.0))
            .configure_sets(
                self.0,
                (
                    (
                        Set::First,
                        Set::Motion,
                        Set::Bounds,
                        Set::Maintenance,
                        Set::BroadPhase,
                    )
                        .chain(),
                    (Set::NarrowPhase, Set::Response, Set::Report, Set::Last).chain(),
                )
                    .chain()
                    .before(TransformSystems::Propagate),
            );
        app.configure_sets(
            self.0,
            PairFilterSystems
                .after(Set::BroadPhase)
                .before(Set::NarrowPhase),
        )
        .configure_sets(self.0, ImpactSystems.in_set(Set::NarrowPhase));
        for add in app
            .world_mut()
            .remove_resource::<Waiting>()
            .unwrap_or_default()
            .0
        {
            add(app, self.0);
        }
    }
}

type Add = Box<dyn FnOnce(&mut App, InternedScheduleLabel) + Send + Sync>;

/// What is to be added to the schedule once it is known.
#[derive(Resource, Default)]
struct Waiting(Vec<Add>);

/// Adds what plugins have for the schedule of the ticks: at once if it is known, else as soon as it
/// is, so that plugins may come in any order.
pub(crate) fn add_to_tick(
    app: &mut App,
    add: impl FnOnce(&mut App, InternedScheduleLabel) + Send + Sync + 'static,
) {
    match app.world().get_resource::<CollisionSchedule>() {
        Some(&CollisionSchedule(schedule)) => add(app, schedule),
        None => app
            .world_mut()
            .get_resource_or_init::<Waiting>()
            .0
            .push(Box::new(add)),
    }
}

/// For a plugin that is of no use by itself: says so in the log, if the [`CollisionSchedulePlugin`]
/// never came.
pub(crate) fn expect_ticks(app: &App, plugin: &str) {
    if !app.world().contains_resource::<CollisionSchedule>() {
        tracing::warn!(
            "there is no `CollisionSchedulePlugin`, as `OctreePlugins` have one: the `{plugin}` does nothing"
        );
    }
}
