//! Boxes on their way.

use bevy::{
    gizmos::gizmos::GizmoBuffer,
    math::{BVec3A, Vec3A, bounding::Aabb3d},
    prelude::*,
};

use super::{boxes::DebugDraw, gizmos::CollisionGizmos};
use crate::{
    components::{BroadPhaseProxy, CollisionShape},
    shear::{self, Sheared},
    swept::{Swept, SweptWay},
};

type Way<'a> = (
    &'a CollisionShape,
    Option<&'a Sheared>,
    &'a BroadPhaseProxy,
    &'a SweptWay,
    Option<&'a DebugDraw>,
);

/// Draws the ways of swept entities that moved in the last tick: from where they began to where
/// they ended, though there may have been bounces on the way.
pub(super) fn draw_ways(mut gizmos: Gizmos<CollisionGizmos>, swept: Query<Way, With<Swept>>) {
    let color @ Some(_) = gizmos.config_ext.sweeps else {
        return;
    };
    for (shape, sheared, proxy, way, own) in &swept {
        let shape = shear::shape(shape, sheared);
        let way = way
            .last_start()
            .filter(|start| start.translation != proxy.pose().translation);
        if let Some(start) = way
            && let Some(color) = DebugDraw::color(own, color)
            && let [Ok(start), Ok(end)] = [start, proxy.pose()].map(|at| shape.world_aabb(at))
        {
            swept_box(&mut gizmos, &start, &end, color);
        }
    }
}

/// Draws a box at its start and at its end, and the lines of its corners between the two.
pub(super) fn swept_box<Config: GizmoConfigGroup, Clear: Send + Sync + 'static>(
    gizmos: &mut GizmoBuffer<Config, Clear>,
    start: &Aabb3d,
    end: &Aabb3d,
    color: Color,
) {
    for aabb in [start, end] {
        gizmos.aabb_3d(*aabb, Transform::IDENTITY, color);
    }
    for (from, to) in corners(start).into_iter().zip(corners(end)) {
        gizmos.line(from, to, color);
    }
}

/// The corners of a box; those of two boxes come in the same order.
fn corners(aabb: &Aabb3d) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let upper = BVec3A::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
        Vec3A::select(upper, aabb.max, aabb.min).into()
    })
}

#[cfg(test)]
mod tests {
    use bevy::gizmos::config::DefaultGizmoConfigGroup;

    use super::*;

    #[test]
    fn each_corner_is_joined_to_itself() {
        let start = Aabb3d::new(Vec3::ZERO, Vec3::ONE);
        let way = Vec3::new(5.0, 6.0, 7.0);
        let end = Aabb3d::new(way, Vec3::ONE);
        let mut gizmos = GizmoBuffer::<DefaultGizmoConfigGroup, ()>::new();
        swept_box(&mut gizmos, &start, &end, Color::WHITE);
        let lines: Vec<[Vec3; 2]> = gizmos
            .list_positions
            .chunks_exact(2)
            .map(|line| [line[0], line[1]])
            .collect();
        let ways = lines.iter().filter(|[from, to]| to - from == way);
        let mut met: Vec<[i32; 3]> = ways.map(|[from, _]| from.as_ivec3().to_array()).collect();
        met.sort_unstable();
        let all = [
            [-1, -1, -1],
            [-1, -1, 1],
            [-1, 1, -1],
            [-1, 1, 1],
            [1, -1, -1],
            [1, -1, 1],
            [1, 1, -1],
            [1, 1, 1],
        ];
        assert_eq!(met, all);
        // Beside these, the edges of two boxes: twelve each, of which three are single lines.
        assert_eq!(lines.len(), 8 + 2 * 3);
        assert!(
            gizmos.strip_positions.contains(&(end.max.into())),
            "{:?}",
            gizmos.strip_positions
        );
    }
}
