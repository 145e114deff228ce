//! Shapes in their places as something that can be asked.

use bevy::math::Vec3;
use bevy_rapier3d::geometry::Collider;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::shape::SharedShape;

use super::convex::{Convex, Isometry};
use super::own_mesh::OwnMesh;
use super::parts::{Part, PosedShape};
use crate::narrow_phase::{frame::placed::Placed, shape::Shape};

impl From<SharedShape> for Shape {
    fn from(shape: SharedShape) -> Self {
        Self::Rapier(shape)
    }
}

impl From<&Collider> for Shape {
    /// The collider as `bevy_rapier3d` has it now, its scale baked in.
    fn from(collider: &Collider) -> Self {
        Self::Rapier(collider.raw.clone())
    }
}

/// How a shape is turned, at the origin.
pub fn turn(placed: Placed) -> Pose {
    Pose::from_parts(Vec3::ZERO, placed.transform.rotation.normalize())
}

/// A shape in its place, relative to an origin, as something that can be asked; `None` for what
/// parry knows no more of than its name.
pub fn posed<'a>(placed: Placed<'a>, origin: Vec3) -> Option<PosedShape<'a>> {
    let at = Isometry::of(placed.transform, origin);
    let scale = Vec3::from(placed.shape.effective_scale(placed.transform.scale));
    let convex = match placed.shape {
        Shape::Cuboid { half_size } => Convex::cuboid(*half_size * scale, at),
        Shape::Sphere { radius } => Convex::ball(radius * scale.x, at),
        Shape::Convex(mesh) => Convex::mesh(mesh, scale.as_dvec3(), at),
        Shape::Mesh(mesh) => {
            let scale = scale.as_dvec3();
            return Some(PosedShape::Mesh(OwnMesh { mesh, scale, at }));
        }
        Shape::Rapier(shape) => return PosedShape::of(&**shape, at),
    };
    Some(PosedShape::Part(Part::Convex(convex)))
}
