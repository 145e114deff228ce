//! The index brought up to date at any moment.

use bevy::prelude::*;

use crate::{bounds, filters, maintenance, swept};

/// Computes the boxes of all entities that changed, and takes them up in the
/// [`CollisionIndex`](crate::collision_index::CollisionIndex), now.
///
/// Entities spawned, moved, reshaped, reparented or put on other layers since the last tick are
/// where they are from then on. No time passes, nothing moves, and no contact starts or ends: that
/// is left to the next tick, whose results are the same with and without.
///
/// That holds at any moment, in the middle of a tick too, and however often. Only what is moved
/// between the sets [`Maintenance`](crate::CollisionSystems::Maintenance) and
/// [`NarrowPhase`](crate::CollisionSystems::NarrowPhase) is then looked at by the exact tests of
/// that very tick where it is by now.
///
/// A system, a command, or a function to call:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{prelude::*, scene::Cube};
///
/// fn spawn(mut commands: Commands) {
///     commands.spawn((Cube, Transform::from_xyz(5.0, 0.0, 0.0)));
/// }
///
/// fn look(spatial: SpatialQuery) {
///     let hit = spatial.cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), 100.0, &SpatialQueryFilter::default());
///     assert_eq!(hit.map(|hit| hit.distance), Some(4.5));
/// }
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::default()));
/// app.add_systems(Update, (spawn, update_spatial_index, look).chain());
/// app.update();
/// ```
///
/// Costs as much as the sets `Bounds` and `Maintenance` of a tick, linear in the entities that
/// changed; the next tick then searches anew for all pairs, those of resting entities included.
/// Does nothing without the plugins.
pub fn update_spatial_index(world: &mut World) {
    let stages = [
        maintenance::begin_refresh,
        bounds::refresh,
        swept::refresh,
        filters::refresh,
        maintenance::refresh,
    ];
    if let Err(error) = stages.into_iter().try_for_each(|refresh| refresh(world)) {
        tracing::warn!("the spatial index could not be brought up to date: {error}");
    }
}
