//! Shapes in their places as something that can be asked.

use bevy::math::{DVec3, Vec3};

use super::convex::{Convex, Isometry};
use super::parts::{Part, PosedShape};
use super::posed_mesh::PosedMesh;
use crate::narrow_phase::{frame::placed::Placed, shape::Shape};

/// A shape in its place, relative to an origin, as something that can be asked; `None` for what
/// parry knows no more of than its name.
pub fn posed<'a>(placed: Placed<'a>, origin: Vec3) -> Option<PosedShape<'a>> {
    let at = Isometry::of(placed.transform, origin);
    posed_at(placed.shape, placed.transform.scale.as_dvec3(), at)
}

/// The same, of a shape at a scale.
pub fn posed_at(shape: &Shape, scale: DVec3, at: Isometry) -> Option<PosedShape<'_>> {
    let size = scale.abs();
    let largest = size.max_element();
    let wide = |number: f32| f64::from(number.abs());
    let convex = match shape {
        Shape::Cuboid { half_size } => Convex::cuboid(half_size.as_dvec3() * scale, at),
        Shape::Sphere { radius } => Convex::ball(wide(*radius) * largest, at),
        Shape::Capsule {
            radius,
            half_length,
        } => Convex::capsule(
            wide(*radius) * size.x.max(size.z),
            wide(*half_length) * size.y,
            at,
        ),
        Shape::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height,
        } => {
            let sizes = [radius_bottom, radius_top, half_height].map(|number| wide(*number));
            Convex::frustum(sizes, scale, 0.0, at)
        }
        Shape::HalfSpace { normal } => {
            let normal = scaled_normal(normal.as_dvec3(), scale);
            return Some(PosedShape::Part(Part::half_space(normal, at)));
        }
        Shape::Rounded(rounded) => {
            Convex::rounded(rounded.core(), scale, wide(rounded.radius()) * largest, at)
        }
        Shape::Convex(mesh) => Convex::mesh(mesh, scale, at),
        Shape::Mesh(mesh) => return Some(PosedShape::Mesh(PosedMesh { mesh, scale, at })),
        #[cfg(feature = "rapier")]
        Shape::Rapier(inner) => {
            return match inner.own() {
                Some(own) => posed_at(own, DVec3::ONE, at),
                None => super::foreign::posed_foreign(shape, at),
            };
        }
    };
    Some(PosedShape::Part(Part::Convex(convex)))
}

/// The normal of a plane through the origin that a scale stretches. A scale that leaves no plane of
/// it leaves the normal as it is.
fn scaled_normal(normal: DVec3, scale: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = scale;
    let cofactors = DVec3::new(y * z, x * z, x * y) * (x * y * z).signum();
    (normal * cofactors)
        .try_normalize()
        .unwrap_or_else(|| normal.normalize_or(DVec3::Y))
}
