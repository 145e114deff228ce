//! Data for shapes of Rapier's.

use bevy::prelude::*;
use bevy_rapier3d::parry::shape::{self as parry, SharedShape, TypedShape};

use super::{
    description::{CoreDescription, PartDescription, ShapeDescription},
    error::NoDescriptionError,
};
use crate::narrow_phase::{RapierShape, Shape};

/// The data of one of the crate's own shapes that is the same as one of Rapier's. Surfaces stay
/// surfaces.
pub(super) fn describe(shape: &RapierShape) -> Result<ShapeDescription, NoDescriptionError> {
    if let Some(own) = shape.own() {
        return ShapeDescription::of(own);
    }
    Ok(match shape.raw().as_typed_shape() {
        TypedShape::HeightField(field) => {
            let (vertices, triangles) = field.to_trimesh();
            ShapeDescription::Mesh {
                vertices,
                polygons: triangles.iter().map(|corners| corners.to_vec()).collect(),
                surface_only: true,
            }
        }
        TypedShape::Polyline(line) => ShapeDescription::Compound {
            parts: line
                .segments()
                .map(|parry::Segment { a, b }| {
                    PartDescription::at(Vec3::ZERO, ShapeDescription::Segment { a, b })
                })
                .collect(),
        },
        TypedShape::Voxels(voxels) if is_cubic(voxels.voxel_size()) => {
            let filled = voxels.voxels().filter(|voxel| !voxel.state.is_empty());
            ShapeDescription::Voxels {
                cell_size: voxels.voxel_size().x,
                cells: filled.map(|voxel| voxel.grid_coords).collect(),
            }
        }
        TypedShape::ConvexPolyhedron(solid) => ShapeDescription::ConvexHull {
            points: solid.points().to_vec(),
        },
        TypedShape::RoundConvexPolyhedron(round) => ShapeDescription::Rounded {
            core: CoreDescription::ConvexHull {
                points: round.inner_shape.points().to_vec(),
            },
            radius: round.border_radius,
        },
        TypedShape::Compound(compound) => {
            let parts = compound.shapes().iter().map(|(pose, shape)| {
                Ok(PartDescription {
                    position: pose.translation,
                    rotation: pose.rotation,
                    shape: describe_part(shape)?,
                })
            });
            ShapeDescription::Compound {
                parts: parts.collect::<Result<_, _>>()?,
            }
        }
        _ => {
            return Err(NoDescriptionError {
                kind: format!("{:?}", shape.raw().shape_type()),
            });
        }
    })
}

fn describe_part(shape: &SharedShape) -> Result<ShapeDescription, NoDescriptionError> {
    ShapeDescription::of(&Shape::from(shape.clone()))
}

fn is_cubic(size: Vec3) -> bool {
    size.x == size.y && size.y == size.z
}
