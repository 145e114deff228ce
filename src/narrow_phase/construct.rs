//! Shapes from numbers, lists of polygons, and the primitives of `bevy_math`.

use std::{
    fmt::{self, Display},
    sync::Arc,
};

use bevy::math::{Isometry3d, Vec2, Vec3, primitives};

use super::composite::{height_field::HeightField, voxels::Voxels};
use super::error::ShapeError;
use super::mesh::{convex_mesh::ConvexMesh, polygon_mesh::PolygonMesh};
use super::rounded::{Rounded, RoundedCore};
use super::shape::{Compound, Shape};

/// Regular polygons of more sides are refused: that is no number of sides, but a mistake.
const MOST_SIDES: u32 = 1 << 16;

/// # Constructors
///
/// Those that take sizes, and the conversions from Bevy's primitives, never fail. One rule is for
/// all numbers that no shape can have. A shape that is made of such is logged as a warning, once:
///
/// * a negative size counts as its absolute value;
/// * a size that is NaN or infinite, a polygon without an area, or a polyhedron without a volume
///   makes a shape without [bounds](super::BoundsError::NonFinite), which is in contact with
///   nothing. An entity that has it is left out of collision detection.
///
/// Cuboids, extruded rectangles, spheres, capsules and frusta may have a size of zero: the shape is
/// then a rectangle, disc, segment or point. All others may not, for they would have no area or no volume. Constructors
/// that begin with `try_` refuse what is wrong instead, with an error that names it, and so do
/// those that take lists.
impl Shape {
    /// Makes a box around the origin, by the lengths of its sides along its own axes.
    ///
    /// They are whole sides, as those of Bevy's `Cuboid::new` and Avian's `Collider::cuboid`;
    /// Rapier's `Collider::cuboid` takes half of them, as [`from_half_size`](Self::from_half_size)
    /// does. For bad numbers see [above](#constructors).
    ///
    /// ```
    /// use bevy::math::primitives::Cuboid;
    /// use bevy_octree::narrow_phase::Shape;
    ///
    /// let Shape::Cuboid { half_size } = Shape::cuboid(4.0, 2.0, 2.0) else { unreachable!() };
    /// assert_eq!(half_size, Cuboid::new(4.0, 2.0, 2.0).half_size);
    /// ```
    #[doc(alias = "box")]
    #[must_use]
    pub fn cuboid(x_length: f32, y_length: f32, z_length: f32) -> Self {
        let half_size = Vec3::new(x_length, y_length, z_length) * 0.5;
        Self::or_absolute(Self::try_cuboid(x_length, y_length, z_length), half_size)
    }

    /// Makes a box as [`cuboid`](Self::cuboid) does, and refuses bad numbers.
    ///
    /// # Errors
    /// [`ShapeError::Size`] if a length is negative, NaN or infinite. Zero is allowed.
    pub fn try_cuboid(x_length: f32, y_length: f32, z_length: f32) -> Result<Self, ShapeError> {
        let size = Vec3::new(x_length, y_length, z_length);
        Self::try_from_half_size(size * 0.5).map_err(|_| ShapeError::Size(size))
    }

    /// Makes a box around the origin, by half the lengths of its sides along its own axes: from its
    /// centre to its faces.
    ///
    /// For bad numbers see [above](#constructors).
    #[must_use]
    pub fn from_half_size(half_size: Vec3) -> Self {
        Self::or_absolute(Self::try_from_half_size(half_size), half_size)
    }

    /// Makes a box as [`from_half_size`](Self::from_half_size) does, and refuses bad numbers.
    ///
    /// # Errors
    /// [`ShapeError::HalfSize`] if one is negative, NaN or infinite. Zero is allowed.
    pub fn try_from_half_size(half_size: Vec3) -> Result<Self, ShapeError> {
        if half_size.is_finite() && half_size.min_element() >= 0.0 {
            Ok(Self::Cuboid { half_size })
        } else {
            Err(ShapeError::HalfSize(half_size))
        }
    }

    /// Makes a solid ball around the origin.
    ///
    /// For a bad radius see [above](#constructors).
    #[doc(alias = "ball")]
    #[must_use]
    pub fn sphere(radius: f32) -> Self {
        if let Err(error) = Self::try_sphere(radius) {
            tell(&error, radius.is_finite());
        }
        Self::Sphere {
            radius: radius.abs(),
        }
    }

    /// Makes a solid ball as [`sphere`](Self::sphere) does, and refuses a bad radius.
    ///
    /// # Errors
    /// [`ShapeError::Radius`] if the radius is negative, NaN or infinite. Zero is allowed.
    pub fn try_sphere(radius: f32) -> Result<Self, ShapeError> {
        if radius.is_finite() && radius >= 0.0 {
            Ok(Self::Sphere { radius })
        } else {
            Err(ShapeError::Radius(radius))
        }
    }

    /// Makes a capsule around the y axis, its middle at the origin: all that is no further than the
    /// radius from a segment of the length, so that it is as high as that and twice the radius.
    ///
    /// The numbers are those of Bevy's `Capsule3d::new`. For bad ones see [above](#constructors).
    ///
    /// ```
    /// use bevy::math::primitives::Capsule3d;
    /// use bevy_octree::narrow_phase::Shape;
    ///
    /// let Shape::Capsule { radius, half_length } = Shape::capsule(0.5, 1.0) else { unreachable!() };
    /// let same = Capsule3d::new(0.5, 1.0);
    /// assert_eq!((radius, half_length), (same.radius, same.half_length));
    /// ```
    #[must_use]
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self::by_sizes(
            "the radius and the length of a capsule",
            [radius, length],
            |[radius, length]| Self::try_capsule(radius, length),
        )
    }

    /// Makes a capsule as [`capsule`](Self::capsule) does, and refuses bad numbers.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if one is negative, NaN or infinite. Zero is allowed.
    pub fn try_capsule(radius: f32, length: f32) -> Result<Self, ShapeError> {
        ShapeError::check("radius", radius)?;
        ShapeError::check("length", length)?;
        let half_length = length * 0.5;
        Ok(Self::Capsule {
            radius,
            half_length,
        })
    }

    /// Makes a capsule from one point to another: all that is no further than the radius from the
    /// segment between them.
    ///
    /// # Errors
    /// Those of [`Rounded::new`].
    pub fn capsule_between(a: Vec3, b: Vec3, radius: f32) -> Result<Self, ShapeError> {
        Ok(Rounded::new(RoundedCore::Segment([a, b]), radius)?.into())
    }

    /// Makes a segment: a line from one point to another.
    ///
    /// # Errors
    /// Those of [`Rounded::new`].
    pub fn segment(a: Vec3, b: Vec3) -> Result<Self, ShapeError> {
        Self::capsule_between(a, b, 0.0)
    }

    /// Makes a triangle, which has no volume and is met from both sides. It may be as thin as a
    /// segment.
    ///
    /// # Errors
    /// Those of [`Rounded::new`].
    pub fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Result<Self, ShapeError> {
        Ok(Rounded::new(RoundedCore::Triangle([a, b, c]), 0.0)?.into())
    }

    /// Makes a solid cylinder around the y axis, its middle at the origin.
    ///
    /// The numbers are those of Bevy's `Cylinder::new`. For bad ones see [above](#constructors).
    #[must_use]
    pub fn cylinder(radius: f32, height: f32) -> Self {
        Self::conical_frustum(radius, radius, height)
    }

    /// Makes a solid cone around the y axis, its tip up, and its middle at the origin: halfway up.
    ///
    /// The numbers are those of Bevy's `Cone::new`. For bad ones see [above](#constructors).
    #[must_use]
    pub fn cone(radius: f32, height: f32) -> Self {
        Self::conical_frustum(0.0, radius, height)
    }

    /// Makes a solid frustum of a cone around the y axis, its middle at the origin.
    ///
    /// For bad numbers see [above](#constructors).
    #[must_use]
    pub fn conical_frustum(radius_top: f32, radius_bottom: f32, height: f32) -> Self {
        let sizes = [radius_top, radius_bottom, height];
        Self::by_sizes("the radii and the height of a frustum", sizes, |sizes| {
            let [radius_top, radius_bottom, height] = sizes;
            Self::try_conical_frustum(radius_top, radius_bottom, height)
        })
    }

    /// Makes a frustum as [`conical_frustum`](Self::conical_frustum) does, and refuses bad numbers.
    ///
    /// # Errors
    /// [`ShapeError::Length`] if one is negative, NaN or infinite. Zero is allowed.
    pub fn try_conical_frustum(
        radius_top: f32,
        radius_bottom: f32,
        height: f32,
    ) -> Result<Self, ShapeError> {
        ShapeError::check("radius at the top", radius_top)?;
        ShapeError::check("radius at the bottom", radius_bottom)?;
        ShapeError::check("height", height)?;
        Ok(Self::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height: height * 0.5,
        })
    }

    /// Makes a tetrahedron of its corners, in any order.
    ///
    /// # Errors
    /// Those of [`convex`](Self::convex): [`ShapeError::Flat`] or [`ShapeError::ZeroArea`] without a
    /// volume.
    pub fn tetrahedron(corners: [Vec3; 4]) -> Result<Self, ShapeError> {
        let [a, b, c, d] = corners;
        let is_left = (b - a).cross(c - a).dot(d - a) > 0.0;
        let corners = if is_left { [a, b, c, d] } else { [a, c, b, d] };
        Self::convex(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    }

    /// Makes a half-space: all that is behind the plane through the origin with this normal, which
    /// points out of it. A floor is one with the normal `Vec3::Y`.
    ///
    /// It has no end, and so no box: it is compared with everything that comes near its side.
    ///
    /// # Errors
    /// [`ShapeError::Direction`] if the normal is zero or not finite.
    #[doc(alias = "plane")]
    #[doc(alias = "infinite plane")]
    pub fn half_space(normal: Vec3) -> Result<Self, ShapeError> {
        let unit = normal.try_normalize().or_else(|| {
            // As far as its squares do not fit.
            (normal / normal.abs().max_element()).try_normalize()
        });
        match unit.filter(|_| normal.is_finite()) {
            Some(normal) => Ok(Self::HalfSpace { normal }),
            None => Err(ShapeError::Direction(normal)),
        }
    }

    /// Puts shapes together, each in a pose. See [`Compound::new`].
    ///
    /// # Errors
    /// Those of [`Compound::new`].
    pub fn compound(
        parts: impl IntoIterator<Item = (Isometry3d, Self)>,
    ) -> Result<Self, ShapeError> {
        Ok(Compound::new(parts)?.into())
    }

    /// Puts a radius around a convex shape: all that is no further from it than that.
    ///
    /// A sphere or capsule is larger by the radius then, and so is what has one already.
    ///
    /// # Errors
    /// Those of [`Rounded::new`]; [`ShapeError::NotRoundable`] if the shape is not convex, or has no
    /// end.
    pub fn rounded(core: &Self, radius: f32) -> Result<Self, ShapeError> {
        ShapeError::check("radius", radius)?;
        let core = match core {
            Self::Sphere { radius: inner } => return Self::try_sphere(inner.abs() + radius),
            Self::Capsule {
                radius: inner,
                half_length,
            } => return Self::try_capsule(inner.abs() + radius, half_length.abs() * 2.0),
            Self::Rounded(inner) => {
                return Ok(Rounded::new(inner.core().clone(), inner.radius() + radius)?.into());
            }
            Self::Cuboid { half_size } => RoundedCore::Cuboid {
                half_size: half_size.abs(),
            },
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => RoundedCore::ConicalFrustum {
                radius_top: radius_top.abs(),
                radius_bottom: radius_bottom.abs(),
                half_height: half_height.abs(),
            },
            Self::Convex(mesh) => RoundedCore::Convex(mesh.clone()),
            _ => return Err(ShapeError::NotRoundable),
        };
        Ok(Rounded::new(core, radius)?.into())
    }

    /// Makes a solid bounded by polygons, each a list of vertex indices, and checks that it is
    /// convex. See [`ConvexMesh::new`].
    ///
    /// # Errors
    /// Those of [`PolygonMesh::new`] and [`ConvexMesh::new`].
    #[doc(alias = "polyhedron")]
    pub fn convex<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        let mesh = PolygonMesh::new(vertices, polygons)?;
        Ok(ConvexMesh::new(mesh)?.into())
    }

    /// Makes the smallest convex solid in which all of some points are. See [`ConvexMesh::hull_of`].
    ///
    /// # Errors
    /// Those of [`ConvexMesh::hull_of`]: less than four points, or all of them in a plane.
    pub fn convex_hull(points: impl IntoIterator<Item = Vec3>) -> Result<Self, ShapeError> {
        Ok(ConvexMesh::hull_of(points)?.into())
    }

    /// Makes a mesh of planar polygons, each a list of vertex indices: solid where parts of it are
    /// closed. See [`PolygonMesh::new`], and for rooms [`PolygonMesh::surface_only`].
    ///
    /// # Errors
    /// Those of [`PolygonMesh::new`].
    #[doc(alias = "trimesh")]
    pub fn mesh<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        Ok(PolygonMesh::new(vertices, polygons)?.into())
    }

    /// A box that may have been refused: then, that of the absolute values.
    fn or_absolute(made: Result<Self, ShapeError>, half_size: Vec3) -> Self {
        made.unwrap_or_else(|error| {
            tell(&error, half_size.is_finite());
            Self::Cuboid {
                half_size: half_size.abs(),
            }
        })
    }

    /// A solid between two congruent convex polygons, half a depth in front of the origin and
    /// behind it.
    fn prism(polygon: impl IntoIterator<Item = Vec2>, half_depth: f32) -> Result<Self, ShapeError> {
        let outline: Vec<Vec2> = polygon.into_iter().collect();
        let count = u32::try_from(outline.len()).map_err(|_| ShapeError::TooLarge)?;
        let level = |z: f32| outline.iter().map(move |corner| corner.extend(z));
        let vertices: Vec<Vec3> = level(-half_depth).chain(level(half_depth)).collect();
        let (back, front) = ((0..count).rev().collect(), (count..2 * count).collect());
        let side = |i: u32| {
            let next = (i + 1) % count;
            vec![i, next, next + count, i + count]
        };
        Self::convex(
            vertices,
            [back, front].into_iter().chain((0..count).map(side)),
        )
    }

    /// The same of half a depth that may be a bad number.
    fn extruded(polygon: impl IntoIterator<Item = Vec2>, half_depth: f32) -> Self {
        let what = "half the depth of an extrusion";
        Self::by_sizes(what, [half_depth], |[half_depth]| {
            Self::prism(polygon, half_depth)
        })
    }

    /// What is made of polygons that may have been refused: then, something without bounds.
    fn or_nothing(made: Result<Self, ShapeError>) -> Self {
        made.unwrap_or_else(|error| Self::nothing(&error))
    }

    /// What is made of polygons by sizes, or rather by their absolute values; `what` they are is
    /// for the log.
    fn by_sizes<const N: usize>(
        what: &str,
        sizes: [f32; N],
        make: impl FnOnce([f32; N]) -> Result<Self, ShapeError>,
    ) -> Self {
        let error =
            fmt::from_fn(|f| write!(f, "{what} must be finite and not negative, got {sizes:?}"));
        if !sizes.iter().all(|size| size.is_finite()) {
            return Self::nothing(&error);
        }
        let made = make(sizes.map(f32::abs));
        if made.is_ok() && sizes.iter().any(|size| *size < 0.0) {
            tell(&error, true);
        }
        Self::or_nothing(made)
    }

    /// Something without bounds, for want of a shape.
    fn nothing(error: &dyn Display) -> Self {
        tell(error, false);
        Self::Sphere { radius: f32::NAN }
    }
}

/// Tells the log what no shape can be made of, and what becomes of it.
#[cold]
fn tell(error: &dyn Display, is_mended: bool) {
    if is_mended {
        tracing::warn!("{error}: the absolute value is used");
    } else {
        tracing::warn!("{error}: the shape is in contact with nothing");
    }
}

/// # From Bevy's primitives
///
/// By the rule of the [constructors](#constructors).
impl From<primitives::Cuboid> for Shape {
    fn from(cuboid: primitives::Cuboid) -> Self {
        Self::from_half_size(cuboid.half_size)
    }
}

impl From<primitives::Sphere> for Shape {
    fn from(sphere: primitives::Sphere) -> Self {
        Self::sphere(sphere.radius)
    }
}

impl From<primitives::Capsule3d> for Shape {
    fn from(capsule: primitives::Capsule3d) -> Self {
        Self::capsule(capsule.radius, capsule.half_length * 2.0)
    }
}

impl From<primitives::Cylinder> for Shape {
    fn from(cylinder: primitives::Cylinder) -> Self {
        Self::cylinder(cylinder.radius, cylinder.half_height * 2.0)
    }
}

impl From<primitives::Cone> for Shape {
    /// Its middle is halfway up, as that of Bevy's mesh is.
    fn from(cone: primitives::Cone) -> Self {
        Self::cone(cone.radius, cone.height)
    }
}

impl From<primitives::ConicalFrustum> for Shape {
    fn from(frustum: primitives::ConicalFrustum) -> Self {
        Self::conical_frustum(frustum.radius_top, frustum.radius_bottom, frustum.height)
    }
}

impl From<primitives::InfinitePlane3d> for Shape {
    /// All that is behind the plane: a half-space.
    fn from(plane: primitives::InfinitePlane3d) -> Self {
        Self::or_nothing(Self::half_space(*plane.normal))
    }
}

impl From<primitives::Segment3d> for Shape {
    fn from(segment: primitives::Segment3d) -> Self {
        let [a, b] = segment.vertices;
        Self::or_nothing(Self::segment(a, b))
    }
}

impl From<primitives::Tetrahedron> for Shape {
    /// A convex solid. One without a volume is in contact with nothing.
    fn from(tetrahedron: primitives::Tetrahedron) -> Self {
        Self::or_nothing(Self::convex(
            tetrahedron.vertices,
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        ))
    }
}

impl From<primitives::Triangle3d> for Shape {
    /// A surface that is met from both sides. One without an area is in contact with nothing.
    fn from(triangle: primitives::Triangle3d) -> Self {
        Self::or_nothing(Self::mesh(triangle.vertices, [[0, 1, 2]]))
    }
}

impl From<primitives::Plane3d> for Shape {
    /// A rectangle, turned as Bevy's mesh of it is, that is met from both sides. One without an
    /// area is in contact with nothing.
    fn from(plane: primitives::Plane3d) -> Self {
        let turn = bevy::math::Quat::from_rotation_arc(Vec3::Y, *plane.normal);
        let half_size = plane.half_size.to_array();
        Self::by_sizes("half extents of a plane", half_size, |[x, y]| {
            let corners =
                [[-x, -y], [-x, y], [x, y], [x, -y]].map(|[x, z]| turn * Vec3::new(x, 0.0, z));
            Self::mesh(corners, [[0, 1, 2, 3]])
        })
    }
}

impl From<primitives::Extrusion<primitives::Rectangle>> for Shape {
    fn from(extrusion: primitives::Extrusion<primitives::Rectangle>) -> Self {
        Self::from_half_size(extrusion.base_shape.half_size.extend(extrusion.half_depth))
    }
}

impl From<primitives::Extrusion<primitives::Triangle2d>> for Shape {
    /// A convex solid. One without a volume is in contact with nothing.
    fn from(extrusion: primitives::Extrusion<primitives::Triangle2d>) -> Self {
        Self::extruded(extrusion.base_shape.vertices, extrusion.half_depth)
    }
}

impl From<primitives::Extrusion<primitives::Rhombus>> for Shape {
    /// A convex solid. One without a volume is in contact with nothing.
    fn from(extrusion: primitives::Extrusion<primitives::Rhombus>) -> Self {
        let Vec2 { x, y } = extrusion.base_shape.half_diagonals;
        let sizes = [x, y, extrusion.half_depth];
        let what = "half the diagonals and half the depth of a rhombus";
        Self::by_sizes(what, sizes, |[x, y, half_depth]| {
            let corners = [Vec2::X * x, Vec2::Y * y, Vec2::NEG_X * x, Vec2::NEG_Y * y];
            Self::prism(corners, half_depth)
        })
    }
}

impl From<primitives::Extrusion<primitives::RegularPolygon>> for Shape {
    /// A convex solid. One without a volume, or of more than 65 536 sides, is in contact with nothing.
    fn from(extrusion: primitives::Extrusion<primitives::RegularPolygon>) -> Self {
        let primitives::RegularPolygon {
            circumcircle: primitives::Circle { radius },
            sides,
        } = extrusion.base_shape;
        let sizes = [radius, extrusion.half_depth];
        let what = "the radius and half the depth of a regular polygon";
        Self::by_sizes(what, sizes, |[radius, half_depth]| {
            if sides > MOST_SIDES {
                return Err(ShapeError::TooLarge);
            }
            let circumcircle = primitives::Circle { radius };
            let polygon = primitives::RegularPolygon {
                circumcircle,
                sides,
            };
            Self::prism(polygon.vertices(0.0), half_depth)
        })
    }
}

impl From<primitives::Extrusion<primitives::ConvexPolygon>> for Shape {
    /// A convex solid. One without a volume is in contact with nothing.
    fn from(extrusion: primitives::Extrusion<primitives::ConvexPolygon>) -> Self {
        let corners = extrusion.base_shape.vertices().iter().copied();
        Self::extruded(corners, extrusion.half_depth)
    }
}

/// # From meshes and what is rounded
impl From<Compound> for Shape {
    fn from(compound: Compound) -> Self {
        Self::Compound(Arc::new(compound))
    }
}

impl From<HeightField> for Shape {
    fn from(field: HeightField) -> Self {
        Self::HeightField(Arc::new(field))
    }
}

impl From<Voxels> for Shape {
    fn from(voxels: Voxels) -> Self {
        Self::Voxels(Arc::new(voxels))
    }
}

impl From<Rounded> for Shape {
    fn from(rounded: Rounded) -> Self {
        Self::Rounded(Arc::new(rounded))
    }
}

impl From<PolygonMesh> for Shape {
    fn from(mesh: PolygonMesh) -> Self {
        Self::Mesh(Arc::new(mesh))
    }
}

impl From<ConvexMesh> for Shape {
    fn from(mesh: ConvexMesh) -> Self {
        Self::Convex(Arc::new(mesh))
    }
}

#[cfg(test)]
mod tests;
