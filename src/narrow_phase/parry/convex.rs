//! Convex shapes as parry has them: a core, and all that is within a radius of it. In 64-bit
//! floats, so that neither the size of one nor a position far from the other costs exactness.

use bevy::math::{DMat3, DVec3, Vec3};
use bevy::transform::components::Transform;
use bevy_rapier3d::parry::math::Pose;
use bevy_rapier3d::parry::shape::{self, SupportMap, TypedShape};

use crate::narrow_phase::mesh::polygon_mesh::PolygonMesh;

/// Where something is, and how it is turned.
#[derive(Clone, Copy, Debug)]
pub struct Isometry {
    pub rotation: DMat3,
    pub translation: DVec3,
}

impl Isometry {
    pub const IDENTITY: Self = Self {
        rotation: DMat3::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// That of a transform, relative to an origin.
    pub fn of(at: &Transform, origin: Vec3) -> Self {
        let rotation = DMat3::from_quat(at.rotation.normalize().as_dquat().normalize());
        Self {
            rotation,
            translation: at.translation.as_dvec3() - origin.as_dvec3(),
        }
    }

    /// That of a part, whose pose in the whole is given.
    pub fn of_part(&self, pose: Option<&Pose>) -> Self {
        pose.map_or(*self, |pose| Self {
            rotation: self.rotation * DMat3::from_quat(pose.rotation.as_dquat().normalize()),
            translation: self.to_world(pose.translation.as_dvec3()),
        })
    }

    pub fn to_world(self, point: DVec3) -> DVec3 {
        self.translation + self.rotation * point
    }

    pub fn to_local(self, point: DVec3) -> DVec3 {
        self.direction_to_local(point - self.translation)
    }

    pub fn direction_to_local(self, direction: DVec3) -> DVec3 {
        self.rotation.transpose() * direction
    }

    /// The centre and half extents of the box, in the axes of this isometry, around one in those of
    /// another.
    pub fn bounds_to_local(self, other: &Self, [center, half]: [DVec3; 2]) -> [DVec3; 2] {
        let turn = self.rotation.transpose() * other.rotation;
        let reach =
            turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z;
        [self.to_local(other.to_world(center)), reach]
    }
}

/// What a convex shape consists of, but for a radius around it, in its own coordinates.
#[derive(Clone, Copy)]
enum Core<'a> {
    Point,
    Segment([DVec3; 2]),
    Triangle([DVec3; 3]),
    Cuboid(DVec3),
    Cylinder { half_height: f64, radius: f64 },
    Cone { half_height: f64, radius: f64 },
    Hull(&'a [Vec3]),
    Mesh(&'a PolygonMesh, DVec3),
    Other(&'a dyn SupportMap),
}

/// A convex shape in its place.
#[derive(Clone, Copy)]
pub struct Convex<'a> {
    core: Core<'a>,
    /// All that is no further from the core is part of the shape.
    pub radius: f64,
    pub at: Isometry,
}

impl<'a> Convex<'a> {
    pub fn point(at: DVec3) -> Self {
        Self::ball(
            0.0,
            Isometry {
                translation: at,
                ..Isometry::IDENTITY
            },
        )
    }

    pub fn ball(radius: f32, at: Isometry) -> Self {
        Self {
            core: Core::Point,
            radius: f64::from(radius.abs()),
            at,
        }
    }

    pub fn cuboid(half_size: Vec3, at: Isometry) -> Self {
        Self {
            core: Core::Cuboid(half_size.abs().as_dvec3()),
            radius: 0.0,
            at,
        }
    }

    /// A mesh that is convex, at a scale.
    pub fn mesh(mesh: &'a PolygonMesh, scale: DVec3, at: Isometry) -> Self {
        Self {
            core: Core::Mesh(mesh, scale),
            radius: 0.0,
            at,
        }
    }

    #[cfg(test)]
    pub fn segment(ends: [DVec3; 2], at: Isometry) -> Self {
        Self {
            core: Core::Segment(ends),
            radius: 0.0,
            at,
        }
    }

    pub fn triangle(corners: [DVec3; 3], at: Isometry) -> Self {
        Self {
            core: Core::Triangle(corners),
            radius: 0.0,
            at,
        }
    }

    /// A shape of parry's; `None` if it is not convex, or has no end.
    pub fn of(shape: &'a dyn shape::Shape, at: Isometry) -> Option<Self> {
        let cylinder = |cylinder: &shape::Cylinder| Core::Cylinder {
            half_height: cylinder.half_height.into(),
            radius: cylinder.radius.into(),
        };
        let cone = |cone: &shape::Cone| Core::Cone {
            half_height: cone.half_height.into(),
            radius: cone.radius.into(),
        };
        let triangle = |triangle: &shape::Triangle| {
            Core::Triangle([triangle.a, triangle.b, triangle.c].map(wide))
        };
        let (core, radius) = match shape.as_typed_shape() {
            TypedShape::Ball(ball) => (Core::Point, ball.radius),
            TypedShape::Cuboid(cuboid) => (Core::Cuboid(wide(cuboid.half_extents)), 0.0),
            TypedShape::Capsule(capsule) => (
                Core::Segment([capsule.segment.a, capsule.segment.b].map(wide)),
                capsule.radius,
            ),
            TypedShape::Segment(segment) => (Core::Segment([segment.a, segment.b].map(wide)), 0.0),
            TypedShape::Triangle(inner) => (triangle(inner), 0.0),
            TypedShape::ConvexPolyhedron(hull) => (Core::Hull(hull.points()), 0.0),
            TypedShape::Cylinder(inner) => (cylinder(inner), 0.0),
            TypedShape::Cone(inner) => (cone(inner), 0.0),
            TypedShape::RoundCuboid(round) => (
                Core::Cuboid(wide(round.inner_shape.half_extents)),
                round.border_radius,
            ),
            TypedShape::RoundTriangle(round) => (triangle(&round.inner_shape), round.border_radius),
            TypedShape::RoundCylinder(round) => (cylinder(&round.inner_shape), round.border_radius),
            TypedShape::RoundCone(round) => (cone(&round.inner_shape), round.border_radius),
            TypedShape::RoundConvexPolyhedron(round) => {
                (Core::Hull(round.inner_shape.points()), round.border_radius)
            }
            TypedShape::Custom(shape) => (Core::Other(shape.as_support_map()?), 0.0),
            _ => return None,
        };
        Some(Self {
            core,
            radius: f64::from(radius.abs()),
            at,
        })
    }

    pub fn moved(mut self, by: DVec3) -> Self {
        self.at.translation += by;
        self
    }

    /// The corners, if it is a triangle.
    pub fn as_triangle(&self) -> Option<[DVec3; 3]> {
        self.core_triangle().filter(|_| self.radius == 0.0)
    }

    /// The corners of the core, if that is a triangle.
    pub fn core_triangle(&self) -> Option<[DVec3; 3]> {
        match self.core {
            Core::Triangle(corners) => Some(corners.map(|corner| self.at.to_world(corner))),
            _ => None,
        }
    }

    /// The ends of the core, if that is a segment, or a point.
    pub fn core_segment(&self) -> Option<[DVec3; 2]> {
        match self.core {
            Core::Point => Some([self.at.translation; 2]),
            Core::Segment(ends) => Some(ends.map(|end| self.at.to_world(end))),
            _ => None,
        }
    }

    pub fn is_point(&self) -> bool {
        matches!(self.core, Core::Point) && self.radius == 0.0
    }

    /// The point of the core that is furthest along a direction.
    pub fn furthest(&self, direction: DVec3) -> DVec3 {
        self.at
            .to_world(self.core.furthest(self.at.direction_to_local(direction)))
    }

    /// Centre and half extents of the box around the shape, in its own axes.
    pub fn local_box(&self) -> [DVec3; 2] {
        let reach = |direction: DVec3| self.core.furthest(direction).dot(direction);
        let high = DVec3::new(reach(DVec3::X), reach(DVec3::Y), reach(DVec3::Z));
        let low = -DVec3::new(reach(-DVec3::X), reach(-DVec3::Y), reach(-DVec3::Z));
        [(low + high) * 0.5, (high - low) * 0.5 + self.radius]
    }
}

fn wide(point: Vec3) -> DVec3 {
    point.as_dvec3()
}

impl Core<'_> {
    fn furthest(&self, direction: DVec3) -> DVec3 {
        let of = |points: &mut dyn Iterator<Item = DVec3>| {
            let (mut best, mut reach) = (DVec3::ZERO, f64::NEG_INFINITY);
            for point in points {
                let along = point.dot(direction);
                if along > reach {
                    (best, reach) = (point, along);
                }
            }
            best
        };
        match *self {
            Self::Point => DVec3::ZERO,
            Self::Segment([a, b]) => {
                if b.dot(direction) > a.dot(direction) {
                    b
                } else {
                    a
                }
            }
            Self::Triangle(corners) => of(&mut corners.into_iter()),
            Self::Cuboid(half) => DVec3::select(direction.cmplt(DVec3::ZERO), -half, half),
            Self::Cylinder {
                half_height,
                radius,
            } => rim(direction, radius, half_height.copysign(direction.y)),
            Self::Cone {
                half_height,
                radius,
            } => {
                let (apex, base) = (DVec3::Y * half_height, rim(direction, radius, -half_height));
                if apex.dot(direction) > base.dot(direction) {
                    apex
                } else {
                    base
                }
            }
            Self::Hull(points) => of(&mut points.iter().copied().map(wide)),
            // Vertices that no polygon names are no part of it.
            Self::Mesh(mesh, scale) => {
                let corners = mesh.edges().as_flattened().iter();
                of(&mut corners.map(|&corner| wide(mesh.vertices()[corner as usize]) * scale))
            }
            Self::Other(shape) => wide(shape.local_support_point(direction.as_vec3())),
        }
    }
}

/// The point of a circle around the second axis that is furthest along a direction.
fn rim(direction: DVec3, radius: f64, height: f64) -> DVec3 {
    let outwards = direction.with_y(0.0).normalize_or_zero() * radius;
    outwards.with_y(height)
}
