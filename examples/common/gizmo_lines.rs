//! What the crate drew in a frame, read back from Bevy's gizmos.

use std::any::TypeId;

use bevy::{gizmos::GizmoHandles, prelude::*};
use bevy_octree::debug_draw::CollisionGizmos;

/// Lines through some points, and their colour.
pub struct Path {
    pub points: Vec<Vec3>,
    pub color: LinearRgba,
}

/// The lines of the last frame, in the order in which they were drawn; those with more than two
/// points first.
pub fn paths(app: &App) -> Vec<Path> {
    let world = app.world();
    let handle = world
        .resource::<GizmoHandles>()
        .handles()
        .get(&TypeId::of::<CollisionGizmos>());
    let asset =
        handle.and_then(|handle| world.resource::<Assets<GizmoAsset>>().get(handle.as_ref()?));
    let Some(asset) = asset else {
        return Vec::new();
    };
    let lines = asset.buffer().buffer();
    // What is not a number ends a strip.
    let mut start = 0;
    let strips = lines
        .strip_positions
        .split_inclusive(|point| point.is_nan())
        .map(|strip| {
            let color = lines.strip_colors[start];
            start += strip.len();
            Path {
                points: strip
                    .iter()
                    .copied()
                    .filter(|point| !point.is_nan())
                    .collect(),
                color,
            }
        });
    let pairs = lines
        .list_positions
        .chunks_exact(2)
        .zip(lines.list_colors.chunks_exact(2));
    strips
        .chain(pairs.map(|(points, colors)| Path {
            points: points.to_vec(),
            color: colors[0],
        }))
        .collect()
}
