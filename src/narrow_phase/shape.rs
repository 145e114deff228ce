//! The shapes that the exact tests know.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A};
#[cfg(feature = "rapier")]
use bevy_rapier3d::parry::shape::{ShapeType, SharedShape};

use super::composite::parts::Parts;
use super::error::BoundsError;
use super::length::length;
use super::mesh::{convex_mesh::ConvexMesh, cube::CUBE, polygon_mesh::PolygonMesh};

/// Half extents beyond this stand for infinity: parry gives unbounded shapes boxes of this order.
#[cfg(feature = "rapier")]
const UNBOUNDED: f32 = f32::MAX / 8.0;

/// The form of an object, in its own coordinates. Cheap to clone: meshes are shared.
///
/// A [`Transform`](bevy::transform::components::Transform) places it: scale first, then rotation,
/// then translation.
///
/// * The scale of a cuboid or mesh works along its own axes; a negative one mirrors.
/// * A sphere stays a sphere: of a scale that differs by axis, the largest absolute component
///   counts.
/// * The half extents of a cuboid, the radius of a sphere and the scale of any shape may be zero:
///   the shape is then flat, or a segment or point.
/// * `Shape::Rapier` ignores the scale, since `bevy_rapier3d` bakes it into the collider itself.
///
/// The [constructors](#constructors) tell the log of bad numbers, or refuse them. Variants built by
/// hand are not checked, and go by the same rule: a negative extent or radius counts as its
/// absolute value, and a shape that is not finite has no bounds and no contacts.
///
/// ```
/// use bevy::math::primitives::Cuboid;
/// use bevy_octree::narrow_phase::Shape;
///
/// let (brick, ball) = (Shape::from(Cuboid::new(4.0, 2.0, 2.0)), Shape::sphere(0.5));
/// # let _ = (brick, ball);
/// assert!(Shape::try_sphere(-1.0).is_err());
/// ```
#[doc(alias = "collider")]
#[derive(Clone, Debug)]
pub enum Shape {
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A solid ball around the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// A convex solid bounded by polygons.
    Convex(Arc<ConvexMesh>),
    /// Any mesh of planar polygons: solid where parts of it are closed, and a surface elsewhere; or a
    /// [surface only](PolygonMesh::surface_only). Its tree makes a whole level one shape.
    Mesh(Arc<PolygonMesh>),
    /// A shape of `bevy_rapier3d`.
    #[cfg(feature = "rapier")]
    Rapier(SharedShape),
}

// All that the exact tests have to know of a kind of shape, but for its row in the table of
// `frame::case`: a new kind is added here.
impl Shape {
    /// Which of the kinds it is.
    #[inline]
    pub(super) const fn kind(&self) -> Kind {
        match self {
            Self::Cuboid { .. } => Kind::Cuboid,
            Self::Sphere { .. } => Kind::Sphere,
            Self::Convex(_) => Kind::Convex,
            Self::Mesh(_) => Kind::Mesh,
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => Kind::Foreign,
        }
    }

    /// The polygons that bound it, and their scale; `None` if it is not made of polygons.
    #[inline]
    pub(super) fn polygons(&self) -> Option<(&PolygonMesh, Vec3A)> {
        match self {
            Self::Cuboid { half_size } => Some((&CUBE, (*half_size).into())),
            Self::Convex(mesh) => Some((mesh, Vec3A::ONE)),
            Self::Mesh(mesh) => Some((mesh, Vec3A::ONE)),
            _ => None,
        }
    }

    /// Its mesh, if it is one of ours.
    pub(super) fn own_mesh(&self) -> Option<&PolygonMesh> {
        match self {
            Self::Convex(mesh) => Some(mesh),
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// The number of a polygon of its mesh in what that was made from.
    pub(super) fn source(&self, polygon: u32) -> u32 {
        self.own_mesh().map_or(polygon, |mesh| mesh.source(polygon))
    }

    /// Are its sizes finite? Those of meshes of ours always are.
    #[inline]
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Cuboid { half_size } => half_size.is_finite(),
            Self::Sphere { radius } => radius.is_finite(),
            Self::Convex(_) | Self::Mesh(_) => true,
            #[cfg(feature = "rapier")]
            Self::Rapier(shape) => foreign_bounds(shape) != Err(BoundsError::NonFinite),
        }
    }

    /// The scale as the shape understands it; see [`Shape`].
    #[inline]
    pub(super) fn effective_scale(&self, scale: Vec3) -> Vec3A {
        match self {
            Self::Sphere { .. } => Vec3A::splat(scale.abs().max_element()),
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => Vec3A::ONE,
            _ => scale.into(),
        }
    }

    /// Centre, half extents and bounding radius around that centre of the unplaced shape.
    #[inline]
    pub(super) fn local_bounds(&self) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
        match self {
            Self::Cuboid { half_size } => {
                let half = Vec3A::from(*half_size).abs();
                Ok((Vec3A::ZERO, half, length(half)))
            }
            Self::Sphere { radius } => {
                let radius = radius.abs();
                Ok((Vec3A::ZERO, Vec3A::splat(radius), radius))
            }
            Self::Convex(mesh) => Ok(mesh.local_bounds()),
            Self::Mesh(mesh) => Ok(mesh.local_bounds()),
            #[cfg(feature = "rapier")]
            Self::Rapier(shape) => foreign_bounds(shape),
        }
    }

    /// A number for its kind, and some for its size: by these, pairs have an order. Those of all
    /// Rapier shapes are equal.
    #[inline]
    pub(super) fn order_key(&self) -> [f32; 4] {
        match self {
            Self::Cuboid { half_size } => [0.0, half_size.x, half_size.y, half_size.z],
            Self::Sphere { radius } => [1.0, *radius, 0.0, 0.0],
            Self::Convex(mesh) => [2.0, mesh.local_bounds().2, 0.0, 0.0],
            Self::Mesh(mesh) => [3.0, mesh.local_bounds().2, 0.0, 0.0],
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => [4.0; 4],
        }
    }

    /// Is it the very same: of the same size, or the same mesh?
    #[inline]
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Cuboid { half_size: a }, Self::Cuboid { half_size: b }) => a == b,
            (Self::Sphere { radius: a }, Self::Sphere { radius: b }) => a == b,
            (Self::Convex(a), Self::Convex(b)) => Arc::ptr_eq(a, b),
            (Self::Mesh(a), Self::Mesh(b)) => Arc::ptr_eq(a, b),
            #[cfg(feature = "rapier")]
            (Self::Rapier(a), Self::Rapier(b)) => Arc::ptr_eq(&a.0, &b.0),
            _ => false,
        }
    }
}

/// Shapes in poses that are one: what games build of simple shapes, as a table, a tree or a house.
///
/// A part is in contact where it would be by itself. Parts may overlap each other. They have a tree,
/// so that a compound may have very many. See [`Compound::new`].
// Here, as it and `Shape` name each other.
#[derive(Clone, Debug)]
pub struct Compound(pub(super) Parts<Shape>);

/// The kinds of shapes: a [`Shape`] without its data. What is Rapier's is one of them, whatever it
/// is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Cuboid,
    Sphere,
    Convex,
    Mesh,
    /// A shape of Rapier's: with the feature `rapier` alone is there one.
    Foreign,
}

impl Kind {
    /// Is there a plane between each two such that are apart?
    #[inline]
    pub(super) const fn is_convex(self) -> bool {
        match self {
            Self::Cuboid | Self::Sphere | Self::Convex => true,
            Self::Mesh | Self::Foreign => false,
        }
    }
}

/// Centre, half extents and bounding radius of the unplaced shape.
#[cfg(feature = "rapier")]
fn foreign_bounds(shape: &SharedShape) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
    let aabb = shape.compute_local_aabb();
    let (min, max) = (Vec3A::from(aabb.mins), Vec3A::from(aabb.maxs));
    let is_finite = min.is_finite() && max.is_finite();
    // Only shapes of somebody else's making say by infinity that they are unbounded.
    let may_be_infinite = shape.shape_type() == ShapeType::Custom;
    if min.is_nan() || max.is_nan() || !(is_finite || may_be_infinite) {
        return Err(BoundsError::NonFinite);
    }
    let half = (max * 0.5 - min * 0.5).max(Vec3A::ZERO);
    if half.max_element() > UNBOUNDED {
        return Err(BoundsError::Unbounded);
    }
    Ok((min * 0.5 + max * 0.5, half, length(half)))
}
