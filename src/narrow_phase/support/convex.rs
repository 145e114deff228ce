//! Convex shapes by their support functions: a core, and all that is within a radius of it. In 64-bit
//! floats, so that neither the size of one nor a position far from the other costs exactness.

pub mod feature;

#[cfg(feature = "rapier")]
use bevy::math::DQuat;
use bevy::math::{DMat3, DVec3, Vec3};
use bevy::transform::components::Transform;

use super::foreign_core::ForeignCore;
use crate::narrow_phase::{
    composite::voxels::Faces, mesh::convex_mesh::ConvexMesh, rounded::RoundedCore,
};

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

    /// That of a part, given how it is turned in the whole and where it is.
    #[cfg(feature = "rapier")]
    pub fn of_part(&self, rotation: DQuat, translation: DVec3) -> Self {
        Self {
            rotation: self.rotation * DMat3::from_quat(rotation.normalize()),
            translation: self.to_world(translation),
        }
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
///
/// A new kind of convex shape is one more of these, with its [support function](Core::furthest).
#[derive(Clone, Copy)]
enum Core<'a> {
    Point,
    Segment([DVec3; 2]),
    Triangle([DVec3; 3]),
    Cuboid(DVec3),
    /// Around the second axis: a cylinder or a cone, too.
    Frustum {
        bottom: f64,
        top: f64,
        half_height: f64,
        scale: DVec3,
    },
    Mesh(&'a ConvexMesh, DVec3),
    #[cfg_attr(
        not(feature = "rapier"),
        expect(dead_code, reason = "nobody else is there")
    )]
    Foreign(ForeignCore<'a>),
}

/// A convex shape in its place.
#[derive(Clone, Copy)]
pub struct Convex<'a> {
    core: Core<'a>,
    /// All that is no further from the core is part of the shape.
    pub radius: f64,
    pub at: Isometry,
    /// Of a cuboid, the faces that bound the solid which it is part of: beyond the others, that goes
    /// on.
    pub faces: Faces,
}

impl<'a> Convex<'a> {
    const fn new(core: Core<'a>, radius: f64, at: Isometry) -> Self {
        let faces = Faces::ALL;
        Self {
            core,
            radius,
            at,
            faces,
        }
    }

    pub fn point(at: DVec3) -> Self {
        Self::ball(
            0.0,
            Isometry {
                translation: at,
                ..Isometry::IDENTITY
            },
        )
    }

    pub fn ball(radius: f64, at: Isometry) -> Self {
        let core = Core::Point;
        Self::new(core, radius, at)
    }

    pub fn cuboid(half_size: DVec3, at: Isometry) -> Self {
        Self::new(Core::Cuboid(half_size.abs()), 0.0, at)
    }

    /// A mesh that is convex, at a scale.
    pub fn mesh(mesh: &'a ConvexMesh, scale: DVec3, at: Isometry) -> Self {
        Self::new(Core::Mesh(mesh, scale), 0.0, at)
    }

    /// Along its second axis.
    pub fn capsule(radius: f64, half_length: f64, at: Isometry) -> Self {
        let end = DVec3::Y * half_length;
        Self::new(Core::Segment([-end, end]), radius, at)
    }

    /// A frustum around its second axis, at a scale: where that differs between the other two, an
    /// elliptic one.
    pub fn frustum(
        [bottom, top, half_height]: [f64; 3],
        scale: DVec3,
        radius: f64,
        at: Isometry,
    ) -> Self {
        let core = Core::Frustum {
            bottom,
            top,
            half_height,
            scale,
        };
        Self::new(core, radius, at)
    }

    /// A core at a scale, with a radius that has its scale already.
    pub fn rounded(core: &'a RoundedCore, scale: DVec3, radius: f64, at: Isometry) -> Self {
        let core = match core {
            RoundedCore::Segment(ends) => Core::Segment(ends.map(|end| wide(end) * scale)),
            RoundedCore::Triangle(corners) => {
                Core::Triangle(corners.map(|corner| wide(corner) * scale))
            }
            RoundedCore::Cuboid { half_size } => Core::Cuboid((wide(*half_size) * scale).abs()),
            RoundedCore::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => {
                let sizes = [radius_bottom, radius_top, half_height];
                let sizes = sizes.map(|size| f64::from(size.abs()));
                return Self::frustum(sizes, scale, radius, at);
            }
            RoundedCore::Convex(mesh) => Core::Mesh(mesh, scale),
        };
        Self::new(core, radius, at)
    }

    /// A core that somebody else knows.
    #[cfg(feature = "rapier")]
    pub fn foreign(core: ForeignCore<'a>, radius: f64, at: Isometry) -> Self {
        Self::new(Core::Foreign(core), radius, at)
    }

    #[cfg(feature = "rapier")]
    pub fn segment(ends: [DVec3; 2], radius: f64, at: Isometry) -> Self {
        Self::new(Core::Segment(ends), radius, at)
    }

    pub fn triangle(corners: [DVec3; 3], radius: f64, at: Isometry) -> Self {
        Self::new(Core::Triangle(corners), radius, at)
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

pub fn wide(point: Vec3) -> DVec3 {
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
            Self::Frustum {
                bottom,
                top,
                half_height,
                scale,
            } => {
                let direction = direction * scale;
                let across = direction.with_y(0.0);
                let outwards = across.normalize_or_zero();
                let steep = across.dot(outwards);
                let (low, high) = (bottom * steep, top * steep);
                let rise = half_height * direction.y;
                let furthest = if high + rise > low - rise {
                    (outwards * top).with_y(half_height)
                } else {
                    (outwards * bottom).with_y(-half_height)
                };
                furthest * scale
            }
            // Vertices that no polygon names are no part of it.
            Self::Mesh(mesh, scale) => {
                let corners = mesh.corners().vertices().iter();
                of(&mut corners.map(|&corner| wide(mesh.vertices()[corner as usize]) * scale))
            }
            Self::Foreign(core) => core.furthest(direction),
        }
    }
}
