//! The corners of a convex mesh, as its support function goes through them: four at a time.

use bevy::math::{Vec3A, Vec4};

use super::polygon_mesh::PolygonMesh;

/// The corners that polygons of a mesh name, around the centre of its box.
#[derive(Clone, Debug, Default)]
pub struct Corners {
    /// Three coordinates of four corners each; the last ones again where there are no four.
    lanes: Vec<[Vec4; 3]>,
    /// The same corners as vertices of the mesh.
    vertices: Vec<u32>,
}

impl Corners {
    /// Those of a mesh. O(n log n).
    pub fn of(mesh: &PolygonMesh) -> Self {
        let mut vertices = mesh.edges().as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let (middle, ..) = mesh.local_bounds();
        let place = |vertex: u32| Vec3A::from(mesh.vertices()[vertex as usize]) - middle;
        let lanes = vertices.chunks(4).map(|four| {
            let four: [Vec3A; 4] =
                std::array::from_fn(|lane| place(four[lane.min(four.len() - 1)]));
            [0, 1, 2].map(|axis| Vec4::from_array(four.map(|corner| corner[axis])))
        });
        Self {
            lanes: lanes.collect(),
            vertices,
        }
    }

    /// The vertices of the mesh that are its corners.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The corner that is furthest along a direction, around the centre of the box. O(corners).
    #[inline]
    pub fn furthest(&self, direction: Vec3A) -> Vec3A {
        let [x, y, z] = direction.to_array().map(Vec4::splat);
        let mut best = Vec4::splat(f32::NEG_INFINITY);
        let mut found = Vec4::ZERO;
        let mut number = Vec4::ZERO;
        for lanes in &self.lanes {
            let along = lanes[0] * x + lanes[1] * y + lanes[2] * z;
            found = Vec4::select(along.cmpgt(best), number, found);
            best = best.max(along);
            number += 1.0;
        }
        let lane = best.max_position();
        let [x, y, z] = self.lanes[found[lane] as usize];
        Vec3A::new(x[lane], y[lane], z[lane])
    }

    /// How far they reach along a direction, from the centre of the box. O(corners).
    #[inline]
    pub fn reach(&self, direction: Vec3A) -> f32 {
        let [x, y, z] = direction.to_array().map(Vec4::splat);
        let along = |lanes: &[Vec4; 3]| lanes[0] * x + lanes[1] * y + lanes[2] * z;
        let lowest = Vec4::splat(f32::NEG_INFINITY);
        let furthest = self.lanes.iter().map(along).fold(lowest, Vec4::max);
        furthest.max_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::narrow_phase::Shape;
    use bevy::math::Vec3;

    #[test]
    fn the_furthest_corner_is_the_furthest_vertex() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut vector = || Vec3::from_array([0; 3].map(|_| random.f32() * 2.0 - 1.0));
        for count in [4, 5, 6, 7, 23] {
            let points = (0..count).map(|_| vector() + Vec3::X * 3.0);
            let Ok(Shape::Convex(mesh)) = Shape::convex_hull(points) else {
                panic!("they span a volume");
            };
            let (middle, ..) = mesh.local_bounds();
            for _ in 0..100 {
                let direction = Vec3A::from(vector());
                let reach = |corner: Vec3A| corner.dot(direction);
                let of_vertex = |v: &u32| reach(Vec3A::from(mesh.vertices()[*v as usize]) - middle);
                let vertices = mesh.corners().vertices().iter();
                let furthest = vertices.map(of_vertex).fold(f32::NEG_INFINITY, f32::max);
                let found = reach(mesh.corners().furthest(direction));
                assert!((found - furthest).abs() < 1e-6, "{found} {furthest}");
                assert!((mesh.corners().reach(direction) - furthest).abs() < 1e-6);
            }
        }
    }
}
