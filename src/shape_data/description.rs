//! Shapes as plain data.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The shape of an entity as plain data: what files, editors and exporters write.
///
/// As a component, it makes the [`CollisionShape`](crate::components::CollisionShape) of its entity:
/// at the start of the next tick, and again in each tick after which it was changed, in place or by a
/// new one. As part of a scene file, it is what objects are made of. [`build`](Self::build) makes the
/// [`Shape`](crate::narrow_phase::Shape) at once, and [`of`](Self::of) leads back.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{prelude::*, shape_data::ShapeDescription};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// let ball = app.world_mut().spawn(ShapeDescription::Sphere { radius: 0.5 }).id();
/// app.update();
/// assert!(app.world().get::<CollisionShape>(ball).is_some());
/// ```
///
/// It is read and written through Bevy's reflection and through serde, in the same form. In JSON:
///
/// ```json
/// { "bevy_octree::ShapeDescription": { "Sphere": { "radius": 0.5 } } }
/// ```
///
/// # What changes
///
/// * Where the data changes, the shape is built anew, at the start of the next tick.
/// * A `CollisionShape` that is there before, or comes along with the data, is a placeholder: it is
///   replaced. One that is inserted later stays until the data changes.
/// * Removing the data leaves the shape.
/// * A clone of the entity has data of its own, and builds a shape of its own. Entities that are to
///   share a large mesh are given clones of a `CollisionShape`, or a `ShapeFromMesh`. An entity has
///   this component or a `ShapeFromMesh`, not both.
///
/// # What goes wrong
///
/// Nothing panics. Data that makes no shape is told in the log, with the entity and its [`Name`],
/// once for each change, and leaves a
/// [`ShapeDescriptionError`](super::ShapeDescriptionError) on the entity that says why. A shape that
/// the entity had before stays, so that one half of an edit in an editor does not drop anything
/// through a floor.
///
/// | in the data | what becomes of it |
/// |---|---|
/// | an unknown kind, an unknown field, a value of another type | is not read: the reader's error names it |
/// | a field that is missing | is not read, but for those with a default, as said of each |
/// | NaN, an infinite or a negative size | an error of [`build`](Self::build) |
/// | no vertices, points, polygons, parts, heights or cells | an error of [`build`](Self::build) |
/// | a rotation that is not of length 1 | is normalised; one of length 0 or not finite is an error |
/// | a part of a compound that is wrong | an error that has the number of the part |
/// | compounds in compounds | are built as one; more than [`MAX_DEPTH`](Self::MAX_DEPTH) deep, an error |
/// | the same cell, hole or point twice | counts once |
///
/// JSON has no NaN: what has it is written as `null`, which is not read.
#[doc(alias("collider", "ColliderConstructor"))]
#[derive(Component, Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[reflect(no_field_bounds)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields)]
#[require(Transform)]
#[component(on_remove)]
#[non_exhaustive]
pub enum ShapeDescription {
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A ball around the origin.
    Sphere {
        /// Its radius.
        radius: f32,
    },
    /// All within a radius of a segment along the y axis, around the origin.
    Capsule {
        /// The radius.
        radius: f32,
        /// The length of the segment: the capsule is longer by two radii.
        length: f32,
    },
    /// All within a radius of a segment between two points.
    CapsuleBetween {
        /// Where the segment begins.
        a: Vec3,
        /// Where it ends.
        b: Vec3,
        /// The radius.
        radius: f32,
    },
    /// A cylinder along the y axis, around the origin.
    Cylinder {
        /// Its radius.
        radius: f32,
        /// Its height.
        height: f32,
    },
    /// A cone along the y axis, its tip up; the origin is halfway up.
    Cone {
        /// The radius of its base.
        radius: f32,
        /// Its height.
        height: f32,
    },
    /// A cone along the y axis without its tip; the origin is halfway up.
    ConicalFrustum {
        /// The radius of the upper end.
        radius_top: f32,
        /// The radius of the lower end.
        radius_bottom: f32,
        /// Its height.
        height: f32,
    },
    /// A solid of four corners.
    Tetrahedron {
        /// The corners, in any order.
        vertices: [Vec3; 4],
    },
    /// A triangle, met from both sides.
    Triangle {
        /// A corner.
        a: Vec3,
        /// Another.
        b: Vec3,
        /// The third.
        c: Vec3,
    },
    /// A segment.
    Segment {
        /// Where it begins.
        a: Vec3,
        /// Where it ends.
        b: Vec3,
    },
    /// All that is behind a plane through the origin, without an end.
    HalfSpace {
        /// The normal of the plane, out of the half-space; of any length but zero.
        normal: Vec3,
    },
    /// A convex solid, from the corners and faces of its surface.
    Convex {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face as the indices of its corners, counter-clockwise seen from outside.
        polygons: Vec<Vec<u32>>,
    },
    /// The smallest convex solid around points.
    ConvexHull {
        /// The points.
        points: Vec<Vec3>,
    },
    /// A solid or surface of any form, from the corners and faces of its surface.
    Mesh {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face, a convex polygon, as the indices of its corners, counter-clockwise seen from
        /// outside.
        polygons: Vec<Vec<u32>>,
        /// Has it no inside, however closed it is? It is a room that is walked in, then; see
        /// [`PolygonMesh::surface_only`](crate::narrow_phase::PolygonMesh::surface_only). Not, if it
        /// is missing.
        #[serde(default)]
        surface_only: bool,
    },
    /// All within a radius of something else.
    Rounded {
        /// What is rounded.
        core: CoreDescription,
        /// The radius.
        radius: f32,
    },
    /// Several shapes that are one, each in its place.
    Compound {
        /// The shapes.
        parts: Vec<PartDescription>,
    },
    /// A ground whose height is given on a grid, around the origin: a surface, met from both sides.
    HeightField {
        /// How many heights there are along z.
        rows: u32,
        /// How many there are along x.
        columns: u32,
        /// The heights, row by row.
        heights: Vec<f32>,
        /// The size of a cell along x and along z.
        cell_size: Vec2,
        /// The row and the column of each cell that is open. None, if they are missing.
        #[serde(default)]
        holes: Vec<[u32; 2]>,
    },
    /// Cubes of one size on a grid.
    Voxels {
        /// The side of a cube.
        cell_size: f32,
        /// Which are filled. That of zeros is between the origin and `cell_size`, along each axis.
        cells: Vec<IVec3>,
    },
}

/// What a [`ShapeDescription::Rounded`] is round of, as plain data.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum CoreDescription {
    /// A segment: rounded, it is a capsule.
    Segment {
        /// Where it begins.
        a: Vec3,
        /// Where it ends.
        b: Vec3,
    },
    /// A triangle.
    Triangle {
        /// A corner.
        a: Vec3,
        /// Another.
        b: Vec3,
        /// The third.
        c: Vec3,
    },
    /// A box around the origin.
    Cuboid {
        /// Half the side along each axis.
        half_size: Vec3,
    },
    /// A cylinder along the y axis, around the origin.
    Cylinder {
        /// Its radius.
        radius: f32,
        /// Its height.
        height: f32,
    },
    /// A cone along the y axis, its tip up; the origin is halfway up.
    Cone {
        /// The radius of its base.
        radius: f32,
        /// Its height.
        height: f32,
    },
    /// A cone along the y axis without its tip; the origin is halfway up.
    ConicalFrustum {
        /// The radius of the upper end.
        radius_top: f32,
        /// The radius of the lower end.
        radius_bottom: f32,
        /// Its height.
        height: f32,
    },
    /// A convex solid, from the corners and faces of its surface.
    Convex {
        /// The corners.
        vertices: Vec<Vec3>,
        /// Each face as the indices of its corners, counter-clockwise seen from outside.
        polygons: Vec<Vec<u32>>,
    },
    /// The smallest convex solid around points.
    ConvexHull {
        /// The points.
        points: Vec<Vec3>,
    },
}

/// A part of a [`ShapeDescription::Compound`], as plain data: a shape and where it is.
#[derive(Clone, Debug, Default, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[reflect(no_field_bounds)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields)]
pub struct PartDescription {
    /// Where its origin is. Zeros, if it is missing.
    #[serde(default)]
    pub position: Vec3,
    /// How it is turned, as in a [`Transform`]: a quaternion, of any length but zero. Not at all, if
    /// it is missing.
    #[serde(default)]
    pub rotation: Quat,
    /// What it is. Any kind but those without an end.
    pub shape: ShapeDescription,
}

impl PartDescription {
    /// Returns a part at a place, not turned.
    #[must_use]
    pub fn at(position: Vec3, shape: ShapeDescription) -> Self {
        Self {
            position,
            rotation: Quat::IDENTITY,
            shape,
        }
    }
}

impl ShapeDescription {
    /// How many compounds may be within one another.
    pub const MAX_DEPTH: usize = 16;
}

/// The cube of side 1 around the origin.
impl Default for ShapeDescription {
    fn default() -> Self {
        Self::default_cuboid()
    }
}

/// The cube of side 1 around the origin.
impl Default for CoreDescription {
    fn default() -> Self {
        Self::default_cuboid()
    }
}

const HALF: Vec3 = Vec3::splat(0.5);

/// The corners of Bevy's own.
const TRIANGLE: [Vec3; 3] = [
    Vec3::new(0.0, 0.5, 0.0),
    Vec3::new(-0.5, -0.5, 0.0),
    Vec3::new(0.5, -0.5, 0.0),
];
const TETRAHEDRON: [Vec3; 4] = [
    Vec3::new(0.5, 0.5, 0.5),
    Vec3::new(-0.5, 0.5, -0.5),
    Vec3::new(-0.5, -0.5, 0.5),
    Vec3::new(0.5, -0.5, -0.5),
];

/// Writes a function for each variant.
macro_rules! defaults {
    ($($name:ident, $variant:literal: $value:expr;)*) => {
        $(
            #[doc = concat!("Returns the `", $variant, "` that `bsn!` begins with.")]
            #[must_use]
            pub fn $name() -> Self {
                $value
            }
        )*
    };
}

/// # For `bsn!`
///
/// What fields are that are left out of a variant in Bevy's `bsn!`: as those of Bevy's own
/// primitives, where they have it, and one unit tall and wide else. Lists are such that there is a
/// shape, but that of [`Convex`](Self::Convex), [`Mesh`](Self::Mesh) and
/// [`Compound`](Self::Compound), which are empty.
impl ShapeDescription {
    defaults! {
        default_cuboid, "Cuboid": Self::Cuboid { half_size: HALF };
        default_sphere, "Sphere": Self::Sphere { radius: 0.5 };
        default_capsule, "Capsule": Self::Capsule { radius: 0.5, length: 1.0 };
        default_capsulebetween, "CapsuleBetween": Self::CapsuleBetween {
            a: Vec3::NEG_Y * 0.5,
            b: Vec3::Y * 0.5,
            radius: 0.5,
        };
        default_cylinder, "Cylinder": Self::Cylinder { radius: 0.5, height: 1.0 };
        default_cone, "Cone": Self::Cone { radius: 0.5, height: 1.0 };
        default_conicalfrustum, "ConicalFrustum": Self::ConicalFrustum {
            radius_top: 0.25,
            radius_bottom: 0.5,
            height: 0.5,
        };
        default_tetrahedron, "Tetrahedron": Self::Tetrahedron { vertices: TETRAHEDRON };
        default_triangle, "Triangle": {
            let [a, b, c] = TRIANGLE;
            Self::Triangle { a, b, c }
        };
        default_segment, "Segment": Self::Segment { a: Vec3::NEG_X * 0.5, b: Vec3::X * 0.5 };
        default_halfspace, "HalfSpace": Self::HalfSpace { normal: Vec3::Y };
        default_convex, "Convex": Self::Convex { vertices: Vec::new(), polygons: Vec::new() };
        default_convexhull, "ConvexHull": Self::ConvexHull { points: TETRAHEDRON.into() };
        default_mesh, "Mesh": Self::Mesh {
            vertices: Vec::new(),
            polygons: Vec::new(),
            surface_only: false,
        };
        default_rounded, "Rounded": Self::Rounded { core: CoreDescription::default(), radius: 0.1 };
        default_compound, "Compound": Self::Compound { parts: Vec::new() };
        default_heightfield, "HeightField": Self::HeightField {
            rows: 2,
            columns: 2,
            heights: vec![0.0; 4],
            cell_size: Vec2::ONE,
            holes: Vec::new(),
        };
        default_voxels, "Voxels": Self::Voxels { cell_size: 1.0, cells: vec![IVec3::ZERO] };
    }
}

/// # For `bsn!`
///
/// As those of [`ShapeDescription`](ShapeDescription#for-bsn).
impl CoreDescription {
    defaults! {
        default_segment, "Segment": Self::Segment { a: Vec3::NEG_X * 0.5, b: Vec3::X * 0.5 };
        default_triangle, "Triangle": {
            let [a, b, c] = TRIANGLE;
            Self::Triangle { a, b, c }
        };
        default_cuboid, "Cuboid": Self::Cuboid { half_size: HALF };
        default_cylinder, "Cylinder": Self::Cylinder { radius: 0.5, height: 1.0 };
        default_cone, "Cone": Self::Cone { radius: 0.5, height: 1.0 };
        default_conicalfrustum, "ConicalFrustum": Self::ConicalFrustum {
            radius_top: 0.25,
            radius_bottom: 0.5,
            height: 0.5,
        };
        default_convex, "Convex": Self::Convex { vertices: Vec::new(), polygons: Vec::new() };
        default_convexhull, "ConvexHull": Self::ConvexHull { points: TETRAHEDRON.into() };
    }
}
