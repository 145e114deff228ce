//! Meshes to draw of collision shapes.

use std::{collections::HashMap, sync::Arc};

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_octree::narrow_phase::{PolygonMesh, RapierShape, Shape};
use bevy_rapier3d::parry::shape::TypedShape;

/// How far a half-space is drawn from where it is.
const FAR: f32 = 200.0;
/// Around what is round.
const SEGMENTS: u32 = 32;

/// Meshes of shapes, each made once, so that Bevy draws all entities of one shape together.
#[derive(Resource, Default)]
pub struct Solids {
    by_numbers: HashMap<Numbers, Handle<Mesh>>,
    /// By the address of what is shared; the shape is kept, so that nothing else gets the address.
    by_address: HashMap<usize, (Shape, Handle<Mesh>)>,
}

/// The kind of a shape, and its lengths as bits.
type Numbers = (&'static str, [u32; 3]);

impl Solids {
    /// Returns the mesh of a shape, or `None` where there is nothing to draw.
    pub fn mesh_of(&mut self, shape: &Shape, meshes: &mut Assets<Mesh>) -> Option<Handle<Mesh>> {
        let own;
        let shape = if let Shape::Rapier(shape) = shape {
            own = own_shape(shape)?;
            &own
        } else {
            shape
        };
        let numbers = |kind, numbers: [f32; 3]| (kind, numbers.map(f32::to_bits));
        let key = match shape {
            Shape::Cuboid { half_size } => numbers("cuboid", half_size.to_array()),
            Shape::Sphere { radius } => numbers("sphere", [*radius, 0.0, 0.0]),
            Shape::Capsule {
                half_length,
                radius,
            } => numbers("capsule", [*half_length, *radius, 0.0]),
            Shape::ConicalFrustum {
                half_height,
                radius_bottom,
                radius_top,
            } => numbers("frustum", [*half_height, *radius_bottom, *radius_top]),
            Shape::HalfSpace { normal } => numbers("half-space", normal.to_array()),
            _ => {
                let address = address(shape)?;
                if let Some((_, mesh)) = self.by_address.get(&address) {
                    return Some(mesh.clone());
                }
                let mesh = meshes.add(mesh_of(shape)?);
                self.by_address
                    .insert(address, (shape.clone(), mesh.clone()));
                return Some(mesh);
            }
        };
        if let Some(mesh) = self.by_numbers.get(&key) {
            return Some(mesh.clone());
        }
        let mesh = meshes.add(mesh_of(shape)?);
        self.by_numbers.insert(key, mesh.clone());
        Some(mesh)
    }
}

/// What Rapier's simplest colliders are like here. Others are not drawn.
fn own_shape(shape: &RapierShape) -> Option<Shape> {
    match shape.raw().as_typed_shape() {
        TypedShape::Ball(ball) => Shape::try_sphere(ball.radius).ok(),
        TypedShape::Cuboid(cuboid) => {
            let half = cuboid.half_extents;
            Shape::try_from_half_size(Vec3::new(half.x, half.y, half.z)).ok()
        }
        // Along y, around its middle, as colliders are built.
        TypedShape::Capsule(capsule) => {
            Shape::try_capsule(capsule.radius, capsule.segment.length()).ok()
        }
        _ => None,
    }
}

fn address(shape: &Shape) -> Option<usize> {
    match shape {
        Shape::Convex(mesh) => Some(Arc::as_ptr(mesh).addr()),
        Shape::Mesh(mesh) => Some(Arc::as_ptr(mesh).addr()),
        Shape::Compound(parts) => Some(Arc::as_ptr(parts).addr()),
        Shape::HeightField(field) => Some(Arc::as_ptr(field).addr()),
        Shape::Voxels(voxels) => Some(Arc::as_ptr(voxels).addr()),
        _ => None,
    }
}

/// Makes the mesh of a shape.
fn mesh_of(shape: &Shape) -> Option<Mesh> {
    match shape {
        Shape::Cuboid { half_size } => Some(Cuboid::from_size(*half_size * 2.0).into()),
        Shape::Sphere { radius } => Some(Sphere::new(*radius).mesh().uv(SEGMENTS, SEGMENTS / 2)),
        Shape::Capsule {
            half_length,
            radius,
        } => Some(Capsule3d::new(*radius, half_length * 2.0).into()),
        Shape::ConicalFrustum {
            half_height,
            radius_bottom,
            radius_top,
        } => Some(
            ConicalFrustum {
                radius_top: *radius_top,
                radius_bottom: *radius_bottom,
                height: half_height * 2.0,
            }
            .into(),
        ),
        Shape::HalfSpace { normal } => {
            let plane = Plane3d::new(*normal, Vec2::splat(FAR));
            Some(plane.into())
        }
        Shape::Convex(mesh) => Some(flat(mesh)),
        Shape::Mesh(mesh) if mesh.polygon_count() <= 64 => Some(flat(mesh)),
        Shape::Mesh(mesh) => Some(smooth(mesh)),
        Shape::Compound(parts) => {
            let mut parts = parts.parts().filter_map(|(place, part)| {
                let place = Transform::from_isometry(place);
                Some(mesh_of(part)?.transformed_by(place))
            });
            let mut whole = parts.next()?;
            for part in parts {
                whole.merge(&part).ok()?;
            }
            Some(whole)
        }
        Shape::HeightField(field) => {
            let triangles = (0..).map_while(|number| field.triangle(number));
            let corners: Vec<_> = triangles.flatten().map(Vec3::from).collect();
            Some(soup(corners).with_computed_flat_normals())
        }
        Shape::Voxels(voxels) => {
            let side = voxels.cell_size();
            let mut cells = voxels.iter().map(|cell| {
                let middle = (cell.as_vec3() + 0.5) * side;
                Mesh::from(Cuboid::from_length(side)).translated_by(middle)
            });
            let mut whole = cells.next()?;
            for cell in cells {
                whole.merge(&cell).ok()?;
            }
            Some(whole)
        }
        _ => None,
    }
}

/// Polygons with an edge between them.
fn flat(mesh: &PolygonMesh) -> Mesh {
    let corners = mesh.polygons().flat_map(|polygon| {
        let fan = (1..polygon.len().saturating_sub(1)).map(|at| [0, at, at + 1]);
        fan.flatten()
            .map(|at| mesh.vertices()[polygon[at] as usize])
    });
    soup(corners.collect()).with_computed_flat_normals()
}

/// Polygons that go over into each other.
fn smooth(mesh: &PolygonMesh) -> Mesh {
    let triangles = mesh.polygons().flat_map(|polygon| {
        let fan = (1..polygon.len().saturating_sub(1)).map(|at| [0, at, at + 1]);
        fan.flatten().map(|at| polygon[at])
    });
    let indices = Indices::U32(triangles.collect());
    let mesh = soup(mesh.vertices().to_vec()).with_inserted_indices(indices);
    mesh.with_computed_smooth_normals()
}

/// A mesh of triangles, three corners each where there are no indices.
fn soup(corners: Vec<Vec3>) -> Mesh {
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
}
