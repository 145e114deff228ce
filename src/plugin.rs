//! The plugins and the sets of systems.

use bevy::{
    app::PluginGroupBuilder,
    ecs::schedule::{InternedScheduleLabel, ScheduleLabel},
    prelude::*,
};

use crate::{
    bounds::BoundsPlugin,
    collision_index::{BroadPhasePlugin, BroadPhaseSettings, CandidatePairs, CollisionIndex},
    components::{BroadPhaseProxy, CollisionShape, Cube, WorldAabb},
    contacts::{
        CollidingEntities, CollisionEnded, CollisionEventSettings, CollisionEventsEnabled, CollisionStarted, Contacts,
        NarrowPhasePlugin, ReportPlugin,
    },
    counters::CollisionCounters,
    filters::FilterPlugin,
    motion::{CollisionClock, MotionPlugin, MotionSettings, Velocity},
    narrow_phase::NarrowPhase,
    response::{Bounce, BouncePlugin},
    scene::{SceneDescription, TestSet},
    swept::SweptPlugin,
};

/// Everything: motion, octree maintenance, broad phase, narrow phase, bounce response and messages.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// App::new().add_plugins((MinimalPlugins, OctreePlugins::default()));
/// ```
///
/// It runs in [`FixedPostUpdate`], or the schedule given to [`OctreePlugins::new`]. Each stage is a plugin of the
/// group, named after its set of [`CollisionSystems`], and can be disabled or replaced:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{prelude::*, motion::MotionPlugin};
///
/// // Detection only: something else moves things.
/// let detection = OctreePlugins::new(PostUpdate).build().disable::<MotionPlugin>().disable::<BouncePlugin>();
/// App::new().add_plugins((MinimalPlugins, detection));
/// ```
#[derive(Clone, Debug)]
pub struct OctreePlugins {
    schedule: InternedScheduleLabel,
}

impl OctreePlugins {
    /// The plugins, with their systems in `schedule`.
    #[must_use]
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl Default for OctreePlugins {
    fn default() -> Self {
        Self::new(FixedPostUpdate)
    }
}

impl PluginGroup for OctreePlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>()
            .add(CollisionCorePlugin(self.schedule))
            .add(MotionPlugin(self.schedule))
            .add(BoundsPlugin(self.schedule))
            .add(BroadPhasePlugin(self.schedule))
            .add(FilterPlugin(self.schedule))
            .add(SweptPlugin(self.schedule))
            .add(NarrowPhasePlugin(self.schedule))
            .add(BouncePlugin(self.schedule))
            .add(ReportPlugin(self.schedule));
        #[cfg(feature = "asset")]
        let group = group.add(crate::scene::SceneAssetPlugin);
        group
    }
}

/// The sets of systems, in the order in which they run. Systems of one's own go before or after any of them.
///
/// | set | reads → writes |
/// |---|---|
/// | `First` | nothing of ours: a place for systems that must run before all others |
/// | `Motion` | `Velocity` or `PositionTrack` → `Transform` |
/// | `Bounds` | changed `Transform`s and shapes → [`WorldAabb`] |
/// | `Maintenance` | changed [`WorldAabb`]s → [`CollisionIndex`] |
/// | `BroadPhase` | [`CollisionIndex`] → [`CandidatePairs`] |
/// | `NarrowPhase` | [`CandidatePairs`] → [`Contacts`] |
/// | `Response` | [`Contacts`] → [`Velocity`]; the [`Transform`] of what bounces on its way ([`Swept`](crate::swept::Swept)) |
/// | `Report` | [`Contacts`] → [`CollisionStarted`], [`CollisionEnded`], [`CollidingEntities`]; observers of these run here |
/// | `Last` | a place for systems that must run after all others |
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CollisionSystems {
    /// Before everything.
    First,
    /// Entities move.
    Motion,
    /// World boxes follow them.
    Bounds,
    /// The broad phase takes up the boxes that changed.
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

/// Settings of the exact tests: see [`NarrowPhase`]. Changes take effect at the next tick, for all pairs.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[reflect(opaque)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct NarrowPhaseSettings(pub NarrowPhase);

/// What the other plugins share: the order of the sets, the clock, the resources, and type registration.
#[derive(Clone, Debug)]
pub struct CollisionCorePlugin(InternedScheduleLabel);

impl Plugin for CollisionCorePlugin {
    fn build(&self, app: &mut App) {
        use CollisionSystems as Set;
        app.init_resource::<CollisionClock>()
            .init_resource::<MotionSettings>()
            .init_resource::<BroadPhaseSettings>()
            .init_resource::<NarrowPhaseSettings>()
            .init_resource::<CollisionIndex>()
            .init_resource::<CandidatePairs>()
            .init_resource::<Contacts>()
            .init_resource::<CollisionEventSettings>()
            .init_resource::<CollisionCounters>()
            .configure_sets(
                self.0,
                (
                    (Set::First, Set::Motion, Set::Bounds, Set::Maintenance, Set::BroadPhase).chain(),
                    (Set::NarrowPhase, Set::Response, Set::Report, Set::Last).chain(),
                )
                    .chain()
                    .before(TransformSystems::Propagate),
            )
            .add_systems(
                self.0,
                (
                    CollisionCounters::begin_tick.before(Set::First),
                    (CollisionCounters::end_tick, CollisionClock::advance).after(Set::Last),
                ),
            )
            .register_type::<CollisionShape>()
            .register_type::<WorldAabb>()
            .register_type::<BroadPhaseProxy>()
            .register_type::<Cube>()
            .register_type::<Velocity>()
            .register_type::<Bounce>()
            .register_type::<BroadPhaseSettings>()
            .register_type::<NarrowPhaseSettings>()
            .register_type::<MotionSettings>()
            .register_type::<CollisionClock>()
            .register_type::<CollisionIndex>()
            .register_type::<CandidatePairs>()
            .register_type::<Contacts>()
            .register_type::<CollisionCounters>()
            .register_type::<SceneDescription>()
            .register_type::<TestSet>()
            .register_type::<CollisionStarted>()
            .register_type::<CollisionEnded>()
            .register_type::<CollisionEventSettings>()
            .register_type::<CollisionEventsEnabled>()
            .register_type::<CollidingEntities>();
    }
}
