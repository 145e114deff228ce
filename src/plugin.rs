//! The plugin group.

use bevy::{
    app::PluginGroupBuilder,
    ecs::schedule::{InternedScheduleLabel, ScheduleLabel},
    prelude::*,
};

use crate::{
    bounds::BoundsPlugin,
    casters::CasterPlugin,
    character::CharacterPlugin,
    collision_index, collision_order, components,
    contacts::{self, NarrowPhasePlugin, ReportPlugin},
    counters,
    filters::FilterPlugin,
    maintenance::BroadPhasePlugin,
    motion::{self, CollisionClock, MotionPlugin},
    parts,
    response::{self, BouncePlugin},
    scene::ScenePlugin,
    schedule::{CollisionSchedulePlugin, CollisionSystems, add_to_tick, expect_ticks},
    settings, shape_data,
    swept::{self, SweptPlugin},
};

/// The plugins for everything: motion, octree maintenance, broad phase, narrow phase, bounce
/// response and messages.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// App::new().add_plugins((MinimalPlugins, OctreePlugins::default()));
/// ```
///
/// It runs in [`FixedPostUpdate`], or the schedule given to [`OctreePlugins::new`].
///
/// # Disabling and replacing stages
///
/// Each stage is one of the [`plugins`](crate::plugins):
///
/// | plugin | set of [`CollisionSystems`] |
/// |---|---|
/// | [`MotionPlugin`] | `Motion` |
/// | [`BoundsPlugin`] | `Bounds` |
/// | [`BroadPhasePlugin`] | `Maintenance`, `BroadPhase` |
/// | [`FilterPlugin`] | between these, and after them |
/// | [`SweptPlugin`] | before `Motion`, `Bounds`, after `Response` |
/// | [`NarrowPhasePlugin`] | `NarrowPhase` |
/// | [`BouncePlugin`] | `Response` |
/// | [`CharacterPlugin`] | after `Maintenance` |
/// | [`CasterPlugin`] | after `Response` |
/// | [`ReportPlugin`] | `Report` |
///
/// One that is disabled leaves its resources in the app, for others to read; with [`ReportPlugin`],
/// the messages about contacts go. What all share stays: [`CollisionCorePlugin`], and the plugin for
/// the schedule, without which there are no ticks.
///
/// A stage of your own has its systems in the set of the one that it is in place of, in the schedule
/// that [`CollisionSchedule`](crate::schedule::CollisionSchedule) names. That resource is there once
/// the group is: a plugin that reads it comes after, or is part of the group.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{plugins::{BouncePlugin, MotionPlugin}, prelude::*, scene::Cube, schedule::CollisionSchedule};
///
/// // Detection only: something else moves things.
/// let detection = OctreePlugins::new(PostUpdate).build().disable::<MotionPlugin>().disable::<BouncePlugin>();
/// App::new().add_plugins((MinimalPlugins, detection));
///
/// /// Whoever touches something goes no further.
/// struct StickyPlugin;
///
/// impl Plugin for StickyPlugin {
///     fn build(&self, app: &mut App) {
///         let ticks = app.world().resource::<CollisionSchedule>().label();
///         app.add_systems(ticks, stick.in_set(CollisionSystems::Response));
///     }
/// }
///
/// fn stick(contacts: Res<Contacts>, mut moving: Query<&mut Velocity>) {
///     for entity in contacts.iter().flat_map(|contact| [contact.a, contact.b]) {
///         if let Ok(mut velocity) = moving.get_mut(entity) {
///             velocity.0 = Vec3::ZERO;
///         }
///     }
/// }
///
/// let sticky = OctreePlugins::new(Update).build().disable::<BouncePlugin>().add(StickyPlugin);
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, sticky));
/// let cube = app.world_mut().spawn((Cube, Velocity(Vec3::X))).id();
/// app.world_mut().spawn((CollisionShape::default(), Transform::from_xyz(0.75, 0.0, 0.0)));
/// app.update();
/// assert_eq!(app.world().get::<Velocity>(cube).unwrap().0, Vec3::ZERO);
/// ```
///
/// # When something goes wrong
///
/// A resource of the crate that is taken away is one for Bevy's error handler, which panics unless
/// [`App::set_error_handler`] was told otherwise: systems that need it do not run. Once it is there
/// again, or another, the second tick is right at the latest. Hooks and
/// [`update_spatial_index`](crate::spatial_query::update_spatial_index) do without it. Bevy's
/// `World::clear_entities` takes all resources, so that nothing is left to tick.
///
/// A panic in an observer or a system breaks off the tick, and Bevy does not run the schedule again;
/// all entities, contacts and the index stay as they were, to be asked or taken elsewhere. A panic in
/// a hook, while something is spawned or despawned between ticks, breaks nothing but what is done to
/// that entity.
#[derive(Clone, Debug)]
pub struct OctreePlugins {
    schedule: InternedScheduleLabel,
}

impl OctreePlugins {
    /// Makes the plugins, with their systems in `schedule`.
    #[must_use]
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self {
            schedule: schedule.intern(),
        }
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
            .add(CasterPlugin)
            .add(CharacterPlugin)
            .add(ReportPlugin)
            .add(ScenePlugin);
        #[cfg(feature = "asset")]
        let group = group.add(crate::scene::SceneAssetPlugin);
        group
    }
}

/// The plugin for what the others share: resources, types known to reflection, counters and the
/// clock. It is to stay whichever of the others are disabled: without it, ticks panic.
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionCorePlugin;

impl Plugin for CollisionCorePlugin {
    fn build(&self, app: &mut App) {
        settings::register(app);
        counters::register(app);
        motion::register(app);
        collision_index::register(app);
        collision_index::upkeep::register(app);
        components::register(app);
        collision_order::register(app);
        shape_data::register(app);
        #[cfg(feature = "mesh")]
        crate::mesh_shape::register(app);
        parts::register(app);
        swept::register(app);
        contacts::register(app);
        response::register(app);
        add_to_tick(app, |app, schedule| {
            app.add_systems(
                schedule,
                CollisionClock::advance.after(CollisionSystems::Last),
            );
        });
    }

    fn finish(&self, app: &mut App) {
        expect_ticks(app, "CollisionCorePlugin");
    }
}
