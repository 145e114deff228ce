//! The leaves of the broad phase's tree.

use bevy::prelude::*;

use super::gizmos::{CollisionGizmos, LeafColors};
use crate::{broad_phase::Leaf, collision_index::CollisionIndex};

/// What the colour of a leaf is about.
fn figure(colors: LeafColors, leaf: &Leaf) -> u32 {
    match colors {
        LeafColors::Generation => leaf.generation,
        LeafColors::Fill => leaf.objects,
    }
}

/// Draws all leaves, coloured in proportion to the deepest or fullest.
pub(super) fn draw_leaves(mut gizmos: Gizmos<CollisionGizmos>, index: Res<CollisionIndex>) {
    let CollisionGizmos {
        leaves: Some(colors),
        leaf_colors: [least, most],
        ..
    } = *gizmos.config_ext
    else {
        return;
    };
    let mut top = 1;
    index
        .index()
        .for_each_leaf(|leaf| top = top.max(figure(colors, &leaf)));
    let [least, most] = [least, most].map(Oklaba::from);
    index.index().for_each_leaf(|leaf| {
        let share = figure(colors, &leaf) as f32 / top as f32;
        gizmos.aabb_3d(leaf.bounds, Transform::IDENTITY, least.mix(&most, share));
    });
}
