//! Draws what is known about collisions by Bevy's gizmos: the leaves of the broad phase's tree, the
//! shapes and boxes of entities, contacts with their normals, and what casters and queries met. With
//! the feature `debug_draw`.
//!
//! ```
//! use bevy::{gizmos::GizmoPlugin, mesh::MeshPlugin, prelude::*};
//! use bevy_octree::{debug_draw::LeafColors, prelude::*};
//!
//! App::new()
//!     // Instead of these, `DefaultPlugins`.
//!     .add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, GizmoPlugin))
//!     .add_plugins((OctreePlugins::default(), CollisionDebugPlugin))
//!     .add_systems(Update, |mut store: ResMut<GizmoConfigStore>| {
//!         let (lines, gizmos) = store.config_mut::<CollisionGizmos>();
//!         lines.line.width = 1.0;
//!         gizmos.leaves = Some(LeafColors::Generation);
//!         gizmos.resting = None;
//!     })
//!     .update();
//! ```
//!
//! What is drawn, and in which colours, is up to the [`CollisionGizmos`], at any time. An entity
//! with a [`DebugDraw`] has a colour of its own, or none. [Casters](crate::casters) are drawn with what
//! they met in the last tick; queries are drawn by whoever makes them: see [`QueryGizmos`].
//!
//! To see it, the app needs what shows gizmos: a window, a camera, and Bevy's feature
//! `bevy_gizmos_render`.

mod boxes;
mod casters;
mod contacts;
mod gizmos;
mod leaves;
mod outline;
mod queries;
mod shapes;
mod sweep;

use bevy::{
    gizmos::{GizmoMeshSystems, GizmoPlugin},
    prelude::*,
};

pub use boxes::DebugDraw;
pub use gizmos::{CollisionGizmos, LeafColors};
pub use queries::QueryGizmos;

use crate::{disabled::see_disabled, schedule::CollisionSystems};

/// Draws by the gizmo group [`CollisionGizmos`], at the end of each frame, what the last tick
/// found. Not part of [`OctreePlugins`](crate::OctreePlugins): add it after them and after Bevy's
/// `GizmoPlugin`, which `DefaultPlugins` have. Without the latter it does nothing, with a warning
/// in the log.
///
/// See the [module's documentation](self) for an example.
#[doc(alias("debug render", "gizmos", "wireframe"))]
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionDebugPlugin;

impl Plugin for CollisionDebugPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<GizmoPlugin>() {
            tracing::warn!(
                "no GizmoPlugin was added before the CollisionDebugPlugin: nothing is drawn"
            );
            return;
        }
        boxes::register(app);
        gizmos::register(app);
        let draw_rays = see_disabled(app.world_mut(), casters::draw_rays);
        let draw_casts = see_disabled(app.world_mut(), casters::draw_shapes);
        app.add_systems(
            Last,
            (
                leaves::draw_leaves,
                boxes::draw_boxes,
                shapes::draw_shapes,
                sweep::draw_ways,
                draw_rays,
                draw_casts,
                contacts::draw_contacts,
            )
                .chain()
                .after(CollisionSystems::Last)
                .before(GizmoMeshSystems)
                .run_if(is_enabled),
        );
    }
}

fn is_enabled(store: Res<GizmoConfigStore>) -> bool {
    store
        .get_config::<CollisionGizmos>()
        .is_some_and(|(config, _)| config.enabled)
}
