//! The boxes of entities.

use bevy::prelude::*;

use super::gizmos::CollisionGizmos;
use crate::{
    collision_index::CollisionIndex,
    components::{BroadPhaseProxy, WorldAabb},
};

/// Says how the box of one entity is drawn, its shape, its way if it is
/// [swept](crate::swept::Swept), and what it [casts](crate::casters), whatever the [`CollisionGizmos`] say about others.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub enum DebugDraw {
    /// Not at all.
    #[default]
    Hidden,
    /// In a colour of its own: its box even where others are not drawn, all else where that of others
    /// is.
    Color(Color),
}

/// # For `bsn!`
impl DebugDraw {
    /// Returns the `Hidden` that `bsn!` begins with.
    #[must_use]
    pub const fn default_hidden() -> Self {
        Self::Hidden
    }

    /// Returns the `Color` that `bsn!` begins with: white.
    #[must_use]
    pub const fn default_color() -> Self {
        Self::Color(Color::WHITE)
    }
}

impl DebugDraw {
    /// The colour of what belongs to an entity, given that of others.
    pub(super) fn color(own: Option<&Self>, others: Option<Color>) -> Option<Color> {
        match own {
            Some(Self::Hidden) => None,
            Some(Self::Color(color)) => Some(*color),
            None => others,
        }
    }
}

type Boxes<'a, M> = (&'a WorldAabb, &'a BroadPhaseProxy, M);

/// Draws the boxes of all entities that are in the index, but unbounded ones.
pub(super) fn draw_boxes(
    mut gizmos: Gizmos<CollisionGizmos>,
    index: Res<CollisionIndex>,
    all: Query<Boxes<Option<&DebugDraw>>>,
    marked: Query<Boxes<&DebugDraw>>,
) {
    let CollisionGizmos {
        moving, resting, ..
    } = *gizmos.config_ext;
    let proxies = index.index().proxies();
    let mut draw = |aabb: &WorldAabb, proxy: &BroadPhaseProxy, own: Option<&DebugDraw>| {
        let Some(id) = proxy.id() else { return };
        let others = if proxies.is_resting(id) {
            resting
        } else {
            moving
        };
        if let Some(color) = DebugDraw::color(own, others).filter(|_| *aabb != WorldAabb::UNBOUNDED)
        {
            gizmos.aabb_3d(aabb.0, Transform::IDENTITY, color);
        }
    };
    if moving.or(resting).is_some() {
        all.iter()
            .for_each(|(aabb, proxy, own)| draw(aabb, proxy, own));
    } else {
        marked
            .iter()
            .for_each(|(aabb, proxy, own)| draw(aabb, proxy, Some(own)));
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<DebugDraw>();
}
