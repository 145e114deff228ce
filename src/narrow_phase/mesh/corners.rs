//! The corners and the faces of a convex mesh, as what is asked of all of them goes through them:
//! four at a time.

use bevy::math::{Vec3A, Vec4};

use super::polygon_mesh::PolygonMesh;

/// The corners that polygons of a mesh name, around the centre of its box.
#[derive(Clone, Debug, Default)]
pub struct Corners {
    /// Three coordinates of four corners each; the last ones again where there are no four.
    lanes: Vec<[Vec4; 3]>,
    /// The same corners as vertices of the mesh.
    vertices: Vec<u32>,
    /// The normals of four faces each, and how far these are from the centre; the last one again
    /// where there are no four.
    planes: Vec<[Vec4; 4]>,
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
            let four = four_of(four).map(place);
            [0, 1, 2].map(|axis| Vec4::from_array(four.map(|corner| corner[axis])))
        });
        let faces: Vec<_> = mesh.polygons().zip(mesh.normals()).collect();
        let planes = faces.chunks(4).map(|four| {
            let four = four_of(four).map(|(corners, normal)| {
                let normal = Vec3A::from(*normal);
                (normal, normal.dot(place(corners[0])))
            });
            let axis = |axis: usize| Vec4::from_array(four.map(|(normal, _)| normal[axis]));
            let heights = Vec4::from_array(four.map(|(_, height)| height));
            [axis(0), axis(1), axis(2), heights]
        });
        Self {
            lanes: lanes.collect(),
            planes: planes.collect(),
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

    /// The face whose plane is highest under a point around the centre of the box, and how far that
    /// is from it: less than nothing, if it is inside. O(faces).
    #[inline]
    pub fn face_under(&self, point: Vec3A) -> (usize, f32) {
        let [x, y, z] = point.to_array().map(Vec4::splat);
        let mut best = Vec4::splat(f32::NEG_INFINITY);
        let mut found = Vec4::ZERO;
        let mut number = Vec4::ZERO;
        for [across, up, along, offset] in &self.planes {
            let height = *across * x + *up * y + *along * z - *offset;
            found = Vec4::select(height.cmpgt(best), number, found);
            best = best.max(height);
            number += 1.0;
        }
        let lane = best.max_position();
        (found[lane] as usize * 4 + lane, best[lane])
    }
}

/// Four of some, the last one again where there are no four.
fn four_of<T: Copy>(some: &[T]) -> [T; 4] {
    std::array::from_fn(|lane| some[lane.min(some.len() - 1)])
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
