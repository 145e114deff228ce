//! What can be wrong with a shape, and with where it is put.

use bevy::math::{Quat, Vec2, Vec3};
use thiserror::Error;

/// Why a shape cannot be built.
///
/// Polygons and vertices are named by their index in the input. What is wrong with a mesh that is
/// to be convex is found once its vertices are welded: there, polygons are named by the [number
/// that they have in the input](super::PolygonMesh::polygon_number), of a Bevy mesh that of the
/// triangle, and vertices by their index in [the mesh](super::PolygonMesh::vertices), with their
/// positions, which are found in the input, too.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// The length of a side of a cuboid is negative, NaN or infinite.
    #[error("the sides of a cuboid must be finite and not negative, got {0}")]
    Size(Vec3),
    /// A half extent of a cuboid is negative, NaN or infinite.
    #[error("half extents of a cuboid must be finite and not negative, got {0}")]
    HalfSize(Vec3),
    /// The radius of a sphere is negative, NaN or infinite.
    #[error("the radius of a sphere must be finite and not negative, got {0}")]
    Radius(f32),
    /// A size, such as a height, is negative, NaN or infinite.
    #[error("the {what} of a shape must be finite and not negative, got {value}")]
    Length {
        /// Of what it is the size.
        what: &'static str,
        /// What it is said to be.
        value: f32,
    },
    /// A direction is zero, NaN or infinite.
    #[error("a direction must be finite and not zero, got {0}")]
    Direction(Vec3),
    /// A radius can be put around convex shapes alone that have an end.
    #[error("a radius can be put around convex shapes alone that have an end")]
    NotRoundable,
    /// The mesh has no polygons.
    #[error("a mesh needs at least one polygon")]
    Empty,
    /// The mesh has more vertices or polygon corners than 32-bit indices can name.
    #[error("a mesh can have at most 2^32 - 1 vertices and polygon corners")]
    TooLarge,
    /// A vertex has a NaN or infinite coordinate.
    #[error("vertex {vertex} is not finite: {position}")]
    NonFiniteVertex {
        /// Which vertex.
        vertex: usize,
        /// Where it is said to be.
        position: Vec3,
    },
    /// A polygon has fewer than three corners.
    #[error("polygon {polygon} has {corners} corners, but needs at least 3")]
    TooFewCorners {
        /// Which polygon.
        polygon: usize,
        /// How many corners it has.
        corners: usize,
    },
    /// A polygon names a vertex that does not exist.
    #[error("polygon {polygon} names vertex {vertex}, but there are only {vertices}")]
    IndexOutOfRange {
        /// Which polygon.
        polygon: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A polygon names the same vertex twice.
    #[error("polygon {polygon} names vertex {vertex} more than once")]
    RepeatedVertex {
        /// Which polygon.
        polygon: usize,
        /// The vertex it repeats.
        vertex: u32,
    },
    /// The corners of a polygon lie on a line or in a point.
    #[error("polygon {polygon} has no area")]
    ZeroArea {
        /// Which polygon.
        polygon: usize,
    },
    /// The corners of a polygon do not lie in a plane.
    #[error("polygon {polygon} is not planar: vertex {vertex} is {distance} off its plane")]
    NotPlanar {
        /// Which polygon.
        polygon: usize,
        /// The vertex which is furthest off the plane.
        vertex: u32,
        /// How far off it is.
        distance: f32,
    },
    /// A convex mesh has to be closed, and along this edge, not as many polygons run one way as the
    /// other, or it belongs to a polygon that bounds no solid.
    #[error(
        "not closed: the edge from {} to {} belongs to a polygon that bounds no solid",
        .positions[0],
        .positions[1]
    )]
    NotClosed {
        /// The vertices at the ends of the edge, by their index in the mesh.
        edge: [u32; 2],
        /// Where they are.
        positions: [Vec3; 2],
    },
    /// A convex mesh is solid, and this one was made to be a surface only.
    #[error("a convex mesh is solid, and cannot be made of a surface only")]
    SurfaceOnly,
    /// A convex mesh has to be in one piece.
    #[error("a convex mesh has to be in one piece, this one has {0}")]
    NotConnected(usize),
    /// A vertex lies outside the plane of a polygon of a mesh that is meant to be convex.
    #[error(
        "not convex: the vertex at {position} is {distance} outside the plane of polygon {polygon}"
    )]
    NotConvex {
        /// The polygon whose plane is crossed, by its number in the input.
        polygon: usize,
        /// The vertex outside of it, by its index in the mesh.
        vertex: u32,
        /// Where it is.
        position: Vec3,
        /// How far outside it is.
        distance: f32,
    },
    /// A convex hull needs four points at least.
    #[error("a convex hull needs at least 4 points, got {0}")]
    FewPoints(usize),
    /// A compound has no parts.
    #[error("a compound needs at least one part")]
    NoParts,
    /// A part of a compound, or where it is put, has no bounds.
    #[error("part {part} of a compound cannot be used: {error}")]
    Part {
        /// Which part, by its number in the input.
        part: usize,
        /// Why it has none.
        error: BoundsError,
    },
    /// A height field has less than two rows or columns of heights.
    #[error("a height field needs at least 2 rows and 2 columns, got {rows} and {columns}")]
    FewHeights {
        /// How many rows.
        rows: usize,
        /// How many columns.
        columns: usize,
    },
    /// A height field has not as many heights as rows times columns.
    #[error("a height field of {rows} rows and {columns} columns cannot have {heights} heights")]
    HeightCount {
        /// How many rows.
        rows: usize,
        /// How many columns.
        columns: usize,
        /// How many heights.
        heights: usize,
    },
    /// A height is NaN or infinite.
    #[error("the height in row {row} and column {column} is not finite: {height}")]
    NonFiniteHeight {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// What it is said to be.
        height: f32,
    },
    /// The size of a cell of a height field is not greater than zero, or makes the field infinite.
    #[error("cells of a height field must have finite sizes greater than zero, got {0}")]
    FieldCellSize(Vec2),
    /// A height field has no such height, or cell.
    #[error("the height field has nothing in row {row} and column {column}")]
    OutsideField {
        /// Which row.
        row: usize,
        /// Which column.
        column: usize,
    },
    /// The size of a voxel is not greater than zero, or beyond 10²⁸.
    #[error("the size of a voxel must be greater than zero and at most 10^28, got {0}")]
    VoxelSize(f32),
    /// A point is in no voxel: it is not finite, or so far away that 32 bits cannot number its cell.
    #[error("point {point} is in no voxel that 32 bits can number: {position}")]
    VoxelPoint {
        /// Which point.
        point: usize,
        /// Where it is.
        position: Vec3,
    },
    /// A convex mesh encloses no volume.
    #[error("a convex mesh has to enclose a volume")]
    Flat,
    /// A part of a compound is wrong.
    #[error("part {part}: {error}")]
    InPart {
        /// Which part.
        part: usize,
        /// What is wrong with it.
        #[source]
        error: Box<Self>,
    },
    /// A part of a compound is nowhere: its position is NaN or infinite, or its rotation is that or
    /// of length zero.
    #[error("part {part} is at {position}, turned by {rotation}: that is nowhere")]
    PartPose {
        /// Which part.
        part: usize,
        /// Its position.
        position: Vec3,
        /// Its rotation.
        rotation: Quat,
    },
    /// Compounds are within compounds, more of them than that.
    #[error("compounds can be within one another {0} deep, these are deeper")]
    TooDeep(usize),
    /// The Bevy mesh does not consist of triangles.
    #[cfg(feature = "mesh")]
    #[error("only triangle lists and triangle strips have polygons, this mesh is a {0:?}")]
    Topology(bevy::mesh::PrimitiveTopology),
    /// The Bevy mesh has no positions of three 32-bit floats.
    #[cfg(feature = "mesh")]
    #[error("the mesh has no `Mesh::ATTRIBUTE_POSITION` of format `Float32x3`")]
    NoPositions,
    /// The Bevy mesh has handed its data over to the renderer.
    #[cfg(feature = "mesh")]
    #[error("the data of the mesh is not in main memory: {0}")]
    NoAccess(String),
    /// The mesh asset could not be loaded.
    #[cfg(feature = "mesh")]
    #[error("the mesh could not be loaded: {0}")]
    NotLoaded(String),
    /// The box around a mesh has more voxels than are looked at.
    #[cfg(feature = "mesh")]
    #[error("{size} is too small a side for the voxels of this mesh: its box has more than {most}")]
    TooManyVoxels {
        /// The side.
        size: f32,
        /// How many there may be at most.
        most: usize,
    },
}

impl ShapeError {
    /// Refuses a size that is negative, NaN or infinite.
    pub(super) fn check(what: &'static str, value: f32) -> Result<(), Self> {
        if value.is_finite() && value >= 0.0 {
            Ok(())
        } else {
            Err(Self::Length { what, value })
        }
    }
}

/// Why a placed shape has no bounding box or sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BoundsError {
    /// The transform (or an unchecked shape) holds NaN or infinity, or a rotation of length zero.
    #[error("the transform or the shape is not finite")]
    NonFinite,
    /// The shape has no end, as a half-space.
    #[error("the shape is unbounded")]
    Unbounded,
}

/// A tolerance has to be finite and greater than zero.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("the tolerance must be finite and greater than zero, got {0}")]
pub struct ToleranceError(
    /// The refused tolerance.
    pub f32,
);
