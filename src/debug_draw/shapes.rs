//! Shapes themselves.

use bevy::prelude::*;

use super::{
    boxes::DebugDraw,
    gizmos::CollisionGizmos,
    outline::{Pen, of_part},
};
use crate::{
    components::{BroadPhaseProxy, CollisionShape},
    narrow_phase::{RoundedCore, Shape},
    shear::{self, Sheared},
};

type Drawn<'a> = (
    &'a CollisionShape,
    Option<&'a Sheared>,
    &'a BroadPhaseProxy,
    Option<&'a DebugDraw>,
);

/// Draws the shapes of all entities that are in the index, where they were in the last tick.
pub(super) fn draw_shapes(mut gizmos: Gizmos<CollisionGizmos>, all: Query<Drawn>) {
    let color @ Some(_) = gizmos.config_ext.shapes else {
        return;
    };
    for (shape, sheared, proxy, own) in &all {
        if proxy.id().is_some()
            && let Some(color) = DebugDraw::color(own, color)
        {
            let gizmos = &mut gizmos;
            draw(
                &mut Pen { gizmos, color },
                shear::shape(shape, sheared),
                proxy.pose(),
            );
        }
    }
}

/// Draws a shape where it is.
pub(super) fn draw<Config: GizmoConfigGroup, Clear: Send + Sync + 'static>(
    pen: &mut Pen<Config, Clear>,
    shape: &Shape,
    at: &Transform,
) {
    match shape {
        Shape::Cuboid { half_size } => pen.cuboid(at, *half_size),
        Shape::Sphere { radius } => pen.sphere(at, *radius),
        Shape::Capsule {
            radius,
            half_length,
        } => pen.capsule(at, *radius, *half_length),
        Shape::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height,
        } => pen.frustum(at, *radius_top, *radius_bottom, *half_height),
        Shape::HalfSpace { normal } => pen.half_space(at, *normal),
        Shape::Rounded(rounded) => draw_rounded(pen, rounded.core(), rounded.radius(), at),
        Shape::Convex(mesh) => pen.edges(at, mesh.vertices(), mesh.edges()),
        Shape::Mesh(mesh) => pen.edges(at, mesh.vertices(), mesh.edges()),
        Shape::Compound(compound) => {
            for (pose, part) in compound.parts() {
                draw(pen, part, &of_part(at, pose));
            }
        }
        Shape::HeightField(field) => {
            let (size, columns) = ([field.rows(), field.columns()], field.columns());
            let height = |row, column| field.heights()[row * columns + column];
            pen.height_field(at, size, field.cell_size(), height);
        }
        Shape::Voxels(voxels) => {
            let count = usize::try_from(voxels.len()).unwrap_or(usize::MAX);
            pen.voxels(at, voxels.cell_size(), count, voxels.iter());
        }
        #[cfg(feature = "rapier")]
        Shape::Rapier(foreign) => {
            // Its scale is baked in.
            let at = at.with_scale(Vec3::ONE);
            if let Some(own) = foreign.own() {
                draw(pen, own, &at);
            } else if let Ok(aabb) = shape.world_aabb(&at) {
                pen.gizmos.aabb_3d(aabb, Transform::IDENTITY, pen.color);
            }
        }
    }
}

fn draw_rounded<Config: GizmoConfigGroup, Clear: Send + Sync + 'static>(
    pen: &mut Pen<Config, Clear>,
    core: &RoundedCore,
    radius: f32,
    at: &Transform,
) {
    match core {
        RoundedCore::Segment(ends) if radius == 0.0 => pen.segment(at, *ends),
        RoundedCore::Segment(ends) => pen.rounded_segment(at, *ends, radius),
        RoundedCore::Triangle(corners) if radius == 0.0 => pen.triangle(at, *corners),
        RoundedCore::Triangle(corners) => {
            let sides = [[0, 1, 2], [2, 1, 0]];
            let sides = sides.iter().map(<[u32; 3]>::as_slice);
            pen.rounded_polygons(at, corners, sides, radius);
            for corner in corners {
                let at = Transform {
                    translation: at.transform_point(*corner),
                    ..*at
                };
                pen.sphere(&at, radius);
            }
        }
        RoundedCore::Cuboid { half_size } => pen.rounded_cuboid(at, *half_size, radius),
        RoundedCore::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height,
        } => pen.rounded_frustum(at, [*radius_top, *radius_bottom, *half_height], radius),
        RoundedCore::Convex(mesh) => {
            pen.rounded_polygons(at, mesh.vertices(), mesh.polygons(), radius);
        }
    }
}
