//! Casters, and what they met.

use bevy::{
    ecs::{archetype::Archetype, entity_disabling::DefaultQueryFilters},
    prelude::*,
};

use super::{
    boxes::DebugDraw,
    gizmos::{CollisionGizmos, surface_point},
    outline::Pen,
    shapes,
};
use crate::{
    casters::{self, RayCaster, RayHits, ShapeCaster, ShapeHits},
    disabled,
    hierarchy::Link,
};

/// How far something is cast that meets so many at most and met these, the last of them that far
/// away: to that one, if there are no more; and no further than is drawn.
fn reach(length: f32, most: u32, met: usize, last: Option<f32>, drawn: f32) -> f32 {
    match last {
        Some(last) if met >= most as usize => last,
        // What was met is drawn, however far away.
        _ => length.min(drawn.max(last.unwrap_or(0.0))),
    }
}

type Rays<'a> = (
    Entity,
    &'a RayCaster,
    &'a RayHits,
    Option<&'a DebugDraw>,
    &'a Archetype,
);

/// Draws the rays of all casters, as far as they reach, and where they met something. For a system that [sees disabled
/// entities](disabled::see_disabled): a disabled parent is still where it is.
pub(super) fn draw_rays(
    mut gizmos: Gizmos<CollisionGizmos>,
    all: Query<Rays>,
    links: Query<Link>,
    filters: Option<Res<DefaultQueryFilters>>,
) {
    let CollisionGizmos {
        rays: color @ Some(_),
        ray_length,
        ..
    } = *gizmos.config_ext
    else {
        return;
    };
    for (entity, caster, hits, own, archetype) in &all {
        let is_disabled = disabled::is_disabled(archetype, filters.as_deref());
        if is_disabled || !caster.enabled || caster.max_hits == 0 {
            continue;
        }
        if let Some(color) = DebugDraw::color(own, color)
            && let Some(pose) = casters::pose(entity, &links)
            && let Some(ray) = caster.ray(&pose)
        {
            let last = hits.last().map(|hit| hit.distance);
            let length = reach(caster.length, caster.max_hits, hits.len(), last, ray_length);
            gizmos.line(ray.origin, ray.get_point(length), color);
            for hit in hits {
                surface_point(&mut gizmos, hit.point, hit.normal, color);
            }
        }
    }
}

type Shapes<'a> = (
    Entity,
    &'a ShapeCaster,
    &'a ShapeHits,
    Option<&'a DebugDraw>,
    &'a Archetype,
);

/// Draws the ways of all shapes that are cast, the shapes where they touch something, and where that
/// is. As [`draw_rays`].
pub(super) fn draw_shapes(
    mut gizmos: Gizmos<CollisionGizmos>,
    all: Query<Shapes>,
    links: Query<Link>,
    filters: Option<Res<DefaultQueryFilters>>,
) {
    let CollisionGizmos {
        sweeps: color @ Some(_),
        ray_length,
        ..
    } = *gizmos.config_ext
    else {
        return;
    };
    for (entity, caster, hits, own, archetype) in &all {
        let is_disabled = disabled::is_disabled(archetype, filters.as_deref());
        if is_disabled || !caster.enabled || caster.max_hits == 0 {
            continue;
        }
        let Some(color) = DebugDraw::color(own, color) else {
            continue;
        };
        let pose = casters::pose(entity, &links);
        let Some((start, direction)) = pose.and_then(|pose| caster.start(&pose)) else {
            continue;
        };
        let last = hits.last().map(|hit| hit.distance);
        let length = reach(caster.length, caster.max_hits, hits.len(), last, ray_length);
        let after = |distance: f32| start.translation + direction * distance;
        gizmos.line(start.translation, after(length), color);
        let stops = hits.iter().map(|hit| hit.distance);
        // One that touches nothing is drawn where its way ends.
        let end = (hits.is_empty() && caster.length <= ray_length).then_some(length);
        for distance in stops.chain(end) {
            let at = start.with_translation(after(distance));
            let mut pen = Pen {
                gizmos: &mut *gizmos,
                color,
            };
            shapes::draw(&mut pen, &caster.shape, &at);
        }
        for hit in hits {
            surface_point(&mut gizmos, hit.point, hit.normal, color);
        }
    }
}
