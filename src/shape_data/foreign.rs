//! Data for shapes of Rapier's.

use bevy::prelude::*;
use bevy_rapier3d::parry::shape::{self as parry, TypedShape};

use super::{
    describe::NoDescriptionError,
    description::{CoreDescription, PartDescription, ShapeDescription},
};

/// The data of one of the crate's own shapes that is the same as one of Rapier's. Surfaces stay
/// surfaces.
pub(super) fn describe(shape: &dyn parry::Shape) -> Result<ShapeDescription, NoDescriptionError> {
    Ok(match shape.as_typed_shape() {
        TypedShape::Ball(ball) => ShapeDescription::Sphere {
            radius: ball.radius,
        },
        TypedShape::Cuboid(cuboid) => ShapeDescription::Cuboid {
            half_size: cuboid.half_extents,
        },
        TypedShape::Capsule(capsule) => {
            let parry::Segment { a, b } = capsule.segment;
            ShapeDescription::capsule(a, b, capsule.radius)
        }
        TypedShape::Segment(&parry::Segment { a, b }) => ShapeDescription::Segment { a, b },
        TypedShape::Triangle(&parry::Triangle { a, b, c }) => {
            ShapeDescription::Triangle { a, b, c }
        }
        TypedShape::TriMesh(mesh) => surface(mesh.vertices().to_vec(), mesh.indices()),
        TypedShape::HeightField(field) => {
            let (vertices, triangles) = field.to_trimesh();
            surface(vertices, &triangles)
        }
        TypedShape::Polyline(line) => ShapeDescription::Compound {
            parts: line
                .segments()
                .map(|parry::Segment { a, b }| {
                    PartDescription::at(Vec3::ZERO, ShapeDescription::Segment { a, b })
                })
                .collect(),
        },
        TypedShape::HalfSpace(half_space) => ShapeDescription::HalfSpace {
            normal: half_space.normal,
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
        TypedShape::Cylinder(cylinder) => ShapeDescription::Cylinder {
            radius: cylinder.radius,
            height: 2.0 * cylinder.half_height,
        },
        TypedShape::Cone(cone) => ShapeDescription::Cone {
            radius: cone.radius,
            height: 2.0 * cone.half_height,
        },
        TypedShape::RoundCuboid(round) => ShapeDescription::Rounded {
            core: CoreDescription::Cuboid {
                half_size: round.inner_shape.half_extents,
            },
            radius: round.border_radius,
        },
        TypedShape::RoundTriangle(round) => {
            let parry::Triangle { a, b, c } = round.inner_shape;
            ShapeDescription::Rounded {
                core: CoreDescription::Triangle { a, b, c },
                radius: round.border_radius,
            }
        }
        TypedShape::RoundCylinder(round) => ShapeDescription::Rounded {
            core: CoreDescription::Cylinder {
                radius: round.inner_shape.radius,
                height: 2.0 * round.inner_shape.half_height,
            },
            radius: round.border_radius,
        },
        TypedShape::RoundCone(round) => ShapeDescription::Rounded {
            core: CoreDescription::Cone {
                radius: round.inner_shape.radius,
                height: 2.0 * round.inner_shape.half_height,
            },
            radius: round.border_radius,
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
                    shape: describe(&**shape)?,
                })
            });
            ShapeDescription::Compound {
                parts: parts.collect::<Result<_, _>>()?,
            }
        }
        TypedShape::Voxels(_) | TypedShape::Custom(_) => {
            return Err(NoDescriptionError {
                kind: format!("{:?}", shape.shape_type()),
            });
        }
    })
}

fn is_cubic(size: Vec3) -> bool {
    size.x == size.y && size.y == size.z
}

/// A mesh without an inside.
fn surface(vertices: Vec<Vec3>, triangles: &[[u32; 3]]) -> ShapeDescription {
    ShapeDescription::Mesh {
        vertices,
        polygons: triangles.iter().map(|corners| corners.to_vec()).collect(),
        surface_only: true,
    }
}
