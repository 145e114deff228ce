//! Shapes of `bevy_rapier3d`, as what they are of ours.

use std::sync::Arc;

use bevy::math::Vec3;
use bevy_rapier3d::{
    geometry::Collider,
    parry::shape::{self, SharedShape, TypedShape},
};

use super::{
    mesh::polygon_mesh::PolygonMesh,
    rounded::{Rounded, RoundedCore},
    shape::{RapierShape, Shape},
};

impl From<SharedShape> for Shape {
    fn from(shape: SharedShape) -> Self {
        let own = own(&*shape.0);
        Self::Rapier(Arc::new(RapierShape::new(shape, own)))
    }
}

impl From<&Collider> for Shape {
    /// The collider as `bevy_rapier3d` has it now, its scale baked in.
    fn from(collider: &Collider) -> Self {
        collider.raw.clone().into()
    }
}

/// A shape of parry's as one of ours, if it is one.
fn own(shape: &dyn shape::Shape) -> Option<Shape> {
    let rounded =
        |core, radius: f32| Some(Shape::Rounded(Arc::new(Rounded::new(core, radius).ok()?)));
    let cylinder =
        |cylinder: &shape::Cylinder| [cylinder.radius, cylinder.radius, cylinder.half_height];
    let cone = |cone: &shape::Cone| [0.0, cone.radius, cone.half_height];
    let solid = |[radius_top, radius_bottom, half_height]: [f32; 3]| Shape::ConicalFrustum {
        radius_top,
        radius_bottom,
        half_height,
    };
    let core = |[radius_top, radius_bottom, half_height]: [f32; 3]| RoundedCore::ConicalFrustum {
        radius_top,
        radius_bottom,
        half_height,
    };
    let triangle = |inner: &shape::Triangle| RoundedCore::Triangle([inner.a, inner.b, inner.c]);
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => Some(Shape::Sphere {
            radius: ball.radius,
        }),
        TypedShape::Cuboid(cuboid) => Some(Shape::Cuboid {
            half_size: cuboid.half_extents,
        }),
        TypedShape::Capsule(capsule) => {
            let (a, b) = (capsule.segment.a, capsule.segment.b);
            if a == -b && b.with_y(0.0) == Vec3::ZERO {
                return Some(Shape::Capsule {
                    radius: capsule.radius,
                    half_length: b.y.abs(),
                });
            }
            rounded(RoundedCore::Segment([a, b]), capsule.radius)
        }
        TypedShape::Segment(segment) => rounded(RoundedCore::Segment([segment.a, segment.b]), 0.0),
        TypedShape::Triangle(inner) => rounded(triangle(inner), 0.0),
        TypedShape::Cylinder(inner) => Some(solid(cylinder(inner))),
        TypedShape::Cone(inner) => Some(solid(cone(inner))),
        TypedShape::RoundCuboid(round) => {
            let half_size = round.inner_shape.half_extents;
            rounded(RoundedCore::Cuboid { half_size }, round.border_radius)
        }
        TypedShape::RoundTriangle(round) => {
            rounded(triangle(&round.inner_shape), round.border_radius)
        }
        TypedShape::RoundCylinder(round) => {
            rounded(core(cylinder(&round.inner_shape)), round.border_radius)
        }
        TypedShape::RoundCone(round) => {
            rounded(core(cone(&round.inner_shape)), round.border_radius)
        }
        TypedShape::HalfSpace(side) => Some(Shape::HalfSpace {
            normal: side.normal,
        }),
        TypedShape::TriMesh(mesh) => {
            let triangles = mesh.indices();
            // A surface, as Rapier has it.
            let made = PolygonMesh::new(mesh.vertices().to_vec(), triangles);
            Some(made.ok()?.surface_only().into())
        }
        _ => None,
    }
}
