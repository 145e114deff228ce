//! The plugin group.

use bevy::{
    app::PluginGroupBuilder,
    ecs::schedule::{InternedScheduleLabel, ScheduleLabel},
    prelude::*,
};

use crate::{
    bounds::BoundsPlugin,
    collision_index::{BroadPhasePlugin, CandidatePairs, CollisionIndex},
    components::{BroadPhaseProxy, CollisionShape, Cube, WorldAabb},
    contacts::{
        CollidingEntities, CollisionEnded, CollisionEventSettings, CollisionEventsEnabled, CollisionStarted, Contacts,
        NarrowPhasePlugin, ReportPlugin,
    },
    counters::CollisionCounters,
    filters::FilterPlugin,
    motion::{CollisionClock, MotionPlugin, MotionSettings, Velocity},
    response::{Bounce, BouncePlugin},
    scene::{SceneDescription, TestSet},
    schedule::{CollisionSchedulePlugin, CollisionSystems, add_to_tick},
    settings::{BroadPhaseSettings, NarrowPhaseSettings},
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
            .add(CollisionSchedulePlugin::new(self.schedule))
            .add(CollisionCorePlugin)
            .add(MotionPlugin)
            .add(BoundsPlugin)
            .add(BroadPhasePlugin)
            .add(FilterPlugin)
            .add(SweptPlugin)
            .add(NarrowPhasePlugin)
            .add(BouncePlugin)
            .add(ReportPlugin);
        #[cfg(feature = "asset")]
        let group = group.add(crate::scene::SceneAssetPlugin);
        group
    }
}

/// What the other plugins share: the clock, the resources, and type registration.
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionCorePlugin;

impl Plugin for CollisionCorePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CollisionClock>()
            .init_resource::<MotionSettings>()
            .init_resource::<BroadPhaseSettings>()
            .init_resource::<NarrowPhaseSettings>()
            .init_resource::<CollisionIndex>()
            .init_resource::<CandidatePairs>()
            .init_resource::<Contacts>()
            .init_resource::<CollisionEventSettings>()
            .init_resource::<CollisionCounters>()
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
        add_to_tick(app, |app, schedule| {
            app.add_systems(
                schedule,
                (
                    CollisionCounters::begin_tick.before(CollisionSystems::First),
                    (CollisionCounters::end_tick, CollisionClock::advance).after(CollisionSystems::Last),
                ),
            );
        });
    }
}
