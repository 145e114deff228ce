//! The plugin group.

use bevy::{
    app::PluginGroupBuilder,
    ecs::schedule::{InternedScheduleLabel, ScheduleLabel},
    prelude::*,
};

use crate::{
    bounds::BoundsPlugin,
    collision_index, components,
    contacts::{self, NarrowPhasePlugin, ReportPlugin},
    counters,
    filters::FilterPlugin,
    maintenance::BroadPhasePlugin,
    motion::{self, CollisionClock, MotionPlugin},
    response::{self, BouncePlugin},
    scene::ScenePlugin,
    schedule::{CollisionSchedulePlugin, CollisionSystems, add_to_tick},
    settings,
    swept::{self, SweptPlugin},
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
            .add(ReportPlugin)
            .add(ScenePlugin);
        #[cfg(feature = "asset")]
        let group = group.add(crate::scene::SceneAssetPlugin);
        group
    }
}

/// What the other plugins share: resources, types known to reflection, counters and the clock. It is in the app whichever of
/// the others are not.
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionCorePlugin;

impl Plugin for CollisionCorePlugin {
    fn build(&self, app: &mut App) {
        settings::register(app);
        counters::register(app);
        motion::register(app);
        collision_index::register(app);
        components::register(app);
        swept::register(app);
        contacts::register(app);
        response::register(app);
        add_to_tick(app, |app, schedule| {
            app.add_systems(schedule, CollisionClock::advance.after(CollisionSystems::Last));
        });
    }
}
