//! A mesh as a convex solid sees it.

use bevy::math::{DMat3, DVec3, Mat3A, Vec3, Vec3A, bounding::Aabb3d};
use bevy::transform::components::Transform;

use crate::narrow_phase::{
    frame::{placed::Placed, placing::cofactors},
    length::unit,
    mesh::polygon_mesh::PolygonMesh,
};

/// How a mesh gets into the frame of a solid: around the centre of the solid's box, along its axes.
///
/// Vertices are taken relative to that centre before anything else, so that what is near the solid
/// is as exact as the solid is small, however large the mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshPlace {
    matrix: Mat3A,
    normals: Mat3A,
    /// The centre of the solid in the space of the mesh, or about there; and where it is in the
    /// frame.
    about: Vec3A,
    shift: Vec3A,
    /// From the frame to the space of the mesh.
    back: Mat3A,
}

fn rotation(transform: &Transform) -> DMat3 {
    DMat3::from_quat(transform.rotation.as_dquat().normalize())
}

impl MeshPlace {
    /// The mesh, placed, in the frame of a solid of which the unplaced box is around `middle`.
    pub fn new(solid: Placed, middle: Vec3A, mesh: Placed, mesh_middle: Vec3A) -> Self {
        let to_frame = rotation(solid.transform).transpose();
        let turn = to_frame * rotation(mesh.transform);
        let scale = mesh.transform.scale.as_dvec3();
        let offset = mesh.transform.translation.as_dvec3() - solid.transform.translation.as_dvec3();
        let solid_scale = solid.shape.effective_scale(solid.transform.scale);
        let origin = to_frame * offset - (middle * solid_scale).as_dvec3();
        let center = turn.transpose() * -origin / scale;
        let about = Vec3A::from(center.as_vec3());
        let about = if about.is_finite() {
            about
        } else {
            mesh_middle
        };
        let shift = origin + turn * (about.as_dvec3() * scale);
        let turn = mat3a(turn);
        let scale = Vec3A::from(mesh.transform.scale);
        let inverse = Mat3A::from_diagonal(scale.recip().into());
        Self {
            matrix: turn * Mat3A::from_diagonal(scale.into()),
            normals: turn * Mat3A::from_diagonal(cofactors(scale).into()),
            about,
            shift: vec3a(shift),
            back: inverse * turn.transpose(),
        }
    }

    #[inline]
    pub fn place(&self, vertex: Vec3) -> Vec3A {
        self.matrix * (Vec3A::from(vertex) - self.about) + self.shift
    }

    #[inline]
    pub fn normal(&self, normal: Vec3) -> Vec3A {
        unit(self.normals * Vec3A::from(normal))
    }

    /// A box in the space of the mesh around all that is as near the origin of the frame as `half`
    /// along each axis.
    pub fn region(&self, half: Vec3A) -> Aabb3d {
        let center = self.about - self.back * self.shift;
        let reach = self.back.abs() * half;
        let (min, max) = (center - reach, center + reach);
        let wide = 8.0 * f32::EPSILON * (self.about.abs() + center.abs() + reach);
        // Along an axis of no scale, everything is near, or nothing.
        let known = min.is_finite_mask() & max.is_finite_mask();
        Aabb3d {
            min: Vec3A::select(known, min - wide, Vec3A::MIN),
            max: Vec3A::select(known, max + wide, Vec3A::MAX),
        }
    }

    /// Calls `found` with each polygon that may be as near the origin as `half`, in no particular
    /// order.
    pub fn for_each_near(&self, mesh: &PolygonMesh, half: Vec3A, found: impl FnMut(u32)) {
        match mesh.tree() {
            Some(tree) => tree.for_each_overlapping(&self.region(half), found),
            None => (0..mesh.polygon_count() as u32).for_each(found),
        }
    }
}

fn vec3a(v: DVec3) -> Vec3A {
    v.as_vec3().into()
}

fn mat3a(m: DMat3) -> Mat3A {
    Mat3A::from_cols(vec3a(m.x_axis), vec3a(m.y_axis), vec3a(m.z_axis))
}
