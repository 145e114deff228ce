//! What is drawn, and how.

use bevy::{color::palettes::tailwind, prelude::*};

/// The settings of debug drawing: `None` is not drawn, and costs nothing. Line widths and all else
/// that gizmos have are in the [`GizmoConfig`] beside it.
///
/// The default draws everything but leaves.
///
/// ```
/// use bevy::{gizmos::GizmoPlugin, mesh::MeshPlugin, prelude::*};
/// use bevy_octree::prelude::*;
///
/// // Contacts alone, from the start.
/// let contacts = CollisionGizmos { moving: None, resting: None, shapes: None, ..default() };
/// App::new()
///     .add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, GizmoPlugin))
///     .add_plugins((OctreePlugins::default(), CollisionDebugPlugin))
///     .insert_gizmo_config(contacts, GizmoConfig::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Reflect, GizmoConfigGroup)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionGizmos {
    /// The boxes ([`WorldAabb`](crate::components::WorldAabb)) of entities that moved in the last
    /// tick.
    pub moving: Option<Color>,
    /// Those of all other entities.
    pub resting: Option<Color>,
    /// Shapes, as the exact tests know them, where they were in the last tick. Of a mesh, its edges,
    /// and where it has more than 2 048 of them, every second one, or third, and so on; of a
    /// half-space, a patch around its origin and the normal. A shape of Rapier's that is none of the
    /// crate's own kinds is drawn as its box.
    pub shapes: Option<Color>,
    /// Contacts: a cross where the two meet, and an arrow along the normal, from
    /// [`a`](crate::contacts::Collision::a) to `b`. Where the geometry is not
    /// [known](crate::contacts::CollisionEventSettings::geometry), a line from the centre of one
    /// box to that of the other.
    pub contacts: Option<Color>,
    /// The length of normals, in world units; none are drawn at 0. Points are marked by crosses of
    /// a size to match.
    pub normal_length: f32,
    /// The leaves of the broad phase's tree ([`Leaf`](crate::broad_phase::Leaf)), and what their
    /// colours tell. The default broad phase has no tree for a handful of objects.
    pub leaves: Option<LeafColors>,
    /// The colours of leaves: from those of which there is nothing to tell (the root, an empty
    /// leaf) to the deepest or fullest of the moment.
    pub leaf_colors: [Color; 2],
    /// Rays, and what they hit: those of [`RayCaster`](crate::casters::RayCaster)s, and
    /// [others](super::QueryGizmos::ray_hit).
    pub rays: Option<Color>,
    /// How far rays that hit nothing are drawn, and the ways of shapes that touch nothing, in world
    /// units.
    pub ray_length: f32,
    /// Boxes on their way from one place to another: those of entities that are
    /// [`Swept`](crate::swept::Swept), and [others](super::QueryGizmos::swept_box). And the ways of
    /// what [`ShapeCaster`](crate::casters::ShapeCaster)s cast: a line, the shape where it touches
    /// something, and where that is.
    pub sweeps: Option<Color>,
}

impl Default for CollisionGizmos {
    fn default() -> Self {
        Self {
            moving: Some(tailwind::AMBER_400.into()),
            resting: Some(tailwind::SLATE_400.into()),
            shapes: Some(tailwind::SKY_400.into()),
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

/// The figure that the colour of a leaf stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub enum LeafColors {
    /// How deep it lies: where objects crowd.
    #[default]
    Generation,
    /// How many objects it lists.
    Fill,
}

/// Draws a point of a surface: a cross, and an arrow along the normal if that has a length.
pub(super) fn surface_point<Clear: Send + Sync + 'static>(
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

pub(super) fn register(app: &mut App) {
    app.init_gizmo_group::<CollisionGizmos>();
}
