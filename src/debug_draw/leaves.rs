//! The leaves of the broad phase's tree.

use bevy::prelude::*;

use super::CollisionGizmos;
use crate::{broad_phase::Leaf, collision_index::CollisionIndex};

/// What the colour of a leaf tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum LeafColors {
    /// How deep it lies: where objects crowd.
    #[default]
    Generation,
    /// How many objects it lists.
    Fill,
}

impl LeafColors {
    fn of(self, leaf: &Leaf) -> u32 {
        match self {
            Self::Generation => leaf.generation,
            Self::Fill => leaf.objects,
        }
    }
}

/// Draws all leaves, coloured in proportion to the deepest or fullest.
pub(super) fn draw_leaves(mut gizmos: Gizmos<CollisionGizmos>, index: Res<CollisionIndex>) {
    let CollisionGizmos { leaves: Some(colors), leaf_colors: [least, most], .. } = *gizmos.config_ext else { return };
    let mut top = 1;
    index.index().for_each_leaf(|leaf| top = top.max(colors.of(&leaf)));
    let [least, most] = [least, most].map(Oklaba::from);
    index.index().for_each_leaf(|leaf| {
        let share = colors.of(&leaf) as f32 / top as f32;
        gizmos.aabb_3d(leaf.bounds, Transform::IDENTITY, least.mix(&most, share));
    });
}
