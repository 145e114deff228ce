//! Draws what is known about collisions by Bevy's gizmos: the leaves of the broad phase's tree, the boxes of entities,
//! contacts with their normals, and what queries met. With the feature `debug_draw`.
//!
//! ```
//! use bevy::{gizmos::GizmoPlugin, mesh::MeshPlugin, prelude::*};
//! use bevy_octree::prelude::*;
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
//! What is drawn, and in which colours, is up to the [`CollisionGizmos`], at any time. An entity with a [`DebugDraw`] has
//! a colour of its own, or none. Queries are drawn by whoever makes them: see [`QueryGizmos`].
//!
//! To see it, the app needs what shows gizmos: a window, a camera, and Bevy's feature `bevy_gizmos_render`.

mod boxes;
mod contacts;
mod leaves;
mod queries;
mod sweep;

use bevy::{
    color::palettes::tailwind,
    gizmos::{GizmoMeshSystems, GizmoPlugin},
    prelude::*,
};

pub use boxes::DebugDraw;
pub use leaves::LeafColors;
pub use queries::QueryGizmos;

use crate::schedule::CollisionSystems;

/// Draws by the gizmo group [`CollisionGizmos`], at the end of each frame, what the last tick found. Not part of
/// [`OctreePlugins`](crate::OctreePlugins): add it after them and after Bevy's `GizmoPlugin`, which `DefaultPlugins` have.
/// Without the latter it does nothing, with a warning in the log.
///
/// See the [module's documentation](self) for an example.
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionDebugPlugin;

impl Plugin for CollisionDebugPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<GizmoPlugin>() {
            tracing::warn!("no GizmoPlugin was added before the CollisionDebugPlugin: nothing is drawn");
            return;
        }
        app.register_type::<DebugDraw>().init_gizmo_group::<CollisionGizmos>().add_systems(
            Last,
            (leaves::draw_leaves, boxes::draw_boxes, sweep::draw_ways, contacts::draw_contacts)
                .chain()
                .after(CollisionSystems::Last)
                .before(GizmoMeshSystems)
                .run_if(is_enabled),
        );
    }
}

fn is_enabled(store: Res<GizmoConfigStore>) -> bool {
    store.get_config::<CollisionGizmos>().is_some_and(|(config, _)| config.enabled)
}

/// What is drawn, and how: `None` is not drawn, and costs nothing. Line widths and all else that gizmos have are in the
/// [`GizmoConfig`] beside it.
///
/// The default draws everything but leaves.
///
/// ```
/// use bevy::{gizmos::GizmoPlugin, mesh::MeshPlugin, prelude::*};
/// use bevy_octree::prelude::*;
///
/// // Contacts alone, from the start.
/// let contacts = CollisionGizmos { moving: None, resting: None, ..default() };
/// App::new()
///     .add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, GizmoPlugin))
///     .add_plugins((OctreePlugins::default(), CollisionDebugPlugin))
///     .insert_gizmo_config(contacts, GizmoConfig::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Reflect, GizmoConfigGroup)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub struct CollisionGizmos {
    /// The boxes ([`WorldAabb`](crate::components::WorldAabb)) of entities that moved in the last tick.
    pub moving: Option<Color>,
    /// Those of all other entities.
    pub resting: Option<Color>,
    /// Contacts: a cross where the two meet, and an arrow along the normal, from
    /// [`a`](crate::contacts::Collision::a) to `b`. Where the geometry is not
    /// [known](crate::contacts::CollisionEventSettings::geometry), a line from the centre of one box to that of the other.
    pub contacts: Option<Color>,
    /// The length of normals, in world units; none are drawn at 0. Points are marked by crosses of a size to match.
    pub normal_length: f32,
    /// The leaves of the broad phase's tree ([`Leaf`](crate::broad_phase::Leaf)), and what their colours tell. The default
    /// broad phase has no tree for a handful of objects.
    pub leaves: Option<LeafColors>,
    /// The colours of leaves: from those of which there is nothing to tell (the root, an empty leaf) to the deepest or
    /// fullest of the moment.
    pub leaf_colors: [Color; 2],
    /// Rays, and what they hit: see [`QueryGizmos::ray_hit`].
    pub rays: Option<Color>,
    /// How far rays that hit nothing are drawn, in world units.
    pub ray_length: f32,
    /// Boxes on their way from one place to another: those of entities that are [`Swept`](crate::swept::Swept), and
    /// [others](QueryGizmos::swept_box).
    pub sweeps: Option<Color>,
}

impl Default for CollisionGizmos {
    fn default() -> Self {
        Self {
            moving: Some(tailwind::AMBER_400.into()),
            resting: Some(tailwind::SLATE_400.into()),
            contacts: Some(tailwind::RED_500.into()),
            normal_length: 0.5,
            leaves: None,
            leaf_colors: [tailwind::INDIGO_800.into(), tailwind::EMERALD_300.into()],
            rays: Some(tailwind::LIME_400.into()),
            ray_length: 100.0,
            sweeps: Some(tailwind::FUCHSIA_400.into()),
        }
    }
}

/// Draws a point of a surface: a cross, and an arrow along the normal if that has a length.
fn surface_point<Clear: Send + Sync + 'static>(
    gizmos: &mut Gizmos<CollisionGizmos, Clear>,
    point: Vec3,
    normal: Vec3,
    color: Color,
) {
    let length = gizmos.config_ext.normal_length;
    if length > 0.0 {
        gizmos.cross(point, 0.2 * length, color);
        gizmos.arrow(point, point + normal * length, color);
    } else {
        gizmos.cross(point, 0.1, color);
    }
}
