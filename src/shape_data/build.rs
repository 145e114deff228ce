//! From data to shapes.

use bevy::math::{Isometry3d, Quat};

use super::description::{CoreDescription, PartDescription, ShapeDescription};
use crate::narrow_phase::{HeightField, PolygonMesh, Shape, ShapeError, Voxels};

impl ShapeDescription {
    /// Makes the shape that is described.
    ///
    /// In time linear in the data, but for what [`PolygonMesh::new`] says of large meshes.
    ///
    /// # Errors
    ///
    /// Those of the constructors of [`Shape`](Shape#constructors) that begin with `try_`, and of
    /// those that take lists; for compounds, [`ShapeError::InPart`] around them,
    /// [`ShapeError::PartPose`] and [`ShapeError::TooDeep`].
    pub fn build(&self) -> Result<Shape, ShapeError> {
        self.build_within(0)
    }

    /// The same, within so many compounds.
    fn build_within(&self, depth: usize) -> Result<Shape, ShapeError> {
        match self {
            Self::Cuboid { half_size } => Shape::try_from_half_size(*half_size),
            Self::Sphere { radius } => Shape::try_sphere(*radius),
            Self::Capsule { radius, length } => Shape::try_capsule(*radius, *length),
            Self::CapsuleBetween { a, b, radius } => Shape::capsule_between(*a, *b, *radius),
            Self::Cylinder { radius, height } => {
                Shape::try_conical_frustum(*radius, *radius, *height)
            }
            Self::Cone { radius, height } => Shape::try_conical_frustum(0.0, *radius, *height),
            Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            } => Shape::try_conical_frustum(*radius_top, *radius_bottom, *height),
            Self::Tetrahedron { vertices } => Shape::tetrahedron(*vertices),
            Self::Triangle { a, b, c } => Shape::triangle(*a, *b, *c),
            Self::Segment { a, b } => Shape::segment(*a, *b),
            // What was normalised is left as it is, so that it comes back the same.
            Self::HalfSpace { normal } if normal.is_normalized() => {
                Ok(Shape::HalfSpace { normal: *normal })
            }
            Self::HalfSpace { normal } => Shape::half_space(*normal),
            Self::Convex { vertices, polygons } => Shape::convex(vertices.as_slice(), polygons),
            Self::ConvexHull { points } => Shape::convex_hull(points.iter().copied()),
            Self::Mesh {
                vertices,
                polygons,
                surface_only,
            } => {
                let mesh = PolygonMesh::new(vertices.as_slice(), polygons)?;
                Ok(if *surface_only {
                    mesh.surface_only().into()
                } else {
                    mesh.into()
                })
            }
            Self::Rounded { core, radius } => Shape::rounded(&core.build()?, *radius),
            Self::Compound { parts } => Shape::compound(build_parts(parts, depth)?),
            Self::HeightField {
                rows,
                columns,
                heights,
                cell_size,
                holes,
            } => {
                let [rows, columns] = [*rows, *columns].map(|count| count as usize);
                let field = HeightField::new(rows, columns, heights.clone(), *cell_size)?;
                let holes = holes
                    .iter()
                    .map(|cell| (cell[0] as usize, cell[1] as usize));
                Ok(field.with_holes(holes)?.into())
            }
            Self::Voxels { cell_size, cells } => {
                Ok(Voxels::from_cells(*cell_size, cells.iter().copied())?.into())
            }
        }
    }
}

impl CoreDescription {
    /// Makes the shape that is to be rounded.
    ///
    /// # Errors
    ///
    /// As [`ShapeDescription::build`].
    pub fn build(&self) -> Result<Shape, ShapeError> {
        ShapeDescription::from(self.clone()).build()
    }
}

/// The same without a radius around it.
impl From<CoreDescription> for ShapeDescription {
    fn from(core: CoreDescription) -> Self {
        match core {
            CoreDescription::Segment { a, b } => Self::Segment { a, b },
            CoreDescription::Triangle { a, b, c } => Self::Triangle { a, b, c },
            CoreDescription::Cuboid { half_size } => Self::Cuboid { half_size },
            CoreDescription::Cylinder { radius, height } => Self::Cylinder { radius, height },
            CoreDescription::Cone { radius, height } => Self::Cone { radius, height },
            CoreDescription::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            } => Self::ConicalFrustum {
                radius_top,
                radius_bottom,
                height,
            },
            CoreDescription::Convex { vertices, polygons } => Self::Convex { vertices, polygons },
            CoreDescription::ConvexHull { points } => Self::ConvexHull { points },
        }
    }
}

/// The parts of a compound that is within so many others.
fn build_parts(
    parts: &[PartDescription],
    depth: usize,
) -> Result<Vec<(Isometry3d, Shape)>, ShapeError> {
    if depth >= ShapeDescription::MAX_DEPTH {
        return Err(ShapeError::TooDeep(ShapeDescription::MAX_DEPTH));
    }
    let built = parts.iter().enumerate().map(|(number, part)| {
        let pose = pose(part).ok_or(ShapeError::PartPose {
            part: number,
            position: part.position,
            rotation: part.rotation,
        })?;
        match part.shape.build_within(depth + 1) {
            Ok(shape) => Ok((pose, shape)),
            // It is about all parts within which it is.
            Err(error @ ShapeError::TooDeep(_)) => Err(error),
            Err(error) => Err(ShapeError::InPart {
                part: number,
                error: Box::new(error),
            }),
        }
    });
    built.collect()
}

/// Where a part is; `None` if it is nowhere.
fn pose(part: &PartDescription) -> Option<Isometry3d> {
    // In 64 bits, lest a length be beyond the largest number, or be none.
    let rotation = part.rotation.as_dquat();
    let length = rotation.length();
    let is_turn = length.is_finite() && length > 0.0 && part.position.is_finite();
    let rotation: Quat = if part.rotation.is_normalized() {
        part.rotation
    } else {
        (rotation / length).as_quat()
    };
    is_turn.then(|| Isometry3d::new(part.position, rotation))
}

/// As [`ShapeDescription::build`].
impl TryFrom<&ShapeDescription> for Shape {
    type Error = ShapeError;

    fn try_from(description: &ShapeDescription) -> Result<Self, ShapeError> {
        description.build()
    }
}

#[cfg(test)]
mod tests;
