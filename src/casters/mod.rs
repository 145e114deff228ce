//! Rays and shapes that are cast in each tick, as components: a [`RayCaster`] or a [`ShapeCaster`]
//! on an entity, and what they meet beside it, as [`RayHits`] or [`ShapeHits`].
//!
//! They are data, which an editor or a scene may hold, and ask no system of your own. Whoever wants
//! to ask at another moment, or only now and then, asks a
//! [`SpatialQuery`](crate::spatial_query::SpatialQuery): a caster does just that, once per tick.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
//! // A lamp post, and somebody who looks ahead.
//! let post = app.world_mut().spawn((CollisionShape::cuboid(0.2, 4.0, 0.2), Transform::from_xyz(0.0, 0.0, -5.1))).id();
//! let eyes = RayCaster::new(Vec3::Y, Dir3::NEG_Z).with_length(20.0);
//! let viewer = app.world_mut().spawn((CollisionShape::sphere(0.5), eyes)).id();
//! app.update();
//! let hit = app.world().get::<RayHits>(viewer).unwrap().nearest().unwrap();
//! assert_eq!((hit.entity, hit.distance), (post, 5.0));
//! ```
//!
//! # Where they start
//!
//! Origin and direction are in the entity's own space, that of its
//! [`GlobalTransform`] as it will be at the end of the
//! tick: by the [`Transform`]s of the entity and its
//! ancestors, so that nothing lags behind. A direction goes along as an arrow that is painted on the
//! entity would, whatever the scale; lengths and distances are those of the world. An entity that is
//! nowhere (its own ancestor, not finite, or scaled to nothing along the direction) casts nothing,
//! and has no hits.
//!
//! # When
//!
//! In the set [`CasterSystems`], after [`Response`](crate::CollisionSystems::Response) and before
//! [`Report`](crate::CollisionSystems::Report): all that moved in the tick is where it has come to,
//! contacts are known, and observers of contacts read hits of the same tick.
//!
//! # Cost
//!
//! As much as the queries, side by side on all threads (feature `multi_threaded`); who has no
//! casters pays nothing. The hits do not depend on the number of threads.

mod cast;
mod filter;
mod hits;
mod ray;
mod shape;

use bevy::prelude::*;

#[cfg(feature = "debug_draw")]
pub(crate) use cast::pose;
pub use filter::{CasterFilter, CasterIgnores};
pub use hits::{RayHits, ShapeHits};
pub use ray::RayCaster;
pub use shape::ShapeCaster;

use crate::{
    disabled::see_disabled,
    schedule::{CollisionSystems, add_to_tick},
};

/// The set of systems that cast what [`RayCaster`]s and [`ShapeCaster`]s say: between
/// [`Response`](CollisionSystems::Response) and [`Report`](CollisionSystems::Report).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CasterSystems;

/// The plugin for [`RayCaster`]s and [`ShapeCaster`]s.
#[derive(Clone, Copy, Debug, Default)]
pub struct CasterPlugin;

impl Plugin for CasterPlugin {
    fn build(&self, app: &mut App) {
        for register in [
            filter::register,
            hits::register,
            ray::register,
            shape::register,
        ] {
            register(app);
        }
        add_to_tick(app, |app, schedule| {
            let place = CasterSystems
                .after(CollisionSystems::Response)
                .before(CollisionSystems::Report);
            let world = app.world_mut();
            let cast = (
                see_disabled(world, cast::cast::<RayCaster>),
                see_disabled(world, cast::cast::<ShapeCaster>),
            );
            app.configure_sets(schedule, place)
                .add_systems(schedule, cast.in_set(CasterSystems));
        });
    }
}
