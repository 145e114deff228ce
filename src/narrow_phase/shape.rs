//! The shapes that the exact tests know.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A};
#[cfg(feature = "rapier")]
use bevy_rapier3d::parry::shape::{ShapeType, SharedShape};

use super::composite::{height_field::HeightField, parts::Parts, voxels::Voxels};
use super::error::BoundsError;
use super::length::length;
use super::mesh::{convex_mesh::ConvexMesh, cube::CUBE, polygon_mesh::PolygonMesh};
use super::rounded::{Rounded, frustum_bounds};

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
///   counts. So it is for the radius of what is rounded. Of a capsule, the second component is for
///   its length, and the larger of the other two for its radius.
/// * A frustum follows the scale along each axis, and may so become elliptic. The plane of a
///   half-space turns as the scale turns it.
/// * The half extents of a cuboid, the radius of a sphere and the scale of any shape may be zero:
///   the shape is then flat, or a segment or point.
/// * Height fields and voxels follow it, and so do the parts of a compound that are not turned in
///   it. What is turned is not sheared: it is as long along each of its own axes as the scale makes
///   it.
/// * In an app, what does not follow a scale is [told of](crate::plugins::BoundsPlugin) in the log.
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
    /// All that is no further than a radius from a segment along the y axis, its middle at the
    /// origin.
    Capsule {
        /// Its radius.
        radius: f32,
        /// Half the length of the segment: without the round ends.
        half_length: f32,
    },
    /// A frustum of a cone around the y axis, its middle at the origin; with equal radii a
    /// cylinder, with one of zero a cone.
    ConicalFrustum {
        /// The radius at its top.
        radius_top: f32,
        /// The radius at its bottom.
        radius_bottom: f32,
        /// Half its height.
        half_height: f32,
    },
    /// All that is behind the plane through the origin: it has no end, and so no box.
    HalfSpace {
        /// The normal of the plane, which points outwards. Its length does not count.
        normal: Vec3,
    },
    /// A convex shape with a radius around it, or a segment or triangle.
    Rounded(Arc<Rounded>),
    /// Shapes in poses that are one.
    Compound(Arc<Compound>),
    /// A grid of heights: a surface, without an inside.
    HeightField(Arc<HeightField>),
    /// Cubes of one size in a grid.
    Voxels(Arc<Voxels>),
    /// A convex solid bounded by polygons.
    Convex(Arc<ConvexMesh>),
    /// Any mesh of planar polygons: solid where parts of it are closed, and a surface elsewhere; or a
    /// [surface only](PolygonMesh::surface_only). Its tree makes a whole level one shape.
    Mesh(Arc<PolygonMesh>),
    /// A shape of `bevy_rapier3d`.
    #[cfg(feature = "rapier")]
    Rapier(Arc<RapierShape>),
}

/// A shape of `bevy_rapier3d`, and what it is of ours: of that, once it is made, all tests are
/// asked. What is none of ours is taken apart by parry.
#[cfg(feature = "rapier")]
#[derive(Clone)]
pub struct RapierShape {
    raw: SharedShape,
    own: Option<Shape>,
}

#[cfg(feature = "rapier")]
impl std::fmt::Debug for RapierShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = self.raw.shape_type();
        f.debug_tuple("RapierShape").field(&kind).finish()
    }
}

#[cfg(feature = "rapier")]
impl RapierShape {
    pub(super) const fn new(raw: SharedShape, own: Option<Shape>) -> Self {
        Self { raw, own }
    }

    /// Returns Rapier's shape.
    #[must_use]
    pub const fn raw(&self) -> &SharedShape {
        &self.raw
    }

    /// Returns the shape of ours that it is, if it is one.
    #[must_use]
    pub const fn own(&self) -> Option<&Shape> {
        self.own.as_ref()
    }

    /// Is it the very same shape of Rapier's?
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.raw.0, &other.raw.0)
    }
}

/// # Changes in place
impl Shape {
    /// Returns its voxels, to be changed, if it has some: all of them are copied first if a clone of
    /// the shape has them, too.
    pub fn voxels_mut(&mut self) -> Option<&mut Voxels> {
        match self {
            Self::Voxels(voxels) => Some(Arc::make_mut(voxels)),
            _ => None,
        }
    }

    /// Returns its height field, to be changed, if it is one: all of it is copied first if a clone of
    /// the shape has it, too.
    pub fn height_field_mut(&mut self) -> Option<&mut HeightField> {
        match self {
            Self::HeightField(field) => Some(Arc::make_mut(field)),
            _ => None,
        }
    }
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
            Self::Capsule { .. } | Self::ConicalFrustum { .. } | Self::Rounded(_) => Kind::Curved,
            Self::HalfSpace { .. } | Self::Compound(_) | Self::HeightField(_) | Self::Voxels(_) => {
                Kind::Parts
            }
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

    /// Are the support functions asked where a ray meets it?
    #[inline]
    pub(super) const fn is_cast_by_support(&self) -> bool {
        let has_chord = matches!(self, Self::Capsule { .. } | Self::ConicalFrustum { .. });
        self.kind().is_by_support() && !has_chord
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
            Self::Capsule {
                radius,
                half_length,
            } => (radius + half_length).is_finite(),
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => (radius_top + radius_bottom + half_height).is_finite(),
            Self::HalfSpace { normal } => normal.is_finite() && *normal != Vec3::ZERO,
            Self::Rounded(_)
            | Self::Compound(_)
            | Self::HeightField(_)
            | Self::Voxels(_)
            | Self::Convex(_)
            | Self::Mesh(_) => true,
            #[cfg(feature = "rapier")]
            Self::Rapier(shape) => match shape.own() {
                Some(own) => own.is_finite(),
                None => foreign_bounds(shape) != Err(BoundsError::NonFinite),
            },
        }
    }

    /// What of it does not follow a scale, as the log has it; `None` if all does.
    pub(crate) fn left_by_scale(&self, scale: Vec3) -> Option<&'static str> {
        let size = scale.abs();
        if size.x == size.y && size.y == size.z {
            return None;
        }
        match self {
            Self::Sphere { .. } => Some("the ball stays round, by the largest of the three"),
            Self::Capsule { .. } if size.x != size.z => {
                Some("the capsule stays round, by the larger of the first and the third")
            }
            Self::Rounded(rounded) if rounded.radius() > 0.0 => {
                Some("the radius around the shape is scaled by the largest of the three")
            }
            Self::Compound(compound) if !compound.follows_scale() => {
                Some("parts of the compound that are turned or round are not sheared")
            }
            _ => None,
        }
    }

    /// Does no scale have an effect on it?
    pub(crate) const fn is_rigid(&self) -> bool {
        matches!(self.kind(), Kind::Foreign)
    }

    /// Does it follow a scale along each of its own axes, so that all of it is where the scale takes
    /// it?
    pub(super) fn follows_scale(&self) -> bool {
        match self {
            Self::Sphere { .. } | Self::Capsule { .. } => false,
            Self::Rounded(rounded) => rounded.radius() == 0.0,
            Self::Compound(compound) => compound.follows_scale(),
            Self::Cuboid { .. }
            | Self::ConicalFrustum { .. }
            | Self::HalfSpace { .. }
            | Self::HeightField(_)
            | Self::Voxels(_)
            | Self::Convex(_)
            | Self::Mesh(_) => true,
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => false,
        }
    }

    /// The scale as the shape understands it; see [`Shape`].
    #[inline]
    pub(super) fn effective_scale(&self, scale: Vec3) -> Vec3A {
        match self {
            Self::Sphere { .. } => {
                let Vec3 { x, y, z } = scale.abs();
                Vec3A::splat(larger(larger(x, y), z))
            }
            Self::Capsule { .. } => {
                let Vec3 { x, y, z } = scale.abs();
                let across = larger(x, z);
                Vec3A::new(across, y, across)
            }
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => without_scale(scale).into(),
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
            Self::Capsule {
                radius,
                half_length,
            } => {
                let (radius, half_length) = (radius.abs(), half_length.abs());
                let reach = radius + half_length;
                Ok((Vec3A::ZERO, Vec3A::new(radius, reach, radius), reach))
            }
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } if self.is_finite() => Ok(frustum_bounds(*radius_top, *radius_bottom, *half_height)),
            Self::ConicalFrustum { .. } => Err(BoundsError::NonFinite),
            Self::HalfSpace { .. } if self.is_finite() => Err(BoundsError::Unbounded),
            Self::HalfSpace { .. } => Err(BoundsError::NonFinite),
            Self::Compound(compound) => Ok(compound.local_bounds()),
            Self::HeightField(field) => Ok(field.local_bounds()),
            Self::Voxels(voxels) => Ok(voxels.local_bounds()),
            Self::Rounded(rounded) => {
                let (center, half, radius) = rounded.core_bounds();
                Ok((center, half + rounded.radius(), radius + rounded.radius()))
            }
            #[cfg(feature = "rapier")]
            Self::Rapier(shape) => match shape.own() {
                Some(own) => own.local_bounds(),
                None => foreign_bounds(shape),
            },
        }
    }

    /// Centre, half extents and bounding radius of the shape at a scale, which is its [effective
    /// one](Self::effective_scale).
    #[inline]
    pub(super) fn bounds_at(&self, scale: Vec3A) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
        let size = scale.abs();
        if let Self::Rounded(rounded) = self {
            let (center, half, radius) = rounded.core_bounds();
            let largest = size.max_element();
            let grown = rounded.radius() * largest;
            let half = half * size + grown;
            return Ok((center * scale, half, radius * largest + grown));
        }
        if let Self::Capsule {
            radius,
            half_length,
        } = self
        {
            // Its ends stay round.
            let (radius, half_length) = (radius.abs() * size.x, half_length.abs() * size.y);
            let reach = radius + half_length;
            return Ok((Vec3A::ZERO, Vec3A::new(radius, reach, radius), reach));
        }
        if let Self::Compound(compound) = self {
            return Ok(compound.bounds_at(scale));
        }
        let (center, half, radius) = self.local_bounds()?;
        Ok((center * scale, half * size, radius * size.max_element()))
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
            Self::Capsule {
                radius,
                half_length,
            } => [4.0, *radius, *half_length, 0.0],
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => [5.0, *radius_top, *radius_bottom, *half_height],
            Self::HalfSpace { normal } => [6.0, normal.x, normal.y, normal.z],
            Self::Rounded(rounded) => [7.0, rounded.radius(), rounded.core_bounds().2, 0.0],
            Self::Compound(compound) => {
                [8.0, compound.len() as f32, compound.local_bounds().2, 0.0]
            }
            Self::HeightField(field) => [9.0, field.local_bounds().2, 0.0, 0.0],
            Self::Voxels(voxels) => [10.0, voxels.local_bounds().2, 0.0, 0.0],
            #[cfg(feature = "rapier")]
            Self::Rapier(_) => [f32::MAX; 4],
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
            (Self::Capsule { .. }, Self::Capsule { .. })
            | (Self::ConicalFrustum { .. }, Self::ConicalFrustum { .. })
            | (Self::HalfSpace { .. }, Self::HalfSpace { .. }) => {
                self.order_key() == other.order_key()
            }
            (Self::Rounded(a), Self::Rounded(b)) => Arc::ptr_eq(a, b),
            (Self::Compound(a), Self::Compound(b)) => Arc::ptr_eq(a, b),
            (Self::HeightField(a), Self::HeightField(b)) => Arc::ptr_eq(a, b),
            (Self::Voxels(a), Self::Voxels(b)) => Arc::ptr_eq(a, b),
            #[cfg(feature = "rapier")]
            (Self::Rapier(a), Self::Rapier(b)) => a.is_same(b),
            _ => false,
        }
    }
}

/// Shapes in poses that are one: what games build of simple shapes, as a table, a tree or a house.
///
/// A part is in contact where it would be by itself. Parts may overlap each other. They have a tree,
/// so that a compound may have very many. See [`Compound::new`].
#[doc(alias = "compound collider")]
// Here, as it and `Shape` name each other.
#[derive(Clone, Debug)]
pub struct Compound(pub(super) Parts<Shape>);

impl Compound {
    /// Centre, half extents and bounding radius at a scale. What of its parts does not follow a
    /// scale that differs by axis, may stick out of the scaled box.
    pub(super) fn bounds_at(&self, scale: Vec3A) -> (Vec3A, Vec3A, f32) {
        let (center, half, radius) = self.0.local_bounds();
        let size = scale.abs();
        let largest = size.max_element();
        let stray = self.0.stray_at(scale);
        if stray == 0.0 {
            return (center * scale, half * size, radius * largest);
        }
        let half = half * size + stray;
        (center * scale, half, length(half))
    }
}

/// The larger of two sizes; no number, if one of the two is none. `f32::max` would pass over that.
#[inline]
pub(super) const fn larger(a: f32, b: f32) -> f32 {
    if a >= b || a.is_nan() { a } else { b }
}

/// A scale that has no effect; what is no scale is none all the same.
#[cfg(feature = "rapier")]
pub(super) fn without_scale(scale: Vec3) -> Vec3 {
    if scale.is_finite() {
        Vec3::ONE
    } else {
        Vec3::NAN
    }
}

/// The kinds of shapes: a [`Shape`] without its data. What is Rapier's is one of them, whatever it
/// is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Cuboid,
    Sphere,
    Convex,
    Mesh,
    /// Convex, and known by its support function.
    Curved,
    /// What is taken apart into convex parts and half-spaces, or is a half-space.
    Parts,
    /// A shape of Rapier's: with the feature `rapier` alone is there one.
    Foreign,
}

impl Kind {
    /// Is it one that the support functions are asked about, whatever the other is?
    #[inline]
    pub(super) const fn is_by_support(self) -> bool {
        matches!(self, Self::Curved | Self::Parts | Self::Foreign)
    }

    /// Is there a plane between each two such that are apart?
    #[inline]
    pub(super) const fn is_convex(self) -> bool {
        match self {
            Self::Cuboid | Self::Sphere | Self::Convex | Self::Curved => true,
            Self::Mesh | Self::Parts | Self::Foreign => false,
        }
    }
}

/// Centre, half extents and bounding radius of the unplaced shape.
#[cfg(feature = "rapier")]
fn foreign_bounds(shape: &RapierShape) -> Result<(Vec3A, Vec3A, f32), BoundsError> {
    let shape = shape.raw();
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
